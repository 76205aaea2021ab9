"""Trajectories beside `exact`, and what is wrong with them.

`zwidth judge` gives the verdict where the program has that command; `facts` says the least of it otherwise.
"""

import json
import subprocess
import tempfile
from pathlib import Path

import numpy as np

# A lever that is further beyond a stop than this has passed it, rad.
BEYOND_RAD = 2e-3
# Faster than this, what moves away from a stop is thrown back by it, rad/s.
LEAVES_RAD_S = 0.1
# A creep is steady: no quarter of a rest moves by more than so many times another.
STEADY = 3.0
# exact refuses more samples than this.
MOST_SAMPLES = 500_000
COLUMNS = "t_s,theta_rad,theta_dot_rad_s"


class Judge:
    def __init__(self, zwidth):
        self.zwidth = zwidth
        self.known = {}
        told = subprocess.run([zwidth, "judge", "--help"], capture_output=True, text=True)
        self.has_judge = told.returncode == 0
        self.name = "zwidth judge" if self.has_judge else "facts"

    def exact(self, scene, step_s):
        """Every how many steps there is a sample of `exact`, and its theta and theta_dot."""
        every = 1
        while scene.duration_s / (step_s * every) > MOST_SAMPLES:
            every += 1
        key = (scene.id, round(scene.duration_s / step_s), every)
        if key not in self.known:
            with tempfile.TemporaryDirectory() as out:
                subprocess.run([self.zwidth, "simulate", scene.path, "--step", repr(step_s * every), "--out", out, "-q"], check=True, capture_output=True)
                table = np.genfromtxt(Path(out) / f"{scene.id}.trajectory.csv", delimiter=",", names=True, usecols=COLUMNS.split(","))
            self.known[key] = every, table["theta_rad"], table["theta_dot_rad_s"]
        return self.known[key]

    def verdict(self, scene, trajectory):
        """The verdict on a file, the largest error of theta in rad, and whether a person could tell (None if not known)."""
        if self.has_judge:
            return self.by_judge(scene, trajectory)
        times, theta, theta_dot = np.loadtxt(trajectory, delimiter=",", skiprows=1, unpack=True)
        step_s = scene.duration_s / (len(times) - 1)
        every, right, right_dot = self.exact(scene, step_s)
        count = min(len(right), len(theta[::every]))
        error = np.abs(theta[::every][:count] - right[:count])
        error = float(error.max()) if np.isfinite(error).all() else float("inf")
        words = facts(times[::every][:count], theta[::every][:count], theta_dot[::every][:count], right[:count], right_dot[:count], scene)
        return words, error, None

    def by_judge(self, scene, trajectory):
        """`zwidth judge`, in a few words."""
        told = subprocess.run([self.zwidth, "judge", scene.path, "--trajectory", trajectory, "--json"], capture_output=True, text=True)
        if not told.stdout:
            return f"refused: {told.stderr.strip().splitlines()[0]}", float("inf"), None
        judged, faults = json.loads(told.stdout)["tables"]
        row = judged["rows"][0]
        return worded(row["verdict"], faults["rows"]), row["theta_error_max_rad"], row["is_felt"]


def worded(verdict, faults):
    """A verdict with the size of the first fault that is it."""
    fault = next((fault for fault in faults if fault["fault"] == verdict), {})
    sizes = []
    if fault.get("event"):
        sizes.append(fault["event"])
    if fault.get("creep_rad_s") is not None:
        sizes.append(f"{np.degrees(abs(fault['creep_rad_s'])):.2g}°/s")
    elif fault.get("late_s") is not None:
        sizes.append(f"{1e3 * abs(fault['late_s']):.2g} ms")
    elif fault.get("theta_rad") is not None:
        sizes.append(f"{np.degrees(abs(fault['theta_rad'])):.2g}°")
    return ": ".join([verdict, ", ".join(sizes)]) if sizes else verdict


def facts(times, theta, theta_dot, right, right_dot, scene):
    """In words: what a trajectory does where `exact` does not."""
    if not np.isfinite(theta).all() or np.abs(theta).max() > 1e3:
        return "unstable"
    least = 1e-9
    beyond = max((theta - scene.high_rad).max(), (scene.low_rad - theta).max())
    words = []
    if beyond > BEYOND_RAD:
        words.append(f"{np.degrees(beyond):.2g}° beyond a stop")
    fastest, swings, leaves = 0.0, 0, False
    for begin, end in rests(right_dot):
        middle = slice(begin + (end - begin) // 4, end - (end - begin) // 4)
        parts = np.array_split(theta[middle], 4)
        moved = [part[-1] - part[0] for part in parts]
        speed = (theta[middle][-1] - theta[middle][0]) / (times[middle][-1] - times[middle][0])
        signs = np.sign(theta_dot[middle])
        turns = int((signs[1:] * signs[:-1] < 0).sum())
        if turns > 6 and np.ptp(theta[middle]) > 2 * least:
            swings = max(swings, turns)
        elif steady(moved, least):
            at_stop = min(abs(right[begin] - scene.low_rad), abs(right[begin] - scene.high_rad)) < least
            leaves = leaves or (at_stop and abs(speed) > LEAVES_RAD_S)
            fastest = max(fastest, abs(speed))
    if swings:
        words.append("chatters")
    if fastest > 1e-6:
        words.append(f"{'leaves a stop' if leaves else 'creeps'}, {np.degrees(fastest):.2g}°/s")
    error = np.abs(theta - right).max()
    if error > np.radians(1.0):
        words.append(f"another motion, {np.degrees(error):.2g}° off")
    return ", ".join(words) or "right"


def steady(moved, least):
    """Whether all quarters move one way, about alike."""
    same_way = all(m > least for m in moved) or all(m < -least for m in moved)
    return same_way and max(map(abs, moved)) < STEADY * min(map(abs, moved))


def rests(theta_dot):
    """Stretches of at least 16 samples in which `exact` stands."""
    still = np.concatenate([[0], (np.abs(theta_dot) < 1e-12).astype(int), [0]])
    edges = np.flatnonzero(np.diff(still))
    return [(a, b) for a, b in zip(edges[::2], edges[1::2]) if b - a >= 16]
