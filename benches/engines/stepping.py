"""A scene driven step by step: what users of an engine do who compute forces in a loop of their own."""

import math
import time

import numpy as np

from scene import Floats

# Below this speed a lever counts as standing, for a dry friction that is larger at rest than in motion, rad/s.
STANDS_RAD_S = 1e-5
# A run that would take longer than this is given up, s.
TOO_LONG_S = 100.0
# After so many steps a run's whole time is foreseen.
FORESEEN = 500


class TooSlow(Exception):
    """A run given up; the text says how far it came."""


def switched(theta_dot, bias_n, level_n, rest_n):
    """The force of a law that switches on the sign of the velocity, N."""
    if theta_dot > 0.0:
        return bias_n - level_n
    if theta_dot < 0.0:
        return bias_n + level_n
    return bias_n - Floats.clip(bias_n, -rest_n, rest_n)


def smoothed(speed_rad_s):
    """The force of a law with tanh(theta_dot / speed) in place of the sign, as scripts have it."""
    return lambda theta_dot, bias_n, level_n, rest_n: bias_n - level_n * math.tanh(theta_dot / speed_rad_s)


def drive(scene, step_s, read, step):
    """Times, theta, theta_dot and seconds of a run. `read()` gives theta and theta_dot of the engine, `step(bias_n,
    level_n, rest_n)` makes a step with a force, and a dry friction in motion and at rest, at the lever's end."""
    steps = round(scene.duration_s / step_s)
    times = np.arange(steps + 1) * step_s
    out = np.empty((2, steps + 1))
    level = 0.0 if scene.lag_s else None
    # The finger's position and velocity against the fixed frame.
    finger, finger_dot = scene.lever_m * scene.theta_rad, scene.lever_m * scene.theta_dot_rad_s
    tip = None
    start = time.process_time()
    for k in range(steps):
        t = k * step_s
        theta, theta_dot = read()
        out[0, k], out[1, k] = theta, theta_dot
        if level is not None:
            asked = scene.level_asked(theta, theta_dot)
            level += (asked - level) * -math.expm1(-step_s / scene.lag_s)
        if scene.finger:
            tip = scene.tissue(finger - scene.lever_m * theta, finger_dot - scene.lever_m * theta_dot)
            finger_dot += step_s * (scene.input.at(t) - tip) / scene.finger["mass_kg"]
            finger += step_s * finger_dot
        forward, backward = scene.forces(t, theta, theta_dot, level, tip)
        # Rounding can put it below 0.
        moving_n = max(0.5 * (backward - forward), 0.0)
        rest_n = moving_n + scene.static_n - scene.kinetic_n
        step(0.5 * (forward + backward), moving_n, rest_n)
        if k % FORESEEN == FORESEEN - 1:
            whole_s = (time.process_time() - start) * steps / (k + 1)
            if whole_s > TOO_LONG_S:
                raise TooSlow(f"given up: it would take some {whole_s:.0f} s")
    out[:, steps] = read()
    return times, out[0], out[1], time.process_time() - start


def friction_level(theta_dot, level_n, rest_n):
    """The level for an engine's own dry friction, which has one number where the scene has two."""
    return rest_n if abs(theta_dot) < STANDS_RAD_S else level_n
