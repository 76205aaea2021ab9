"""Numbers of SciPy, statsmodels, pingouin, spm1d and psignifit for crates/stats/tests/exact.rs, as JSON: random data with ties, zeros, constants.

    python exact.py [ROUNDS [SEED]]

Each round draws the same kinds of data anew. What has no such number (one value, all equal) is null: there our functions
must say why instead.
"""

import itertools
import json
import os
import sys
import warnings

# Matrices here are small: threads of their own would only wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
import pandas as pd
import pingouin
import psignifit
import spm1d
import statsmodels.api as sm
from scipy import stats
from scipy.integrate import simpson
from scipy.optimize import brentq, minimize
from scipy.special import expit, gammaln, ndtr
from statsmodels.genmod.families import links
from statsmodels.stats.meta_analysis import combine_effects
from statsmodels.stats.multitest import multipletests
from statsmodels.stats.weightstats import ttost_paired

EVERY = np.inf  # resamples: all of them are counted


def sign_flip(d):
    """All flips of signs, by permutation_test (which asks for two values)."""
    if not d.any():
        return None
    if len(d) == 1:
        return 1.0
    found = stats.permutation_test((d,), np.sum, permutation_type="samples", n_resamples=EVERY, vectorized=False)
    return found.pvalue


def signed_rank(d):
    """All flips of the signs of ranks, zeros after Pratt; SciPy's "exact" would leave ties out of account."""
    if not d.any():
        return None
    ranks = np.sign(d) * stats.rankdata(np.abs(d))
    if np.count_nonzero(d) > 50:
        method = "asymptotic"
        p = stats.wilcoxon(d, zero_method="pratt", correction=True, method=method).pvalue
    elif len(d) == 1:
        p = 1.0
    elif len(d) <= 12:
        p = stats.permutation_test((ranks,), np.sum, permutation_type="samples", n_resamples=EVERY).pvalue
    else:  # without ties or zeros
        p = stats.wilcoxon(d, method="exact").pvalue
    return {"p": p, "statistic": ranks[ranks > 0].sum(), "rank_biserial": ranks.sum() / np.abs(ranks).sum()}


def differences(rng):
    """Eighths, so that sums are exact: many ties and zeros in small ranges; one value; all equal."""
    sets = [rng.integers(-4, 9, n) / 8 for n in range(1, 13) for _ in range(4)]
    sets += [np.full(n, v) for n in (1, 2, 6) for v in (0.0, 0.5)]
    sets += [rng.permutation(np.arange(1, n + 1)) * rng.choice([-1, 1, 1], n) / 8 for n in (13, 20, 37, 50)]
    return [{"d": d, "signed_rank": signed_rank(d), "sign_flip": sign_flip(d) if len(d) < 13 else None}
            for d in map(np.asarray, sets)] + [
        {"d": d, "signed_rank": signed_rank(d)} for d in (rng.integers(-9, 14, n) / 8 for n in (60, 75, 200))]


def noncentral_t(t, df, noncentrality):
    """P(T ≤ t) by its definition: SciPy 1.17's nct.cdf is not a number for some noncentralities far from t."""
    s = np.linspace(0, 1 + 9 / np.sqrt(df), 20001)
    density = stats.chi.pdf(s * np.sqrt(df), df) * np.sqrt(df)
    return simpson(ndtr(t * s - noncentrality) * density, x=s)


def effects(a, b, t):
    """d_z and d_av with g and the intervals of the noncentral t (the formulas are those of docs/analysis.md)."""
    d, spare, root_n = a - b, len(a) - 1, np.sqrt(len(a))
    covariances = np.cov(a, b)
    s_av = np.sqrt(np.trace(covariances) / 2)
    df_av = spare * np.trace(covariances) ** 2 / (covariances ** 2).sum()
    unbiased = lambda df: np.exp(gammaln(df / 2) - gammaln((df - 1) / 2)) / np.sqrt(df / 2)
    reach = 10 + 10 * abs(t)
    ends = np.array([brentq(lambda x: noncentral_t(t, spare, x) - p, t - reach, t + reach, xtol=1e-12)
                     for p in (0.975, 0.025)])
    d_z, d_av = d.mean() / d.std(ddof=1), d.mean() / s_av
    return {"d_z": {"d": d_z, "g": d_z * unbiased(spare), "ci": [*ends / root_n]},
            "d_av": {"d": d_av, "g": d_av * unbiased(df_av), "ci": [*ends * d.std(ddof=1) / (s_av * root_n)]}}


def paired(rng):
    """Paired t, effect sizes and two one-sided tests."""
    for n in (2, 3, 6, 12, 40):
        for bound in (0.2, 1.0):
            a = rng.normal(5, 1, n)
            b = a + rng.normal(0.3, 0.5, n)
            t = stats.ttest_1samp(a - b, 0)
            p, (_, lower, _), (_, upper, _) = ttost_paired(a, b, -bound, bound)
            wide, narrow = t.confidence_interval(0.95), t.confidence_interval(0.9)
            yield {"a": a, "b": b, "bound": bound, "t": t.statistic, "p": t.pvalue, "ci": [*wide],
                   **effects(a, b, t.statistic),
                   "tost": {"p": p, "lower": lower, "upper": upper, "ci": [*narrow]}}


def friedman(rng):
    """The χ² of friedmanchisquare; all orders within rows, on ranks, by permutation_test."""
    for modes, n in ((3, 1), (3, 2), (3, 4), (3, 5), (4, 3), (3, 3), (4, 2), (5, 2)):
        for values in (2, 4, 100):
            rows = rng.integers(0, values, (n, modes)) / 8
            ranks = stats.rankdata(rows, axis=1)
            if (ranks == (modes + 1) / 2).all():
                yield {"rows": rows, "p": None}
                continue
            spread = lambda *columns: sum((c.sum() - n * (modes + 1) / 2) ** 2 for c in columns)
            p = 1.0 if n == 1 else stats.permutation_test(
                tuple(ranks.T), spread, permutation_type="samples", alternative="greater",
                n_resamples=EVERY, vectorized=False).pvalue
            chi2 = stats.friedmanchisquare(*rows.T).statistic
            yield {"rows": rows, "p": p, "statistic": chi2, "concordance": chi2 / (n * (modes - 1))}


def repeated(rng):
    """Intraclass correlations (ends to two digits), repeated-measures ANOVA, Kendall's W, d_av, by pingouin.

    Its ε is right with one factor, as here; with two it is not.
    """
    for n, k in ((3, 2), (4, 3), (6, 3), (12, 4), (30, 3), (8, 5)):
        for people, unlike in ((1.0, 0.0), (0.2, 1.5)):
            scatter = 1 + unlike * np.arange(k)  # no sphericity
            rows = 5 + people * rng.normal(size=(n, 1)) + 0.4 * np.arange(k) + scatter * rng.normal(size=(n, k))
            long = pd.DataFrame(
                [(i, j, rows[i, j]) for i in range(n) for j in range(k)], columns=["participant", "mode", "y"])
            one = {"data": long, "dv": "y", "within": "mode", "subject": "participant"}
            icc = pingouin.intraclass_corr(long, targets="participant", raters="mode", ratings="y").set_index("Type")
            anova = pingouin.rm_anova(**one, correction=True).iloc[0]
            yield {"rows": rows, "icc": [[icc.ICC[t], *icc.CI95[t]] for t in ("ICC(A,1)", "ICC(C,1)", "ICC(A,k)", "ICC(C,k)")],
                   "anova": {"F": anova.F, "df": [anova.ddof1, anova.ddof2], "p": anova.p_unc},
                   "p_gg": anova.get("p_GG_corr", anova.p_unc), "gg": pingouin.epsilon(pd.DataFrame(rows), correction="gg"),
                   "hf": pingouin.epsilon(pd.DataFrame(rows), correction="hf"),
                   "concordance": pingouin.friedman(**one).W.iloc[0],
                   "d_av": pingouin.compute_effsize(rows[:, 0], rows[:, 1], paired=True, eftype="cohen")}


def holm(rng):
    """Adjusted p values, with ties."""
    for m in (1, 2, 3, 6, 15):
        for p in (rng.uniform(0, 1, m) ** 3, rng.integers(0, 5, m) / 40):
            yield {"p": p, "adjusted": multipletests(p, method="holm")[1]}


def orders(rng):
    """All assignments of modes to trials, by permutation_test of independent samples."""
    for sizes in ((3, 3), (4, 2), (2, 2, 2), (3, 2, 2)):
        for values in (4, 1000):
            v = rng.integers(0, values, sum(sizes)) / 8
            if (v == v[0]).all():
                continue
            groups = np.split(v, np.cumsum(sizes)[:-1])
            between = lambda *g: sum(len(x) * (x.mean() - v.mean()) ** 2 for x in g)
            found = stats.permutation_test(
                tuple(groups), between, permutation_type="independent", alternative="greater",
                n_resamples=EVERY, vectorized=False)
            modes = [mode for mode, size in enumerate(sizes) for _ in range(size)]
            every = sorted(set(itertools.permutations(modes)))
            yield {"values": v, "modes": modes, "orders": every, "statistic": found.statistic, "p": found.pvalue}


def bca(rng):
    """BCa ends of given resamples: SciPy takes over a distribution when it draws none of its own."""
    for n in (5, 12, 30):
        for statistic in (np.mean, np.median, lambda x, axis=-1: np.std(x, axis=axis, ddof=1)):
            v = rng.gamma(2, 1, n)
            drawn = statistic(rng.choice(v, (999, n)), axis=-1)
            whole = statistic(v)  # SciPy would tell apart what differs by rounding
            drawn = np.where(np.isclose(drawn, whole, rtol=1e-12, atol=0), whole, drawn)
            rest = [statistic(np.delete(v, i)) for i in range(n)]
            given = stats.bootstrap((v,), statistic, n_resamples=2, method="percentile")
            given.bootstrap_distribution = drawn
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                ends = stats.bootstrap((v,), statistic, n_resamples=0, method="BCa", bootstrap_result=given)
            ends = [*ends.confidence_interval]
            if np.isfinite(ends).all():  # degenerate for SciPy: nothing to compare with
                yield {"estimate": whole, "resampled": drawn, "jackknife": rest, "ci": ends}


def curves(rng):
    """Flips of whole curves: t, its largest and how often flips reach it by spm1d; band, runs and groups by definition.

    The example of spm1d's paired curves is the first case.
    """
    first, second = spm1d.data.uv1d.tpaired.PlantarArchAngle().get_data()
    cases = [np.asarray(first) - np.asarray(second)]
    x = np.linspace(0, 1, 31)
    for n in (6, 8, 9, 11):
        waves = sum(np.outer(rng.normal(size=n), np.cos(np.pi * k * x + k)) for k in range(4))
        cases.append(waves + rng.uniform(-0.5, 1.5) * np.exp(-((x - 0.4) / 0.2) ** 2))
    for d in cases:
        n, nodes = d.shape
        test = spm1d.stats.nonparam.ttest(d, 0)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = test.inference(0.05, two_tailed=True, iterations=-1)
        largest = np.abs(np.ravel(found.PDF0))  # of every flip but its mirror
        signs = np.array(list(itertools.product((1, -1), repeat=n)))
        root = d.std(axis=0, ddof=1) / np.sqrt(n)

        def flipped(values):
            sums = signs @ values
            return sums / n / np.sqrt(((values ** 2).sum(axis=0) - sums ** 2 / n) / (n * (n - 1)))

        of_residuals = np.sort(np.abs(flipped(d - d.mean(axis=0))[1:-1]).max(axis=1))[::-1]
        threshold = stats.t.ppf(0.975, n - 1)

        def masses(t):
            side = np.where(np.abs(t) > threshold, np.sign(t), 0)
            runs = [list(run) for _, run in itertools.groupby(range(nodes), lambda i: side[i])]
            return [(run[0], run[-1], np.abs(t[run]).sum()) for run in runs if side[run[0]]]

        heaviest = np.array([max((mass for *_, mass in masses(t)), default=0) for t in flipped(d)])
        a, b = d[: n // 2], d[n // 2:]
        welch = lambda a, b: np.abs(stats.ttest_ind(a, b, equal_var=False).statistic).max()
        split = [(list(c), [i for i in range(n) if i not in c]) for c in itertools.combinations(range(n), n // 2)]
        permuted = [welch(d[one], d[other]) >= welch(a, b) * (1 - 1e-9) for one, other in split]
        yield {"d": d, "t": test.z, "p": (largest >= np.abs(test.z).max() * (1 - 1e-9)).mean(),
               "critical": np.sort(largest)[::-1][int(0.05 * 2 ** n) // 2],
               "band": of_residuals[int(0.05 * (2 ** n - 2))],
               "low": d.mean(axis=0) - of_residuals[int(0.05 * (2 ** n - 2))] * root,
               "runs": [[first, last, mass, (heaviest >= mass * (1 - 1e-9)).mean()] for first, last, mass in masses(test.z)],
               "skewness": np.median(np.abs(stats.skew(d, axis=0, bias=False))),
               "mean": (np.abs(signs @ d).max(axis=1) >= np.abs(d.sum(axis=0)).max() * (1 - 1e-9)).mean(),
               "groups": np.mean(permuted)}


def correlations(rng):
    """Repeated-measures correlations by pingouin."""
    for n, k in ((3, 3), (6, 2), (8, 4), (20, 3), (5, 9)):
        level = rng.normal(size=(n, 1)) * 3
        x = level + rng.normal(size=(n, k))
        y = rng.normal(size=(n, k)) - 2 * level + rng.uniform(-2, 2) * x
        long = pd.DataFrame({"who": np.repeat(np.arange(n), k), "x": x.ravel(), "y": y.ravel()})
        found = pingouin.rm_corr(long, x="x", y="y", subject="who").iloc[0]
        yield {"x": x, "y": y, "r": found.r, "df": found.dof, "p": found.iloc[2], "ci": [*found.iloc[3]]}


# F, and z at F = 1/4, 1/2 and 3/4. Weibull's is taken in ln x.
SIGMOIDS = {
    "norm": (ndtr, stats.norm.ppf([0.25, 0.5, 0.75])),
    "logistic": (expit, stats.logistic.ppf([0.25, 0.5, 0.75])),
    "weibull": (lambda z: -np.expm1(-np.exp(np.minimum(z, 700))), np.log(-np.log([0.75, 0.5, 0.25]))),
}


def least(x, n, k, asks, sigmoid, fixed=None, near=None, most_lapses=0.06, many=False, falls=False):
    """The smallest -ln L over m, ln sigma, (gamma and) lambda, from many starts or near one, one number of the curve held.

    Few levels or answers can have a best curve at and between any two levels. Of curves that fall F and 1 - F change places.
    """
    rising, (low, middle, high) = SIGMOIDS[sigmoid]
    share = (lambda z: 1 - rising(z)) if falls else rising
    u = np.log(x) if sigmoid == "weibull" else x
    back = np.exp if sigmoid == "weibull" else (lambda value: value)

    def read(m, scale):
        return back(m + scale * middle), (back(m + scale * high) - back(m + scale * low)) / 2

    def ends(p):
        return {"more": (p[-1], p[-1]), "right": (0.5, p[-1]), "yes": (p[-2], p[-1])}[asks]

    def shape(p):
        """m and sigma; what is held decides about one of them."""
        if fixed is None:
            return p[0], np.exp(p[1])
        scale = np.exp(p[0])
        what, value = fixed
        if what == "threshold":
            return (np.log(value) if sigmoid == "weibull" else value) - scale * middle, scale
        if sigmoid == "weibull":
            return np.log(value / read(0.0, scale)[1]), scale
        return p[0], value / read(0.0, 1.0)[1]

    def shares(p):
        m, scale = shape(p)
        gamma, lapse = ends(p)
        return np.clip(gamma + (1 - gamma - lapse) * share((u - m) / scale), 1e-300, 1 - 1e-16)

    def cost(p):
        psi = shares(p)
        return -(k * np.log(psi) + (n - k) * np.log1p(-psi)).sum()

    shown = u[x > 1e-6] if sigmoid == "weibull" else u  # ln 0
    span = shown[-1] - shown[0]
    ends_of_lapses = [(0.0, 0.5)] * (asks == "yes") + [(0.0, most_lapses)]
    bounds = [(shown[0] - 4 * span, shown[-1] + 4 * span), (-6.0, 4.0)] + ends_of_lapses
    if near is None:
        lapses = [[0.1]] * (asks == "yes") + [[0.02]]
        places, scales = shown[0] + span * np.array([0.35, 0.65]), span * np.array([0.1, 0.3])
        if many:
            # A step between two levels is the best curve where many lapse.
            lapses = [[0.1, 0.4]] * (asks == "yes") + [[0.02, 0.9 * most_lapses]]
            places = np.concatenate([shown, (shown[1:] + shown[:-1]) / 2])
            scales = np.geomspace(np.diff(shown).min() / 20, span, 8)
        starts = itertools.product(places, np.log(scales), *lapses)
    else:
        starts = [near]
    if fixed is not None:
        drop = 1 if fixed[0] == "jnd" and sigmoid != "weibull" else 0
        starts = [np.delete(start, drop) for start in starts]
        bounds.pop(drop)
        if fixed[0] == "jnd":
            # Wherever the threshold lies between the levels, with any lapse: a held JND has a best place between any two.
            places = np.linspace(shown[0], shown[-1], 49)
            free = np.log(fixed[1] / np.exp(places) / 0.786) if sigmoid == "weibull" else places
            starts = starts + [np.array([place, *near[2:-1], lapse]) for place in free for lapse in (near[-1], most_lapses)]
    starts = sorted(starts, key=cost)[:8]
    rough = min((minimize(cost, start, method="L-BFGS-B", bounds=bounds) for start in starts), key=lambda one: one.fun)
    best = minimize(cost, rough.x, method="Nelder-Mead", bounds=bounds, options={"xatol": 1e-9, "fatol": 1e-12, "maxiter": 4000})
    return best.fun, read(*shape(best.x)), ends(best.x), best.x, shares(best.x)


def psychometric(rng):
    """Maximum likelihood of a curve and its profile intervals, by SciPy from many starts.

    Answers of half of the curves scatter more than binomial ones, and their intervals are those of F(1, K - P).
    """
    every = list(itertools.product(("more", "right", "yes"), SIGMOIDS))
    for asks, sigmoid in (every[i] for i in rng.permutation(len(every))[:3]):
        x = np.arange(7.0) + (asks != "yes") * 2
        truth = 0.5 if asks == "right" else 0.1 if asks == "yes" else 0.02
        n = np.full(7, rng.integers(40, 90))
        z = (x - x.mean() - rng.uniform(-0.5, 0.5)) / rng.uniform(1.3, 1.8)
        psi = truth + (0.97 - truth) * ndtr(z)
        scatters = bool(rng.integers(2))
        k = rng.binomial(n, rng.beta(psi * (0.12 ** -2 - 1), (1 - psi) * (0.12 ** -2 - 1)) if scatters else psi)
        if sigmoid == "weibull" and asks == "yes":
            x[0] = 1e-300  # F is 0 there as at 0, whose logarithm NumPy warns of
        value, (threshold, jnd), (gamma, lapse), near, psi = least(x, n, k, asks, sigmoid)
        left = len(x) - len(near)
        phi = max(1.0, ((k - n * psi) ** 2 / (n * psi * (1 - psi))).sum() / left) if scatters else 1.0
        half = phi * (stats.f.ppf(0.95, 1, left) if phi > 1 else stats.chi2.ppf(0.95, 1)) / 2

        def end(what, estimate, far):
            over = lambda at: least(x, n, k, asks, sigmoid, (what, at), near)[0] - value - half
            return brentq(over, estimate, far, xtol=1e-6) if over(far) > 0 else None

        yield {"x": x * (x > 1e-6), "n": n, "k": k, "asks": asks, "sigmoid": sigmoid, "is_constant": scatters,
               "log_likelihood": -value, "threshold": threshold, "jnd": jnd, "guess": gamma, "lapse": lapse, "dispersion": phi,
               "threshold_low": end("threshold", threshold, 0.3), "threshold_high": end("threshold", threshold, 12),
               "jnd_low": end("jnd", jnd, 0.1), "jnd_high": end("jnd", jnd, 12)}


# Twice this difference of ln L is the 95 % point of chi-squared with one degree of freedom.
SLOPE = stats.chi2.ppf(0.95, 1)
# What is nearer than this to where a verdict changes is not compared, nor a search that ended at its bounds.
EDGE = 1e-3


def verdict(x, n, k, asks, sigmoid, most_lapses):
    """The verdict of docs/analysis.md by its definition, or None near where it changes; and the best rising curve."""
    best = least(x, n, k, asks, sigmoid, most_lapses=most_lapses, many=True)
    value, (threshold, jnd), _, (m, ln_scale, *_), _ = best
    falls = -least(x, n, k, asks, sigmoid, most_lapses=most_lapses, many=True, falls=True)[0]
    share = k.sum() / n.sum()
    of_all = lambda at: stats.binom.logpmf(k, n, at).sum() - stats.binom.logpmf(k, n, k / n).sum()
    full = np.nansum(k * np.log(np.where(k > 0, k / n, 1)) + (n - k) * np.log(np.where(k < n, 1 - k / n, 1)))
    lowest, half = {"more": (0.0, (0.5, 0.5)), "right": (0.5, ((1.5 - most_lapses) / 2, 0.75)),
                    "yes": (0.0, ((1 - most_lapses) / 2, 0.75))}[asks]
    constant = of_all(max(share, lowest))
    rising, falling, from_half = (2 * (to - at) for to, at in (
        (-value - full, constant), (falls - full, constant), (constant, of_all(np.clip(share, *half)))))
    near = lambda *numbers: any(abs(number) < EDGE for number in numbers)
    if n.sum() < 30:  # of three levels or more
        return "too few", best
    if near(falling - SLOPE, rising - SLOPE) or (max(falling, rising) > SLOPE and near(falling - rising)):
        return None, best
    if falling > rising and falling > SLOPE:
        return "falling", best
    below = "flat" if asks == "yes" else "below"
    if rising < SLOPE:
        if near(from_half - SLOPE):
            return None, best
        return "flat" if from_half < SLOPE else below if share > half[1] else "above", best
    u = np.log(x[x > 1e-6]) if sigmoid == "weibull" else x
    if abs(m - u.mean()) > 4 * np.ptp(u) or ln_scale > 3.9:
        return None, best
    # A step through the share of a level may lie on either side of it, with another lapse.
    if 2 * jnd < np.diff(x).max() and (abs(x - threshold) < 2 * jnd).any():
        return None, best
    gaps = np.diff(x)[(x[:-1] - EDGE < threshold) & (threshold < x[1:] + EDGE)]
    if near(*(x - threshold), *(2 * jnd / gaps - 1), jnd / np.ptp(x) / 10 - 1):
        return None, best
    if jnd > 10 * np.ptp(x):
        return "flat", best
    if not x[0] <= threshold <= x[-1]:
        return below if threshold < x[0] else "above", best
    return "steep" if 2 * jnd < gaps.max() else "estimated", best


def plans(rng):
    """Verdicts, and maximum likelihood from many starts, of any plan: few levels and answers, thresholds beyond the levels."""
    for asks, sigmoid in itertools.product(("more", "right", "yes"), SIGMOIDS):
        for most_lapses in (0.06, 0.06, 0.3):
            levels = rng.integers(5, 10)
            x = np.cumsum(rng.choice([0.5, 1.0, 1.0, 2.0], levels)) + rng.integers(0, 9)
            x[0] = 0 if asks == "yes" else x[0]
            n = np.full(levels, rng.integers(5, 61)) if rng.integers(2) else rng.integers(5, 61, levels)
            guess = {"more": 0.02, "right": 0.5, "yes": 0.1}[asks]
            z = (x - x[0] - rng.uniform(-0.1, 1.1) * np.ptp(x)) / (np.ptp(x) * np.exp(rng.uniform(np.log(0.03), 0.0)))
            psi = guess + (1 - guess - rng.uniform(0, 0.06)) * ndtr(-z if rng.integers(8) == 0 else z)
            k = rng.binomial(n, psi)
            x[0] = max(x[0], 1e-300 if sigmoid == "weibull" else 0)
            word, (value, (threshold, jnd), (gamma, lapse), *_) = verdict(x, n, k, asks, sigmoid, most_lapses)
            unit = rng.choice([1.0, 30.0, 1 / 64])  # N/m, or N
            yield {"x": x * (x > 1e-6) * unit, "n": n, "k": k, "asks": asks, "sigmoid": sigmoid, "most_lapses": most_lapses,
                   "verdict": word, "log_likelihood": -value, "threshold": threshold * unit, "jnd": jnd * unit,
                   "guess": gamma, "lapse": lapse}


LINKS = {"norm": links.Probit(), "logistic": links.Logit(), "weibull": links.CLogLog()}


def without_lapses(rng):
    """Curves without lapses are generalised linear models: statsmodels' estimates, profiles of the deviance, Wald's errors.

    A held threshold leaves a slope over the distance from it; a held JND (but Weibull's) leaves the constant.
    """
    for sigmoid, many in itertools.product(SIGMOIDS, (False, True)):
        scatters = bool(rng.integers(2))
        quarter = np.diff(SIGMOIDS[sigmoid][1][[0, 2]])[0] / 2
        middle = SIGMOIDS[sigmoid][1][1]
        while True:
            levels = rng.integers(5, 10)
            x = np.cumsum(rng.choice([0.5, 1.0, 2.0], levels)) + 2
            u = np.log(x) if sigmoid == "weibull" else x
            n = np.full(levels, 20_000) if many else rng.integers(15, 61, levels)
            z = (x - x[0] - rng.uniform(0.3, 0.7) * np.ptp(x)) / (np.ptp(x) * rng.uniform(0.15, 0.3))
            psi = ndtr(z) if not many else SIGMOIDS[sigmoid][0](z if sigmoid != "weibull" else (u - u.mean()) / 0.4)
            spread = 0.15 ** -2 - 1
            k = rng.binomial(n, rng.beta(psi * spread, (1 - psi) * spread) if scatters and not many else psi)
            counts = np.column_stack([k, n - k])
            fitted = lambda design, offset=None: sm.GLM(
                counts, design, offset=offset, family=sm.families.Binomial(link=LINKS[sigmoid])).fit(tol=1e-10)
            found = fitted(sm.add_constant(u)) if ((k > 0) & (k < n)).sum() >= 3 else None
            # Neither separated nor steep.
            if found and 2 * quarter / found.params[1] > 1.2 * np.diff(u).max():
                break
        (b0, b1), covariance = found.params, found.cov_params()
        at, scale = (middle - b0) / b1, 1 / b1

        def read(b):
            """The threshold as a level, and ln JND."""
            lower, center, upper = (SIGMOIDS[sigmoid][1] - b[0]) / b[1]
            if sigmoid == "weibull":
                return np.array([np.exp(center), np.log((np.exp(upper) - np.exp(lower)) / 2)])
            return np.array([center, np.log((upper - lower) / 2)])

        steps = np.diag(1e-4 * np.sqrt(np.diag(covariance)))
        slopes = np.array([(read(found.params + step) - read(found.params - step)) / (2 * step.sum()) for step in steps])
        error, ln_error = np.sqrt(np.diag(slopes.T @ covariance @ slopes))
        phi = max(1.0, found.pearson_chi2 / (levels - 2)) if scatters else 1.0
        critical = phi * (stats.f.ppf(0.95, 1, levels - 2) if phi > 1 else stats.chi2.ppf(0.95, 1))
        held_threshold = lambda value: fitted((u - value)[:, None], np.full(levels, middle)).deviance
        held_jnd = lambda value: fitted(np.ones((levels, 1)), quarter / np.exp(value) * u).deviance

        def end(held, estimate, step):
            over = lambda value: held(value) - found.deviance - critical
            far = step
            while over(estimate + far) < 0 and abs(far) < 64 * abs(step):
                far *= 2
            return brentq(over, estimate, estimate + far, xtol=1e-12) if over(estimate + far) > 0 else None

        spread = np.sqrt(critical)
        of_threshold = error / np.exp(at) if sigmoid == "weibull" else error
        ends = [end(held_threshold, at, sign * spread * of_threshold) for sign in (-1, 1)]
        of_jnd = [None, None] if sigmoid == "weibull" else [
            end(held_jnd, np.log(quarter * scale), sign * spread * ln_error) for sign in (-1, 1)]
        shown = lambda values, read: [None if value is None else read(value) for value in values]
        yield {"x": x, "n": n, "k": k, "asks": "more", "sigmoid": sigmoid, "is_constant": scatters, "many": many,
               "location": -b0 / b1, "scale": scale, "deviance": found.deviance, "dispersion": phi,
               "threshold_ci": shown(ends, np.exp if sigmoid == "weibull" else float), "jnd_ci": shown(of_jnd, np.exp),
               "threshold_error": np.sqrt(phi) * error,
               "ln_jnd_error": np.sqrt(phi) * ln_error}


def posteriors(rng):
    """psignifit's posterior: its modes, means of its masses, and the ends of its intervals with the cells of its grid.

    Of "which was more" it counts the prior of lambda twice, so it is given the root of it. Weibull's levels are ln x.
    """
    kinds = {"more": "equal asymptote", "right": "2AFC", "yes": "yes/no"}
    rare = lambda lapse: np.sqrt(stats.beta.pdf(lapse, 1, 10))
    every = [each for each in itertools.product(kinds, SIGMOIDS) if each != ("yes", "weibull")]  # ln 0
    for asks, sigmoid in [every[i] for i in rng.permutation(len(every))[:4]] + [("right", "norm")]:
        scatter = 0.2 if asks == "right" and rng.integers(2) else 0.0
        x = np.cumsum(rng.choice([0.5, 1.0, 1.5], rng.integers(6, 10))) + 1
        x[0] = 0 if asks == "yes" else x[0]
        n = np.full(len(x), rng.integers(30, 61))
        guess = {"more": 0.02, "right": 0.5, "yes": 0.1}[asks]
        z = (x - x[0] - rng.uniform(0.4, 0.6) * np.ptp(x)) / (np.ptp(x) * rng.uniform(0.15, 0.25))
        psi = guess + (0.98 - guess) * ndtr(z)
        k = rng.binomial(n, psi if scatter == 0 else rng.beta(psi * (scatter ** -2 - 1), (1 - psi) * (scatter ** -2 - 1)))
        is_log = sigmoid == "weibull"
        found = psignifit.psignifit(
            np.column_stack([np.log(x) if is_log else x, k, n]), experiment_type=kinds[asks], sigmoid=sigmoid, verbose=False, debug=True,
            fixed_parameters={} if scatter else {"eta": 0.0}, priors={"lambda": rare} if asks == "more" else None)
        masses = found.debug["posteriors"].sum(axis=tuple(range(found.debug["posteriors"].ndim - 2)))
        axes = found.parameter_values
        at, width = np.meshgrid(axes["threshold"], axes["width"], indexing="ij")
        F, (low, middle, high) = SIGMOIDS[sigmoid]
        one = brentq(lambda z: F(z) - 0.95, -5, 5, xtol=1e-14) - brentq(lambda z: F(z) - 0.05, -5, 5, xtol=1e-14)

        def read(at, width):
            """The threshold and the JND, in levels."""
            lower, upper = at + width / one * (low - middle), at + width / one * (high - middle)
            return (np.exp(at), (np.exp(upper) - np.exp(lower)) / 2) if is_log else (at, (upper - lower) / 2)

        mode, ends = found.parameter_estimate_MAP, found.confidence_intervals
        threshold_cell, width_cell = (np.diff(axes[name])[0] for name in ("threshold", "width"))
        yield {"x": x, "n": n, "k": k, "asks": asks, "sigmoid": sigmoid, "scatters": scatter > 0,
               "mode": [*read(mode["threshold"], mode["width"]), mode["lambda"]],
               "mean": [*((masses * values).sum() for values in read(at, width)), found.parameter_estimate_mean["lambda"]],
               "eta": found.parameter_estimate_mean["eta"],
               "threshold_ci": ends["threshold"]["0.95"], "threshold_cell": threshold_cell,
               # Weibull's JND is no width.
               "jnd_ci": None if is_log else read(0.0, np.array(ends["width"]["0.95"]))[1],
               "jnd_cell": None if is_log else read(0.0, width_cell)[1]}


def weighted(rng):
    """Two-level means: tau squared by its definition (Paule and Mandel), the rest by statsmodels (Hartung and Knapp).

    statsmodels' own search for tau squared gives 0 where its last step is too far by rounding.
    """
    for k, scatter in ((2, 1.0), (3, 0.0), (5, 1.0), (8, 0.3), (12, 2.0), (20, 0.5)):
        variances = rng.uniform(0.1, 2.0, k)
        y = 1 + rng.normal(size=k) * np.sqrt(variances + scatter ** 2)
        over = lambda tau2: combine_effects(y, variances + tau2).q - (k - 1)
        tau2 = brentq(over, 0, 100, xtol=1e-14) if over(0) > 0 else 0.0
        found = combine_effects(y, variances + tau2)
        yield {"y": y, "v": variances, "tau2": tau2, "mean": found.mean_effect_fe, "se": found.sd_eff_w_fe_hksj}


def plain(value):
    """Arrays and NumPy's numbers as JSON has them."""
    return value.tolist()


rounds, seed = (int(given) for given in (sys.argv[1:] + ["1", "20240601"][len(sys.argv) - 1:])[:2])
rng = np.random.default_rng(seed)
kinds = (differences, paired, friedman, holm, orders, bca, repeated, curves, correlations, psychometric, plans,
         without_lapses, posteriors, weighted)
cases = {f.__name__: [case for _ in range(rounds) for case in f(rng)] for f in kinds}
print(json.dumps(cases, default=plain, allow_nan=False))
