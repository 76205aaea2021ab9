"""Processor time of a trial in a session of two thousand: of the first hundred trials and of the last.

    python session.py --zwidth PROGRAM [--scale 56] [--folder FOLDER]       the measurement, as a row of Markdown

The simulated device and participant record one session. When the files of four trials appear, the system is asked how
much processor time the process has taken, user and system, of all threads.
"""

import argparse
import os
import subprocess
import tempfile
import time
from pathlib import Path

# Conditions and repeats of a new study, and its trials for practice.
CONDITIONS, REPEATS, PRACTICE = 6, 6, 3
# Trials at the beginning and at the end of the session.
MANY = 100
POLL_S = 0.001


def processor_s(process):
    """User and system time of a process that runs, s."""
    fields = Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def measure(zwidth, scale, folder):
    """Processor time at the trials named, s."""
    trials = CONDITIONS * REPEATS * scale + PRACTICE
    command = [zwidth, "--quiet", "--root", folder, "twin", "long", "--participants", "1", "--sessions", "1"]
    process = subprocess.Popen([*map(str, command), "--scale", str(scale)])
    found = []
    for trial in (1, 1 + MANY, trials - MANY, trials):
        path = folder / f"raw/long/trials/participant=P01/session=S01/trial-{trial:03}.parquet"
        while not path.exists():
            if process.poll() is not None:
                raise SystemExit(f"the program ended with {process.returncode} before trial {trial}")
            time.sleep(POLL_S)
        found.append(processor_s(process.pid))
    process.wait()
    return trials, found


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--zwidth", type=Path, required=True)
    arguments.add_argument("--scale", type=int, default=56)
    arguments.add_argument("--folder", type=Path)
    given = arguments.parse_args()
    with tempfile.TemporaryDirectory(dir=given.folder) as folder:
        trials, at = measure(given.zwidth.resolve(), given.scale, Path(folder))
    first_ms, last_ms = ((at[i + 1] - at[i]) / MANY * 1e3 for i in (0, 2))
    print("| trials | first hundred, ms each | last hundred, ms each | ratio |")
    print("| ---: | ---: | ---: | ---: |")
    print(f"| {trials:,} | {first_ms:.1f} | {last_ms:.1f} | {last_ms / first_ms:.2f} |")


main()
