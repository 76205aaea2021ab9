"""What zwidth joins to recordings (a log by number and by time, a second file by time), against pandas."""

import json
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd

from checks import DONE_OR_WITH_CARE, check, run

RNG = np.random.default_rng(11)
MODES = ["active", "passive", "hybrid"]
TRIALS = """
[trial]
participant = "P01"
session = "{session}"
environment = "spring"
mode = {mode}
{more}
[time]
from = "t"
unit = "s"
[[column]]
to = "force_ex_n"
from = "f"
unit = "N"
"""


def check_all(zwidth):
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        run(zwidth, "--root", root, "new", "joined")
        by_number(zwidth, root)
        by_time(zwidth, root)
        for resample in ["linear", "previous"]:
            second(zwidth, root, resample)


def bring(zwidth, root, session, mapping, files):
    """Imports recordings with a mapping; their samples."""
    path = root / "map.toml"
    path.write_text(mapping)
    run(zwidth, "--root", root, "import", "joined", "--map", path, *files, codes=DONE_OR_WITH_CARE)
    frame = pd.read_parquet(root / "raw/joined/trials")
    frame = frame[frame["session"].astype(str) == session].sort_values(["trial", "t_s"])
    return frame.reset_index(drop=True)


def by_number(zwidth, root):
    """A log of PsychoPy's kind, counted from 0, beside 20 recordings counted from 1: as `merge` joins them."""
    numbers = RNG.permutation(20)
    log = pd.DataFrame({"condition": RNG.choice(MODES, 20), "trials.thisN": numbers, "slider.response": RNG.integers(1, 6, 20)})
    log.to_csv(root / "log.csv", index=False)
    recordings = []
    for n in range(1, 21):
        path = root / f"n_{n:02}.csv"
        pd.DataFrame({"t": [0.0, 0.1], "f": [float(n), -float(n)]}).to_csv(path, index=False)
        recordings.append(path)
    more = 'trial = { name = "n" }\n[questions.columns]\nfelt_spring = "slider.response@log"\n'
    mapping = 'kind = "trials"\n[name]\npattern = \'n_(?<n>\\d+)\\.csv$\'\n' + TRIALS.format(session="S01", mode='{ column = "condition@log" }', more=more)
    mapping += '[log]\npath = "log.csv"\ntrial = "trials.thisN"\nnumber = { name = "n" }\nadd = 1\n'
    found = bring(zwidth, root, "S01", mapping, recordings).drop_duplicates("trial")
    expect = pd.DataFrame({"trial": range(1, 21)}).merge(log.assign(trial=log["trials.thisN"] + 1), on="trial")
    check("a log by number: modes as merge has them", found["mode"].astype(str).tolist() == expect["condition"].tolist())
    events = (root / "raw/joined/sessions/P01_S01.events.jsonl").read_text().splitlines()
    events = [json.loads(line)["what"] for line in events]
    answers = {event["trial"]: event["value"] for event in events if event["event"] == "answer"}
    check("a log by number: answers as merge has them", answers == dict(zip(expect["trial"], expect["slider.response"], strict=True)), str(answers))


def by_time(zwidth, root):
    """A session of one recording, which a log parts by a clock of its own: as `merge_asof` gives each sample its row."""
    t = np.round(np.cumsum(RNG.uniform(0.0005, 0.0015, 30_000)), 6)
    pd.DataFrame({"t": t, "f": np.arange(t.size, dtype=float)}).to_csv(root / "whole.csv", index=False)
    began = np.round(np.sort(RNG.uniform(1.0, 29.0, 25)), 4)
    log = pd.DataFrame({"started": began - 100.0, "condition": RNG.choice(MODES, 25), "row": range(25)})
    log.sample(frac=1.0, random_state=3).to_csv(root / "log.csv", index=False)
    mapping = 'kind = "trials"\n' + TRIALS.format(session="S02", mode='{ column = "condition@log" }', more="")
    mapping += '[log]\npath = "log.csv"\ntime = "started"\nunit = "s"\noffset_s = 100.0\n'
    found = bring(zwidth, root, "S02", mapping, [root / "whole.csv"])
    samples = pd.DataFrame({"t": t, "f": np.arange(t.size, dtype=float)})
    expect = pd.merge_asof(samples, log.assign(t=log["started"] + 100.0).sort_values("t"), on="t").dropna()
    same = found["force_ex_n"].tolist() == expect["f"].tolist() and found["mode"].astype(str).tolist() == expect["condition"].tolist()
    check("a log by time: each sample has the row of merge_asof", same, f"{len(found)} against {len(expect)} samples")
    check("a log by time: each row is a trial", (found["trial"].to_numpy() - 1 == expect["row"].to_numpy()).all())


def second(zwidth, root, resample):
    """Motion at 100 Hz with jitter beside force at 1 kHz: as NumPy's interp and as merge_asof."""
    session = {"linear": "S03", "previous": "S04"}[resample]
    t = np.round(np.arange(5_000) / 1000 + RNG.uniform(-2e-4, 2e-4, 5_000), 6)
    pd.DataFrame({"t": t, "f": RNG.normal(size=t.size)}).to_csv(root / f"force_{resample}.csv", index=False)
    at = np.round(np.arange(450) / 100 + RNG.uniform(-3e-3, 3e-3, 450), 6)
    motion = pd.DataFrame({"time": at * 1000, "x": np.round(RNG.normal(0, 10, at.size), 5)})
    motion.to_csv(root / "motion.csv", index=False)
    mapping = 'kind = "trials"\n' + TRIALS.format(session=session, mode='"active"', more="")
    mapping += '[[column]]\nto = "theta_rad"\nfrom = "x@motion"\nunit = "deg"\n'
    mapping += f'[[with]]\nid = "motion"\npath = "motion.csv"\ntime = "time"\nunit = "ms"\noffset_s = 0.2\nresample = "{resample}"\n'
    found = bring(zwidth, root, session, mapping, [root / f"force_{resample}.csv"])
    moved = motion["time"].to_numpy() * 1e-3 + 0.2
    inside = t[(t >= moved[0] - 1e-6) & (t <= moved[-1] + 1e-6)]
    check(f"a second file, {resample}: the samples that both have", np.abs(found["t_s"].to_numpy() - inside).max() < 1e-12, str(len(found)))
    if resample == "linear":
        expect = np.interp(inside, moved, motion["x"])
    else:
        # Within a microsecond a sample is that of this time.
        held = pd.merge_asof(pd.DataFrame({"t": inside + 1e-6}), pd.DataFrame({"t": moved, "x": motion["x"]}), on="t")
        expect = held["x"].to_numpy()
    off = np.abs(np.rad2deg(found["theta_rad"].to_numpy()) - expect).max()
    # A time within a microsecond of a sample has its value: 50 deg a step of 10 ms are 5e-3 deg.
    check(f"a second file, {resample}: values as {'interp' if resample == 'linear' else 'merge_asof'} has them", off < (1e-2 if resample == "linear" else 1e-9), str(off))
