"""CasADi's integrators with zero-crossing events: one integrator per mode of motion, which stands still after its event."""

import time

import casadi as ca
import numpy as np

import machine
from engine import Setting
from stepping import TOO_LONG_S, TooSlow

NAME = "CasADi"
BOOK = "CasADi documentation, integrator: "
SETTINGS = [
    Setting("cvodes", "default", "cvodes, reltol 1e-6, abstol 1e-8; events by “zero” and “transition”, 3 iterations", BOOK + "“Zero-crossing events”", {"plugin": "cvodes"}),
    Setting("idas", "best", "idas, reltol and abstol 1e-11, 50 iterations per event; an output grid of 0.02 ms where there are edges to cross",
            BOOK + "options abstol, reltol, max_event_iter, event_tol",
            {"plugin": "idas", "grid_s": 2e-5, "reltol": 1e-11, "abstol": 1e-11, "event_tol": 1e-12, "max_event_iter": 50}),
]


class Symbols:
    sin, remainder = ca.sin, ca.fmod

    @staticmethod
    def where(condition, yes, no):
        return ca.if_else(condition, yes, no)

    @staticmethod
    def clip(value, low, high):
        return ca.fmin(ca.fmax(value, low), high)


def versions():
    return f"casadi {ca.__version__}"


def run(scene, setting):
    options = dict(setting.options)
    plugin = options.pop("plugin")
    # A guard that is 0 where a mode begins (on an edge) is seen to become negative only after the next point of the grid.
    grid_s = options.pop("grid_s", None)
    if not scene.edges():
        grid_s = None
    start = time.process_time()

    def phase(part, mode, t0, t1, y0, wanted, blocked):
        if time.process_time() - start > TOO_LONG_S:
            raise TooSlow(f"given up after {TOO_LONG_S:g} s, at {t0:.3g} s of {scene.duration_s:g} s")
        named = [(name, g) for name, g in part.guards(mode, Symbols) if name not in blocked]
        # The state; 1 until an event has happened; its time; its guard.
        n = part.size
        x, t = ca.SX.sym("x", n + 3), ca.SX.sym("t")
        y, on = ca.vertsplit(x)[:n], x[n]
        slope = ca.vertcat(*part.slope(mode, Symbols)(t, y))
        dae = {"t": t, "x": x, "ode": ca.vertcat(on * slope, 0, 0, 0)}
        more = {}
        if named:
            index = ca.SX.sym("index")
            # What has happened does not happen again.
            dae["zero"] = ca.vertcat(*[ca.if_else(on > 0.5, g(t, y), 1.0) for _, g in named])
            after = ca.vertcat(x[:n], 0.0, t, index)
            more["transition"] = ca.Function("transition", {"index": index, "t": t, "x": x, "post_x": after}, ca.event_in(), ca.event_out())
        grid = np.union1d(wanted[wanted > t0], [t1])
        if grid_s:
            grid = np.union1d(grid, np.arange(t0 + grid_s, t1, grid_s))
        integrator = ca.integrator("lever", plugin, dae, t0, grid, options | more)
        states = np.array(integrator(x0=[*y0, 1.0, 0.0, -1.0])["xf"]).T
        last = states[-1]
        before = [y0] if len(wanted) and wanted[0] <= t0 else []
        rows = states[np.isin(grid, wanted)]
        if last[n] > 0.5:
            return [*before, *rows[:, :n]], t1, last[:n], None
        event_s, which = last[n + 1], int(round(last[n + 2]))
        within = grid[np.isin(grid, wanted)] <= event_s
        return [*before, *rows[within][:, :n]], event_s, last[:n], named[which][0]

    times = np.linspace(0.0, scene.duration_s, round(scene.duration_s / scene.step_s) + 1)
    out = machine.run(scene, phase, times)
    return times, out[0], out[1], time.process_time() - start
