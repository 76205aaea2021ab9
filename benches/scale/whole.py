"""A whole study, from the simulated device to the page, then what is asked of it every day; prints Markdown.

    python whole.py ZWIDTH FOLDER [--participants 1000] [--rounds 3]

FOLDER is where the study is made; one that is there is made again.
"""

import argparse
import re
import shutil
import sys
from pathlib import Path

from measure import measured, median, output, table

STUDY = "big"


def row(what, runs):
    wall, processor, memory = (median(runs, which) for which in range(3))
    return [what, f"{wall:,.2f}", f"{processor:,.2f}", f"{memory:,.0f}"]


def size(folder):
    files = [file.stat().st_size for file in folder.rglob("*") if file.is_file()]
    return len(files), sum(files)


def dead_links(reports):
    """Links of the page and the summary to files that are not there."""
    page, summary = ((reports / name).read_text() for name in ("index.html", "summary.md"))
    links = re.findall(r'(?:href|src)="([^"#:]+)', page) + re.findall(r"\]\(([^)#:]+)\)", summary)
    return sorted({link for link in links if not (reports / link).exists()})


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("zwidth", type=Path)
    arguments.add_argument("folder", type=Path)
    arguments.add_argument("--participants", type=int, default=1000)
    arguments.add_argument("--rounds", type=int, default=3)
    given = arguments.parse_args()
    program = given.zwidth.resolve()
    shutil.rmtree(given.folder, ignore_errors=True)
    given.folder.mkdir(parents=True)
    zwidth = lambda *words: measured(program, "--root", given.folder, "--quiet", *words)

    of = ["--participants", given.participants, "--sessions", 1, "--rate", 1000]
    rows = [row(f"`zwidth twin {STUDY} {' '.join(map(str, of))}`", [zwidth("twin", STUDY, *of)])]
    rows.append(row(f"`zwidth run {STUDY}`, everything", [zwidth("run", STUDY)]))
    for name, what in [("run", ", nothing to do"), ("list", ""), ("verify", "")]:
        rows.append(row(f"`zwidth {name} {STUDY}`{what}", [zwidth(name, STUDY) for _ in range(given.rounds)]))

    if dead := dead_links(given.folder / "reports" / STUDY):
        sys.exit(f"links to what is not there: {', '.join(dead)}")

    print(f"{output(program, '--version').strip()}. `twin` and the first `run` once, the others {given.rounds} times: medians.")
    print("Processors: user and system time together; memory: the largest resident set.\n")
    print(table(["command", "wall, s", "of processors, s", "memory, MB"], rows))
    places = {"recordings": "raw", "derived tables": "derived", "figures, tables, page": "reports"}
    counted = ((what, *size(given.folder / place / STUDY)) for what, place in places.items())
    print(table(["what", "files", "GB"], [[what, f"{n:,}", f"{bytes / 1e9:.2f}"] for what, n, bytes in counted]), end="")


main()
