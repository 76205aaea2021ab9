"""The plant (mass, damping, dry friction, lags of motor and brake) from the balance of forces of the recorded motion, in
weak form (docs/analysis.md, "Identification"): bounded least squares, jackknife over trials, profiles, and replays as judge.
"""

from itertools import groupby

import numpy as np
import pandas as pd
from scipy import stats
from scipy.linalg.blas import dtbsv
from scipy.optimize import least_squares

import metrics
from model import BY_EYE

NAMES = ["mass", "damping", "friction", "motor_lag", "brake_on", "brake_off"]
UNITS = ["kg", "N·s/rad", "N", "s", "s", "s"]
LOWER = np.array([1e-3, 0.0, 0.0, 0.0, 0.0, 0.0])
UPPER = np.array([2.0, 10.0, 2.0, 0.05, 0.2, 0.2])
STARTS = [BY_EYE, (0.05, 0.1, 0.1, 1e-4, 0.01, 0.01), (0.3, 0.3, 0.2, 1e-3, 0.05, 0.05)]
NODE_S, HALF_S, MOVING_RAD_S = 0.008, 0.05, 0.1
GAUSS = [(0.5 - np.sqrt(0.15), 5 / 18), (0.5, 8 / 18), (0.5 + np.sqrt(0.15), 5 / 18)]
LAGS = (3, "motor"), (4, "brake"), (5, "brake")
PROFILE = np.arange(-6, 7) / 2  # standard errors
MOST_INFLATION = 100.0


# --- what a trial's motion and commands tell --------------------------------------------------------------------------

def cubic(t, y, at):
    """Lagrange's cubic through the four samples around each place."""
    first = np.clip(np.searchsorted(t, at) - 2, 0, len(t) - 4)
    total = 0.0
    for i in range(4):
        weight = 1.0
        for j in range(4):
            if j != i:
                weight = weight * (at - t[first + j]) / (t[first + i] - t[first + j])
        total = total + weight * y[first + i]
    return total


def running_integral(t, y):
    """The trapezoid less its error by the second derivative at both ends."""
    h, slope = np.diff(t), np.diff(y) / np.diff(t)
    bend = np.zeros(len(t))
    bend[1:-1] = 2 * np.diff(slope) / (t[2:] - t[:-2])
    return np.r_[0.0, np.cumsum(h * (y[:-1] + y[1:]) / 2 - h ** 3 / 24 * (bend[:-1] + bend[1:]))]


def hats_of(t, theta, force_t):
    """Three samples for each hat, and the direction of the motion under it."""
    nodes = [0]
    for i in range(1, len(t)):
        if t[i] - t[nodes[-1]] >= NODE_S:
            nodes.append(i)
    nodes = np.array(nodes)
    velocity = np.diff(theta[nodes]) / np.diff(t[nodes])
    quarter = max(round(HALF_S / 2 / np.diff(t[nodes]).mean()), 1)
    hats, directions, begins = [], [], 0
    for direction, stretch in groupby(np.sign(velocity) * (np.abs(velocity) > MOVING_RAD_S)):
        count = len(list(stretch))
        first, last = begins + 1, begins + count - 1
        begins += count
        if direction == 0 or count <= 2:
            continue
        starts = np.arange(first, last - 4 * quarter + 1, quarter)
        hats += [nodes[[s, s + 2 * quarter, s + 4 * quarter]] for s in starts]
        directions += [direction] * len(starts)
    hats, directions = np.array(hats, dtype=int).reshape(-1, 3), np.array(directions)
    known = (t[hats[:, 0]] >= force_t[0]) & (t[hats[:, 2]] <= force_t[-1])
    return hats[known], directions[known]


class Balance:
    """The weak forms of some trials, one below the other."""

    def __init__(self, models):
        parts = [self.of(model) for model in models]
        columns, measured, hats, t, commands = zip(*parts)
        self.block = np.repeat(np.arange(len(parts)), [len(m) for m in measured])
        self.columns, self.measured = np.concatenate(columns), np.concatenate(measured)
        self.direction = np.sign(self.columns[:, 2])
        first = np.cumsum([0] + [len(one) for one in t])[:-1]
        self.hats = np.concatenate([h + f for h, f in zip(hats, first)])
        self.t = np.concatenate(t)
        # the step over the end of a trial has no length: its command is none and its level decays at once
        self.h = np.concatenate([np.r_[np.diff(one), np.inf] for one in t])
        self.motor, self.brake = (np.concatenate([c[k] for c in commands]) for k in (0, 1))

    @staticmethod
    def of(model):
        frame, t = model.frame, model.frame.t_s.to_numpy()
        theta = model.theta
        force_t, force = metrics.force_updates(frame)
        hats, direction = hats_of(t, theta, force_t)

        def bent(y):
            (a, b, c), (ta, tb, tc) = y[hats].T, t[hats].T
            return (c - b) / (tc - tb) - (b - a) / (tb - ta)

        base = (t[hats[:, 2]] - t[hats[:, 0]]) / 2
        columns = np.column_stack([model.lever * bent(theta), bent(running_integral(t, theta)), direction * base])
        h, part, moment = np.diff(t), 0.0, 0.0
        for place, weight in GAUSS:
            value = weight * h * cubic(force_t, force, t[:-1] + place * h)
            part, moment = part + value, moment + place * h * value
        measured = through(hats, t, part, moment + t[:-1] * part)
        motor, brake = (model.calibration[a](frame[f"voltage_{a}_v"].to_numpy(dtype=float)) for a in ("motor", "brake"))
        motor[-1] = brake[-1] = 0.0
        return columns, measured, hats, t, (motor, np.abs(brake))

    def lagging(self, command, rising, falling):
        """Impulse of a force that follows a held command with time constants, under every hat. Its levels after each step
        are a bidiagonal system of equations, once it is known which of them fall."""
        lag = np.full(len(command), max(rising, 1e-12))
        while True:
            decay = np.exp(-self.h / lag)
            after = dtbsv(1, np.array([np.ones(len(lag)), np.r_[-decay[1:], 0.0]]), command * (1 - decay), lower=1, diag=1)
            level = np.r_[0.0, after[:-1]]
            found = np.where(level > command, max(falling, 1e-12), max(rising, 1e-12))
            if np.array_equal(found, lag):
                break
            lag = found
        off, gone = level - command, 1 - decay
        h = np.where(np.isfinite(self.h), self.h, 0.0)
        part = command * h + off * lag * gone
        moment = command * h ** 2 / 2 + off * lag * (lag * gone - h * decay)
        return through(self.hats, self.t, part[:-1], (moment + self.t * part)[:-1])

    def actuated(self, p, which=("motor", "brake")):
        total = 0.0
        if "motor" in which:
            total = total - self.lagging(self.motor, p[3], p[3])
        if "brake" in which:
            total = total + self.direction * self.lagging(self.brake, p[4], p[5])
        return total

    def residuals(self, p):
        return self.columns @ p[:3] + self.actuated(p) - self.measured

    def slopes(self, p):
        """Of the linear parameters exact, of the lags central differences."""
        slopes = np.empty((len(self.measured), 6))
        slopes[:, :3] = self.columns
        for j, which in LAGS:
            step = 1e-4 * abs(p[j]) + 1e-7 * (UPPER[j] - LOWER[j])
            low, high = p.copy(), p.copy()
            low[j], high[j] = max(p[j] - step, LOWER[j]), min(p[j] + step, UPPER[j])
            slopes[:, j] = (self.actuated(high, which) - self.actuated(low, which)) / (high[j] - low[j])
        return slopes


def through(hats, t, part, moment):
    """Integral of a force times each hat, from its integral and its first moment over each step."""
    force, moment = np.r_[0.0, np.cumsum(part)][hats].T, np.r_[0.0, np.cumsum(moment)][hats].T
    a, b, c = t[hats].T
    up, down = (moment[1] - moment[0]) - a * (force[1] - force[0]), c * (force[2] - force[1]) - (moment[2] - moment[1])
    return up / (b - a) + down / (c - b)


# --- the fit ----------------------------------------------------------------------------------------------------------

def fit(balance, start, held=None):
    """The parameters that balance best, one of them held where asked, and their sum of squares."""
    start = np.clip(start, LOWER, UPPER)
    free = [j for j in range(6) if j != held]

    def whole(q):
        p = start.copy()
        p[free] = q
        return p

    found = least_squares(lambda q: balance.residuals(whole(q)), start[free],
                          jac=lambda q: balance.slopes(whole(q))[:, free], bounds=(LOWER[free], UPPER[free]),
                          x_scale="jac", ftol=1e-10, xtol=1e-10, gtol=None)
    return whole(found.x), 2 * found.cost


class Profile:
    """How much less likely a parameter's values are than the fit, the others fitted anew."""

    def __init__(self, balance, p, rss, inverse, j, error):
        self.balance, self.p, self.rss, self.j, self.error = balance, p, rss, j, error
        self.scale, self.along = inverse[j, j] / error ** 2, inverse[:, j] / inverse[j, j]

    def at(self, value):
        away = value - self.p[self.j]
        start = self.p + away * self.along
        start[self.j] = value
        rss = fit(self.balance, start, self.j)[1] if away else self.rss
        return dict(value=value, relative_error=rss / self.rss, likelihood_ratio=max((rss - self.rss) * self.scale, 0.0))

    def points(self):
        values = np.clip(self.p[self.j] + PROFILE * self.error, LOWER[self.j], UPPER[self.j])
        return [self.at(value) for value in dict.fromkeys(values)]

    def crossing(self, critical, side):
        """Where the ratio is the critical value's square, or the bound before, by secants."""
        distance, fitted = critical * self.error, self.p[self.j]
        for _ in range(20):
            asked = fitted + side * distance
            value = np.clip(asked, LOWER[self.j], UPPER[self.j])
            root = np.sqrt(self.at(value)["likelihood_ratio"])
            if (asked != value and root <= critical) or abs(root / critical - 1) <= 1e-4:
                return value
            distance = abs(value - fitted) * critical / root
        return np.nan


def jackknife(curvature, gradient, j, free):
    """Standard error of parameter j by leaving out each trial in turn, and Satterthwaite's degrees of freedom."""
    keep = np.ix_(free, free)
    place = free.index(j)
    whole = curvature.sum(axis=0)
    others = (whole - curvature)[:, keep[0], keep[1]]
    moved = -np.linalg.solve(others, (gradient.sum(axis=0) - gradient)[:, free, None])[:, place, 0]
    n = len(moved)
    row = np.linalg.inv(whole[keep])[place]
    shares = np.einsum("k,gkl,l->g", row, curvature[:, keep[0], keep[1]], row)
    return np.sqrt((n - 1) / n * np.sum((moved - moved.mean()) ** 2)), shares.sum() ** 2 / np.sum(shares ** 2)


def verdict(j, p, low, high, inflation):
    if on_bound(j, p[j]):
        return "on_bound"
    if not inflation <= MOST_INFLATION:
        return "confounded"
    if on_bound(j, low) or on_bound(j, high):
        return "flat"
    return "identifiable" if high - low <= 2 * abs(p[j]) else "uncertain"


def on_bound(j, value):
    return value <= LOWER[j] or value >= UPPER[j]


def estimates(balance, p, rss, curvature, gradient, level):
    """Tables of the parameters and of their profiles."""
    free = [j for j in range(6) if not on_bound(j, p[j])]
    whole = curvature.sum(axis=0)
    rows, points = [], []
    for j in range(6):
        freed = sorted({*free, j})
        inverse = np.zeros((6, 6))
        inverse[np.ix_(freed, freed)] = np.linalg.inv(whole[np.ix_(freed, freed)])
        error, df = jackknife(curvature, gradient, j, freed)
        profile = Profile(balance, p, rss, inverse, j, error)
        t = stats.t.ppf(0.5 + level / 2, df)
        low, high = profile.crossing(t, -1), profile.crossing(t, 1)
        inflation = inverse[j, j] * whole[j, j] if j in free else np.nan
        rows.append(dict(parameter=NAMES[j], unit=UNITS[j], by_eye=BY_EYE[j], fitted=p[j], std_error=error, df=df,
                         ci_low=low, ci_high=high, lower_bound=LOWER[j], upper_bound=UPPER[j],
                         variance_inflation=inflation, verdict=verdict(j, p, low, high, inflation)))
        points += [dict(parameter=NAMES[j], unit=UNITS[j], **point) for point in profile.points()]
    return pd.DataFrame(rows), pd.DataFrame(points)


# --- the whole --------------------------------------------------------------------------------------------------------

def threshold(trials):
    """The bracket of the force below which the brake lets go, over the hybrid trials."""
    low, high, releases = -np.inf, np.inf, 0
    for trial in trials:
        if not trial.hybrid:
            continue
        force, velocity, motor, brake = (trial.frame[c].to_numpy()[1:] for c in (
            "force_ex_n", "theta_dot_rad_s", "voltage_motor_v", "voltage_brake_v"))
        was_on = trial.frame.voltage_brake_v.to_numpy()[:-1] > 0
        let_go = was_on & (brake <= 0) & (motor != 0)
        low = max(low, force[let_go].max(initial=-np.inf))
        high = min(high, force[was_on & (brake > 0) & (velocity <= 0)].min(initial=np.inf))
        releases += int(let_go.sum())
    return pd.DataFrame([dict(threshold="let_go", low_n=low, high_n=high, releases=releases,
                              set_n=trials[0].let_go)])


def identify(trials, replays, level):
    """Least squares on every other repeat, judged by replay on all. Tables of estimates, profiles, threshold, held-out
    errors, and trials. `replays` has the errors of the replays by eye."""
    order = pd.DataFrame([t.meta for t in trials])
    part = order.groupby(["participant", "session", "environment", "mode"]).cumcount() % 2
    balance = Balance([t for t, p in zip(trials, part) if p == 0])
    p, rss = min((fit(balance, np.array(start)) for start in STARTS), key=lambda found: found[1])
    errors, slopes = balance.residuals(p), balance.slopes(p)
    starts = np.searchsorted(balance.block, np.arange(balance.block[-1] + 1))
    curvature = np.add.reduceat(slopes[:, :, None] * slopes[:, None, :], starts)
    gradient = np.add.reduceat(slopes * errors[:, None], starts)
    parameters, profiles = estimates(balance, p, rss, curvature, gradient, level)

    free = [j for j in range(6) if not on_bound(j, p[j])]
    left_out = np.tile(p, (len(starts), 1))
    others = (curvature.sum(axis=0) - curvature)[:, free][:, :, free]
    left_out[:, free] -= np.linalg.solve(others, (gradient.sum(axis=0) - gradient)[:, free, None])[..., 0]
    left_out = iter(np.clip(left_out, LOWER, UPPER))

    def rmse(trial, plant):  # every sample counts: they are farther apart than 4 ms
        return np.sqrt(np.mean((trial.force_driven(plant)[0] - trial.theta) ** 2))

    by_eye = replays[replays.causality == "force_driven"].set_index("trial").rmse_rad
    rows = [dict(trial.meta, part="held_out" if of else "fitted", rmse_by_eye_rad=by_eye[trial.meta["trial"]],
                 rmse_fitted_rad=rmse(trial, p), rmse_left_out_rad=np.nan if of else rmse(trial, next(left_out)))
            for trial, of in zip(trials, part)]
    table = pd.DataFrame(rows)
    held = table[table.part == "held_out"]
    over = held.groupby(["environment", "mode"])[["rmse_by_eye_rad", "rmse_fitted_rad"]]
    against = over.agg(lambda e: np.sqrt(np.mean(e ** 2))).reset_index()
    against.insert(2, "n", over.size().to_numpy())
    every = np.sqrt((held[["rmse_by_eye_rad", "rmse_fitted_rad"]] ** 2).mean())
    against.loc[len(against)] = ["all", "all", len(held), *every]
    against["fitted_over_by_eye"] = against.rmse_fitted_rad / against.rmse_by_eye_rad
    tables = {"identify": parameters, "identify.profile": profiles, "identify.threshold": threshold(trials),
              "identify.held_out": against, "identify.trials": table}
    return tables, p
