"""Times `zwidth run` and the script on the default study, one after the other in turns, checks that both made the same
numbers, and prints one Markdown section.

    python bench.py ZWIDTH REPOSITORY FOLDER [--rounds 3] [--repeats 15]

FOLDER is for roots of our own.
"""

import argparse
import io
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
import pyarrow.parquet as pq
from blake3 import blake3

from check import compare

STUDY = "thesis-twin"
INTRO = """\
`zwidth run --fresh` on `raw/thesis-twin` (36 trials, 45 sweeps) beside `study/study.py`, a plain script of pandas, SciPy
and matplotlib that makes the same averages, metrics with intervals, characteristics (ten candidate models, error on
sweeps left out, 400 resamples) and calibration, replays in three causalities (SciPy's LSODA with events, theta within 1e-6
rad), identification (weak-form balance of forces, `least_squares` with bounds from three starts, jackknife, 78 points of
profiles and twelve ends of intervals, each with five parameters fitted anew, bracket of the threshold, 54 replays with
lags), tallies, 17 figures as SVG, PDF and PNG with their data, 19 tables in six formats, and a summary. Both start as a
new process and end with all files written; one after the other, in turns; medians. zwidth uses both cores, the script
one: "of processor" compares user and system time, in which other work on the machine counts for less.

The script does not make: the checks of the files it reads, exclusions and late answers, records of what was made from
what and skipping what is up to date, the same bytes everywhere, rounding by uncertainty, notes under figures and tables, a
verdict in words for each model, tables of the plan read from the scene (its constants are typed in). Intervals by
resamples rest on other draws and are not compared.

The script says how long its parts take; zwidth's identification is timed by `--fresh --only identify`, and taken off where a
row leaves it out.

Where one trial changed, the identification is to be left aside, for it depends on every trial. Through it its printed tables
and the figures that show the fitted plant (replay) do so too: one row has them on the clock, one makes them before it starts.
The replays of the changed trial's condition, which those figures read too, are on the clock either way."""
WHY = """\
Numbers are compared column by column; where each row has a unit of its own (identify), parameter by parameter. Averages
and metrics differ by rounding. Replays, and the errors of the identified trials, by LSODA's tolerances; the fitted plant,
its profiles and intervals by the rules at which fits stop and either search for an end of an interval (1e-4 of the
critical value), and the standard error of the motor's lag of 65 µs by rounding, for its slope is a difference over 23 ns.
The characteristics differ because zwidth gathers 640 commands into 256 steps before it fits: where the script does so
too, the errors of its chosen models are within 1 % instead of 9 % (brake) and 0.3 instead of 0.8 % (motor) of zwidth's."""
# What a table may differ by: more than rounding where LSODA's tolerances, rules at which fits stop, or steps that are
# gathered first come in; what is printed has six digits.
ALLOWED = {"replay": 2e-4, "replay.agreement": 1e-4, "identify": 1e-3, "identify.profile": 1e-3, "identify.threshold": 1e-3,
           "identify.held_out": 1e-4, "identify.trials": 1e-4, "characteristic.brake": 0.02, "characteristic.motor": 0.03,
           "modes": 1e-5, "weight": 1e-5}
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


def as_recorded(other, path):
    """The bytes of another take, with the seed and the time of the one that it takes the place of: zwidth refuses a recording
    that its session's record knows nothing of."""
    table, meant = pq.read_table(other), pq.read_metadata(path).metadata
    footer = pq.read_metadata(other).metadata | {key: meant[key] for key in (b"seed", b"start_utc")}
    own = sorted(item for item in footer.items() if item[0] not in (b"footer_blake3", b"ARROW:schema"))
    text = b"".join(b"%d:%b=%d:%b;" % (len(key), key, len(value), value) for key, value in own)
    out = io.BytesIO()
    pq.write_table(table.replace_schema_metadata(dict(own) | {b"footer_blake3": blake3(text).hexdigest()}), out)
    return out.getvalue()


def shows_the_plant(root):
    """The figures and tables that read what the identification found, by name."""
    records = json.loads((root / "derived" / STUDY / "records.json").read_text())
    found = set(records["identify"]["outputs"])
    return [name for name, record in records.items() if name != "summary" and found & set(record["inputs"])]


def replays_of(path, root):
    """The replays of a trial's condition, which its change asks for, whoever reads them."""
    participant, session = (folder.name.split("=")[1] for folder in (path.parents[1], path.parent))
    environment, mode = pd.read_parquet(path, columns=["environment", "mode"]).iloc[0]
    return root / "derived" / STUDY / "replay" / f"{participant}.{session}.{environment}.{mode}.parquet"


def record(path, content):
    """Puts a trial's file in place, and its hash into the session's log, whose lines each hold a hash of all before, and
    whose head holds that of the last."""
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
    log.with_suffix(".head").write_text(f'{{"lines":{len(lines)},"blake3":"{previous}"}}\n')


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("zwidth", type=Path)
    arguments.add_argument("repository", type=Path)
    arguments.add_argument("folder", type=Path)
    arguments.add_argument("--rounds", type=int, default=3)
    arguments.add_argument("--repeats", type=int, default=15)
    args = arguments.parse_args()
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # threads that wait for each other would count against the script
    ours, theirs = args.folder / "ours", args.folder / "script"
    shutil.rmtree(args.folder, ignore_errors=True)
    for root in (ours, theirs):
        shutil.copytree(args.repository / "raw" / STUDY, root / "raw" / STUDY)

    run = [args.zwidth, "--root", ours, "--quiet", "run", STUDY]
    script = [sys.executable, HERE / "study.py", theirs, STUDY]
    fresh = lambda: timed(*run, "--fresh")
    fresh()
    rounds = [(fresh(), timed(*run, "--fresh", "--only", "identify"), timed(*script), os.getloadavg()[0])
              for _ in range(args.rounds)]
    fresh()
    compared = compare([ours, theirs], STUDY)
    for name, count, nulls, largest, column, _ in compared:
        if nulls or not largest <= ALLOWED.get(name, 1e-8):
            sys.exit(f"{name}: {column} differs by {largest:.1e} of its largest value, {nulls} values are null in one alone")

    nothing = [timed(*run) for _ in range(args.repeats)]
    path, other, trial = another_take(args.zwidth, ours, args.folder / "again")
    takes = [path.read_bytes(), as_recorded(other, path)]
    shown = shows_the_plant(ours)
    changed = []
    for k in range(args.repeats):
        record(path, takes[(k + 1) % 2])
        whole = timed(*run)
        record(path, takes[k % 2])
        identified, and_shown = timed(*run, "--only", "identify"), timed(*run)
        record(path, takes[(k + 1) % 2])
        for name in ["identify", *shown]:
            timed(*run, "--only", name)
        replays_of(path, ours).unlink()
        rest = timed(*run)
        changed.append((whole, identified, and_shown, rest, fresh()))

    print(section(rounds, compared, nothing, changed, trial))


def section(rounds, compared, nothing, changed, trial):
    libraries = ", ".join(f"{n} {version(n)}" for n in ("numpy", "pandas", "scipy", "pyarrow", "matplotlib"))
    load = ", ".join(f"{r[3]:.1f}" for r in rounds)
    lines = [
        "<!-- Written by study/run.sh. -->", "# A whole study, by zwidth and by a script", "", INTRO, "",
        f"{platform.machine()}, {os.cpu_count()} cores, load average after each of the {len(rounds)} rounds {load}. Python "
        f"{platform.python_version()}, {libraries}.", "",
        "| job, fresh | zwidth, s | of processor | script, s | of processor | script / zwidth | of processor |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    parts = [json.loads(r[2][2].splitlines()[-1]) for r in rounds]

    def row(job, ours, theirs):
        a, b = ([median(runs, k) for k in (0, 1)] for runs in (ours, theirs))
        numbers = [f"{a[0]:.2f}", f"{a[1]:.2f}", f"{b[0]:.1f}", f"{b[1]:.1f}", f"{b[0] / a[0]:.1f}", f"{b[1] / a[1]:.1f}"]
        lines.append(f"| {job} | {' | '.join(numbers)} |")

    less = lambda a, b: [x - y for x, y in zip(a[:2], b[:2])]
    row("everything", [r[0] for r in rounds], [r[2] for r in rounds])
    row("everything but the identification", [less(r[0], r[1]) for r in rounds],
        [less(r[2], p["identification"]) for r, p in zip(rounds, parts)])
    row("the identification", [r[1] for r in rounds], [p["identification"] for p in parts])
    seconds = lambda k: f"{median([c[k] for c in changed]):.2f} s | {median([c[k] for c in changed], 1):.2f} s |"
    share = lambda of: " | ".join(f"{100 * statistics.median(of(c, k) for c in changed):.0f} %" for k in (0, 1))
    lines += ["", "| zwidth alone | wall | of processor |", "| --- | --- | --- |",
              f"| nothing to do | {1e3 * median(nothing):.0f} ms | {1e3 * median(nothing, 1):.0f} ms |",
              f"| one changed trial ({trial}) | {seconds(0)}",
              f"| the same in two runs: the identification | {seconds(1)}",
              f"| and then all else | {seconds(2)}",
              f"| in several: identification, its printed tables and figures first; then all else | {seconds(3)}",
              f"| a fresh run | {seconds(4)}",
              f"| changed trial over a fresh run | {share(lambda c, k: c[0][k] / c[4][k])} |",
              f"| the same without the identification | {share(lambda c, k: c[2][k] / c[4][k])} |",
              f"| and without what shows it | {share(lambda c, k: c[3][k] / c[4][k])} |", ""]
    ratio = median([r[2] for r in rounds]) / median([r[0] for r in rounds])
    with_shown, rest = (100 * statistics.median(c[i][0] / c[4][0] for c in changed) for i in (2, 3))
    lines += [f"The aims, in wall time: the script at least 30 times as long as zwidth (it is {ratio:.0f}), nothing to do below "
              f"50 ms (it is {1e3 * median(nothing):.0f}), a changed trial without the identification below 20 % of a fresh "
              f"run (it is {rest:.0f}, and {with_shown:.0f} with the figures and tables that show what was identified).", ""]
    lines += ["The script's parts, s of processor: " + ", ".join(
                  f"{k} {statistics.median(p[k][1] for p in parts):.1f}" for k in parts[0]) + ".", "",
              "| table | columns compared | null in one alone | largest difference / largest value | in |",
              "| --- | --- | --- | --- | --- |"]
    lines += [f"| {n} | {c} | {nulls} | {largest:.0e} | `{column}` |" for n, c, nulls, largest, column, _ in compared]
    lines += ["", WHY]
    return "\n".join(lines)


if __name__ == "__main__":
    main()
