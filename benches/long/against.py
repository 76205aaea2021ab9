"""Import of one long recording by two builds of the program, in turns: seconds of each, and their ratio.

    python3 benches/long/against.py OLD NEW [--rows 20000000] [--turns 3]
"""

import argparse
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

MAP = """kind = "trials"
[trial]
participant = "P01"
session = "S01"
environment = "spring"
mode = "hybrid"
[time]
from = "t"
unit = "s"
[[column]]
to = "theta_rad"
from = "angle"
unit = "deg"
[[column]]
to = "force_ex_n"
from = "force"
unit = "N"
[[column]]
to = "theta_dot_rad_s"
derive = "derivative of theta_rad"
"""


def recording(path, rows):
    """A lever that swings slowly, at 1 kHz."""
    with path.open("w") as file:
        file.write("t,angle,force\n")
        for start in range(0, rows, 10_000):
            lines = (f"{i / 1000:.3f},{(i * 7) % 4000 / 100 - 20:.2f},{(i * 13) % 900 / 100:.2f}\n" for i in range(start, min(start + 10_000, rows)))
            file.write("".join(lines))


def imported(program, folder, csv):
    root = Path(tempfile.mkdtemp(dir=folder))
    run = lambda *arguments: subprocess.run([program, "--root", root, *arguments], capture_output=True, check=False)
    run("new", "long")
    (root / "map.toml").write_text(MAP)
    begin = time.perf_counter()
    done = run("import", "long", "--map", str(root / "map.toml"), str(csv))
    seconds = time.perf_counter() - begin
    assert done.returncode in (0, 3), done.stderr.decode()
    subprocess.run(["rm", "-r", root], check=True)
    return seconds


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("old")
    parser.add_argument("new")
    parser.add_argument("--rows", type=int, default=20_000_000)
    parser.add_argument("--turns", type=int, default=3)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        csv = Path(folder) / "long.csv"
        recording(csv, arguments.rows)
        turns = [(imported(arguments.old, folder, csv), imported(arguments.new, folder, csv)) for _ in range(arguments.turns)]
    old, new = (statistics.median(seconds) for seconds in zip(*turns))
    print(f"{arguments.rows:,} rows: old {old:.1f} s, new {new:.1f} s, ratio {new / old:.2f} (medians of {arguments.turns} turns: {turns})")


main()
