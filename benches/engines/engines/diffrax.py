"""diffrax: one solve per mode of motion, ended by events, compiled once per mode."""

import math
import time

import diffrax as dx
import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx

import machine
from engine import Setting
from engines.mjx import Arrays
from stepping import TOO_LONG_S, TooSlow

NAME = "diffrax"
BOOK = "diffrax documentation, "
SETTINGS = [
    Setting("step_end", "default", "Tsit5, rtol 1e-3, atol 1e-6 in float32; events without a root finder, so at the end of their step",
            BOOK + "“Getting started”; Events (“root_finder”: by default at the end of the step)", {"x64": False, "rtol": 1e-3, "atol": 1e-6, "root": False}),
    Setting("root", "best", "Dopri8, rtol and atol 1e-10 in float64, events by optimistix.Newton; steps of at most 4 ms where there are edges to cross",
            BOOK + "Events (“root_finder”), “How to choose a solver”, FAQ (jax_enable_x64), PIDController (dtmax)",
            {"x64": True, "rtol": 1e-10, "atol": 1e-10, "root": True, "largest_s": 4e-3}),
]


def versions():
    return f"diffrax {dx.__version__}, jax {jax.__version__}"


# The most samples within one mode, so that one compiled program serves all.
SAMPLES = 512


def run(scene, setting):
    options = setting.options
    jax.config.update("jax_enable_x64", options["x64"])
    dtype = jnp.float64 if options["x64"] else jnp.float32
    programs = {}

    def program(part, mode, blocked):
        key = (str(part.scene.input), mode, frozenset(blocked))
        if key in programs:
            return programs[key]
        slope = part.slope(mode, Arrays)
        named = [(name, g) for name, g in part.guards(mode, Arrays) if name not in blocked]
        term = dx.ODETerm(lambda t, y, _: jnp.stack([jnp.asarray(v, dtype) for v in slope(t, y)]))
        solver = dx.Dopri8() if options["root"] else dx.Tsit5()
        largest = options.get("largest_s") if scene.edges() else None
        controller = dx.PIDController(rtol=options["rtol"], atol=options["atol"], dtmax=largest)
        finder = optx.Newton(1e-12, 1e-12) if options["root"] else None
        event = dx.Event([lambda t, y, args, *, g=g, **_: g(t, y) for _, g in named], finder, direction=False) if named else None

        @eqx.filter_jit
        def solve(t0, t1, y0, wanted):
            first = jnp.minimum(1e-5, 0.5 * (t1 - t0)) if scene.edges() else None
            solution = dx.diffeqsolve(term, solver, t0, t1, first, y0, saveat=dx.SaveAt(ts=wanted, t1=True), stepsize_controller=controller,
                                      event=event, max_steps=1_000_000, throw=False)
            mask = jnp.stack(solution.event_mask) if named else jnp.zeros(1, bool)
            return solution.ts, solution.ys, mask

        programs[key] = named, solve
        return programs[key]

    def phase(part, mode, t0, t1, y0, wanted, blocked):
        named, solve = program(part, mode, blocked)
        states = []
        done = 0
        while True:
            # Of more samples than a program has room for, as many as it has, and on from there.
            chunk = wanted[done:done + SAMPLES]
            end = t1 if done + SAMPLES >= len(wanted) else float(chunk[-1])
            padded = np.full(SAMPLES, end)
            padded[:len(chunk)] = np.clip(chunk, t0, end)
            ts, ys, mask = jax.device_get(solve(jnp.asarray(t0, dtype), jnp.asarray(end, dtype), jnp.asarray(y0, dtype), jnp.asarray(padded, dtype)))
            if time.process_time() - start > TOO_LONG_S:
                raise TooSlow(f"given up after {TOO_LONG_S:g} s, at {t0:.3g} s of {scene.duration_s:g} s")
            # What was saved stands at the front, its end last.
            found = int(np.isfinite(ts).sum())
            t_end, y_end = float(ts[found - 1]), ys[found - 1]
            states += list(ys[:min(len(chunk), found - 1)])
            if mask.any():
                which = int(np.flatnonzero(mask)[0])
                return states, t_end, y_end.tolist(), named[which][0]
            if found < SAMPLES + 1:
                raise ArithmeticError(f"the solve ended at {t_end} s, before {end} s")
            done += len(chunk)
            t0, y0 = end, y_end
            if end == t1:
                return states, t1, y0.tolist(), None

    times = np.linspace(0.0, scene.duration_s, round(scene.duration_s / scene.step_s) + 1)
    start = math.inf
    machine.run(scene, phase, times)  # compiles, which does not count
    start = time.process_time()
    out = machine.run(scene, phase, times)
    return times, out[0], out[1], time.process_time() - start
