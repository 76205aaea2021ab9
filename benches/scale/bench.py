"""A large study, read and made into metrics by zwidth, polars and DuckDB in turns; prints Markdown.

    python bench.py ZWIDTH EXAMPLES FOLDER [--participants 1000] [--rounds 3]

EXAMPLES has the programs `decode`, `compacted` and `metrics`; FOLDER keeps the study between runs.
"""

import argparse
import json
import os
import platform
import shutil
import statistics
import sys
import tempfile
from importlib.metadata import version
from pathlib import Path

from measure import measured, median, output, table

HERE = Path(__file__).parent
STUDY = "big"
# How often copies of a study are decoded beside it.
COPIES = 3
# Columns of ours that say which trial it is.
IDENTITY = 7
PEERS = {
    "polars, in memory": ["by_polars.py", "--engine", "in-memory"],
    "polars, streaming": ["by_polars.py", "--engine", "streaming"],
    "polars, with NumPy and FINUFFT": ["by_polars.py", "--engine", "in-memory", "--series"],
    "DuckDB": ["by_duckdb.py"],
}


class Study:
    """A simulated study below a folder of its own, and zwidth at work on it."""

    def __init__(self, zwidth, folder, participants, aside):
        self.zwidth, self.root, self.aside = zwidth, folder / str(participants), aside
        self.raw, self.derived = (self.root / place / STUDY for place in ("raw", "derived"))
        if not self.raw.exists():
            self.make(folder / f"{participants}.unfinished", participants)
        self.files = sum(1 for _ in (self.raw / "trials").glob("*/*/*.parquet"))

    def make(self, place, participants):
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir(parents=True)
        size = ["--participants", participants, "--sessions", 1, "--rate", 1000]
        measured(self.zwidth, "--root", place, "--quiet", "twin", STUDY, *size)
        place.rename(self.root)

    def run(self, *words):
        return measured(self.zwidth, "--root", self.root, *words)

    def lay_aside(self, *made):
        """What is to be made anew, for as long as the bench runs: some file systems make files slowly for seconds
        after they removed thousands."""
        aside = Path(tempfile.mkdtemp(dir=self.aside))
        for path in (self.derived / name for name in made):
            if path.exists():
                path.rename(aside / path.name)

    def first(self):
        """The metrics as somebody gets them who asks for them first: with the plant that some rest on."""
        self.lay_aside("")
        return self.run("-v", "run", STUDY, "--only", "metrics")

    def stage(self, *forgotten):
        """The metrics anew, where the plant is known."""
        self.lay_aside("metrics", "metrics.parquet", "conditions.parquet", *forgotten)
        return self.run("-v", "run", STUDY, "--only", "metrics")

    def unseen(self):
        """The same, where no run has written down what the files were."""
        return self.stage(".hashes.json")


def stage_seconds(said):
    """What `-v` says that the jobs of the stage took together."""
    return next(float(line.split()[-2]) for line in said.splitlines() if line.split()[:1] == ["metrics"])


def compared(study, theirs):
    """Each column's trials and largest relative difference; ends the bench where one differs."""
    lines = output(sys.executable, HERE / "check.py", study.derived / "metrics.parquet", theirs).splitlines()
    rows = (line.split("\t") for line in lines)
    return {name: (int(trials), float(largest)) for name, trials, _, largest in rows}


def in_turns(study, examples, scratch, rounds):
    """The runs of each, and how each peer's columns compare."""
    runs, differences = {}, {}
    decode = examples / "decode"
    # Once before the clock runs: who comes first would otherwise wait for the disk, and the others not.
    measured(decode, study.raw / "trials")
    for _ in range(rounds):
        runs.setdefault("decode", []).append(measured(decode, study.raw / "trials"))
        runs.setdefault("alone", []).append(measured(examples / "metrics", study.root, STUDY))
        runs.setdefault("first", []).append(study.first())
        runs.setdefault("unseen", []).append(study.unseen())
        runs.setdefault("stage", []).append(study.stage())
        for name, (script, *words) in PEERS.items():
            table = scratch / "metrics.parquet"
            runs.setdefault(name, []).append(measured(sys.executable, HERE / script, study.raw, table, *words))
            differences[name] = compared(study, table)
    return runs, differences


def compacted(study, examples, scratch):
    """Copies with a file for each participant, and decoding them beside the study's own in turns. Last of all: the
    disk is busy with what was written for a while."""
    decode, trials, copies = examples / "decode", study.raw / "trials", scratch / "copies"
    copying = [measured(examples / "compacted", trials, copies)]
    os.sync()
    apart, together = zip(*((measured(decode, trials), measured(decode, copies)) for _ in range(COPIES)))
    row = lambda name, run: [name, *(f"{median(run, of):,.2f}" for of in (0, 1))]
    rows = [row("decoding the trials", apart), row("decoding the copies", together), row("making the copies", copying)]
    about = (
        "Would a study of small files be read faster in copies with one file for each participant? The columns' chunks\n"
        f"copied as they are, and nothing checked; decoding alone, medians of {COPIES} in turns.\n\n"
    )
    return about + table(["what", "wall, s", "of processors, s"], rows)


def cells(name, columns, runs, stage):
    wall, processor = median(runs), median(runs, 1)
    ratios = [f"{wall / median(stage):.2f}", f"{processor / median(stage, 1):.2f}"]
    return [name, columns, f"{wall:,.2f}", f"{processor:,.2f}", f"{median(runs, 2):,.0f}", *ratios]


def times(runs, ours, differences):
    stage = runs["stage"]
    rows = [cells("decoding alone, parquet in Rust", "–", runs["decode"], stage),
            cells("**zwidth, the stage `metrics`**", str(ours), stage, stage),
            cells("zwidth, the stage, its files never seen", str(ours), runs["unseen"], stage),
            cells("zwidth, its reader and metrics alone", str(ours), runs["alone"], stage),
            cells("zwidth, with the identification before it", str(ours), runs["first"], stage)]
    rows += [cells(name, str(len(differences[name])), runs[name], stage) for name in PEERS]
    ratios = ["wall / zwidth", "of processors / zwidth"]
    return table(["metrics", "columns", "wall, s", "of processors, s", "memory, MB", *ratios], rows)


def beside(runs):
    """The rows that `cargo xtask bench` reads."""
    wall = median(runs["stage"])
    names = {"decoding alone": runs["decode"]} | {name: runs[name] for name in PEERS}
    rows = [[name, f"{wall:,.2f}", f"{median(run):,.2f}", f"{median(run) / wall:.2f}"] for name, run in names.items()]
    return table(["metrics, beside", "zwidth, s", "a part of it, s", "ratio"], rows)


def columns(differences):
    trials = {name: trials for found in differences.values() for name, (trials, _) in found.items()}
    cell = lambda value: "–" if value is None else f"{value:.0e}" if value else "0"
    rows = [[f"`{name}`", f"{trials[name]:,}"]
            + [cell(found.get(name, (0, None))[1]) for found in differences.values()] for name in sorted(trials)]
    return table(["column", "trials", *differences], rows)


def sizes(study, scratch):
    found = json.loads(output(sys.executable, HERE / "sizes.py", study.raw, scratch))
    ours, theirs = found["zwidth"], found["pandas"]
    times = lambda of: [f"{of[clock] * 1e3:.2f}" for clock in ("wall_s", "processor_s")]
    row = lambda name, of: [name, f"{of['bytes'] / 1e3:,.1f}", *times(of)]
    ratios = [f"{theirs[what] / ours[what]:.2f}" for what in ("bytes", "wall_s", "processor_s")]
    rows = [row("zwidth's", ours), row("`DataFrame.to_parquet()`", theirs), ["pandas' / zwidth's", *ratios]]
    about = (
        f"{found['files']} trial files, and the same columns with the same values written by pandas' defaults. Both\n"
        "are read by `pandas.read_parquet`, all columns, file by file in turns: means over the files, medians of\n"
        f"{found['rounds']} rounds.\n\n"
    )
    return about + table(["files", "kB per trial", "to read one, ms", "of processors, ms"], rows)


def page(study, runs, differences, ours, raw):
    least, most = (of(map(len, differences.values())) for of in (min, max))
    samples = int(runs["decode"][0][3].split()[2]) // 9
    stage = statistics.median(stage_seconds(run[3]) for run in runs["stage"])
    largest = max(value for found in differences.values() for _, value in found.values())
    versions = [f"{name} {version(name)}" for name in ("polars", "finufft", "duckdb", "pandas", "pyarrow")]
    return [
        f"{output(study.zwidth, '--version').strip()}, Python {platform.python_version()}, {', '.join(versions)}.\n",
        f"{study.files:,} trial files with {samples:,} samples at 1 kHz, {raw / 1e9:.2f} GB; those of\n"
        f"practice trials are decoded, but are in nobody's metrics. Medians of {len(runs['stage'])} rounds in\n"
        "turns, each a process of its own from its start to its end, after all files were read once.\n"
        "Processors: user and system time together; memory: the largest resident set.\n",
        times(runs, ours, differences),
        f"`-v` says that the jobs of zwidth's stage took {stage:.1f} s together, in which time that one spends on\n"
        "another's work counts twice. The stage looks at each file for its footer and then reads it,\n"
        "compares its bytes with their hash, and writes tables with records of what they were made from. Where no run\n"
        "has seen the files before, it hashes each and holds the columns that it reads against their digests; so\n"
        "do its reader and metrics alone, which read each file once, do not ask whether clock and angle are\n"
        "plausible, and write nothing; they make the metrics of practice trials too. The stage's\n"
        f"{ours} columns have intervals and energies among them. The peers make {least} of them, with FINUFFT\n"
        f"{most}, and check, hash and record nothing.\n",
        beside(runs),
        "Largest relative difference of each column from zwidth's, over all trials (the largest of all:\n"
        f"{largest:.0e}). A value is missing in both or in none. Above 1e-9 the bench would have stopped.\n",
        columns(differences),
    ]


def count_columns(table):
    code = "import sys, pyarrow.parquet as p; print(len(p.read_schema(sys.argv[1])))"
    return int(output(sys.executable, "-c", code, table)) - IDENTITY


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("zwidth", type=Path)
    arguments.add_argument("examples", type=Path)
    arguments.add_argument("folder", type=Path)
    arguments.add_argument("--participants", type=int, default=1000)
    arguments.add_argument("--rounds", type=int, default=3)
    given = arguments.parse_args()
    with tempfile.TemporaryDirectory(dir=given.folder) as scratch:
        study = Study(given.zwidth.resolve(), given.folder.resolve(), given.participants, Path(scratch).resolve())
        runs, differences = in_turns(study, given.examples.resolve(), Path(scratch), given.rounds)
        raw = sum(file.stat().st_size for file in (study.raw / "trials").glob("*/*/*.parquet"))
        parts = page(study, runs, differences, count_columns(study.derived / "metrics.parquet"), raw)
        parts.append(sizes(study, Path(scratch)))
        parts.append(compacted(study, given.examples.resolve(), Path(scratch)))
    print("\n".join(parts), end="")


main()
