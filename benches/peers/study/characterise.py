"""Characteristics of motor and brake: first order, candidate models, leave-one-sweep-out error, bootstrap."""

import numpy as np
import pandas as pd
from scipy import stats
from scipy.optimize import curve_fit, nnls

RESAMPLES, SEED, KNOTS = 400, 1, 7


def line(x, a, b):
    return a + b * x


def hinge(x, a, b, x0):
    return a + b * np.maximum(x - x0, 0.0)


def saturation(x, a, b, x0, x1):
    return a + b * np.maximum(np.minimum(x, x1) - x0, 0.0)


def power_law(x, a, b, x0, p):
    return a + b * np.maximum(x - x0, 0.0) ** p


def spline_columns(x, low, high):
    """The rise since `low` for a slope of 1 at each knot alone."""
    width = (high - low) / (KNOTS - 1)
    u = (np.asarray(x)[:, None] - low) / width - np.arange(KNOTS)

    def integral(v):
        inner = np.clip(v, -1, 1)
        hat = inner - 0.5 * inner * np.abs(inner)
        hat[:, 0] = np.where(v[:, 0] < 0, v[:, 0], hat[:, 0])
        hat[:, -1] = np.where(v[:, -1] > 0, v[:, -1], hat[:, -1])
        return hat

    return width * (integral(u) - integral(np.tile(-np.arange(KNOTS, dtype=float), (len(u), 1))))


class Parametric:
    """Levenberg-Marquardt, which is fast; where it fails or leaves the bounds, SciPy's bounded method."""

    def __init__(self, function, names, start):
        self.function, self.names, self.start = function, names, start

    def fit(self, x, y, near=None):
        bounds = np.array([self.limits(x)[name] for name in self.names]).T
        p0 = np.clip(self.start(x, y) if near is None else near, *bounds)
        inside = np.all((p0 > bounds[0]) & (p0 < bounds[1]))
        try:
            p = curve_fit(self.function, x, y, p0=p0)[0] if inside else None
        except RuntimeError:
            p = None
        if p is None or np.any((p < bounds[0]) | (p > bounds[1])):
            p = curve_fit(self.function, x, y, p0=p0, bounds=bounds)[0]
        return p

    @staticmethod
    def limits(x):
        """A break lies between the first command and the third last, a plateau between the third and the last."""
        free = (-np.inf, np.inf)
        levels = np.sort(x)
        return {"a": free, "b": free, "x0": (levels[0], levels[-3]), "x1": (levels[2], levels[-1]), "p": (0.2, 8.0)}

    def predict(self, p, x):
        return self.function(x, *p)


class Spline:
    names = ["a"] + [f"s{k}" for k in range(KNOTS)]
    columns, x = None, None

    def fit(self, x, y, near=None):
        if self.x is not x:
            self.x, self.ends = x, (x.min(), x.max())
            self.columns = spline_columns(x, *self.ends)
        centred = self.columns - self.columns.mean(axis=0)
        slopes, _ = nnls(centred, y - y.mean())
        return np.r_[y.mean() - slopes @ self.columns.mean(axis=0), slopes]

    def predict(self, p, x):
        return p[0] + spline_columns(x, *self.ends) @ p[1:]


def line_start(x, y):
    slope, offset = np.polyfit(x, y, 1)
    return offset, slope


def hinge_start(x, y):
    half = x > np.median(x)
    slope, offset = np.polyfit(x[half], y[half], 1)
    return y.min(), slope, (y.min() - offset) / slope


def models():
    """Candidates by name: how to fit, whether up and down are apart."""
    shapes = {
        "line": Parametric(line, ["a", "b"], line_start),
        "hinge": Parametric(hinge, ["a", "b", "x0"], hinge_start),
        "saturation": Parametric(saturation, ["a", "b", "x0", "x1"],
                                 lambda x, y: (*hinge_start(x, y), x.min() + 0.98 * np.ptp(x))),
        "power_law": Parametric(power_law, ["a", "b", "x0", "p"], lambda x, y: (*hinge_start(x, y), 1.0)),
        "spline": Spline(),
    }
    order = ["line", "hinge", "saturation", "power_law", "line_up_down", "hinge_up_down", "spline",
             "saturation_up_down", "power_law_up_down", "spline_up_down"]
    return {name: (shapes[name.removesuffix("_up_down")], name.endswith("_up_down")) for name in order}


def characterise(sweeps, level):
    """`sweeps` is a list of frames with the same commands. Tables of models, parameters and the curve."""
    command = sweeps[0].command.to_numpy()
    response = np.array([s.response.to_numpy() for s in sweeps])
    count = len(sweeps)
    up = np.arange(len(command)) <= np.argmax(command)
    rng = np.random.default_rng(SEED)
    draws = np.array([np.bincount(rng.integers(count, size=count), minlength=count) for _ in range(RESAMPLES)])
    resampled = draws @ response / count
    without = (response.sum(axis=0) - response) / (count - 1)
    z = np.sqrt(count / (count - 1)) * stats.t.ppf(0.5 + level / 2, count - 1)
    wide = 2 * stats.norm.cdf(z) - 1
    tails = [50 * (1 - wide), 50 * (1 + wide)]
    scatter = noise(command, response)
    found, rows = {}, []
    for name, (shape, apart) in models().items():
        parts = [("up", up), ("down", ~up)] if apart else [("both", np.ones_like(up))]
        fits, draws_of, fitted, left_out = [], [], np.empty_like(command), np.empty_like(response)
        for branch, part in parts:
            x = command[part]
            best = shape.fit(x, response.mean(axis=0)[part])
            near = [shape.fit(x, y[part], best) for y in resampled]
            fitted[part] = shape.predict(best, x)
            for k in range(count):
                left_out[k, part] = shape.predict(shape.fit(x, without[k][part], best), x)
            fits.append((branch, best))
            draws_of.append(np.array(near))
            low, high = np.percentile(near, tails, axis=0)
            rows += [dict(model=name, parameter=n, branch=branch, estimate=e, std_error=s, ci_low=a, ci_high=b)
                     for n, e, s, a, b in zip(shape.names, best, np.std(near, axis=0, ddof=1), low, high)]
        squares = np.mean((response - left_out) ** 2, axis=1)
        residuals = response - fitted
        size = sum(len(p) for _, p in fits)
        rms = np.sqrt(np.mean(residuals ** 2))
        lagged = np.sum(residuals[:, 1:] * residuals[:, :-1]) / np.sum(residuals ** 2)
        found[name] = dict(
            model=name, complexity=size, rms=rms, left_out_rms=np.sqrt(squares.mean()), rms_over_noise=rms / scatter,
            r2=1 - np.sum(residuals ** 2) / np.sum((response - response.mean()) ** 2), autocorrelation=lagged,
            aicc=aicc(command, residuals, size), squares=squares, fits=fits, draws=draws_of, shape=shape)
    chosen = choose(found)
    table = pd.DataFrame([{k: v for k, v in m.items() if k not in ("squares", "fits", "draws", "shape")}
                          for m in found.values()])
    table["verdict"] = np.where(table.model == chosen, "chosen", "rejected or not needed")
    curve = curve_of(found[chosen], command, response, up, level, tails)
    return table.drop(columns="complexity"), pd.DataFrame(rows), curve, found[chosen]


def noise(command, response):
    """Scatter about local lines over five samples."""
    rss = df = 0.0
    n = len(command) // 5
    for k in range(n):
        window = slice(k * len(command) // n, (k + 1) * len(command) // n)
        x, y = command[window], response[:, window]
        X = np.column_stack([np.ones(len(x)), x])
        beta, *_ = np.linalg.lstsq(X, y.T, rcond=None)
        rss += np.sum((y.T - X @ beta) ** 2)
        df += len(y) * (len(x) - 2)
    return np.sqrt(rss / df)


def aicc(command, residuals, k):
    """On the residuals' means in fifty bins of the command."""
    bins = np.minimum((command - command.min()) / np.ptp(command) * 50, 49).astype(int)
    means = np.bincount(bins, residuals.mean(axis=0)) / np.bincount(bins)
    n, k = len(means), k + 1
    return n * np.log(np.sum(means ** 2) / n) + 2 * k + 2 * k * (k + 1) / (n - k - 1)


def choose(found):
    """The simplest law within a standard error of the best."""
    laws = {n: m for n, m in found.items() if not n.startswith("spline")}
    if all(m["rms_over_noise"] > 1.5 for m in laws.values()):
        laws = found
    best = min(laws.values(), key=lambda m: m["left_out_rms"])
    error = best["squares"].std(ddof=1) / np.sqrt(len(best["squares"])) / (2 * best["left_out_rms"])

    def as_good(m):
        d = m["squares"] - best["squares"]
        return m["left_out_rms"] <= best["left_out_rms"] + error and (
            d.mean() <= 2 * d.std(ddof=1) / np.sqrt(len(d)) + 1e-18)

    good = [m for m in laws.values() if as_good(m)]
    return min(good, key=lambda m: (m["complexity"], m["left_out_rms"]))["model"]


def curve_of(best, command, response, up, level, tails):
    """The chosen fit with its bands, the mean of the samples, and the first-order fit, on a grid."""
    grid = np.linspace(command.min(), command.max(), 201)
    x, y = np.tile(command, len(response)), response.ravel()
    first = stats.linregress(x, y)
    df = y.size - best["complexity"]
    spread = stats.t.ppf(0.5 + level / 2, df) * best["rms"] * np.sqrt(y.size / df)
    frames = []
    for (branch, p), draws in zip(best["fits"], best["draws"]):
        part = {"up": up, "down": ~up, "both": np.ones_like(up)}[branch]
        fit = best["shape"].predict(p, grid)
        low, high = np.percentile([best["shape"].predict(d, grid) for d in draws], tails, axis=0)
        low, high = np.minimum(low, fit), np.maximum(high, fit)
        step = grid[1] - grid[0]
        place = np.clip(((command[part] - grid[0]) / step + 0.5).astype(int), 0, 200)
        n = np.bincount(place, minlength=201)
        with np.errstate(invalid="ignore"):
            mean = np.bincount(place, response.mean(axis=0)[part], minlength=201) / n
        frames.append(pd.DataFrame(dict(
            branch=branch, command=grid, mean=mean, fit=fit, ci_low=low, ci_high=high,
            prediction_low=fit - np.hypot(fit - low, spread), prediction_high=fit + np.hypot(high - fit, spread),
            first_order=first.intercept + first.slope * grid)))
    return pd.concat(frames, ignore_index=True)


PLACES, CLOSENESS, RISE, AT_END = 1024, 5e-4, 1e-9, 0.01


def calibration(best, low, high):
    """Voltages and forces as knots: the chosen curve less its value at no voltage, mean of up and down, rising. After each
    turn of the voltage dry friction keeps one branch flat for a while: there the mean goes on along its tangent."""
    low, names = max(low, 0.0), best["shape"].names

    def mean(v):
        return np.mean([best["shape"].predict(p, np.asarray(v, dtype=float)) for _, p in best["fits"]], axis=0)

    def of_branches(name):
        return [p[names.index(name)] for branch, p in best["fits"] if branch != "both" and name in names]

    breaks, plateaus = of_branches("x0"), of_branches("x1")
    start, stop = max([low, *breaks]), min([high, *plateaus])
    start, stop = (start, stop) if start < stop else (low, high)
    h = (stop - start) / PLACES
    ends = mean([start, start + h, stop - h, stop])
    slopes = (ends[1] - ends[0]) / h, (ends[3] - ends[2]) / h
    end = AT_END * (high - low)
    floor = mean([low])[0] if breaks and min(breaks) > low + end else -np.inf
    cap = mean([high])[0] if plateaus and max(plateaus) < high - end else np.inf

    corners = [start + (floor - ends[0]) / slopes[0], stop + (cap - ends[3]) / slopes[1], *breaks, *plateaus]
    voltage = np.sort(np.r_[np.linspace(low, high, PLACES + 1), [v for v in corners if low < v < high]])
    force = mean(np.clip(voltage, start, stop)) + slopes[0] * np.minimum(voltage - start, 0.0) + (
        slopes[1] * np.maximum(voltage - stop, 0.0))
    force = np.clip(force, floor, cap)
    return knots(*rising(voltage, force - force[0]))


def rising(voltage, force):
    """From the last place without force on, strictly."""
    kept, least = [], RISE * force.max()
    for i, f in enumerate(force):
        if not kept or (len(kept) == 1 and f <= least):
            kept = [i]
        elif f > (force[kept[-1]] if len(kept) > 1 else 0.0) + least:
            kept.append(i)
    return voltage[kept], np.r_[0.0, force[kept[1:]]]


def knots(voltage, force):
    """Straight lines within the tolerance (Douglas & Peucker 1973)."""
    def between(a, b):
        gap = np.abs(force[a:b + 1] - np.interp(voltage[a:b + 1], voltage[[a, b]], force[[a, b]]))
        if gap.max() <= CLOSENESS * force[-1]:
            return [a]
        farthest = a + int(np.argmax(gap))
        return between(a, farthest) + between(farthest, b)

    at = [*between(0, len(voltage) - 1), len(voltage) - 1]
    return voltage[at], force[at]
