"""A study as a script: raw files to averages, metrics, characteristics, replay, identification, figures, tables and a
summary, with pandas, SciPy and matplotlib.

    python study.py ROOT STUDY

Reads ROOT/raw/STUDY and writes ROOT/derived and ROOT/reports. Prints the seconds each part takes, and those of processor.
"""

import json
import sys
import time
import tomllib
import warnings
from pathlib import Path

import numpy as np
import pandas as pd

import characterise
import figures
import identify
import metrics
import model
import report

# Every parameter's error comes from resamples, not from curve_fit's covariance.
warnings.filterwarnings("ignore", "Covariance of the parameters could not be estimated")

KNOWN = ["participant", "session", "trial", "repeat", "environment", "mode", "source"]


def load(raw):
    """study.toml with what the analysis asks of it at hand, in radians and by name."""
    study = tomllib.loads((raw / "study.toml").read_text())
    study["environment"] = {}
    for e in study["environments"]:
        wall = np.radians(e["wall_deg"]) if "wall_deg" in e else None
        study["environment"][e["id"]] = e | {
            "rest_rad": np.radians(e["rest_deg"]), "wall_rad": wall,
            "slope_from_rad": np.radians(study["analysis"]["slope_from_deg"])}
    study["mode"] = {m["id"]: m for m in study["modes"]}
    return study


def forward(knots):
    """Force of a voltage by a calibration."""
    return lambda v: np.sign(v) * np.interp(np.abs(v), knots["voltage_v"], knots["force_n"])


def read_trials(raw):
    """(metadata, frame) of every trial that counts, and the session's calibration."""
    trials = []
    for path in sorted((raw / "trials").glob("*/*/*.parquet")):
        frame = pd.read_parquet(path)
        first = frame.iloc[0]
        if first.kind != "trial" or first.status != "complete":
            continue
        values = [path.parts[-3].partition("=")[2], path.parts[-2].partition("=")[2], int(first.trial),
                  int(first["repeat"]), first["environment"], first["mode"], "twin"]
        trials.append((dict(zip(KNOWN, values)), frame))
    record = json.loads(next((raw / "sessions").glob("*.json")).read_text())

    return trials, {name: forward(record["calibration"][name]) for name in ("motor", "brake")}


def answers(raw):
    """What was answered, by trial and question: one session is all there is."""
    log = next((raw / "sessions").glob("*.events.jsonl")).read_text().splitlines()
    events = [json.loads(line)["what"] for line in log]
    return {(e["trial"], e["question"]): e["value"] for e in events if e["event"] == "answer"}


def likert(trials, study, given):
    rows = []
    for environment in study["environments"]:
        for mode in study["modes"]:
            answers = np.sort([given[m["trial"], environment["question"]] for m, f in trials
                               if m["environment"] == environment["id"] and m["mode"] == mode["id"]])
            counts = {f"count_{k}": int(np.sum(answers == k)) for k in range(1, 6)}
            n = len(answers)
            rows.append(dict(environment=environment["id"], mode=mode["id"], question=environment["question"],
                             participants=1, n=n, **counts, median_low=int(answers[(n - 1) // 2]),
                             median_high=int(answers[n // 2])))
    return pd.DataFrame(rows)


def main(root, name):
    raw, derived, reports = (root / part / name for part in ("raw", "derived", "reports"))
    for folder in (derived / "average", derived / "characterise", reports / "figures", reports / "tables"):
        folder.mkdir(parents=True, exist_ok=True)
    clock, seconds = [(time.perf_counter(), time.process_time())], {}

    def lap(part):
        clock.append((time.perf_counter(), time.process_time()))
        seconds[part] = [now - before for now, before in zip(clock[-1], clock[-2])]

    study = load(raw)
    level = study["analysis"]["confidence"]
    trials, study["calibration"] = read_trials(raw)
    sweeps = {a: [pd.read_parquet(p) for p in sorted((raw / "sweeps" / f"actuator={a}").glob("*.parquet"))]
              for a in ("brake", "motor")}
    lap("reading")

    tables = {}
    characteristics, knots = {}, {}
    for actuator, frames in sweeps.items():
        found = characterise.characterise(frames, level)
        tables[f"characteristic.{actuator}"], tables[f"parameters.{actuator}"], curve, chosen = found
        curve.to_parquet(derived / "characterise" / f"curve.{actuator}.parquet")
        ends = frames[0].command.min(), frames[0].command.max()
        knots[actuator] = dict(zip(("voltage_v", "force_n"), (v.tolist() for v in characterise.calibration(chosen, *ends))))
        characteristics[actuator] = (curve, tables[f"parameters.{actuator}"], chosen, forward(knots[actuator]))
    (derived / "characterise" / "calibration.json").write_text(json.dumps(knots))
    lap("characteristics")

    tables["metrics"] = pd.DataFrame([metrics.trial_metrics(frame, meta, study) for meta, frame in trials])
    tables["conditions"] = metrics.by_condition(tables["metrics"])
    averages = {}
    for environment in study["environment"].values():
        for mode in study["mode"]:
            mine = [f for m, f in trials if m["environment"] == environment["id"] and m["mode"] == mode]
            for alignment in ("onset", "landmarks"):
                table = metrics.average(mine, environment, study["analysis"], alignment)
                averages[environment["id"], mode, alignment] = table
                suffix = "" if alignment == "onset" else ".landmarks"
                table.to_parquet(derived / "average" / f"P01.S01.{environment['id']}.{mode}{suffix}.parquet")
    lap("metrics and averages")

    models = [model.Trial(frame, meta, study) for meta, frame in trials]
    tables["replay"] = pd.DataFrame([row for trial in models for row in model.replay(trial)])
    tables["replay.agreement"] = model.agreement(tables["replay"], level)
    lap("replay")

    found, fitted = identify.identify(models, tables["replay"], level)
    tables |= found
    lap("identification")

    tables["likert"] = likert(trials, study, answers(raw))
    tables |= report.plan_tables(study, tables, characteristics)
    for stem in [stem for stem in tables if stem.startswith(("metrics", "conditions", "replay", "likert", "identify"))]:
        tables[stem].to_parquet(derived / f"{stem}.parquet")
    for stem, table in tables.items():
        report.write_table(table, reports / "tables" / stem)
    lap("tables")

    figures.draw_all(reports / "figures", study, trials, averages, tables, sweeps, characteristics, models, fitted)
    lap("figures")

    (reports / "summary.md").write_text(report.summary(study, tables, reports))
    lap("summary")
    print(json.dumps(seconds))


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2])
