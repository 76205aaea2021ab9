"""A command, its time and its memory; tables of them.

Nothing but Python's own library is loaded here: the system counts the memory of a process from before its program is
loaded, when it is still a copy of this one.
"""

import os
import statistics
import subprocess
import sys
import tempfile
import time


def measured(*command):
    """Runs a command: seconds of the clock, of processors, largest resident set in MB, and what it printed."""
    begun = time.perf_counter()
    with tempfile.TemporaryFile("w+") as said:
        process = subprocess.Popen([str(part) for part in command], stdout=said, stderr=subprocess.STDOUT)
        _, status, usage = os.wait4(process.pid, 0)
        wall = time.perf_counter() - begun
        said.seek(0)
        text = said.read()
    code = os.waitstatus_to_exitcode(status)
    # 3: something is to be read with care.
    if code not in (0, 3):
        raise SystemExit(f"{command} ended with {code}: {text[-2000:]}")
    print(f"{wall:9.2f} s  {' '.join(str(part) for part in command[:6])}", file=sys.stderr)
    return wall, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024, text


def output(*command):
    return subprocess.run([str(part) for part in command], stdout=subprocess.PIPE, text=True, check=True).stdout


def median(runs, which=0):
    return statistics.median(run[which] for run in runs)


def table(headings, rows, left=1):
    rule = ["---"] * left + ["--:"] * (len(headings) - left)
    return "\n".join("| " + " | ".join(cells) + " |" for cells in [headings, rule, *rows]) + "\n"
