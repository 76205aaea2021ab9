"""The stage `compare` against pandas, SciPy and statsmodels: a simulated study of six people in two sessions."""

import tempfile
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
from scipy import stats
from scipy.special import gammaln
from statsmodels.stats.multitest import multipletests

import tidy
from checks import check, close, equal, run

STUDY = "six"
PEOPLE, SESSIONS = 6, 2
# Numbers that come of a t distribution have nine digits.
DIGITS = 2e-8
# The twin's lever.
LEVER_M = 0.045


def study(zwidth):
    """Simulates, compares and checks every metric of a study."""
    with tempfile.TemporaryDirectory() as folder:
        run(zwidth, "--root", folder, "twin", STUDY, "--participants", PEOPLE, "--sessions", SESSIONS, "--quiet")
        run(zwidth, "--root", folder, "run", STUDY, "--only", "compare", "--quiet")
        made(Path(folder) / "derived" / STUDY)


def made(derived):
    """Every contrast of a study of the twin, from the trials again."""
    metrics = pd.read_parquet(derived / "metrics.parquet")
    compared = pd.read_parquet(derived / "compare" / "compared.parquet")["metric"]
    check(f"{derived.name}: some metrics are compared", len(compared) > 3, str(len(compared)))
    for metric in compared:
        found = tidy.rows(derived / "compare", "contrasts", metric)
        if metrics["participant"].nunique() > 1:
            contrasts(metrics, found, metric)
        else:
            within(found, metric)


def within(found, metric):
    """One person: claims rest on the orders, whose p values Rust's tests count by hand."""
    adjusted = multipletests(found["p_sharp_null"], method="holm")[1]
    for (_, row), p in zip(found.iterrows(), adjusted):
        close(f"{metric}: Holm", row["p_adjusted"], p, DIGITS)
        verdict(metric, row, "different" if p < 0.05 else "undecided")


def tied(differences):
    """The differences, those of one size to 1e-9 of the largest made equal."""
    sizes = np.abs(differences)
    order = np.argsort(sizes)
    steps = np.diff(sizes[order], prepend=0) > 1e-9 * sizes.max()
    found = np.empty_like(sizes)
    found[order] = np.cumsum(steps)
    return np.sign(differences) * found


def ranked(differences):
    """All flips of the signs of ranks: SciPy's exact signed-rank test leaves ties out of account."""
    ranks = np.sign(differences) * stats.rankdata(np.abs(differences))
    return stats.permutation_test((ranks,), np.sum, permutation_type="samples", n_resamples=np.inf).pvalue


def stem(table, name):
    """The column of that stem, whatever its unit."""
    endings = ["", "_n", "_rad", "_s", "_j", "_n_per_rad"]
    found = [name + ending for ending in endings if name + ending in table]
    return table[found[0]]


def contrasts(metrics, found, metric):
    """One metric: everything from the trials again."""
    cells = metrics.dropna(subset=[metric]).groupby(["participant", "session", "environment", "mode"])[metric].mean()
    p_values = []
    for i, row in found.iterrows():
        label = f"{metric}: {row['environment']}, {row['contrast']}"
        mode, against = row["contrast"].split(" − ")
        of = cells.xs(row["environment"], level="environment").unstack("mode")
        pairs = of[[mode, against]].dropna().groupby("participant").mean()
        differences = (pairs[mode] - pairs[against]).to_numpy()
        equal(f"{label}: n counts participants", row["n"], len(differences))
        equal(f"{label}: the unit", row["unit_of_analysis"], "participants")
        close(f"{label}: difference", stem(found, "difference")[i], differences.mean(), 1e-9)
        test = stats.ttest_rel(pairs[mode], pairs[against])
        ends = test.confidence_interval(0.95)
        for name, expect in [
            ("difference_std_error", stats.sem(differences)),
            ("statistic", test.statistic),
            ("p_value", test.pvalue),
            ("g_av", unbiased_d_av(pairs[mode].to_numpy(), pairs[against].to_numpy())),
            ("p_sign_flip", flipped(differences)),
        ]:
            close(f"{label}: {name}", stem(found, name)[i], expect, DIGITS)
        # Of an end near zero the distance from the difference has the nine digits.
        for name, expect in [("difference_ci_low", ends.low), ("difference_ci_high", ends.high)]:
            mean = differences.mean()
            close(f"{label}: {name}", stem(found, name)[i] - mean, expect - mean, DIGITS)
        # Differences that rounding alone tells apart are tied, as `zwidth_stats::signed_rank` says.
        close(f"{label}: signed rank", row["p_signed_rank"], ranked(tied(differences)), DIGITS)
        p_values.append(test.pvalue)
    adjusted = multipletests(p_values, method="holm")[1]
    for found_p, expect in zip(found["p_adjusted"], adjusted):
        close(f"{metric}: Holm", found_p, expect, DIGITS)
    for (_, row), p in zip(found.iterrows(), adjusted):
        verdict(metric, row, "different" if p < 0.05 else "undecided")


def verdict(metric, row, existence):
    """Both parts of a verdict, by the rule of docs/analysis.md."""
    label = f"{metric}: {row['environment']}, {row['contrast']}"
    equal(f"{label}: existence", row["verdict"], existence)
    share = {"n": 0.07, "rad": None, "n_per_rad": 0.08, "j": 0.07}
    unit = next((u for u in sorted(share, key=len, reverse=True) if metric.endswith("_" + u)), None)
    if unit is None or "size" not in row:
        check(f"{label}: no size without a difference that is just noticed", "size" not in row, "")
        return
    value = lambda name: row[f"{name}_{unit}"]
    base = value("commanded") if f"commanded_{unit}" in row else value("mean_second")
    least = {"n": 0.05, "j": 0.05 * LEVER_M * np.radians(2)}.get(unit, 0)
    jnd = np.radians(2) if unit == "rad" else max(share[unit] * abs(base), least)
    close(f"{label}: JND", value("jnd"), jnd, 1e-12)
    low, high = value("difference_ci_low") / jnd, value("difference_ci_high") / jnd
    size = "felt" if low > 1 or high < -1 else "below what is felt" if -1 < low and high < 1 else "may be felt"
    equal(f"{label}: size", row["size"], size)
    print(f"{label}: {existence}, {size}: {value('difference') / jnd:.2g} JND [{low:.2g}, {high:.2g}]")


def unbiased_d_av(one, other):
    """d_av without its bias where people are few, as docs/analysis.md has it."""
    covariances = np.cov(one, other)
    df = (len(one) - 1) * np.trace(covariances) ** 2 / (covariances ** 2).sum()
    d = (one - other).mean() / np.sqrt(np.trace(covariances) / 2)
    return d * np.exp(gammaln(df / 2) - gammaln((df - 1) / 2)) / np.sqrt(df / 2)


def flipped(differences):
    """The sign-flip test, every flip counted."""
    sums = [abs(np.dot(signs, differences)) for signs in product([1, -1], repeat=len(differences))]
    return np.mean(np.array(sums) >= abs(differences.sum()) * (1 - 1e-9))
