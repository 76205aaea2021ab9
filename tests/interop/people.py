"""Verdicts of a study of several people, from recordings that others made: each session of the haptic paddle as a person.

Who moved the paddle is not known, so this says nothing of people: it holds `zwidth compare` against the recordings
themselves, from the samples to the verdict. The torque is taken as a force at a lever of 70 mm, so that the metrics in N have a
just noticeable difference. Three rules of `[compare]` give each word that a verdict can have.
"""

import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
from scipy import stats
from statsmodels.stats.multitest import multipletests

import tidy
from checks import check, close, equal, run
from paddle import CONTRASTS, MODES, RATE_HZ, duration

STUDY = "paddlers"
SESSIONS = [9, 10, 11, 12]
LEVER_M = 0.07
# `[perception]`: the share of a force that is just noticed, and the least force.
SHARE, LEAST_N = 0.07, 0.05
# alpha, the level of intervals, and bounds of metrics in their units.
RULES = [
    (0.05, 0.95, {}),
    (0.4, 0.5, {"duration_s": 3.0, "force_largest_n": 0.16, "force_mean_n": 0.03}),
    (0.05, 0.95, {"duration_s": 20.0, "force_largest_n": 2.0, "force_mean_n": 0.05}),
]
METRICS = ["duration_s", "force_largest_n", "force_mean_n"]
# Numbers that come of a t distribution have nine digits, and sums of a few numbers more.
DIGITS, SUMS = 2e-8, 1e-12


def check_all(zwidth, real, mappings):
    """Every contrast of every metric, by each rule; all words of a verdict must have been seen."""
    files = sorted((real / "ethz_haptic_paddle/transparency").glob("*/*.csv"))
    values = measured(real / "ethz_haptic_paddle/transparency")
    seen = set()
    for number, rule in enumerate(RULES):
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder)
            lay_down(root, mappings / "ethz", rule)
            run(zwidth, "--root", root, "import", STUDY, "--map", root / "map.toml", *files)
            run(zwidth, "--root", root, "run", STUDY, "--only", "compare", "--quiet")
            for metric in METRICS:
                table = tidy.rows(root / f"derived/{STUDY}/compare", "contrasts", metric)
                seen |= verdicts(f"{STUDY} {number}, {metric}", table, values[metric], metric, rule)
    words = {"different", "different, within the bound", "equivalent", "undecided", "felt", "may be felt", "below what is felt"}
    equal("paddlers: words of verdicts that were seen", seen, words)


def lay_down(root, mappings, rule):
    """The paddle's study and mapping, with a person for each session and a force for the torque."""
    alpha, level, bounds = rule
    study = replaced((mappings / "study.toml").read_text(), {
        'id = "ethz"': f'id = "{STUDY}"',
        'name = "one-axis haptic paddle"': f'name = "one-axis haptic paddle"\nlever_m = {LEVER_M}',
    })
    study += f"\n[compare]\nmetrics = {METRICS}\nalpha = {alpha}\nlevel = {level}\n\n[compare.bounds]\n"
    study += "".join(f"{metric} = {bound}\n" for metric, bound in bounds.items())
    mapping = replaced((mappings / "map-transparency.toml").read_text(), {
        'participant = "P01"': 'participant = { name = "session", prefix = "P", digits = 2 }',
        'session = { name = "session", prefix = "S", digits = 2 }': 'session = "S01"',
        'to = "torque_ex_nm"': 'to = "force_ex_n"',
        'unit = "N·m"': f'unit = "N"\nscale = {1 / LEVER_M!r}',
    })
    raw = root / "raw" / STUDY
    raw.mkdir(parents=True)
    (raw / "study.toml").write_text(study)
    (root / "map.toml").write_text(mapping)


def replaced(text, words):
    """The text with each of these replaced, which must stand in it once."""
    for old, new in words.items():
        if text.count(old) != 1:
            raise SystemExit(f"{old!r} stands {text.count(old)} times in the paddle's files")
        text = text.replace(old, new)
    return text


def measured(folder):
    """Each metric by person and mode, from the recordings."""
    rows = []
    for session in SESSIONS:
        for mode in MODES:
            file = folder / f"session_{session}/{mode}.csv"
            force = pd.read_csv(file)["torque_Nm"].to_numpy() * (1 / LEVER_M)
            mean = np.trapezoid(force) / (len(force) - 1)
            largest = force[np.argmax(np.abs(force))]
            rows.append((session, mode, duration(file), largest, mean))
    table = pd.DataFrame(rows, columns=["person", "mode", *METRICS])
    return {metric: table.pivot(index="person", columns="mode", values=metric) for metric in METRICS}


def verdicts(label, found, values, metric, rule):
    """One metric's contrasts by one rule; the words of their verdicts."""
    alpha, level, bounds = rule
    tests, words, bound = {}, set(), bounds.get(metric)
    for mode, against in CONTRASTS:
        tests[mode, against] = stats.ttest_rel(values[mode], values[against])
    adjusted = multipletests([test.pvalue for test in tests.values()], method="holm")[1]
    equal(f"{label}: contrasts", found["contrast"].tolist(), [f"{mode} − {against}" for mode, against in CONTRASTS])
    for ((mode, against), test), p, (_, row) in zip(tests.items(), adjusted, found.iterrows()):
        name = f"{label}: {mode} − {against}"
        unit = metric.rsplit("_", 1)[1]
        differences = (values[mode] - values[against]).to_numpy()
        mean, error = differences.mean(), stats.sem(differences)
        ends = test.confidence_interval(level)
        equal(f"{name}: n", row["n"], len(SESSIONS))
        close(f"{name}: difference", row[f"difference_{unit}"], mean, 1e-9)
        for column, expect in [("p_value", test.pvalue), ("p_adjusted", p), (f"difference_ci_low_{unit}", ends.low), (f"difference_ci_high_{unit}", ends.high)]:
            close(f"{name}: {column}", row[column], expect, DIGITS)
        within = False
        if bound is not None:
            # Two one-sided tests (Schuirmann 1987): the larger of their p values.
            sides = [stats.t.sf((bound - mean) / error, len(SESSIONS) - 1), stats.t.sf((bound + mean) / error, len(SESSIONS) - 1)]
            close(f"{name}: p of the bound", row["p_not_equivalent"], max(sides), DIGITS)
            within = max(sides) < alpha
        existence = {(True, True): "different, within the bound", (True, False): "different", (False, True): "equivalent", (False, False): "undecided"}[p < alpha, within]
        equal(f"{name}: existence", row["verdict"], existence)
        words.add(existence)
        if unit != "n":
            check(f"{name}: a time has no size", "size" not in row, "it has one")
            continue
        jnd = max(SHARE * abs(values[against].mean()), LEAST_N)
        close(f"{name}: JND", row["jnd_n"], jnd, SUMS)
        low, high = ends.low / jnd, ends.high / jnd
        size = "felt" if low > 1 or high < -1 else "below what is felt" if -1 < low and high < 1 else "may be felt"
        equal(f"{name}: size", row["size"], size)
        words.add(size)
    return words
