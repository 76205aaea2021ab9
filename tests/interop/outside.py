"""A metric that pandas makes of the recordings, given with `zwidth metric`: its comparison against pingouin and R's pbkrtest."""

import csv
import io
import subprocess
import tempfile
from pathlib import Path

import pandas as pd
import pingouin

import tidy
from checks import check, close, equal, run

STUDY = "outside"
PEOPLE = 5
COLUMN = "own_push_peak_n"
# Numbers that come of a t distribution have nine digits; lme4's optimiser ends near the optimum, not at it.
DIGITS, OPTIMISED = 2e-8, 2e-4

# Random effects of participant and participant × mode, as docs/analysis.md describes the models beside the tests.
MODEL = """
suppressPackageStartupMessages({library(lme4); library(pbkrtest)})
data <- read.csv(commandArgs(TRUE)[1], stringsAsFactors = TRUE)
for (place in levels(data$environment)) {
  own <- droplevels(data[data$environment == place, ])
  own$mode <- factor(own$mode, levels = c("active", "passive", "hybrid"))
  tight <- lmerControl(optimizer = "bobyqa", optCtrl = list(rhoend = 1e-12, maxfun = 1e5), calc.derivs = FALSE)
  fit <- suppressMessages(lmer(value ~ 0 + mode + (1 | participant) + (1 | participant:mode), own, control = tight))
  adjusted <- vcovAdj(fit)
  for (against in c("active", "passive")) {
    L <- as.numeric(levels(own$mode) == "hybrid") - as.numeric(levels(own$mode) == against)
    se <- sqrt(as.numeric(t(L) %*% adjusted %*% L))
    estimate <- sum(L * fixef(fit))
    df <- Lb_ddf(L, vcov(fit), adjusted)
    cat(sprintf("%s,%s,%.17g,%.17g,%.17g\\n", place, against, estimate, se, df))
  }
}
"""


def check_all(zwidth):
    """Simulates a study, computes the metric, gives it, and compares."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        run(zwidth, "--root", root, "twin", STUDY, "--participants", PEOPLE, "--sessions", 1, "--rate", 250, "--quiet")
        values = peaks(root / "raw" / STUDY / "trials")
        values.drop(columns=["environment", "mode", "kind"]).to_parquet(root / "peaks.parquet", index=False)
        run(
            zwidth, "--root", root, "metric", STUDY, "--from", root / "peaks.parquet", "--id", "push_peak", "--unit", "N",
            "--label", "largest push", "--program", f"pandas {pd.__version__}",
        )  # fmt: skip
        kept = pd.read_parquet(root / "raw" / STUDY / "own/push_peak.0001.parquet")
        equal("outside: the values as they are kept, bit for bit", kept["value"].tolist(), values["push_peak"].tolist())
        run(zwidth, "--root", root, "run", STUDY, "--only", "compare", "--quiet")
        derived = root / "derived" / STUDY
        metrics = pd.read_parquet(derived / "metrics.parquet")
        own = metrics.merge(values, on=["participant", "session", "trial"])
        equal("outside: the column of the metric", own[COLUMN].tolist(), own["push_peak"].tolist())
        counted = values[values["kind"] == "trial"].rename(columns={"push_peak": "value"})
        equal("outside: every trial that counts has its value", len(own), len(counted))
        tests(counted, tidy.rows(derived / "compare", "contrasts", COLUMN))
        models(root, counted, tidy.rows(derived / "compare", "models", COLUMN))


def peaks(trials):
    """The largest force of each recording, and what it is of."""
    samples = pd.read_parquet(trials)
    keys = ["participant", "session", "trial", "environment", "mode", "kind"]
    samples = samples.assign(force=samples["force_ex_n"].abs()).astype({key: str for key in keys if key != "trial"})
    return samples.groupby(keys, as_index=False)["force"].max().rename(columns={"force": "push_peak"})


def tests(values, found):
    """Student's t of everybody's differences, by pingouin."""
    means = values.groupby(["environment", "participant", "mode"])["value"].mean().unstack()
    check("outside: contrasts are compared", len(found) == 4, str(len(found)))
    for _, row in found.iterrows():
        first, against = row["contrast"].split(" − ")
        own = means.loc[row["environment"]]
        test = pingouin.ttest(own[first], own[against], paired=True).iloc[0]
        name = f"outside: {row['environment']}, {first} − {against}"
        close(f"{name}: t", row["statistic"], test["T"], DIGITS)
        close(f"{name}: df", row["df"], test["dof"], DIGITS)
        close(f"{name}: p", row["p_value"], test[[key for key in test.index if key.startswith("p")][0]], 1e-6)


def models(root, values, found):
    """Kenward and Roger's standard errors and degrees of freedom, by pbkrtest."""
    (root / "model.R").write_text(MODEL)
    values.to_csv(root / "values.csv", index=False)
    done = subprocess.run(["Rscript", root / "model.R", root / "values.csv"], capture_output=True, text=True, check=False)
    check("outside: R fits the models", done.returncode == 0, done.stderr)
    theirs = {(row[0], row[1]): [float(cell) for cell in row[2:]] for row in csv.reader(io.StringIO(done.stdout))}
    check("outside: models are compared", len(theirs) == 4 and len(found) >= 4, f"{len(theirs)}, {len(found)}")
    for _, row in found.iterrows():
        against = row["contrast"].split(" − ")[1]
        estimate, std_error, df = theirs[row["environment"], against]
        name = f"outside: {row['environment']}, hybrid − {against}"
        close(f"{name}: difference of the model", row["difference_n"], estimate, OPTIMISED)
        close(f"{name}: its standard error", row["difference_std_error_n"], std_error, OPTIMISED)
        close(f"{name}: its degrees of freedom", row["df"], df, OPTIMISED)
