"""diffsol by its Python package: one model in DiffSL per mode of motion, ended by its stop conditions."""

import time

import numpy as np
import pydiffsol as ds

import machine
from engine import Setting
from stepping import TOO_LONG_S, TooSlow

NAME = "diffsol"
BOOK = "diffsol documentation, "
SETTINGS = [
    Setting("bdf", "default", "bdf, rtol and atol 1e-6, one model per mode of motion", BOOK + "Ode (ode_solver, rtol, atol); DiffSL, “stop”", {"solver": "bdf", "tolerance": 1e-6}),
    Setting("tsit45", "best", "tsit45, rtol and atol 1e-11; parts of at most 0.04 ms after an edge",
            BOOK + "“Choosing a solver”; Ode (rtol, atol)", {"solver": "tsit45", "tolerance": 1e-11, "first_s": 4e-5}),
]


class Text:
    """An expression of DiffSL."""

    def __init__(self, text):
        self.text = str(text)

    def __add__(self, other):
        return Text(f"({self.text} + {written(other)})")

    def __radd__(self, other):
        return Text(f"({written(other)} + {self.text})")

    def __sub__(self, other):
        return Text(f"({self.text} - {written(other)})")

    def __rsub__(self, other):
        return Text(f"({written(other)} - {self.text})")

    def __mul__(self, other):
        return Text(f"({self.text} * {written(other)})")

    def __rmul__(self, other):
        return Text(f"({written(other)} * {self.text})")

    def __truediv__(self, other):
        return Text(f"({self.text} / {written(other)})")

    def __neg__(self):
        return Text(f"(0 - {self.text})")


def written(value):
    """DiffSL has no signs before numbers."""
    if isinstance(value, Text):
        return value.text
    return f"{value:.17g}" if value >= 0.0 else f"(0 - {-value:.17g})"


class Symbols:
    @staticmethod
    def sin(value):
        return Text(f"sin({written(value)})")

    @staticmethod
    def clip(value, low, high):
        return Text(f"min(max({written(value)}, {written(low)}), {written(high)})")


def versions():
    return f"pydiffsol {ds.version()}, diffsol {ds.diffsol_version()}"


def run(scene, setting):
    options, models = setting.options, {}
    solver = getattr(ds, options["solver"])

    def model(part, mode, blocked):
        key = (str(part.scene.input), mode, frozenset(blocked))
        if key not in models:
            named = [(name, g) for name, g in part.guards(mode, Symbols) if name not in blocked]
            names = [f"y{i}" for i in range(part.size)]
            y, t = [Text(name) for name in names], Text("(t + t0)")
            code = "in_i { t0 = 0, " + ", ".join(f"s{i} = 0" for i in range(part.size)) + " }\n"
            code += "u_i { " + ", ".join(f"{name} = s{i}" for i, name in enumerate(names)) + " }\n"
            code += "F_i { " + ", ".join(written(v) for v in part.slope(mode, Symbols)(t, y)) + " }\n"
            if named:
                code += "stop_i { " + ", ".join(written(g(t, y)) for _, g in named) + " }\n"
            ode = ds.Ode(code, matrix_type=ds.nalgebra_dense, scalar_type=ds.f64, ode_solver=solver)
            ode.rtol = ode.atol = options["tolerance"]
            models[key] = ode, named
        return models[key]

    def phase(part, mode, t0, t1, y0, wanted, blocked):
        if time.process_time() - start > TOO_LONG_S:
            raise TooSlow(f"given up after {TOO_LONG_S:g} s, at {t0:.3g} s of {scene.duration_s:g} s")
        ode, named = model(part, mode, blocked)
        plain = dict(machine.Machine(part.scene).guards(mode))
        states, done = [], int(np.searchsorted(wanted, t0, side="right"))
        states += [list(y0)] * done
        t, y = t0, list(y0)
        first_s = options.get("first_s") if scene.edges() else None
        while True:
            # A root is found by a change of sign over a step: the first step from an edge must be short.
            end = min(t1, t + first_s) if first_s and t == t0 else t1
            within = wanted[done:int(np.searchsorted(wanted, end, side="right"))]
            grid = np.union1d(within, [end]) - t
            solution = ode.solve_dense(np.array([t, *y]), grid)
            found = np.isin(solution.ts, within - t)
            states += solution.ys.T[found].tolist()
            done += int(found.sum())
            y = solution.ys[:, -1].tolist()
            if solution.ts[-1] < grid[-1] and named:
                t += float(solution.ts[-1])
                which = min(((abs(plain[name](t, y)), name) for name, _ in named))[1]
                return states, t, y, which
            t = end
            if end == t1:
                return states, t1, y, None

    times = np.linspace(0.0, scene.duration_s, round(scene.duration_s / scene.step_s) + 1)
    start = time.process_time()
    machine.run(scene, phase, times)  # compiles
    start = time.process_time()
    out = machine.run(scene, phase, times)
    return times, out[0], out[1], time.process_time() - start
