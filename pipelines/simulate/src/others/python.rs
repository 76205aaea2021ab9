//! A program of NumPy and SciPy: the equations piece by piece, each up to its located event.

use super::equations::{ACTUATORS, INPUTS, MOTION, NUMBERS, SAMPLES, WRITE};
use super::writer::{Comment, Form, Writer};

pub(super) const WRITER: Writer = Writer {
    files: &[Form {
        ending: "scipy.py",
        comment: Comment::Hash,
        templates: &[
            ("", HEAD),
            ("", NUMBERS),
            ("", INPUTS),
            ("", ACTUATORS),
            ("", MOTION),
            ("", SAMPLES),
            ("", LOOP),
            ("", WRITE),
        ],
    }],
    remarks: r"
    |theta is the lever's angle in rad, theta = 0 is upright, and forces are at the lever's end: MASS LEVER theta'' = their sum. Above 0 is into the object.
    |Run it: `python FILE trajectory.csv` writes t_s, theta_rad, theta_dot_rad_s every STEP seconds.
    |Every change of the way of moving is an event that solve_ivp locates and stops at; the pieces between are smooth but for the limits of the actuators, which are kinks.
    |solve_ivp looks for events between its own steps: two of one kind within a step are missed. MAX_STEP bounds the steps.
zones|At an edge of the environment where both sides push back, a bounce of less than 2e-10 rad is rest.
hybrid lags|Lagging actuators follow the command of holding or releasing while the lever rests.
    ",
    refused: &[],
};

const HEAD: &str = r#"
        |@head@
        |
series  |import bisect
        |import math
        |import sys
        |from dataclasses import dataclass
        |
        |import numpy as np
        |from scipy.integrate import solve_ivp
        |
"#;

const LOOP: &str = r#"
        |
        |
        |ACCURACY, SMALLEST = 1e-10, 1e-12  # of a step: relative, and absolute in units of the state
        |MAX_STEP = DURATION / 400  # s; events are looked for between steps
        |MOST_EVENTS = 1_000_000
        |
        |
        |def simulate():
        |    """Times in steps of STEP, s, and the state at each."""
        |    times = sample_times()
        |    states = np.empty((len(times), @entries@))
        |    t, y, done = 0.0, first_state(), 0
        |    end = stretch_end(t)
        |    region = settled(t, y, (t + end) / 2)
        |    for _ in range(MOST_EVENTS):
        |        ends = exits(region)
        |        for function in ends.values():
        |            function.terminal, function.direction = True, -1
        |        run = solve_ivp(
        |            lambda t, y: slope(t, y, region), (t, end), y, method="DOP853", rtol=ACCURACY, atol=SMALLEST,
        |            max_step=MAX_STEP, events=list(ends.values()), dense_output=True,
        |        )
        |        if run.status < 0:
        |            raise SystemExit(f"solve_ivp at t = {run.t[-1]} s: {run.message}")
        |        t, y = run.t[-1], run.y[:, -1].copy()
        |        reached = np.searchsorted(times, t, side="right")
        |        if reached > done:
        |            states[done:reached] = run.sol(times[done:reached]).T
        |            done = reached
        |        if run.status == 1:
        |            kind = next(kind for kind, found in zip(ends, run.t_events) if len(found))
        |            region = after(kind, t, y, region)
        |        elif t >= DURATION:
        |            return times, states
        |        else:  # the next stretch of the input
        |            end = stretch_end(t)
        |            region = settled(t, y, (t + end) / 2@region_contact@)
        |    raise SystemExit(f"more than {MOST_EVENTS} events up to t = {t} s")
"#;
