"""The model of a trial (M L theta'' = F_O + F_ex - B theta' - dry friction) and its replay in three causalities by
SciPy."""

from bisect import bisect_right

import numpy as np
import pandas as pd
from scipy import stats
from scipy.integrate import cumulative_trapezoid, solve_ivp

import metrics

# Mass, damping, friction, and the lags of the motor, of the brake going on, and of it going off.
BY_EYE = (0.1, 1.0, 0.0, 0.0, 0.0, 0.0)
# The coarsest that keep theta within 1e-6 rad of the exact solution on the trials here: at once, and with lags.
TOLERANCES = dict(rtol=1e-6, atol=1e-8), dict(rtol=1e-7, atol=1e-9)
# The force's own updates.
MAX_STEP_S = 0.0125
# A shorter lag is none.
LEAST_LAG_S = 1e-6
FORWARD, BACKWARD, REST = 1, -1, 0


def ending(function, direction):
    function.terminal, function.direction = True, direction
    return function


def central_differences(t, y):
    """np.gradient, but exactly 0 for a lever that stands still: the model switches on the velocity's sign."""
    h = np.diff(t)
    s = np.diff(y) / h
    return np.r_[s[0], (h[:-1] * s[1:] + h[1:] * s[:-1]) / (h[:-1] + h[1:]), s[-1]]


class Trial:
    """A trial made ready: its force as straight lines between the sensor's updates, and what its mode can do."""

    def __init__(self, frame, meta, study):
        self.meta, self.study = meta, study
        t = frame.t_s.to_numpy()
        self.t, self.theta = t - t[0], frame.theta_rad.to_numpy()
        self.began, self.velocity, self.frame = t[0], frame.theta_dot_rad_s.to_numpy(), frame
        update_t, update_f = metrics.force_updates(frame.assign(t_s=self.t))
        later = update_t > 0
        self.update_t = np.r_[0.0, update_t[later]]
        self.update_f = np.r_[np.interp(0.0, update_t, update_f), update_f[later]]
        self.force = np.interp(self.t, self.update_t, self.update_f)
        self.knots = self.update_t.tolist(), self.update_f.tolist()
        environment, mode, device = study["environment"][meta["environment"]], study["mode"][meta["mode"]], study["device"]
        self.lever, self.let_go = device["lever_m"], study["control"]["let_go_n"]
        self.stops = np.radians([device["theta_min_deg"], device["theta_max_deg"]])
        self.k, self.rest = environment["stiffness_n_per_rad"], environment["rest_rad"]
        self.wall = np.inf if environment["wall_rad"] is None else environment["wall_rad"]
        self.calibration = study["calibration"]
        self.motor_n = float(self.calibration["motor"](mode.get("motor_max_v", 0.0)))
        self.brake_n = float(self.calibration["brake"](mode.get("brake_max_v", 0.0)))
        self.hybrid = "motor_max_v" in mode and "brake_max_v" in mode
        self.brake_only = "motor_max_v" not in mode

    def feedback(self, theta, side, past):
        """Force of the motor and level of the brake on a side, above 0 against a push. Works on arrays too."""
        u = self.k * (theta - self.rest)
        if self.brake_only or (self.hybrid and side == FORWARD):
            return 0.0 * u, np.where(past, self.brake_n, np.clip(u, 0.0, self.brake_n))
        return np.where(past, self.motor_n, np.clip(u, -self.motor_n, self.motor_n)), 0.0 * u

    # --- force-driven -----------------------------------------------------------------------------------------------

    def force_at(self, t):
        """What np.interp does, five times as fast for one number."""
        ts, fs = self.knots
        i = bisect_right(ts, t)
        if i == len(ts):
            return fs[-1]
        return fs[i - 1] + (fs[i] - fs[i - 1]) * (t - ts[i - 1]) / (ts[i] - ts[i - 1])

    def force_driven(self, plant):
        """theta, theta' and feedback: phases of motion and rest, with events between them."""
        return self.lagging(plant) if max(plant[3:]) >= LEAST_LAG_S else self.at_once(plant)

    def at_once(self, plant):
        """Of actuators without lags."""
        mass, damping, friction, *_ = plant
        inertia, times = mass * self.lever, self.t
        out = np.empty((3, len(times)))
        t, done = 0.0, 0
        y = np.array([np.clip(self.theta[0], *self.stops), self.velocity[0]])
        phase = None
        while done < len(times):
            if phase is None:
                phase = self.leaving(t, y[0], friction) if y[1] == 0.0 else int(np.sign(y[1]))
            if phase == REST:
                end, phase = self.release(t, y[0], friction)
                until = max(done, int(np.searchsorted(times, end)))
                at_rest = np.full(until - done, y[0])
                out[:, done:until] = at_rest, 0 * at_rest, self.held(at_rest, times[done:until])
                t, done = end, until
                continue
            past = y[0] >= self.wall if phase == FORWARD else y[0] > self.wall
            slope, events = self.phase(phase, past, inertia, damping, friction)
            solution = solve_ivp(slope, (t, times[-1]), y, "LSODA", times[done:], events=events,
                                 **TOLERANCES[0], max_step=MAX_STEP_S)
            if solution.status < 0:
                raise ArithmeticError(solution.message)
            found = solution.y if len(solution.t) else np.empty((2, 0))
            until = done + found.shape[1]
            out[:2, done:until] = found
            motor, level = self.feedback(found[0], phase, past)
            out[2, done:until] = motor + phase * level
            done = until
            if solution.status == 0:
                break
            event = next(i for i, e in enumerate(solution.t_events) if e.size)
            t, y = solution.t_events[event][0], solution.y_events[event][0].copy()
            phase = None
            if event == 0:  # the lever comes to rest
                y[1] = 0.0
            elif event == 1:  # a stop
                y[:] = self.stops[1] if y[1] > 0 else self.stops[0], 0.0
            else:  # the wall
                y[0] = self.wall if y[1] > 0 else np.nextafter(self.wall, -np.inf)
        return out

    def phase(self, phase, past, inertia, damping, friction):
        k, rest, most = self.k, self.rest, self.motor_n
        force_at = self.force_at
        by_brake = self.brake_only or (self.hybrid and phase == FORWARD)
        low, high = (0.0, self.brake_n) if by_brake else (-most, most)
        sign = phase if by_brake else 1.0
        dry = phase * friction

        def slope(t, y):
            x, v = y
            u = high if past else min(max(k * (x - rest), low), high)
            return v, (force_at(t) - sign * u - dry - damping * v) / inertia

        stop = self.stops[1] if phase == FORWARD else self.stops[0]
        events = [ending(lambda t, y: y[1], -phase), ending(lambda t, y: y[0] - stop, phase)]
        if np.isfinite(self.wall) and past != (phase == FORWARD):
            wall = self.wall
            events.append(ending(lambda t, y: y[0] - wall, phase))
        return slope, events

    def limits(self, theta, friction):
        """Forces of the user beyond which a lever at rest leaves, backward and forward."""
        motor, level = self.feedback(theta, BACKWARD, theta > self.wall)
        low = motor - level - friction
        motor, level = self.feedback(theta, FORWARD, theta >= self.wall)
        high = motor + level + friction
        if self.hybrid:
            low = min(low, self.let_go)
        if theta <= self.stops[0]:
            low = -np.inf
        if theta >= self.stops[1]:
            high = np.inf
        return float(low), float(high)

    def leaving(self, t, theta, friction):
        low, high = self.limits(theta, friction)
        force = self.force_at(t)
        return BACKWARD if force < low else FORWARD if force > high else REST

    def release(self, t, theta, friction):
        """When a lever at rest leaves, and where to."""
        low, high = self.limits(theta, friction)
        later = self.update_t > t
        ts = np.r_[t, self.update_t[later]]
        fs = np.r_[np.interp(t, self.update_t, self.update_f), self.update_f[later]]
        out = np.flatnonzero((fs[1:] < low) | (fs[1:] > high))
        if not out.size:
            return np.inf, REST
        i = out[0] + 1
        side = FORWARD if fs[i] > high else BACKWARD
        level = high if side == FORWARD else low
        share = (level - fs[i - 1]) / (fs[i] - fs[i - 1])
        return ts[i - 1] + max(share, 0.0) * (ts[i] - ts[i - 1]), side

    def held(self, theta, times):
        """Feedback of a lever at rest: what is needed, within what the actuators give on either side."""
        if not len(theta):
            return theta
        motor, level = self.feedback(theta[0], BACKWARD, theta[0] > self.wall)
        below = motor - level
        motor, level = self.feedback(theta[0], FORWARD, theta[0] >= self.wall)
        above = motor + level
        needed = np.interp(times, self.update_t, self.update_f)
        return np.clip(needed, min(above, below), max(above, below))

    # --- force-driven, with actuators that lag -------------------------------------------------------------------------

    def lagging(self, plant):
        """As above; the motor's force and the brake's level are states that follow what they are asked for."""
        friction, times = plant[2], self.t
        out = np.empty((3, len(times)))
        t, done, phase, held = 0.0, 0, None, None
        y = np.array([np.clip(self.theta[0], *self.stops), self.velocity[0], 0.0, 0.0])
        while done < len(times):
            if phase is None:
                held = self.holds(t) if held is None else held
                phase = self.leaving_lagging(t, y, friction, held) if y[1] == 0.0 else int(np.sign(y[1]))
            slope, events = self.phase_lagging(phase, held, y[0], plant)
            solution = solve_ivp(slope, (t, times[-1]), y, "LSODA", times[done:], events=[e for _, e in events],
                                 **TOLERANCES[1], max_step=MAX_STEP_S)
            if solution.status < 0:
                raise ArithmeticError(solution.message)
            found = solution.y if len(solution.t) else np.empty((4, 0))
            until = done + found.shape[1]
            out[:2, done:until] = found[:2]
            motor, level = found[2:]
            needed = np.interp(times[done:until], self.update_t, self.update_f)
            resting = np.clip(needed, -motor - level, level - motor)
            out[2, done:until] = resting if phase == REST else phase * level - motor
            done = until
            if solution.status == 0:
                break
            i = next(i for i, e in enumerate(solution.t_events) if e.size)
            t, y = solution.t_events[i][0], solution.y_events[i][0].copy()
            event, held, phase = events[i][0], not held if events[i][0] == "let_go" else None, None
            if event == "rest":
                y[1] = 0.0
            elif event == "stop":
                y[:2] = self.stops[1] if y[1] > 0 else self.stops[0], 0.0
            elif event == "wall":
                y[0] = self.wall
            elif event in (FORWARD, BACKWARD):
                phase = event
        return out

    def holds(self, t):
        """Whether the user's force keeps the brake on at rest."""
        return self.hybrid and self.force_at(t) >= self.let_go

    def leaving_lagging(self, t, y, friction, held):
        """Where a lever at rest goes."""
        theta, _, motor, level = y
        force = self.force_at(t) + motor
        if theta > self.stops[0] and not held and force + level + friction < 0:
            return BACKWARD
        return FORWARD if theta < self.stops[1] and force - level - friction > 0 else REST

    def phase_lagging(self, phase, held, theta, plant):
        """Slope of (theta, theta', motor, level) in a phase, and the events that end it, by name."""
        mass, damping, friction, *lags = plant
        motor_lag, on, off = np.maximum(lags, LEAST_LAG_S).tolist()
        k, rest, inertia, force_at = self.k, self.rest, mass * self.lever, self.force_at
        up = phase == FORWARD or (phase == REST and held)
        past = theta >= self.wall if up else theta > self.wall
        by_brake = self.brake_only or (self.hybrid and up)
        low, high = (0.0, self.brake_n) if by_brake else (-self.motor_n, self.motor_n)
        brake_lag = on if by_brake else off

        def slope(t, y):
            x, v, motor, level = y
            u = high if past else min(max(k * (x - rest), low), high)
            asked_motor, asked_level = (0.0, u) if by_brake else (-u, 0.0)
            moved = 0.0, 0.0
            if phase != REST:
                moved = v, (force_at(t) + motor - phase * (level + friction) - damping * v) / inertia
            return *moved, (asked_motor - motor) / motor_lag, (asked_level - level) / brake_lag

        if phase != REST:
            stop = self.stops[1] if phase == FORWARD else self.stops[0]
            events = [("rest", ending(lambda t, y: y[1], -phase)), ("stop", ending(lambda t, y: y[0] - stop, phase))]
            if np.isfinite(self.wall) and past != up:
                events.append(("wall", ending(lambda t, y: y[0] - self.wall, phase)))
            return slope, events
        events = []
        if theta < self.stops[1]:
            events.append((FORWARD, ending(lambda t, y: force_at(t) + y[2] - y[3] - friction, 1)))
        if theta > self.stops[0] and not held:
            events.append((BACKWARD, ending(lambda t, y: force_at(t) + y[2] + y[3] + friction, -1)))
        if self.hybrid:
            events.append(("let_go", ending(lambda t, y: force_at(t) - self.let_go, -1 if held else 1)))
        return slope, events

    # --- the other causalities ----------------------------------------------------------------------------------------

    def position_driven(self, plant):
        mass, damping, friction, *_ = plant
        velocity = central_differences(self.t, self.theta)
        acceleration = central_differences(self.t, velocity)
        forward, past = velocity > 0, self.theta >= self.wall
        motor_up, level_up = self.feedback(self.theta, FORWARD, past)
        motor_down, level_down = self.feedback(self.theta, BACKWARD, past)
        resisting = np.where(forward, motor_up + level_up + friction, motor_down - level_down - friction)
        return mass * self.lever * acceleration + resisting + damping * velocity

    def closed_loop(self, plant):
        """The plant alone: between samples all forces are held, so that theta' relaxes exponentially."""
        mass, damping, friction, *_ = plant
        tau = mass * self.lever / damping
        grid = np.union1d(self.t, self.update_t)
        whole = np.interp(grid, self.update_t, self.update_f)
        impulse = cumulative_trapezoid(whole, grid, initial=0)
        impulse = impulse[np.searchsorted(grid, self.t)]
        step = np.diff(self.t)
        motor = self.calibration["motor"](self.frame.voltage_motor_v.to_numpy(dtype=float))[:-1]
        hold = np.abs(self.calibration["brake"](self.frame.voltage_brake_v.to_numpy(dtype=float)))[:-1] + friction
        push = motor + np.diff(impulse) / step
        low, high = self.stops
        x, v = float(np.clip(self.theta[0], low, high)), 0.0
        theta, theta_dot = np.empty_like(self.t), np.zeros_like(self.t)
        theta[0] = x
        for i, h in enumerate(step):
            left = h
            while left > 0:
                if v == 0.0:
                    if abs(push[i]) <= hold[i] or (x >= high and push[i] > 0) or (x <= low and push[i] < 0):
                        break
                    sign = np.sign(push[i])
                else:
                    sign = np.sign(v)
                final = (push[i] - sign * hold[i]) / damping
                turns = -tau * np.log(final / (final - v)) if final * sign < 0 and v != 0.0 else np.inf
                dt = min(left, turns)
                decay = np.exp(-dt / tau)
                x += final * dt + (v - final) * tau * (1 - decay)
                v = 0.0 if turns <= left else final + (v - final) * decay
                if x > high or x < low:
                    x, v = min(max(x, low), high), 0.0
                left -= dt
            theta[i + 1], theta_dot[i + 1] = x, v
        return theta, theta_dot


# --- replay -----------------------------------------------------------------------------------------------------------

def lag(t, recorded, model):
    steps = min(len(t) - 1, int((t[-1] - t[0]) / 0.005))
    step = (t[-1] - t[0]) / steps
    grid = np.linspace(t[0], t[-1], steps + 1)
    recorded, model = np.interp(grid, t, recorded), np.interp(grid, t, model)
    most = min(int(0.5 / step), steps // 2)
    if np.ptp(recorded) == 0 or np.ptp(model) == 0:
        return np.nan

    def at(shift):
        a = recorded[max(-shift, 0):len(recorded) - max(shift, 0)]
        b = model[max(shift, 0):len(model) - max(-shift, 0)]
        a, b = a - a.mean(), b - b.mean()
        return a @ b / np.sqrt((a @ a) * (b @ b))

    shifts = np.arange(-most, most + 1)
    r = np.array([at(s) for s in shifts])
    best = int(np.nanargmax(r))
    if best in (0, len(r) - 1):
        return np.nan
    curvature = r[best - 1] - 2 * r[best] + r[best + 1]
    return (shifts[best] + (r[best - 1] - r[best + 1]) / (2 * curvature)) * step


def reversal_of(theta, velocity, trial):
    frame = pd.DataFrame({"theta_rad": theta, "theta_dot_rad_s": velocity})
    try:
        return trial.t[metrics.movement_of(frame, trial.study["analysis"])[1]]
    except IndexError:  # it never moves
        return np.nan


def replay(trial):
    """One row a causality."""
    turned = reversal_of(trial.theta, trial.velocity, trial)
    rows = []
    for causality in ("force_driven", "position_driven", "closed_loop"):
        if causality == "force_driven":
            model, velocity, _ = trial.force_driven(BY_EYE)
        elif causality == "position_driven":
            model, velocity = trial.position_driven(BY_EYE), None
        else:
            model, velocity = trial.closed_loop(BY_EYE)
        recorded = trial.force if causality == "position_driven" else trial.theta
        unit = "n" if causality == "position_driven" else "rad"
        error = model - recorded
        row = dict(trial.meta, causality=causality, outcome="replayed", mass_kg=BY_EYE[0],
                   damping_n_s_per_rad=BY_EYE[1], friction_n=BY_EYE[2])
        rmse = np.sqrt(np.mean(error ** 2))
        peak, model_peak = int(np.argmax(recorded)), int(np.argmax(model))
        row |= {"nrmse": rmse / np.ptp(recorded), "vaf": 1 - error.var() / recorded.var(),
                "lag_s": lag(trial.t, recorded, model), f"rmse_{unit}": rmse,
                f"peak_recorded_{unit}": recorded[peak], f"peak_error_{unit}": model[model_peak] - recorded[peak],
                "peak_time_recorded_s": trial.t[peak] + trial.began,
                "peak_time_error_s": trial.t[model_peak] - trial.t[peak],
                "reversal_recorded_s": turned + trial.began,
                "reversal_error_s": np.nan if velocity is None else reversal_of(model, velocity, trial) - turned}
        rows.append(row)
    return rows


def agreement(replays, level):
    """Bland-Altman limits, one value a trial."""
    rows = []
    quantities = [("peak_error_rad", "peak angle", "rad"), ("peak_error_n", "peak force", "N"),
                  ("peak_time_error_s", "time of the peak", "s"), ("reversal_error_s", "time of the reversal", "s")]
    for causality in ("force_driven", "position_driven", "closed_loop"):
        for mode in replays["mode"].unique():
            mine = replays[(replays.causality == causality) & (replays["mode"] == mode)]
            for column, quantity, unit in quantities:
                d = mine[column].dropna()
                if d.empty:
                    continue
                n, sd = len(d), d.std()
                t = stats.t.ppf(0.5 + level / 2, n - 1)
                row = dict(causality=causality, mode=mode, quantity=quantity, unit=unit, n=n)
                places = [("bias", 0.0, sd / np.sqrt(n))]
                limit_error = sd * np.sqrt(1 / n + 1.96 ** 2 / (2 * (n - 1)))
                places += [("limit_low", -1.96, limit_error), ("limit_high", 1.96, limit_error)]
                for name, sds, error in places:
                    value = d.mean() + sds * sd
                    row |= {name: value, f"{name}_ci_low": value - t * error, f"{name}_ci_high": value + t * error}
                rows.append(row)
    return pd.DataFrame(rows)
