"""`zwidth compare --peers`: every number that it says other programs print, against what they print."""

import json
import subprocess
import tempfile
import warnings
from pathlib import Path

import pandas as pd

from checks import check, close, equal, run

STUDY = "peers"
PEOPLE = 6
# Numbers that come of a t distribution have nine digits; optimisers end near the optimum, not at it.
DIGITS, OPTIMISED = 2e-8, 1e-6
# statsmodels prints three decimals, and at a variance of zero stops where it likes.
PRINTED = 6e-4
COLUMNS = ["difference_n", "difference_std_error_n", "df", "statistic", "p_value"]


def h(a, b, c=0):
    """A number between −1/2 and 1/2 that is the same everywhere."""
    return ((1 + 131 * a + 173 * b + 197 * c) ** 3 % 9941) / 9941 - 0.5


def complete(p, m, r):
    """People differ in their level and in every mode."""
    return 3 + 0.3 * m + 0.8 * h(p, 0) + 0.5 * h(p, m + 1) + 0.6 * h(p, m + 1, r + 1)


def missing_trials(p, m, r):
    """The same without every seventh trial."""
    return None if (p + 2 * m + 3 * r) % 7 == 0 else complete(p, m, r)


def lacks_mode(p, m, r):
    """The third participant has none of the third mode."""
    return None if (p, m) == (2, 2) else complete(p, m, r)


def no_variance(p, m, r):
    """People differ less than their trials let one expect: every variance between them is zero."""
    own = sum(h(3 * p + m, 7 * q + 1) for q in range(6)) / 6
    return 3 + 0.3 * m + 0.6 * h(3 * p + m, 7 * r + 1) - 0.54 * own


STUDIES = {"complete": complete, "missing_trials": missing_trials, "lacks_mode": lacks_mode, "no_variance": no_variance}


def check_all(zwidth):
    """One study, four metrics; each difference of modes by every program."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        run(zwidth, "--root", root, "twin", STUDY, "--participants", PEOPLE, "--sessions", 1, "--rate", 100, "--quiet")
        keys = ["participant", "session", "trial", "environment", "mode", "repeat", "kind"]
        trials = pd.read_parquet(root / "raw" / STUDY / "trials", columns=keys)
        trials = trials.astype({key: str for key in keys if key not in ("trial", "repeat")}).drop_duplicates()
        trials = trials[trials["kind"] == "trial"].sort_values(["participant", "trial"])
        people, modes = sorted(trials["participant"].unique()), ["active", "passive", "hybrid"]
        for name, formula in STUDIES.items():
            rows = zip(trials["participant"], trials["mode"], trials["repeat"], strict=True)
            values = [formula(people.index(p), modes.index(m), int(r) - 1) for p, m, r in rows]
            trials[name] = pd.array([None if value is None else round(value, 4) for value in values], dtype="Float64")
            given = trials[["participant", "session", "trial", name]].rename(columns={name: "value"})
            given.to_csv(root / f"{name}.csv", index=False)
            run(
                zwidth, "--root", root, "metric", STUDY, "--from", root / f"{name}.csv", "--id", name, "--unit", "N",
                "--label", name.replace("_", " "), "--program", "formula 1",
            )  # fmt: skip
        for name in STUDIES:
            column = f"own_{name}_n"
            listed = json.loads(run(zwidth, "--root", root, "--json", "compare", STUDY, "--peers", "--metric", column, codes=(0, 3)))
            found = pd.DataFrame(listed[0]["rows"])
            place = found["environment"].iloc[0]
            own = trials[(trials["environment"] == place) & trials[name].notna()]
            data = own[["participant", "mode"]].assign(value=own[name].astype(float)).reset_index(drop=True)
            compared(name, found[found["environment"] == place], data, root)


def compared(name, found, data, root):
    """The rows of one environment against the programs."""
    contrasts = sorted(found["contrast"].unique())
    check(f"peers: {name}: two contrasts, ten programs each", len(contrasts) == 2 and len(found) == 20, f"{len(found)}")
    by_r = r(data, root)
    for contrast in contrasts:
        first, against = contrast.split(" − ")
        rows = found[found["contrast"] == contrast].set_index("program")
        where = f"peers: {name}, {contrast}"
        for program, call in (
            ("lmerTest", "intercept"),
            ("lmerTest, with participant:mode", "modes"),
            ("pbkrtest, with participant:mode", "kenward_roger"),
        ):
            theirs = by_r[call][f"{first} {against}"]
            numbers(f"{where}: {program}", rows.loc[program], theirs, COLUMNS, OPTIMISED)
            check(f"{where}: {program} prints no interval", rows.loc[program, ["difference_ci_low_n", "effect_size"]].isna().all())
        emmeans(where, rows.loc["emmeans, with participant:mode"], by_r["emmeans"][f"{first} {against}"])
        statsmodels(where, name, rows.loc["statsmodels"], data, first, against)
        pingouin(where, rows.loc["pingouin"], data, first, against)
        for program, vcov in (("pyfixest", None), ("pyfixest, clustered", {"CRV1": "participant"})):
            pyfixest(f"{where}: {program}", rows.loc[program], data, first, against, vcov)
    if name == "lacks_mode":
        out = found.set_index("program")["left_out"]
        names = sorted(data["participant"].unique())
        equal("peers: pingouin leaves out who lacks a mode, also of the other pair", out.loc["pingouin"].tolist(), [names[2]] * 2)
    if name == "no_variance":
        df = found.set_index("program")["df"]
        each = ["zwidth", "zwidth, mixed model", "lmerTest", "pbkrtest, with participant:mode"]
        equal("peers: degrees of freedom at a variance of zero", [round(df.loc[own].iloc[0], 4) for own in each], [5, 10, 105, 10])


def numbers(name, row, theirs, columns, relative):
    """Some columns against the same numbers of another program; p, far out, changes a hundred times as fast as t."""
    for column, value in zip(columns, theirs, strict=True):
        close(f"{name}: {column}", row[column], value, relative * (100 if column == "p_value" else 1))


def r(data, root):
    """What peers.R prints."""
    data.to_csv(root / "values.csv", index=False)
    script = Path(__file__).parent / "stats/peers.R"
    done = subprocess.run(["Rscript", script, root / "values.csv"], capture_output=True, text=True, check=False)
    check("peers: R compares the modes", done.returncode == 0, done.stderr)
    return json.loads(done.stdout)


def emmeans(where, row, theirs):
    """Its p is held to the four decimals that it prints: R's `ptukey` is wrong by percents far out."""
    columns = ["difference_n", "difference_std_error_n", "df", "difference_ci_low_n", "difference_ci_high_n", "effect_size"]
    numbers(f"{where}: emmeans", row, theirs[:-1], columns, OPTIMISED)
    check(f"{where}: emmeans: p", abs(row["p_value"] - theirs[-1]) < 1e-6, f"{row['p_value']} {theirs[-1]}")


def statsmodels(where, name, row, data, first, against):
    """mixedlm, with the mode of comparison as the reference; three decimals are what it prints."""
    import statsmodels.formula.api as smf

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        fit = smf.mixedlm(f"value ~ C(mode, Treatment('{against}'))", data, groups="participant").fit()
    key = f"C(mode, Treatment('{against}'))[T.{first}]"
    low, high = fit.conf_int().loc[key]
    theirs = [fit.fe_params[key], fit.bse_fe[key], low, high, fit.pvalues[key]]
    columns = ["difference_n", "difference_std_error_n", "difference_ci_low_n", "difference_ci_high_n", "p_value"]
    for column, value in zip(columns, theirs, strict=True):
        found = row[column]
        check(f"{where}: statsmodels: {column}", abs(found - value) < PRINTED, f"{found} {value}")
        if name != "no_variance" and column != "p_value":
            close(f"{where}: statsmodels: {column}, more digits", found, value, 1e-4)
    check(f"{where}: statsmodels: infinite degrees of freedom", pd.isna(row["df"]) and row["distribution"] == "normal")


def pingouin(where, row, data, first, against):
    """pairwise_tests with its defaults."""
    import pingouin

    table = pingouin.pairwise_tests(data, dv="value", within="mode", subject="participant", return_desc=True)
    own = table[table["A"].isin([first, against]) & table["B"].isin([first, against])].iloc[0]
    sign = 1 if own["A"] == first else -1
    p = own[next(key for key in own.index if key.startswith("p_unc") or key.startswith("p-unc"))]
    columns = ["difference_n", "statistic", "df", "p_value", "effect_size"]
    theirs = [sign * (own[low] - own[high]) for low, high in [mean_columns(own)]]
    theirs += [sign * own["T"], own["dof"], p, sign * own["hedges"]]
    numbers(f"{where}: pingouin", row, theirs, columns, DIGITS)


def mean_columns(own):
    """The columns of the two means, however this version writes them."""
    return next((a, b) for a, b in (("mean_A", "mean_B"), ("mean(A)", "mean(B)")) if a in own.index)


def pyfixest(where, row, data, first, against, vcov):
    """feols with constants for participants."""
    import pyfixest

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        coded = data.assign(mode=data["mode"].map(lambda mode: "0" if mode == against else mode))
        fit = pyfixest.feols("value ~ mode | participant", coded, vcov=vcov)
        own = fit.tidy().loc[f"mode[T.{first}]"]
    columns = ["difference_n", "difference_std_error_n", "statistic", "p_value", "difference_ci_low_n", "difference_ci_high_n"]
    theirs = [own["Estimate"], own["Std. Error"], own["t value"], own["Pr(>|t|)"], own["2.5%"], own["97.5%"]]
    for column, value in zip(columns, theirs, strict=True):
        if column == "p_value":
            # It is one less a share, which has no digits left far out.
            check(f"{where}: {column}", abs(row[column] - value) < 1e-8, f"{row[column]} {value}")
        else:
            # An end near zero has the error of the interval's width.
            close(f"{where}: {column}", row[column], value, OPTIMISED if "_ci_" in column else DIGITS)
