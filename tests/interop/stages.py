"""Stages of a study's own: the examples in Python and R, run by zwidth, against pandas on the recordings.

    python stages.py --zwidth PROGRAM [--people N --rate HZ --time]

The simulated study has N people. With `--time` the example in Python is timed alone, on the same tables, and beside it the
whole job: what is ours must be small. R must be there for its example.
"""

import argparse
import json
import os
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

import pandas as pd

import checks
from checks import check, close, equal

WORKSPACE = Path(__file__).resolve().parents[2]
EXAMPLES = WORKSPACE / "examples/stages"
STUDY = "own"


def table_of(example):
    """The [[stage]] that an example's head shows."""
    lines = [line.removeprefix("#") for line in (EXAMPLES / example).read_text(encoding="utf-8").splitlines()]
    first = next(place for place, line in enumerate(lines) if line.strip() == "[[stage]]")
    rest = lines[first:]
    last = next(place for place, line in enumerate(rest) if not line.strip())
    return "\n".join(line.strip() for line in rest[:last]) + "\n"


def study(zwidth, folder, people, rate, examples):
    """A simulated study with these examples as its stages."""
    checks.run(zwidth, "--root", folder, "twin", STUDY, "--participants", people, "--sessions", 1, "--seed", 1, "--rate", rate, "--quiet")
    analysis = Path(folder) / "analysis" / STUDY
    analysis.mkdir(parents=True)
    with open(Path(folder) / "raw" / STUDY / "study.toml", "a", encoding="utf-8") as toml:
        for example in examples:
            shutil.copy(EXAMPLES / example, analysis)
            toml.write("\n" + table_of(example))


def recorded(folder):
    """Each trial that counts: who, where, and its samples."""
    root = Path(folder)
    trials = pd.read_parquet(root / "derived" / STUDY / "trials.parquet")
    for trial in trials[trials["counts"]].itertuples():
        yield (trial.participant, trial.session, trial.trial), pd.read_parquet(root / trial.path)


def values(zwidth, people, rate):
    """The metrics of both examples are those that pandas finds in the recordings."""
    with tempfile.TemporaryDirectory() as folder:
        os.environ["XDG_STATE_HOME"] = f"{folder}/state"
        study(zwidth, folder, people, rate, ["push.py", "hold.R"])
        checks.run(zwidth, "--root", folder, "allow", STUDY)
        checks.run(zwidth, "--root", folder, "run", STUDY, "--quiet")
        metrics = pd.read_parquet(Path(folder) / "derived" / STUDY / "metrics.parquet")
        metrics = metrics.set_index(["participant", "session", "trial"])
        n = 0
        for key, samples in recorded(folder):
            found = metrics.loc[key]
            force, angle, step = samples["force_ex_n"], samples["theta_rad"], samples["t_s"].diff()
            name = " ".join(map(str, key))
            equal(f"{name}: largest push", found["own_push_peak_n"], force.abs().max())
            close(f"{name}: growth of the push", found["own_push_rate_n_s"], (force.diff() / step).abs().max(), 1e-12)
            near = angle >= angle.max() - 0.1 * (angle.max() - angle.min())
            close(f"{name}: time near the farthest point", found["own_hold_s"], step.shift(-1)[near].sum(), 1e-12)
            n += 1
        equal("every trial that counts has values", len(metrics), n)
        reports = Path(folder) / "reports" / STUDY
        for figure in ["push/push.svg", "hold/hold.png"]:
            beside = json.loads((reports / "stages" / f"{figure}.json").read_text(encoding="utf-8"))
            check(f"{figure} is marked as simulated", "SYNTHETIC" in beside["mark"], str(beside))
            page = (reports / "index.html").read_text(encoding="utf-8")
            check(f"the page shows {figure}", f'<img src="stages/{figure}"' in page)
        for stage in ["push", "hold"]:
            said = checks.run(zwidth, "--root", folder, "run", STUDY, "--twice", stage, "--quiet")
            check(f"{stage} gives the same bytes twice", "with the same bytes" in said, said)


def times(zwidth, people, rate):
    """How long the example takes alone, on the tables that it gets, and as a job."""
    with tempfile.TemporaryDirectory() as folder:
        os.environ["XDG_STATE_HOME"] = f"{folder}/state"
        study(zwidth, folder, people, rate, ["push.py"])
        kept = Path(folder) / "kept"
        # The job's own tables, as the program finds them: a stage before it copies them out.
        script = Path(folder) / "analysis" / STUDY / "push.py"
        example = script.read_text(encoding="utf-8")
        script.write_text(f"import shutil\nshutil.copytree('in', {str(kept / 'in')!r})\n{example}", encoding="utf-8")
        checks.run(zwidth, "--root", folder, "run", STUDY, "--only", "push", "--allow-scripts", "--quiet")
        script.write_text(example, encoding="utf-8")
        (kept / "out/figures").mkdir(parents=True)
        shutil.copy(script, kept)
        alone, job = [], []
        for _ in range(3):
            begun = time.perf_counter()
            subprocess.run(["python3", "push.py"], cwd=kept, check=True)
            alone.append(time.perf_counter() - begun)
            script.write_text(f"{example}# {len(job)}\n", encoding="utf-8")
            said = json.loads(checks.run(zwidth, "--root", folder, "--json", "run", STUDY, "--only", "push", "--allow-scripts"))
            job += [made["seconds"] for made in said[0]["made"] if made["name"] == "stage push"]
        size = (kept / "in/samples.parquet").stat().st_size / 1e6
        print(f"in/samples.parquet: {size:.0f} MB; the program alone {min(alone):.2f} s, the job {min(job):.2f} s")
        print(f"ours: {100 * (min(job) / min(alone) - 1):.0f} % of the program's own time")


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--zwidth", type=Path, required=True, help="the program")
    arguments.add_argument("--people", type=int, default=2, help="how many are simulated [default: 2]")
    arguments.add_argument("--rate", type=int, default=200, help="samples a second [default: 200]")
    arguments.add_argument("--time", action="store_true", help="time the example, and check nothing")
    given = arguments.parse_args()
    zwidth = given.zwidth.resolve()
    if given.time:
        times(zwidth, given.people, given.rate)
        return
    values(zwidth, given.people, given.rate)
    checks.end()


main()
