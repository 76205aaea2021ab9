"""The sticking scene by Python peers: SciPy's solve_ivp with events and the same mode machine as the Rust peers
(src/scene.rs), and the fixed-step loop that people write, in numba.

    python peers.py REFERENCE [--plain]

REFERENCE holds theta of the exact solution, one sample a line. Writes the same tab-separated rows as
`zwidth-peers measure`. With --plain also SciPy's RK45 on the plain right-hand side, which chatters: minutes.
"""

import math
import sys
import time
import warnings

import numba
import numpy as np
import scipy
from scipy.integrate import solve_ivp

MASS, STIFFNESS, DAMPING, REST = 0.005, 4.0, 1.0, -math.pi / 4
MOTOR, BRAKE = 3.25, 13.0
MAGNITUDE, OMEGA = 2.15, math.pi / 2
STEP_S, SAMPLES = 0.0083, 482
TIMES = np.arange(SAMPLES) * STEP_S
END_S = TIMES[-1]

FORWARD, SATURATED, BACKWARD, STICK = range(4)

TARGETS_RAD = [1e-6, 1e-10]
TOLERANCES = [m * 10.0**-e for e in range(3, 14) for m in (1.0, 0.3)]
LARGEST_STEPS_S = [math.inf, 0.016]
# A method is not tuned to finer tolerances once a run takes longer than this, s.
TOO_SLOW_S = 1.0
ROUNDS = 3
# The scene has five phases; a coarse tolerance may find some more.
MOST_PHASES = 20


def push(t):
    return MAGNITUDE + MAGNITUDE * math.sin(OMEGA * t)


def law(phase):
    """Stiffness, damping and constant part of the actuators' resisting force."""
    return (0.0, 0.0, MOTOR) if phase == SATURATED else (STIFFNESS, DAMPING, -STIFFNESS * REST)


def slope(phase, sine_joins):
    k, b, c = law(phase)
    if sine_joins:
        def joined(t, y):
            x, v, s, r = y.tolist()
            return [v, (MAGNITUDE + s - k * x - b * v - c) / MASS, r, -OMEGA * OMEGA * s]
        return joined

    def evaluated(t, y):
        x, v = y.tolist()
        return [v, (push(t) - k * x - b * v - c) / MASS]
    return evaluated


def jacobian(phase, sine_joins):
    k, b, _ = law(phase)
    if sine_joins:
        rows = [[0, 1, 0, 0], [-k / MASS, -b / MASS, 1 / MASS, 0], [0, 0, 0, 1], [0, 0, -OMEGA * OMEGA, 0]]
    else:
        rows = [[0, 1], [-k / MASS, -b / MASS]]
    return np.array(rows, dtype=float)


def full(t, y, sine_joins):
    swing = [MAGNITUDE * math.sin(OMEGA * t), MAGNITUDE * OMEGA * math.cos(OMEGA * t)]
    return list(y) + (swing if sine_joins else [])


def ending(f):
    """An event that ends a phase where f falls through 0."""
    f.terminal, f.direction = True, -1
    return f


def below_limit(y):
    return MOTOR - STIFFNESS * (y[0] - REST) - DAMPING * y[1]


GUARDS = {
    FORWARD: [ending(lambda t, y: y[1])],
    SATURATED: [ending(lambda t, y: -y[1]), ending(lambda t, y: -below_limit(y))],
    BACKWARD: [ending(lambda t, y: -y[1]), ending(lambda t, y: below_limit(y))],
}


def spring(theta):
    return STIFFNESS * (theta - REST)


def backward(theta):
    return SATURATED if spring(theta) > MOTOR else BACKWARD


def at_rest(t, theta):
    if push(t) > spring(theta):
        return FORWARD
    return backward(theta) if push(t) < min(spring(theta), MOTOR) else STICK


def next_time(t, force, falling):
    if abs(force / MAGNITUDE - 1.0) > 1.0:
        return math.inf
    angle = math.asin(force / MAGNITUDE - 1.0)
    first = math.pi - angle if falling else angle
    return t + (first - OMEGA * t) % math.tau / OMEGA


def release(t, theta):
    rises = next_time(t, spring(theta), False)
    falls = next_time(t, min(spring(theta), MOTOR), True)
    return (rises, FORWARD) if rises < falls else (falls, backward(theta))


def run(method, tolerance, largest_step_s, sine_joins):
    """theta and theta_dot at every sample, and the number of evaluations."""
    out = np.zeros((2, SAMPLES))
    t, y, phase, evaluations, done = 0.0, [REST, 0.0], FORWARD, 0, 0
    phases = 0
    while done < SAMPLES:
        phases += 1
        if phases > MOST_PHASES:
            raise ArithmeticError("an event is found again and again at the same time")
        if phase == STICK:
            t, phase = release(t, y[0])
            until = int(np.searchsorted(TIMES, t))
            out[0, done:until] = y[0]
            done = until
            continue
        options = {}
        if method in ("Radau", "BDF"):
            options["jac"] = jacobian(phase, sine_joins)
        elif method == "LSODA":
            constant = jacobian(phase, sine_joins)
            options["jac"] = lambda t, y: constant
        solution = solve_ivp(
            slope(phase, sine_joins), (t, END_S), full(t, y, sine_joins), method, TIMES[done:],
            events=GUARDS[phase], rtol=tolerance, atol=tolerance, max_step=largest_step_s, **options)
        if solution.status < 0:
            raise ArithmeticError(solution.message)
        found = len(solution.t)
        if found:  # a phase may end before its first sample
            out[:, done:done + found] = solution.y[:2]
        done += found
        evaluations += solution.nfev
        if solution.status == 0:
            break
        guard = next(i for i, times in enumerate(solution.t_events) if times.size)
        t, y = float(solution.t_events[guard][0]), solution.y_events[guard][0, :2].tolist()
        if guard == 0:
            y[1] = 0.0
            phase = at_rest(t, y[0])
        else:
            phase = BACKWARD if phase == SATURATED else SATURATED
    return out, evaluations


@numba.njit
def resisting(theta, theta_dot):
    """Brake forward, motor backward: switched on the sign of the velocity, at every stage."""
    u = STIFFNESS * (theta - REST) + DAMPING * theta_dot
    if theta_dot > 0.0:
        return min(max(u, 0.0), BRAKE)
    return min(max(u, -MOTOR), MOTOR)


@numba.njit
def acceleration(t, theta, theta_dot):
    return (MAGNITUDE + MAGNITUDE * math.sin(OMEGA * t) - resisting(theta, theta_dot)) / MASS


@numba.njit
def loop(steps):
    """RK4 with so many steps a sample."""
    out = np.zeros((2, SAMPLES))
    x, v = REST, 0.0
    h = STEP_S / steps
    out[0, 0] = x
    for i in range(1, SAMPLES):
        for j in range(steps):
            t = ((i - 1) * steps + j) * h
            a1 = acceleration(t, x, v)
            v2 = v + 0.5 * h * a1
            a2 = acceleration(t + 0.5 * h, x + 0.5 * h * v, v2)
            v3 = v + 0.5 * h * a2
            a3 = acceleration(t + 0.5 * h, x + 0.5 * h * v2, v3)
            v4 = v + h * a3
            a4 = acceleration(t + h, x + h * v3, v4)
            x += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4)
            v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
        out[0, i], out[1, i] = x, v
    return out


def timed(work):
    start = time.perf_counter()
    result = work()
    return result, time.perf_counter() - start


def sweep(method, reference):
    """Time, setting, error and evaluations of the settings of a method, the coarsest tolerance first, until the
    finest target is reached with some to spare or runs become too slow."""
    for tolerance in TOLERANCES:
        least_error = least_seconds = math.inf
        for largest in LARGEST_STEPS_S:
            for joins in (False, True):
                setting = (tolerance, largest, joins)
                try:
                    (out, evaluations), seconds = timed(lambda: run(method, *setting))
                except ArithmeticError:
                    continue
                error = np.abs(out[0] - reference).max()
                if error <= max(TARGETS_RAD):
                    seconds = min(seconds, *(timed(lambda: run(method, *setting))[1] for _ in range(2)))
                least_error, least_seconds = min(least_error, error), min(least_seconds, seconds)
                yield seconds, setting, error, evaluations
        if least_error < 0.03 * min(TARGETS_RAD) or TOO_SLOW_S < least_seconds < math.inf:
            return


def best(method, settings, target):
    """The fastest setting whose error is below the target, or None. The six that came first are timed again."""
    good = sorted(entry for entry in settings if entry[2] <= target)[:6]
    again = [(min(timed(lambda: run(method, *entry[1]))[1] for _ in range(5)), *entry[1:]) for entry in good]
    return min(again, default=None)


def tune_loop(target, reference):
    """The fewest steps a sample, to about 10 %, with which the loop's error is below the target."""
    steps = 64
    while np.abs(loop(steps)[0] - reference).max() > target:
        steps = steps * 2
    low, high = steps // 2, steps
    while high > 1.1 * low:
        middle = (low + high) // 2
        low, high = (low, middle) if np.abs(loop(middle)[0] - reference).max() <= target else (middle, high)
    return high, np.abs(loop(high)[0] - reference).max()


def plain(target, reference):
    """SciPy's RK45 on the plain right-hand side."""
    def chattering(t, y):
        x, v = y.tolist()
        u = STIFFNESS * (x - REST) + DAMPING * v
        force = min(max(u, 0.0), BRAKE) if v > 0.0 else min(max(u, -MOTOR), MOTOR)
        return [v, (push(t) - force) / MASS]
    solution, seconds = timed(lambda: solve_ivp(
        chattering, (0.0, END_S), [REST, 0.0], "RK45", TIMES, rtol=target, atol=target))
    return np.abs(solution.y[0] - reference).max(), solution.nfev, seconds


def row(*cells):
    print("\t".join(str(cell) for cell in cells), flush=True)


def main():
    warnings.filterwarnings("ignore")  # tolerances below what a method can reach
    reference = np.loadtxt(sys.argv[1])
    peer = f"SciPy {scipy.__version__}"
    tuned = []
    for method in ("RK45", "DOP853", "Radau", "BDF", "LSODA"):
        settings = list(sweep(method, reference))
        for target in TARGETS_RAD:
            found = best(method, settings, target)
            if found is None:
                row(peer, method, "", target, "", "", "", "", "", "", "not reached")
            else:
                tuned.append((method, target, *found[1:]))
    steps, error = tune_loop(TARGETS_RAD[0], reference)
    works = [lambda m=method, s=setting: run(m, *s) for method, _, setting, _, _ in tuned]
    works.append(lambda: loop(steps))
    passes = [[math.inf] * len(works) for _ in range(2)]
    for least in passes:
        for _ in range(ROUNDS):
            for i, work in enumerate(works):
                least[i] = min(least[i], timed(work)[1], timed(work)[1])
    for (method, target, (tolerance, largest, joins), found, evaluations), *seconds in zip(tuned, *passes):
        sine = "in the state" if joins else "evaluated"
        largest = "" if math.isinf(largest) else largest
        row(peer, method, sine, target, f"{tolerance:.0e}", largest, found, evaluations, *seconds, "")
    seconds = [least[-1] for least in passes]
    row(f"numba {numba.__version__}", "RK4 loop, switches on the sign", "evaluated", TARGETS_RAD[0], "",
        STEP_S / steps, error, 4 * steps * (SAMPLES - 1), *seconds, "chatters")
    if "--plain" in sys.argv[2:]:
        error, evaluations, seconds = plain(TARGETS_RAD[0], reference)
        row(peer, "RK45, plain right-hand side", "evaluated", TARGETS_RAD[0], "1e-06", "", error, evaluations,
            seconds, "", "chatters")


main()
