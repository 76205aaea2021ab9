"""SciPy's solve_ivp: with located events, and as scripts have it."""

import math
import time

import numpy as np
import scipy
from scipy.integrate import solve_ivp

import machine
from engine import Setting
from stepping import TOO_LONG_S, TooSlow, smoothed

NAME = "SciPy solve_ivp"
PAGE = "scipy.integrate.solve_ivp, “Parameters”: "
SETTINGS = [
    Setting("rk45_tanh", "default", "RK45, rtol 1e-3, atol 1e-6; friction by tanh(θ̇ / 0.01 rad/s); a terminal event at the stop",
            PAGE + "method, rtol, atol", {"law": True}),
    Setting("located", "best", "DOP853, rtol and atol 1e-10; one run per mode of motion, ended by terminal events with a direction; steps of at most 4 ms where there are edges to cross",
            PAGE + "events (“terminal”, “direction”; “if multiple zero crossings occur within one step, events may be missed”), method (“DOP853”), max_step",
            {"method": "DOP853", "tolerance": 1e-10, "largest_s": 4e-3}),
    Setting("max_0", "more", "as rk45_tanh, with max(0, θ − stop) as the event", "what scripts have", {"law": True, "max_0": True}),
    *[Setting(f"located_{e}", "more", f"RK45, tolerance 1e-{e}, located events", "", {"method": "RK45", "tolerance": 10.0**-e})
      for e in (3, 5, 7, 9)],
]


def versions():
    return f"SciPy {scipy.__version__}, NumPy {np.__version__}"


def run(scene, setting):
    times = np.linspace(0.0, scene.duration_s, round(scene.duration_s / scene.step_s) + 1)
    start = time.process_time()
    options = setting.options
    if "law" in options:
        out = naive(scene, times, start, options.get("max_0", False))
    else:
        out = located(scene, times, **options)
    return times, out[0], out[1], time.process_time() - start


def located(scene, times, method, tolerance, largest_s=math.inf):
    options = {"rtol": tolerance, "atol": tolerance, "max_step": largest_s if scene.edges() else math.inf}

    def phase(machine, mode, t0, t1, y0, wanted, blocked):
        # Of a mode that begins and ends on the same edge, a first step over all of it would find the end at its beginning.
        first = {"first_step": min(1e-5, t1 - t0)} if scene.edges() else {}
        named = [(name, g) for name, g in machine.guards(mode) if name not in blocked]
        for _, g in named:
            g.terminal, g.direction = True, -1
        solution = solve_ivp(machine.slope(mode), (t0, t1), y0, method, np.union1d(wanted, [t1]), events=[g for _, g in named], **options, **first)
        if solution.status < 0:
            raise ArithmeticError(solution.message)
        if solution.status == 0:
            # With t_eval, the last state is that of the last time asked for.
            return solution.y.T[:len(wanted)], t1, solution.y[:, -1], None
        which = next(i for i, found in enumerate(solution.t_events) if found.size)
        states = solution.y.T if len(solution.t) else []
        return states, float(solution.t_events[which][0]), solution.y_events[which][0], named[which][0]
    return machine.run(scene, phase, times)


def naive(scene, times, start, max_0):
    """One call up to a stop, where the lever then rests."""
    law = smoothed(0.01)
    model = machine.Machine(scene)

    def slope(t, y):
        if time.process_time() - start > TOO_LONG_S:
            raise TooSlow(f"given up after {TOO_LONG_S:g} s, at {t:.3g} s of {scene.duration_s:g} s")
        y = y.tolist()
        forward, backward = model.forces(t, y, None)
        level = 0.5 * (backward - forward)
        out = [y[1], law(y[1], 0.5 * (forward + backward), level, level) / scene.inertia]
        level, finger = model.parts(y)
        if level is not None:
            out.append((scene.level_asked(y[0], y[1]) - level) / scene.lag_s)
        if finger is not None:
            net = scene.input.at(t) - scene.tissue(*finger)
            out += [finger[1], net / scene.finger["mass_kg"] - scene.lever_m * out[1]]
        return out

    def at_stop(t, y):
        return max(0.0, y[0] - scene.high_rad) if max_0 else y[0] - scene.high_rad

    at_stop.terminal, at_stop.direction = True, 1
    y, _ = model.start()
    solution = solve_ivp(slope, (0.0, scene.duration_s), y, t_eval=times, events=at_stop)
    found = len(solution.t)
    out = np.empty((2, len(times)))
    out[:, :found] = solution.y[:2]
    out[:, found:] = [[scene.high_rad], [0.0]]
    return out
