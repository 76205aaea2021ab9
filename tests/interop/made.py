"""Recordings of our own making, as other programs write them, from the file to the printed tables: a LabChart text of presses on a
spring, and a survey of seven points in a workbook. What comes out is computed once more from what was made, by SciPy, statsmodels
and pandas."""

import tempfile
from pathlib import Path

import numpy as np
import openpyxl
import pandas as pd

import definitions
import folders
import results
from checks import check, close, equal, run

# To what two programs must agree, relative to the number.
AGREEMENT = 1e-6
RATE_HZ = 1000.0
LEVER_M, STIFFNESS, REST_RAD = 0.05, 4.0, np.radians(-45.0)
# `analysis` of the study below.
ONSET, OFFSET, PAST_REST, POINTS = np.radians(2.0), np.radians(1.0), np.radians(0.5), 401
# Presses: seconds of a stroke, its reach, the device's stiffness and friction (N), by mode.
PRESSES = {"active": [(1.2, 0.9, 3.7, 0.15), (1.0, 1.1, 3.8, 0.15)], "passive": [(1.4, 1.0, 2.9, 0.55), (1.1, 0.8, 3.0, 0.5)]}

STUDY = """
schema = 2
[study]
id = "labchart"
title = "Presses on a spring, written by LabChart"
[design]
repeats = 2
trial_limit_s = 5.0
[device]
name = "lever with a force sensor"
lever_m = 0.05
theta_min_deg = -46.0
theta_max_deg = 46.0
[analysis]
onset_deg_s = 2.0
offset_deg_s = 1.0
slope_from_deg = 0.5
[[environments]]
id = "spring"
label = "Spring"
kind = "spring"
stiffness_n_per_rad = 4.0
rest_deg = -45.0
[[modes]]
id = "active"
label = "Active"
[[modes]]
id = "passive"
label = "Passive"
"""
MAP = """
kind = "trials"
[file]
split = "time"
[name]
pattern = '(?<mode>[a-z]+)\\.txt$'
[trial]
participant = "P01"
session = "S01"
environment = "spring"
mode = { name = "mode" }
[time]
from = "Time"
unit = "s"
[[column]]
to = "theta_rad"
from = "Angle"
unit = "deg"
[[column]]
to = "theta_dot_rad_s"
from = "Velocity"
unit = "deg/s"
[[column]]
to = "force_ex_n"
from = "Force"
unit = "mN"
sign = -1
[[column]]
to = "force_cmd_n"
from = "Command"
unit = "N"
"""

SURVEY = """
schema = 2
[study]
id = "survey"
title = "A survey of seven points"
[design]
repeats = 1
trial_limit_s = 60.0
[device]
name = "none"
[[environments]]
id = "lever"
label = "The lever"
kind = "none"
[[modes]]
id = "motor"
label = "Motor"
[[modes]]
id = "brake"
label = "Brake"
[[questions]]
id = "pleasant"
text = "How pleasant was it?"
points = 7
from = -3
[[questions]]
id = "tiring"
text = "How tiring was it?"
points = 7
from = -3
reversed = true
"""
SURVEY_MAP = """
kind = "likert"
[file]
sheet = "answers"
[trial]
participant = { column = "Person", prefix = "P", digits = 2 }
session = "S01"
environment = "lever"
mode = { column = "Device", translate = { "M" = "motor", "B" = "brake" } }
[questions.columns]
pleasant = "How pleasant?"
tiring = "How tiring?"
[questions.translate]
"very much" = 3
"""


def check_all(zwidth):
    """Both, from their files to the tables."""
    labchart(zwidth)
    survey(zwidth)


def press(seconds, reach, stiffness, friction, seed):
    """A stroke out and back, held before and after: time, angle, velocity (rad, rad/s) and force on the device, N."""
    n = round((seconds + 0.6) * RATE_HZ)
    t = np.arange(n) / RATE_HZ
    phase = np.clip((t - 0.3) / seconds, 0, 1)
    theta = REST_RAD + reach * (1 - np.cos(2 * np.pi * phase)) / 2
    velocity = np.where((phase > 0) & (phase < 1), np.pi * reach / seconds * np.sin(2 * np.pi * phase), 0.0)
    noise = np.random.default_rng(seed).normal(0, 0.02, n)
    return t, theta, velocity, stiffness * (theta - REST_RAD) + friction * np.tanh(velocity / 0.2) + noise


def labchart_text(presses):
    """LabChart's export: a block a press, time from its start, a comment at the end of a line."""
    lines = []
    for i, (t, theta, velocity, force) in enumerate(presses):
        lines += [f"Interval=\t{1 / RATE_HZ:g} s", "ExcelDateTime=\t4.5e+04\t01/02/2026", "TimeFormat=\tStartOfBlock", "DateFormat=\t"]
        lines += ["ChannelTitle=\tAngle\tVelocity\tForce\tCommand", "Range=\t90 °\t500 °/s\t10 N\t10 N"]
        command = STIFFNESS * (theta - REST_RAD)
        rows = zip(t, np.degrees(theta), np.degrees(velocity), -1e3 * force, command, strict=True)
        for j, row in enumerate(rows):
            remark = f"\t#* press {i + 1}" if j == 300 else ""
            lines.append("\t".join(f"{value:.9g}" for value in row) + remark)
    return "\r\n".join(lines) + "\r\n"


def read_back(text):
    """The blocks of such a text, by NumPy: time, angle, velocity, force and command in SI."""
    for block in text.split("Interval=")[1:]:
        rows = [line.split("\t")[:5] for line in block.splitlines()[6:]]
        t, theta, velocity, force, command = np.array(rows, float).T
        yield t, np.radians(theta), np.radians(velocity), -1e-3 * force, command


def labchart(zwidth):
    """Discrepancy and stiffness with their intervals, of every block."""
    with tempfile.TemporaryDirectory() as folder:
        root = begun(folder, "labchart", STUDY, MAP)
        expect, seed = [], 0
        for mode, strokes in PRESSES.items():
            made = []
            for stroke in strokes:
                seed += 1
                made.append(press(*stroke, seed))
            path = root / f"{mode}.txt"
            # As LabChart writes it on Windows.
            path.write_bytes(labchart_text(made).encode("latin-1"))
            expect += [(mode, repeat, block) for repeat, block in enumerate(read_back(path.read_text("latin-1")), start=1)]
        mapping = root / "map.toml"
        mapping.write_text(MAP.replace('split = "time"', 'split = "time"\nencoding = "latin-1"'))
        said = run(zwidth, "--root", root, "import", "labchart", "--map", mapping, root / "active.txt", root / "passive.txt")
        check("labchart: it is told what it was read as", "LabChart" in said and "read with care" not in said, said)
        finished(zwidth, root, "labchart")
        metrics = pd.read_csv(root / "reports/labchart/tables/metrics.csv", float_precision="round_trip")
        equal("labchart: trials", len(metrics), len(expect))
        rows = metrics.set_index(["mode", "repeat"])
        for mode, repeat, (t, theta, velocity, force, command) in expect:
            row, label = rows.loc[(mode, repeat)], f"labchart {mode} {repeat}"
            first, turn, last = definitions.phases(theta, velocity, ONSET, OFFSET)
            for name, i in [("onset_s", first), ("reversal_s", turn)]:
                close(f"{label}: {name}", row[name], t[i], 1e-12)
            numbers = definitions.discrepancy(theta, force, first, turn, last, POINTS, LEVER_M)
            numbers |= definitions.spring(theta, force, command, first, turn, last, REST_RAD, PAST_REST)
            for quantity, values in numbers.items():
                for part, value in zip(["", "_ci_low", "_ci_high"], values):
                    close(f"{label}: {quantity}{part}", row[f"{quantity}{part}{UNITS.get(quantity, '')}"], value, AGREEMENT)


UNITS = {
    "discrepancy_user_mean": "_n",
    "discrepancy_user_max": "_n",
    "discrepancy_user_step": "_n",
    "loop_area": "_j",
    "stiffness": "_n_per_rad",
    "stiffness_std_error": "_n_per_rad",
    "force_at_rest": "_n",
    "force_rms_error": "_n",
}


def survey(zwidth):
    """Counts and medians of every question under every mode, the reversed one turned round."""
    with tempfile.TemporaryDirectory() as folder:
        root = begun(folder, "survey", SURVEY, SURVEY_MAP)
        draw = np.random.default_rng(7)
        book = openpyxl.Workbook()
        sheet = book.active
        sheet.title = "answers"
        sheet.append(["Person", "Device", "How pleasant?", "How tiring?"])
        rows = []
        for person in range(1, 13):
            for device, shift in [("M", 1), ("B", -1)]:
                answers = [int(np.clip(round(draw.normal(s, 1.4)), -3, 3)) for s in (shift, -shift)]
                rows.append((device, *answers))
                sheet.append([person, device, *["very much" if a == 3 else a for a in answers]])
        book.create_sheet("notes")["A1"] = "by hand"
        book.save(root / "survey.xlsx")
        run(zwidth, "--root", root, "import", "survey", "--map", root / "map.toml", root / "survey.xlsx")
        finished(zwidth, root, "survey")
        tally = pd.read_csv(root / "reports/survey/tables/likert.csv").dropna(subset=["question"])
        tally = tally.set_index(["question", "mode"])
        frame = pd.DataFrame(rows, columns=["device", "pleasant", "tiring"])
        frame["tiring"] *= -1
        for question in ["pleasant", "tiring"]:
            for device, mode in [("M", "motor"), ("B", "brake")]:
                given = frame.loc[frame["device"] == device, question]
                row, label = tally.loc[(question, mode)], f"survey {question} {mode}"
                counts = [int((given == answer).sum()) for answer in range(-3, 4)]
                equal(f"{label}: counts", [int(row[f"count_{k}"]) for k in range(1, 8)], counts)
                ordered = sorted(given)
                middle = [ordered[(len(ordered) - 1) // 2], ordered[len(ordered) // 2]]
                equal(f"{label}: medians", [int(row["median_low"]), int(row["median_high"])], middle)


def begun(folder, study, text, mapping):
    """A study of this text, and the mapping beside it."""
    root = Path(folder)
    raw = root / "raw" / study
    raw.mkdir(parents=True)
    (raw / "study.toml").write_text(text)
    (root / "map.toml").write_text(mapping)
    return root


def finished(zwidth, root, study):
    """Verifies and runs a study, and reads what came out as other programs do."""
    said = run(zwidth, "--root", root, "verify", study)
    check(f"{study}: verify finds nothing", "read with care" not in said, said)
    run(zwidth, "--root", root, "run", study, "--quiet")
    folders.study(zwidth, root, study)
    results.tables(study, root / "reports" / study / "tables")
    results.figures(study, root / "reports" / study / "figures", synthetic=False)
