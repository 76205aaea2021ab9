"""A study of many participants: its page and figures by zwidth, a static page by plotly, both opened in Chromium. Prints Markdown.

    python bench.py ZWIDTH FOLDER --chromium PROGRAM [--participants 1000] [--repeats 6] [--rate 120]
"""

import argparse
import os
import platform
import shutil
import subprocess
import sys
import time
from importlib.metadata import version
from pathlib import Path

import pyarrow.parquet as parquet

import browsed

STUDY = "thousand"
# The aims: first paint, a trial from its choice on, memory of the writer.
PAINT_MS, CHOICE_MS, WRITER_MB = 2000, 100, 300
INTRO = """\
`zwidth twin` simulates {participants:,} participants ({trials:,} trials that count, {samples:,} samples, {rate:g} Hz); `zwidth run` checks them, derives
metrics, means, replays, the fitted plant and comparisons, and writes figures, tables, summary and page. A study of so many sessions
has no figures of each (`zwidth figure` makes one of them); the figures are those over participants. Each row of the writers is
one process: the page's and the figures' rows are runs after their files were taken away, so that they hold reading the study, checking what is
up to date, and writing.

The static page is by plotly from the same Parquet files: a table of means (of the metrics that zwidth derived), paired dots, and a
browser of trials with three columns of samples rounded to six decimals, packed in the one file and unpacked when it is opened, the way of
MultiQC. Ours has every column, bit for bit, and the model's runs, in a script for each environment of a session, loaded when asked for."""


def timed(*command):
    """Wall and processor seconds of a command, and its peak memory, MB."""
    start = time.perf_counter()
    process = subprocess.Popen([str(c) for c in command], stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    wall = time.perf_counter() - start
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode not in (0, 3):  # 3: done, with something to be read with care
        sys.exit(f"failed: {' '.join(map(str, command))}")
    print(f"{wall:8.1f} s  {' '.join(map(str, command[1:]))}", file=sys.stderr)
    return {"wall_s": wall, "cpu_s": usage.ru_utime + usage.ru_stime, "mb": usage.ru_maxrss / 1024}


def megabytes(path):
    files = [path] if path.is_file() else [file for file in path.rglob("*") if file.is_file()]
    return sum(file.stat().st_size for file in files) / 1e6, len(files)


def simulated(zwidth, root, args):
    """The study, once a size."""
    if (root / "done").exists():
        return
    shutil.rmtree(root, ignore_errors=True)
    run = [zwidth, "--root", root, "--quiet"]
    timed(*run, "new", STUDY)
    toml = root / "raw" / STUDY / "study.toml"
    text = toml.read_text()
    for was, now in [("\nrepeats = 6\n", f"\nrepeats = {args.repeats}\n"), ("\nrate_hz = 1000.0\n", f"\nrate_hz = {args.rate:.1f}\n")]:
        assert text.count(was) == 1
        text = text.replace(was, now)
    toml.write_text(text)
    timed(*run, "twin", STUDY, "--participants", args.participants, "--sessions", 1)
    (root / "done").touch()


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("zwidth", type=Path)
    arguments.add_argument("folder", type=Path)
    arguments.add_argument("--chromium", default="/usr/bin/chromium")
    arguments.add_argument("--participants", type=int, default=1000)
    arguments.add_argument("--repeats", type=int, default=6)
    arguments.add_argument("--rate", type=float, default=120.0)
    args = arguments.parse_args()
    zwidth, root = args.zwidth.resolve(), (args.folder / f"{args.participants}x{args.repeats}").resolve()
    before = os.getloadavg()
    simulated(zwidth, root, args)
    reports, run = root / "reports" / STUDY, [zwidth, "--root", root, "--quiet", "run", STUDY]
    rows = [("`zwidth run`: everything", timed(*run, "--fresh"))]
    rows.append(("nothing to do", timed(*run)))
    # Moved, not removed: ext4 spends a tenth of the run on passing over the inodes of files that were just removed.
    aside = root / "aside"
    shutil.rmtree(aside, ignore_errors=True)
    aside.mkdir()
    (reports / "figures").rename(aside / "figures")
    rows.append(("the figures over participants", timed(*run)))
    (reports / "report-data").rename(aside / "report-data")
    (reports / "index.html").unlink()
    rows.append(("the page and its data", timed(*run)))
    (reports / "index.html").unlink()
    rows.append(("the page alone", timed(*run)))
    page = root / "plotly.html"
    rows.append(("plotly's page", timed(sys.executable, Path(__file__).parent / "peer.py", root, STUDY, page)))
    seen = {"zwidth": browsed.browsed(reports / "index.html", *browsed.OURS, args.chromium)}
    seen["plotly"] = browsed.browsed(page, *browsed.PEER, args.chromium)
    print(report(args, root, reports, page, rows, seen, before))


def report(args, root, reports, page, rows, seen, before):
    metrics = parquet.read_table(root / "derived" / STUDY / "metrics.parquet", columns=["participant", "trial"])
    trials, people = metrics.num_rows, len(set(metrics["participant"].to_pylist()))
    files = sorted((root / "raw" / STUDY / "trials").rglob("trial-*.parquet"))
    samples = sum(parquet.ParquetFile(file).metadata.num_rows for file in files[:: max(1, len(files) // 500)])
    samples = round(samples / len(files[:: max(1, len(files) // 500)]) * trials, -3)
    libraries = ", ".join(f"{name} {version(name)}" for name in ("pandas", "pyarrow", "plotly"))
    load = " and ".join(f"{one:.1f}" for one in (before[0], os.getloadavg()[0]))
    chromium = subprocess.run([args.chromium, "--version"], capture_output=True, text=True, check=True).stdout.strip()
    lines = [
        "<!-- Written by run.sh. -->", "# The page of a large study, by zwidth and by plotly", "",
        INTRO.format(participants=people, trials=trials, samples=int(samples), rate=args.rate), "",
        f"{platform.machine()}, {os.cpu_count()} cores, load average before and after {load}. Python {platform.python_version()}, {libraries}, {chromium}. The number of "
        "samples is that of every so many files, times the trials.", "",
        "## Writers", "", "| one process | wall, s | of processor, s | peak memory, MB |", "| --- | --- | --- | --- |",
    ]
    lines += [f"| {name} | {row['wall_s']:.1f} | {row['cpu_s']:.1f} | {row['mb']:.0f} |" for name, row in rows]
    kinds = [("raw data", root / "raw"), ("derived", root / "derived"), ("`index.html`", reports / "index.html"), ("`report-data/`", reports / "report-data"),
             ("`figures/`", reports / "figures"), ("`tables/`", reports / "tables"), ("plotly's page", page)]
    lines += ["", "## Sizes", "", "| what | MB | files |", "| --- | --- | --- |"]
    lines += [f"| {name} | {size:.1f} | {n:,} |" for name, (size, n) in ((name, megabytes(path)) for name, path in kinds)]
    lines += ["", "## In the browser", "",
              f"Medians of {browsed.OPENINGS} openings and of {browsed.CHOICES - 1} choices of another participant.", "",
              "| page | first paint, ms | first trial drawn, ms | choice to trials, ms | largest, ms | heap, MB |", "| --- | --- | --- | --- | --- | --- |"]
    lines += [f"| {name} | {s['paint_ms']:.0f} | {s['first_ms']:.0f} | {s['choice_ms']:.0f} | {s['choice_max_ms']:.0f} | {s['heap_mb']:.0f} |" for name, s in seen.items()]
    ours, writer = seen["zwidth"], dict(rows)["the page and its data"]["mb"]
    aims = [("first paint", ours["paint_ms"], PAINT_MS, "ms"), ("from a choice to its trials", ours["choice_ms"], CHOICE_MS, "ms"), ("memory of the page's writer", writer, WRITER_MB, "MB")]
    said = [f"{name} below {aim} {unit} ({'' if value < aim else '**missed**: '}{value:.0f})" for name, value, aim, unit in aims]
    return "\n".join([*lines, "", f"The aims: {', '.join(said)}."])


main()
