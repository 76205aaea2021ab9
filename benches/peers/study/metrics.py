"""Averages of repeats and the metrics of a trial, as docs/analysis.md defines them. One trial is a data frame."""

import numpy as np
import pandas as pd
from scipy import stats
from scipy.integrate import trapezoid

BRAKE_ON, MOTOR_ON = 128, 256


def force_updates(trial):
    """Times at which the force sensor had new values, and the values."""
    t, age = trial.t_s.to_numpy(), trial.force_age_s.to_numpy(dtype=float)
    new = np.r_[True, age[1:] < age[:-1] + np.diff(t) / 2]
    taken, values = (t - age)[new], trial.force_ex_n.to_numpy()[new]
    later = np.r_[True, taken[1:] > np.maximum.accumulate(taken)[:-1]]
    return taken[later], values[later]


def movement_of(trial, analysis):
    """Onset, reversal and end of the movement as indices; whether the end was seen."""
    speed = trial.theta_dot_rad_s.abs().to_numpy()
    moving = np.flatnonzero(speed > np.radians(analysis["onset_deg_s"]))
    onset, last = moving[0], moving[-1]
    slow = np.flatnonzero(speed[last:] < np.radians(analysis["offset_deg_s"]))
    end = last + slow[0] if slow.size else len(speed) - 1
    reversal = onset + int(np.argmax(trial.theta_rad.to_numpy()[onset:end + 1]))
    return onset, reversal, end, bool(slow.size)


def return_begins(velocity, reversal, end, analysis):
    """From where on the lever stays on its way back until it is fast; None if it never is."""
    onset, offset = (np.radians(analysis[f"{name}_deg_s"]) for name in ("onset", "offset"))
    begins = None
    for i in range(reversal, end + 1):
        begins = (i if begins is None else begins) if velocity[i] < -offset else None
        if velocity[i] < -onset:
            return begins
    return None


def first_passing(t, x, level):
    past = np.flatnonzero(x > level)
    if not past.size or past[0] == 0:
        return np.nan
    i = past[0]
    return t[i - 1] + (level - x[i - 1]) / (x[i] - x[i - 1]) * (t[i] - t[i - 1])


# --- averages -------------------------------------------------------------------------------------------------------

QUANTITIES = {"theta_rad": "theta_{}_rad", "theta_dot_rad_s": "theta_dot_{}_rad_s",
              "force_ex_n": "force_ex_{}_n", "force_cmd_n": "force_cmd_{}_n"}


def average(trials, environment, analysis, alignment):
    """Mean, SD and pointwise t band of a condition's repeats on a common grid."""
    times, marks = [], []
    for trial in trials:
        t, theta = trial.t_s.to_numpy(), trial.theta_rad.to_numpy()
        onset, reversal, end, _ = movement_of(trial, analysis)
        wall = first_passing(t, theta, environment["wall_rad"]) if environment["wall_rad"] is not None else np.nan
        back = return_begins(trial.theta_dot_rad_s.to_numpy(), reversal, end, analysis)
        times.append(t - t[onset])
        marks.append(np.array([t[onset], wall, t[reversal], np.nan if back is None else t[back], t[end]]) - t[onset])
    if alignment == "landmarks":
        marks = np.array(marks)
        keep = [0]
        for k in (1, 2, 3):
            if np.all((marks[:, k] > marks[:, keep[-1]]) & (marks[:, k] < marks[:, 4])):
                keep.append(k)
        keep.append(4)
        common = marks[:, keep].mean(axis=0)
        for i, own in enumerate(marks[:, keep]):
            t = times[i]
            shift = np.where(t < own[0], common[0] - own[0], common[-1] - own[-1])
            inside = (t >= own[0]) & (t < own[-1])
            times[i] = np.where(inside, np.interp(t, own, common), t + shift)
    lengths = np.sort([t[-1] for t in times])[::-1]
    half = lengths[(len(lengths) + 1) // 2 - 1]
    grid = np.linspace(0.0, lengths[lengths >= half * (1 - 1e-9)].min(), analysis["grid_points"])
    columns = {"t_s": grid, "n": np.sum([t[-1] >= grid for t in times], axis=0)}
    for source, name in QUANTITIES.items():
        rows = np.array([np.interp(grid, t, trial[source], right=np.nan) for t, trial in zip(times, trials)])
        n = np.sum(~np.isnan(rows), axis=0)
        mean, sd = np.nanmean(rows, axis=0), np.nanstd(rows, axis=0, ddof=1)
        half_width = stats.t.ppf(0.5 + analysis["confidence"] / 2, n - 1) * sd / np.sqrt(n)
        columns |= {name.format("mean"): mean, name.format("sd"): sd,
                    name.format("ci_low"): mean - half_width, name.format("ci_high"): mean + half_width}
    return pd.DataFrame(columns)


# --- metrics --------------------------------------------------------------------------------------------------------

def sparc(t, speed):
    """Spectral arc length (Balasubramanian 2015), Fourier integral on the recorded times."""
    if len(t) < 3:
        return np.nan
    rate = (len(t) - 1) / (t[-1] - t[0])
    step = rate / (16 * 2 ** int(np.ceil(np.log2(len(t)))))
    f = np.arange(int(10.0 / step) + 1) * step
    last = len(t) - 1
    weights = (t[np.minimum(np.arange(len(t)) + 1, last)] - t[np.maximum(np.arange(len(t)) - 1, 0)]) / 2
    amplitude = np.abs(np.exp(-2j * np.pi * np.outer(f, t - t[0])) @ (weights * speed))
    share = amplitude / amplitude[0]
    last = np.flatnonzero(share >= 0.05)[-1]
    return -np.sum(np.hypot(1 / last, np.diff(share[:last + 1])))


def zigzag(y, least):
    """Directions and first samples of the legs between turns of more than `least`."""
    starts, ups, leg_to = [], [], 0
    low = high = 0
    for i, value in enumerate(y):
        low, high = (i if value < y[low] else low), (i if value > y[high] else high)
        if not ups:
            if value - y[low] > least or y[high] - value > least:
                starts.append(0)
                ups.append(bool(value - y[low] > least))
                leg_to = i
        else:
            beyond = value - y[leg_to] if ups[-1] else y[leg_to] - value
            if beyond > 0:
                leg_to = i
            elif -beyond > least:
                starts.append(leg_to)
                ups.append(not ups[-1])
                leg_to = i
    return starts, ups


def arrivals(theta, limit, sign, retreat):
    beyond = sign * (theta - limit)
    state = np.where(beyond >= 0, 1, np.where(beyond < -retreat, -1, 0))
    known = state[state != 0]
    return int(np.sum((known[1:] == 1) & (known[:-1] == -1)))


def newey_west_fit(x, y, level):
    """Line with Newey-West errors, a tenth of the samples as lags, t with 9 df: rows of (estimate, se, low, high)."""
    X = np.column_stack([np.ones(len(y)), x]) if x is not None else np.ones((len(y), 1))
    if len(y) <= X.shape[1] or (x is not None and np.ptp(x) == 0):
        return None
    beta, *_ = np.linalg.lstsq(X, y, rcond=None)
    e = y - X @ beta
    scores, lags = X * e[:, None], len(y) // 10
    meat = scores.T @ scores
    for lag in range(1, lags + 1):
        gamma = scores[lag:].T @ scores[:-lag]
        meat += (1 - lag / (lags + 1)) * (gamma + gamma.T)
    inverse = np.linalg.inv(X.T @ X)
    se = np.sqrt(np.maximum(np.diag(inverse @ meat @ inverse), 0))
    half = stats.t.ppf(0.5 + level / 2, 9) * se
    return np.column_stack([beta, se, beta - half, beta + half]), e


def saturates_at(u, f):
    """Where a line ends in a plateau (Hudson 1966), or None."""
    order = np.argsort(u, kind="stable")
    u, f = u[order], f[order]
    n, best = len(u), None
    for at in range(10, n - 9):
        line = np.polynomial.polynomial.polyfit(u[:at], f[:at], 1)
        level = f[at:].mean()
        meets = (level - line[0]) / line[1]
        if not u[at - 1] <= meets <= u[at]:
            continue
        rss = np.sum((f[:at] - line[0] - line[1] * u[:at]) ** 2) + np.sum((f[at:] - level) ** 2)
        if best is None or rss < best[0]:
            best = rss, at, meets, line[1]
    if best is None:
        return None
    rss, at, meets, slope = best
    whole = np.polynomial.polynomial.polyfit(u, f, 1)
    whole_rss = np.sum((f - whole[0] - whole[1] * u) ** 2)
    top = np.polynomial.polynomial.polyfit(u[at:], f[at:], 1)[1]
    is_plateau = u[-1] - meets >= 0.05 * (u[-1] - u[0]) and top < 0.25 * slope and slope > 0 and rss <= 0.5 * whole_rss
    return meets if is_plateau else None


def band(t, y):
    """RMS, dominant frequency and top of the band 5...50 Hz, Welch on segments of 1 s at the recorded times."""
    rate = (len(t) - 1) / (t[-1] - t[0])
    top = next(f for f in range(50, 4, -1) if f < rate / 2)
    length = t[-1] - t[0]
    if length < 1.0:
        return np.nan, np.nan, np.nan
    hops = int(np.ceil((length - 1.0) / 0.5))
    hop = (length - 1.0) / hops if hops else 0.0
    frequencies, power = np.arange(4, top + 2), 0.0
    for k in range(hops + 1):
        start = t[0] + k * hop
        inside = (t >= start) & (t <= start + 1.0)
        ts, ys = t[inside], y[inside]
        ys = (ys - np.polyval(np.polyfit(ts, ys, 1), ts)) * (0.5 - 0.5 * np.cos(2 * np.pi * (ts - start)))
        weights = (np.r_[ts[1:], ts[-1]] - np.r_[ts[0], ts[:-1]]) / 2
        spectrum = np.exp(-2j * np.pi * np.outer(frequencies, ts - ts[0])) @ (weights * ys)
        power = power + 2 / (3 / 8 * (hops + 1)) * np.abs(spectrum) ** 2
    peak = 1 + int(np.argmax(power[1:-1]))
    dominant = np.nan
    if power[peak] > power[peak - 1]:
        ratio = np.sqrt(max(power[peak - 1], power[peak + 1]) / power[peak])
        offset = max((2 * ratio - 1) / (1 + ratio), 0.0)
        dominant = frequencies[peak] + (offset if power[peak + 1] > power[peak - 1] else -offset)
        dominant = np.clip(dominant, 5, top)
    return np.sqrt(power[1:-1].sum()), dominant, float(top)


def trial_metrics(trial, meta, study):
    analysis, device, environment = study["analysis"], study["device"], study["environment"][meta["environment"]]
    level, lever = analysis["confidence"], device["lever_m"]
    t, theta, velocity = (trial[c].to_numpy() for c in ("t_s", "theta_rad", "theta_dot_rad_s"))
    update_t, update_f = force_updates(trial)
    force = np.interp(t, update_t, update_f)
    onset, reversal, end, ended = movement_of(trial, analysis)
    there, back, moving = slice(onset, reversal + 1), slice(reversal, end + 1), slice(onset, end + 1)
    span, speed = np.ptp(theta), np.abs(velocity)
    low, high = np.radians(device["theta_min_deg"]), np.radians(device["theta_max_deg"])
    m = dict(meta)

    m["onset_s"], m["reversal_s"], m["end_s"] = t[onset], t[reversal], t[end] if ended else np.nan
    m["duration_s"], m["theta_max_rad"] = m["end_s"] - m["onset_s"], theta.max()
    for name, part in (("forward", there), ("backward", back)):
        duration = t[part][-1] - t[part][0]
        m[f"velocity_{name}_mean_rad_s"] = trapezoid(speed[part], t[part]) / duration if duration > 0 else np.nan
        m[f"velocity_{name}_peak_rad_s"] = speed[part].max()
        way = abs(theta[part][-1] - theta[part][0])
        m[f"sparc_{name}"] = sparc(t[part], speed[part]) if way > 0.1 * span else np.nan
    m["work_space_hits_low"] = arrivals(theta, low, -1, 0.01 * span)
    m["work_space_hits_high"] = arrivals(theta, high, 1, 0.01 * span)

    _, ups = zigzag(theta[moving], 0.1 * np.ptp(theta[moving]))
    mode = study["mode"][meta["mode"]]
    m["movements_forward"], m["movements_backward"] = sum(ups), len(ups) - sum(ups)
    brakes_only = "brake_max_v" in mode and "motor_max_v" not in mode
    m["protocol_one_movement"] = ups == [True, False] or (ups == [True] and brakes_only)
    m["protocol_in_time"] = t[end] - t[onset] <= study["design"]["trial_limit_s"]
    excess = 0.01 * (high - low)
    m["protocol_inside"] = theta.min() >= low - excess and theta.max() <= high + excess
    m["protocol_met"] = m["protocol_one_movement"] and m["protocol_in_time"] and m["protocol_inside"]

    m |= discrepancy(theta, force, (onset, reversal, end), analysis["grid_points"], lever, level)
    m |= spring(trial, theta, force, (onset, reversal, end), environment, level)
    m |= wall(t, theta, velocity, force, trial, environment["wall_rad"], lever, level)

    flags = trial["state_bits"].to_numpy()
    motor = (flags & MOTOR_ON != 0) | (trial.voltage_motor_v.to_numpy() != 0)
    brake = (flags & BRAKE_ON != 0) | (trial.voltage_brake_v.to_numpy() != 0)
    for name, state in (("motor", motor), ("brake", brake), ("actuator", motor + 2 * brake)):
        m[f"{name}_switches"] = int(np.sum(state[moving][1:] != state[moving][:-1]))
    starts, _ = zigzag(theta[moving], 0.002 * np.ptp(theta[moving]))
    turns = onset + np.array(starts[1:], dtype=int)
    gaps, sizes = np.diff(t[turns]), np.abs(np.diff(theta[turns]))
    fast = gaps < 0.1
    m["reversals"], m["fast_swings"] = len(turns), int(fast.sum())
    oscillates = fast.sum() >= 6
    m["recorded_stability"] = "oscillating" if oscillates else "smooth"
    m["oscillation_hz"] = fast.sum() / (2 * gaps[fast].sum()) if oscillates else np.nan
    m["oscillation_amplitude_rad"] = np.sort(sizes[fast])[fast.sum() // 2] if oscillates else np.nan
    inside = (update_t >= t[onset]) & (update_t <= t[end])
    m["force_band_rms_n"], m["force_band_dominant_hz"], m["force_band_top_hz"] = band(
        update_t[inside], update_f[inside])
    m["velocity_band_rms_rad_s"], m["velocity_band_dominant_hz"], m["velocity_band_top_hz"] = band(
        t[moving], velocity[moving])
    return m


def discrepancy(theta, force, phases, points, lever, level):
    onset, reversal, end = phases
    names = ["discrepancy_user_mean_n", "discrepancy_user_mean_ci_low_n", "discrepancy_user_mean_ci_high_n", "discrepancy_user_max_n",
             "discrepancy_user_step_n", "discrepancy_user_step_ci_low_n", "discrepancy_user_step_ci_high_n", "loop_area_j",
             "loop_area_ci_low_j", "loop_area_ci_high_j"]
    nothing = dict.fromkeys(names, np.nan)

    def advancing(x, f, sign, left):
        keep = sign * x > np.maximum.accumulate(np.r_[left, sign * x])[:-1]
        return (x[keep], f[keep]) if sign > 0 else (x[keep][::-1], f[keep][::-1])

    if reversal == end:
        return nothing
    x1, f1 = advancing(theta[onset:reversal + 1], force[onset:reversal + 1], 1, -np.inf)
    # The angle of the reversal is of the way there alone.
    x2, f2 = advancing(theta[reversal + 1:end + 1], force[reversal + 1:end + 1], -1, -theta[reversal])
    if not x2.size:
        return nothing
    low, high = max(x1[0], x2[0]), min(x1[-1], x2[-1])
    if high <= low or high - low < 0.1 * (x1[-1] - x1[0]):
        return nothing
    grid = low + (high - low) * np.linspace(0.0, 1.0, points)
    d = np.interp(grid, x1, f1) - np.interp(grid, x2, f2)
    last = points - 1 - (points - 1) // 10
    x, f = theta[onset:end + 1], force[onset:end + 1]
    area = lever * (trapezoid(f, x) + (x[0] - x[-1]) * (f[-1] + f[0]) / 2)
    mean = trapezoid(d, grid) / (high - low)
    middle = newey_west_fit(grid - (low + high) / 2, d, level)[0][0]
    half = (middle[3] - middle[2]) / 2
    step, _, step_low, step_high = newey_west_fit(grid[last:] - theta[reversal], d[last:], level)[0][0]
    wide = lever * (high - low) * half
    return dict(zip(names, [mean, mean - half, mean + half, d.max(), step, step_low, step_high,
                            area, area - wide, area + wide]))


def spring(trial, theta, force, phases, environment, level):
    onset, reversal, end = phases
    rest, wall_rad = environment["rest_rad"], environment["wall_rad"]
    m = {}
    u = theta[onset:reversal + 1] - rest
    use = u >= environment["slope_from_rad"]
    if wall_rad is not None:
        use &= theta[onset:reversal + 1] < wall_rad
    u, f = u[use], force[onset:reversal + 1][use]
    u_s = saturates_at(u, f)
    below = u < u_s if u_s is not None else np.ones(len(u), bool)
    (line, residuals) = newey_west_fit(u[below], f[below], level)
    slope, se, ci_low, ci_high = line[1]
    m["stiffness_n_per_rad"], m["stiffness_std_error_n_per_rad"] = slope, se
    m["stiffness_ci_low_n_per_rad"], m["stiffness_ci_high_n_per_rad"] = ci_low, ci_high
    m["stiffness_error_n_per_rad"] = slope - environment["stiffness_n_per_rad"]
    m["force_at_rest_n"] = line[0, 0]
    m["stiffness_r2"] = 1 - np.sum(residuals ** 2) / np.sum((f[below] - f[below].mean()) ** 2)
    m["stiffness_samples"] = int(below.sum())
    names = ["saturation_force_n", "saturation_force_ci_low_n", "saturation_force_ci_high_n",
             "saturation_theta_rad", "saturation_theta_ci_low_rad", "saturation_theta_ci_high_rad"]
    m |= dict.fromkeys(names, np.nan)
    if u_s is not None:
        (flat,), _ = newey_west_fit(None, f[~below], level)
        at_s = newey_west_fit(u[below] - u_s, f[below], level)[0][0]
        half = stats.t.ppf(0.5 + level / 2, 9) * np.hypot(at_s[1], flat[1]) / abs(slope)
        theta_s = rest + u_s
        m |= dict(zip(names, [flat[0], flat[2], flat[3], theta_s, theta_s - half, theta_s + half]))
    commanded = trial.force_cmd_n.to_numpy()[onset:reversal + 1][use]
    m["force_rms_error_n"] = np.sqrt(np.mean((f - commanded) ** 2))
    put_in = trapezoid(force[onset:reversal + 1], theta[onset:reversal + 1])
    given_back = -trapezoid(force[reversal:end + 1], theta[reversal:end + 1])
    m["returned_energy_share"] = given_back / put_in if put_in > 0 and reversal + 1 < len(theta) else np.nan
    return m


def wall(t, theta, velocity, force, trial, wall_rad, lever, level):
    names = ["wall_past_max_rad", "wall_depth_m", "wall_dwell_s", "wall_impulse_n_s", "wall_energy_j",
             "wall_impact_velocity_rad_s", "wall_rebounds", "wall_brake_releases", "wall_stiffness_n_per_rad",
             "wall_stiffness_ci_low_n_per_rad", "wall_stiffness_ci_high_n_per_rad"]
    m = {"wall_reached": None} | dict.fromkeys(names, np.nan)
    if wall_rad is None:
        return m
    m["wall_reached"] = bool(theta.max() > wall_rad)
    if not m["wall_reached"]:
        return m
    a, b = theta[:-1] > wall_rad, theta[1:] > wall_rad
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = (wall_rad - theta[:-1]) / np.diff(theta)
    start, stop = np.where(~a & b, crossing, 0.0), np.where(a & ~b, crossing, 1.0)
    share = np.where(a | b, stop - start, 0.0)
    middle = force[:-1] + np.where(a | b, (start + stop) / 2, 0.0) * np.diff(force)
    past = theta.max() - wall_rad
    impact = np.interp(first_passing(t, theta, wall_rad), t, velocity)
    entries = arrivals(theta, np.nextafter(wall_rad, np.inf), 1, 0.01 * np.ptp(theta))
    brake = (trial["state_bits"].to_numpy() & BRAKE_ON != 0) | (trial.voltage_brake_v.to_numpy() != 0)
    releases = int(np.sum((theta[:-1] > wall_rad) & brake[:-1] & ~brake[1:]))
    deepest = int(np.argmax(theta))
    way_in = np.flatnonzero(theta[:deepest + 1] > wall_rad)
    fit = newey_west_fit(theta[way_in] - wall_rad, force[way_in], level) if len(way_in) > 2 else None
    slope = fit[0][1, [0, 2, 3]] if fit else [np.nan] * 3
    values = [past, lever * past, np.sum(share * np.diff(t)), np.sum(middle * share * np.diff(t)),
              lever * np.sum(middle * share * np.diff(theta)), impact, entries - 1, releases, *slope]
    return m | dict(zip(names, values))


SUMMARISED = ["duration_s", "theta_max_rad", "sparc_forward", "sparc_backward", "discrepancy_user_mean_n",
              "discrepancy_user_step_n", "loop_area_j", "stiffness_n_per_rad", "saturation_force_n", "force_rms_error_n",
              "returned_energy_share", "wall_past_max_rad", "wall_dwell_s"]


def deviation(name):
    """stiffness_n_per_rad -> stiffness_sd_n_per_rad."""
    unit = next((u for u in ("_n_per_rad", "_rad", "_s", "_n", "_j", "_m") if name.endswith(u)), "")
    return f"{name.removesuffix(unit)}_sd{unit}"


def by_condition(metrics):
    group = metrics.groupby(["participant", "session", "environment", "mode"], sort=False)
    table = group.size().rename("n").to_frame()
    for name in SUMMARISED:
        table[name], table[deviation(name)] = group[name].mean(), group[name].std()
    return table.reset_index()
