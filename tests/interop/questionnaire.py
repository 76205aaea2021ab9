"""The answers of the questionnaire compared, from its two files: who answered what, effects, odds ratios.

Of no question has `answers_compared` a Friedman or signed-rank test, so none is computed here.
"""

import json
import os
import shutil
import subprocess
import tempfile
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import pandas as pd
from scipy import stats
from statsmodels.miscmodels.ordinal_model import OrderedModel
from statsmodels.stats.multitest import multipletests

import odds
from checks import check, close, equal
from ledger import compared

STUDY = "likert_vr_shoes"
# The default: the last mode of study.toml against each other one.
REFERENCE, OTHERS = "AVG", ["HED", "HIP", "STF"]
PARTICIPANTS = 20
# Numbers that come of a t distribution have nine digits.
DIGITS = 2e-8
# Two searches for one maximum, and a rule of 61 nodes against trapezoids.
SEARCHED = 3e-6
# R stops its searches earlier.
SEARCHED_BY_R = 5e-5
# Questions for R: people who differ little and much (SDs of 0.9 to 5.6 logits).
ASKED_OF_R = ["q01", "q05", "q06", "q17", "q22", "q25", "q29", "q33", "q36", "q37"]


def check_compared(zwidth, root, real):
    """Every number of `zwidth compare likert_vr_shoes --by answer`."""
    answers = given(real / STUDY)
    stored(pd.read_parquet(root / "derived" / STUDY / "answers.parquet"), answers)
    of_question = {question: rows for question, rows in answers.groupby("question")}
    with ProcessPoolExecutor(os.cpu_count()) as workers:
        models = dict(zip(of_question, workers.map(model, of_question.values())))
    table = compared(zwidth, root, STUDY, "answer")["answers_compared"]
    equal(f"{table.label}: rows", len(table.frame), len(of_question) * len(OTHERS))
    for question, rows in of_question.items():
        ratios, any_p = models[question]
        adjusted = multipletests([ratios[other]["p_value"] for other in OTHERS], method="holm")[1]
        for other, p in zip(OTHERS, adjusted):
            row = table.row(question=question, environment="walking", contrast=f"{REFERENCE} − {other}")
            table.counts(row, n=PARTICIPANTS, answers=2 * PARTICIPANTS, test_any="F")
            table.numbers(row, superiority(rows, other), DIGITS)
            table.numbers(row, {**ratios[other], "p_adjusted": p, "p_any": any_p}, SEARCHED)
    table.nulls("every contrast has a model with an interval", ["remark"])
    table.closed()
    without_people(of_question)
    by_r(table, answers)


def given(folder):
    """One row per answer: question, participant, mode, the answer as given, and turned round where that is reversed."""
    sheet = pd.read_csv(folder / "UXdata2023-04-28.csv", sep=";")
    questions = pd.read_csv(folder / "UXdata_questions2023-04-17.csv", sep=";").query("ToBeInverted != -2")
    parts = []
    for number, question in enumerate(questions.itertuples(), start=1):
        answer = sheet[question.Question_description]
        parts.append(pd.DataFrame({
            "question": f"q{number:02}",
            "participant": sheet["Participant ID"].map("P{:02}".format),
            "mode": sheet["VR motion used ask researcher"],
            "given": answer,
            "answer": 6 - answer if question.ToBeInverted == -1 else answer,
        }))
    return pd.concat(parts, ignore_index=True)


def stored(table, answers):
    """Who answered what in which mode, answer by answer."""
    keys = ["question", "participant", "mode"]
    expect = answers.set_index(keys)["given"].sort_index()
    found = table.set_index(keys)["answer"].sort_index()
    equal(f"{STUDY}: answers", len(found), len(expect))
    same = found.index.equals(expect.index) and (found.to_numpy() == expect.to_numpy()).all()
    check(f"{STUDY}: everybody's answers are those of the file", same, "they differ")
    equal(f"{STUDY}: participants", found.index.get_level_values("participant").nunique(), PARTICIPANTS)
    counts = table.groupby(["mode", "question"]).size()
    equal(f"{STUDY}: modes with questions, and the answers to each", (len(counts), set(counts)), (4 * 45, {PARTICIPANTS}))


def superiority(rows, other):
    """P(A > B) + ½ P(A = B) over everybody's pairs of repeats, their mean, and its t interval within [0, 1]."""
    shares = []
    for _, own in rows.groupby("participant"):
        a = own.loc[own["mode"] == REFERENCE, "answer"].to_numpy()[:, None]
        b = own.loc[own["mode"] == other, "answer"].to_numpy()
        shares.append(np.mean((a > b) + 0.5 * (a == b)))
    ends = stats.ttest_1samp(shares, 0.5).confidence_interval(0.95)
    return {
        "superiority": np.mean(shares),
        "superiority_ci_low": max(ends.low, 0.0),
        "superiority_ci_high": min(ends.high, 1.0),
    }


def model(rows):
    """Odds ratios with intervals and p values, by mode, and the p value of any difference."""
    columns = [rows[name].to_numpy() for name in ["answer", "participant", "mode"]]
    return odds.against_reference(*columns, REFERENCE, OTHERS)


def without_people(of_question):
    """The model here, with nobody differing from anybody, has the likelihood of statsmodels' ordered logit."""
    wrong = []
    for question, rows in of_question.items():
        columns = np.array([[float(mode == other) for other in OTHERS] for mode in rows["mode"]])
        ours = odds.Model(rows["answer"].to_numpy(), rows["participant"].to_numpy(), columns)
        theirs = OrderedModel(rows["answer"].to_numpy(), columns, distr="logit")
        theta, beta = np.linspace(-1.0, 0.5, ours.thresholds), np.array([0.7, -0.2, 0.4])
        ours = ours.minus_log_likelihood(np.concatenate([theta, beta, [0.0]]))[0]
        theirs = -theirs.loglike(np.concatenate([beta, theta]))
        wrong += [question] if abs(ours - theirs) > 1e-10 * theirs else []
    equal("odds.py without effects of people: questions whose likelihood statsmodels finds otherwise", wrong, [])


def by_r(table, answers):
    """Odds ratios and p values of some questions, by R's package ordinal."""
    if not shutil.which("Rscript"):
        print("skipped: there is no Rscript for the odds ratios of the questionnaire")
        return
    order = [REFERENCE, *OTHERS]
    asked = answers[answers["question"].isin(ASKED_OF_R)]
    asked = asked.sort_values(["question", "mode"], key=lambda column: column.map(order.index) if column.name == "mode" else column)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "answers.csv"
        asked.to_csv(file, index=False)
        script = Path(__file__).parent / "stats/odds.R"
        done = subprocess.run(["Rscript", script, file], capture_output=True, text=True, check=False)
    check("R's package ordinal has fits", done.returncode == 0, done.stderr)
    fits = json.loads(done.stdout)
    equal("R's package ordinal: questions without a fit", [q for q in ASKED_OF_R if "refused" in fits[q]], [])
    df = (PARTICIPANTS - 1) * len(OTHERS)
    for question, fit in fits.items():
        for mode, ratio, without in zip(fit["modes"], fit["odds_ratio"], fit["without"]):
            row = table.row(question=question, environment="walking", contrast=f"{REFERENCE} − {mode}")
            p = stats.f.sf(2 * (fit["log_likelihood"] - without), 1, df)
            p_any = stats.f.sf(2 * (fit["log_likelihood"] - fit["none"]) / len(OTHERS), len(OTHERS), df)
            for column, expect in [("odds_ratio", ratio), ("p_value", p), ("p_any", p_any)]:
                label = f"{table.label}, {question} against {mode}: {column} of R's package ordinal"
                close(label, table.frame.loc[row, column], expect, SEARCHED_BY_R)
