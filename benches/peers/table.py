"""One Markdown table from the rows of all peers, and the versions they ran with.

    python table.py ROWS
"""

import os
import platform
import subprocess
import sys

import numba
import numpy
import scipy


def rows(path):
    with open(path) as file:
        return [line.rstrip("\n").split("\t") for line in file]


def micro(seconds):
    return f"{float(seconds) * 1e6:,.1f}"


def group(row):
    """Place and name of the part of the table a row belongs to."""
    target, remark = float(row[3]), row[10]
    if remark.startswith("chatters"):
        return 3, "right-hand side switched on the sign of the velocity, no events: it chatters"
    if target < 0.0:
        return 4, "1,000 scenes of other parameters each, per scene"
    return (0, "exact") if target == 0.0 else (1 if target > 1e-8 else 2, f"error ≤ {target:.0e} rad")


def order(row):
    """By part, then by time; what was not reached comes last."""
    return group(row), float(row[8]) if row[8] else float("inf")


def cells(row, exact):
    name, method, sine, _, tolerance, step, error, evaluations, first, second, remark = row
    step = f"{float(step) * 1e3:.3g} ms" if step else "–"
    tolerance = f"{float(tolerance):.0e}" if tolerance else "–"
    if not first:
        return [name, method, sine or "–", tolerance, step, "–", "–", "–", remark]
    ratio = min(float(seconds) for seconds in (first, second) if seconds) / exact
    error = f"{float(error):.1e}" if float(error) else "reference"
    times = " / ".join(micro(seconds) for seconds in (first, second) if seconds)
    return [name, method, sine or "–", tolerance, step, error, f"{int(evaluations):,}", times, f"{ratio:,.1f}"]


def table(all_rows):
    def best(method):
        row = next(row for row in all_rows if row[:2] == ["zwidth exact", method])
        return min(float(row[8]), float(row[9]))

    exact, swept = best("ready"), best("new parameters")
    heads = ["peer", "method", "sine", "tolerance", "largest step", "error of θ, rad", "evaluations",
             "time of two passes, µs", "time / exact"]
    lines = [heads, ["---"] * len(heads)]
    part = None
    for row in sorted(all_rows, key=order):
        if group(row) != part:
            part = group(row)
            lines.append([f"**{part[1]}**"] + [""] * (len(heads) - 1))
        lines.append(cells(row, swept if float(row[3]) < 0.0 else exact))
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


ABOUT = """\
Table 3 without finger, a sine of 2.15 N, motor 3.25 N, brake 13 N, lever 1 m; 482 samples of 8.3 ms, θ and θ̇ written by
every peer. All but the last part use the same mode machine: forward, stick, backward below and at the motor's limit, with
events between them; the release from stick is in closed form. Each peer has the setting (tolerance, largest step, sine
evaluated at each stage or carried in the state) that is fastest among those whose largest error of θ over the samples,
against the exact solution, stays below the bound. Times are the shortest of many runs, in two passes. Ready: regions
met before; first run: matrices made anew. New parameters: a sweep over stiffness (3.5…8 N/rad), damping (0.5…2 N s/rad)
and magnitude (1…2.5 N), each scene made anew from its numbers; beside it Dormand–Prince with the setting that is best
among those whose error stays below 1e-06 rad in all scenes, and with the setting of the one scene. Evaluations: of the right-hand side and its derivative; products with a flow
matrix for exact.
"""


def output(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()


def main():
    versions = [output("rustc", "--version"), f"Python {platform.python_version()}", f"NumPy {numpy.__version__}",
                f"SciPy {scipy.__version__}", f"numba {numba.__version__}"]
    load = ", ".join(f"{x:.1f}" for x in os.getloadavg())
    print("<!-- Written by run.sh. -->")
    print("# The sticking scene, solved by zwidth and by its peers\n")
    print(f"{platform.machine()}, {os.cpu_count()} cores, one used; load average at the end {load}. "
          + ", ".join(versions) + ".\n")
    print(ABOUT)
    print(table(rows(sys.argv[1])))


main()
