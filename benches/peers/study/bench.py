"""Times `zwidth run` and the script on the default study, one after the other in turns, checks that both made the same
numbers, and prints one Markdown section.

    python bench.py ZWIDTH REPOSITORY FOLDER [--rounds 3] [--full-rounds 1] [--repeats 15]

FOLDER is for roots of our own. A round times both without the script's identification, which takes minutes; a full
round times both with it.
"""

import argparse
import json
import os
import platform
import shutil
import statistics
import subprocess
import sys
import time
from importlib.metadata import version
from pathlib import Path

import pandas as pd
from blake3 import blake3

from check import compare

STUDY = "thesis-twin"
INTRO = """\
`zwidth run --fresh` on `raw/thesis-twin` (36 trials, 45 sweeps) beside `study/study.py`, a plain script of pandas, SciPy
and matplotlib that makes the same averages, metrics, characteristics (ten candidate models, error on sweeps left out, 400
resamples), replays in three causalities (SciPy's LSODA with events, theta within 1e-6 rad), identification (bounded least
squares from three starts, profiles, 2,000 resamples), tallies, 17 figures as SVG, PDF and PNG with their data, 17 tables
in six formats, and a summary. Both start as a new process and end with all files written; one after the other, in turns;
medians. zwidth uses both cores, the script one: "of processor" compares user and system time, in which other work
on the machine counts for less.

The script does not make: the checks of the files it reads, exclusions and late answers, records of what was made from what and
skipping what is up to date, the same bytes everywhere, rounding by uncertainty, notes under figures and tables, a verdict in words for each
model, tables of the plan read from the scene (its constants are typed in). Intervals by resamples rest on other draws
and are not compared.

zwidth's identification is timed by `--fresh --only identify`, which also makes its tables, and taken off where a row leaves
it out."""
HERE = Path(__file__).parent


def timed(*command):
    """Wall and processor seconds of a command, and what it prints."""
    start = time.perf_counter()
    process = subprocess.Popen([str(c) for c in command], stdout=subprocess.PIPE, text=True)
    printed = process.stdout.read()
    _, status, usage = os.wait4(process.pid, 0)
    wall = time.perf_counter() - start
    if status:
        sys.exit(f"failed: {' '.join(map(str, command))}")
    print(f"{wall:8.2f} s  {' '.join(map(str, command[2:]))}", file=sys.stderr)
    return wall, usage.ru_utime + usage.ru_stime, printed


def median(runs, k=0):
    return statistics.median(run[k] for run in runs)


def another_take(zwidth, root, folder):
    """A trial of `root`, and the same trial (number, condition, repeat) recorded with another seed."""
    what = ["trial", "repeat", "kind", "environment", "mode"]
    row = lambda path: pd.read_parquet(path, columns=what).iloc[0].to_list()
    for seed in range(2, 20):
        shutil.rmtree(folder, ignore_errors=True)
        timed(zwidth, "--root", folder, "--quiet", "twin", STUDY, "--participants", 1, "--sessions", 1, "--seed", seed,
              "--rate", 120)
        for path in sorted((root / "raw" / STUDY / "trials").glob("*/*/*.parquet")):
            other, (number, _, kind, environment, mode) = folder / path.relative_to(root), row(path)
            if kind == "trial" and row(other) == row(path):
                return path, other, f"trial {number}, {environment}, {mode}, recorded with another seed"
    sys.exit("no seed gives a trial of the same condition")


def record(path, content):
    """Puts a trial's file in place, and its hash into the session's log, whose lines each hold a hash of all before."""
    path.write_bytes(content)
    log = next((path.parents[3] / "sessions").glob("*.events.jsonl"))
    number, lines, previous = int(path.stem.removeprefix("trial-")), [], ""
    for line in log.read_text().splitlines():
        line = json.loads(line)
        event = line["what"]
        if event["event"] == "recorded" and event["trial"] == number:
            event["blake3"] = blake3(content).hexdigest()
        compact = json.dumps(event, separators=(",", ":"), ensure_ascii=False)
        previous = blake3(f"{previous}\n{line['utc']}\n{compact}".encode()).hexdigest()
        lines.append(f'{{"utc":"{line["utc"]}","what":{compact},"blake3":"{previous}"}}\n')
    log.write_text("".join(lines))


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("zwidth", type=Path)
    arguments.add_argument("repository", type=Path)
    arguments.add_argument("folder", type=Path)
    arguments.add_argument("--rounds", type=int, default=3)
    arguments.add_argument("--full-rounds", type=int, default=1)
    arguments.add_argument("--repeats", type=int, default=15)
    args = arguments.parse_args()
    ours, theirs = args.folder / "ours", args.folder / "script"
    shutil.rmtree(args.folder, ignore_errors=True)
    for root in (ours, theirs):
        shutil.copytree(args.repository / "raw" / STUDY, root / "raw" / STUDY)

    run = [args.zwidth, "--root", ours, "--quiet", "run", STUDY]
    script = [sys.executable, HERE / "study.py", theirs, STUDY]
    fresh = lambda: timed(*run, "--fresh")
    identification = lambda: timed(*run, "--fresh", "--only", "identify")
    fresh()
    rounds = [(fresh(), identification(), timed(*script, "--no-identify")) for _ in range(args.rounds)]
    full = [(fresh(), timed(*script)) for _ in range(args.full_rounds)]
    compared = compare([ours, theirs], STUDY)

    nothing = [timed(*run) for _ in range(args.repeats)]
    path, other, trial = another_take(args.zwidth, ours, args.folder / "again")
    takes = [path.read_bytes(), other.read_bytes()]
    changed = []
    for k in range(args.repeats):
        record(path, takes[(k + 1) % 2])
        changed.append((timed(*run), identification(), fresh()))  # in this order: each leaves all up to date

    print(section(rounds, full, compared, nothing, changed, trial))


def section(rounds, full, compared, nothing, changed, trial):
    libraries = ", ".join(f"{n} {version(n)}" for n in ("numpy", "pandas", "scipy", "pyarrow", "matplotlib"))
    load = ", ".join(f"{v:.1f}" for v in os.getloadavg())
    lines = [
        "<!-- Written by study/run.sh. -->", "# A whole study, by zwidth and by a script", "", INTRO, "",
        f"{platform.machine()}, {os.cpu_count()} cores, load average at the end {load}. Python "
        f"{platform.python_version()}, {libraries}.", "",
        "| job | zwidth, s | of processor | script, s | of processor | script / zwidth | of processor |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]

    def row(job, ours, theirs):
        a, b = ([median(runs, k) for k in (0, 1)] for runs in (ours, theirs))
        numbers = [f"{a[0]:.2f}", f"{a[1]:.2f}", f"{b[0]:.1f}", f"{b[1]:.1f}", f"{b[0] / a[0]:.0f}", f"{b[1] / a[1]:.0f}"]
        lines.append(f"| {job} | {' | '.join(numbers)} |")

    if full:
        row("everything, fresh", [r[0] for r in full], [r[1] for r in full])
    without = [tuple(a - b for a, b in zip(r[0][:2], r[1][:2])) for r in rounds]
    row("everything but the identification, fresh", without, [r[2] for r in rounds])
    row("the script without identification, zwidth with it", [r[0] for r in rounds], [r[2] for r in rounds])
    again = [[c[0][k] - c[1][k] for k in (0, 1)] for c in changed]
    over_fresh = [[a[k] / c[2][k] for k in (0, 1)] for a, c in zip(again, changed)]
    over_rest = [[a[k] / (c[2][k] - c[1][k]) for k in (0, 1)] for a, c in zip(again, changed)]
    lines += ["", "| zwidth alone | wall | of processor |", "| --- | --- | --- |",
              f"| nothing to do | {1e3 * median(nothing):.0f} ms | {1e3 * median(nothing, 1):.0f} ms |",
              f"| one changed trial ({trial}), with identification | {median([c[0] for c in changed]):.2f} s | "
              f"{median([c[0] for c in changed], 1):.2f} s |",
              f"| without it | {median(again):.2f} s | {median(again, 1):.2f} s |",
              f"| that over a fresh run | {100 * median(over_fresh):.0f} % | {100 * median(over_fresh, 1):.0f} % |",
              f"| that over a fresh run without identification | {100 * median(over_rest):.0f} % | "
              f"{100 * median(over_rest, 1):.0f} % |", ""]
    parts = json.loads((full[-1][1] if full else rounds[-1][2])[2].splitlines()[-1])
    lines += ["The script's parts, s: " + ", ".join(f"{k} {v:.1f}" for k, v in parts.items()) + ".", "",
              "| table | columns compared | null in one alone | largest difference / largest value | in |",
              "| --- | --- | --- | --- | --- |"]
    lines += [f"| {n} | {c} | {nulls} | {largest:.0e} | `{column}` |" for n, c, nulls, largest, column, _ in compared]
    return "\n".join(lines)


if __name__ == "__main__":
    main()
