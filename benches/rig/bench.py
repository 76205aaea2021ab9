"""Ours, the plain loop and one that only looks at the clock, in turns: python bench.py RIG_BENCH [ROUNDS [SECONDS]] prints the
tables of RESULTS.md."""

import os
import subprocess
import sys
import time
from pathlib import Path
from statistics import median

RATE_HZ = 1000
SHARES = [("median", 0.5), ("99 %", 0.99), ("99.9 %", 0.999), ("most", 1.0)]
BUSY = [sys.executable, "-c", "while True: pass"]
CORES = os.cpu_count()
ALONE = "the clock alone"
PROGRAM = "zwidth, a program in Python"
LEVER = Path(__file__).resolve().parents[2] / "examples/device/lever.py"
# Times below are not told apart.
SHORTEST_US = 1.0


def at(sorted_values, share):
    return sorted_values[min(len(sorted_values) - 1, int(share * len(sorted_values)))]


def run(command, ticks):
    """Lateness and time of each tick of a loop, µs, sorted; and the ticks that it left out."""
    lines = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split("\n")
    looks = [tuple(map(float, line.split())) for line in lines if line]
    late, took = (sorted(column) for column in zip(*looks))
    return late, took, ticks - len(looks)


def rounds(commands, ticks, number):
    """So many rounds of one after the other: each one's columns, and the share of its time that the machine was away, %."""
    found = {name: [] for name in commands}
    for _ in range(number):
        for name, command in commands.items():
            stolen, began = stolen_s(), time.monotonic()
            late, took, left_out = run(command, ticks)
            away = 100 * (stolen_s() - stolen) / CORES / (time.monotonic() - began)
            found[name].append((late, took, left_out, away))
    return found


def stolen_s():
    """What a virtual machine's host gave to others while ours wanted to run, of all cores; 0 where nobody tells."""
    stat = Path("/proc/stat")
    fields = stat.read_text().split("\n")[0].split() if stat.exists() else []
    return int(fields[8]) / os.sysconf("SC_CLK_TCK") if len(fields) > 8 else 0.0


def table(found):
    print("| | " + " | ".join(f"late, {name}" for name, _ in SHARES) + " | " + " | ".join(f"answered, {name}" for name, _ in SHARES) + " | ticks left out | taken by others |")
    print("|---" * (2 * len(SHARES) + 3) + "|")
    rows = {}
    for name, columns in found.items():
        rows[name] = [median(at(column[which], share) for column in columns) for which in (0, 1) for _, share in SHARES]
        left_out = sum(column[2] for column in columns)
        words = [f"{value:,.0f} µs" for value in rows[name]]
        if name == ALONE:
            words[len(SHARES) :] = [""] * len(SHARES)
        print(f"| {name} | " + " | ".join(words) + f" | {left_out:,} | {median(column[3] for column in columns):.1f} % |")
    ratios = [
        median(at(peer[which], share) / max(at(own[which], share), SHORTEST_US) for own, peer in zip(found["zwidth"], found["pySerial"]))
        for which in (0, 1)
        for _, share in SHARES
    ]
    print("| pySerial : zwidth | " + " | ".join(ratio_words(ratio) for ratio in ratios) + " | | |")


def ratio_words(ratio):
    return f"{ratio:,.0f}" if ratio >= 10 else f"{ratio:.2g}"


def main(program, number=5, seconds=10):
    ticks = int(RATE_HZ * float(seconds))
    board = subprocess.Popen([program, "board"], stdout=subprocess.PIPE, text=True)
    try:
        port = board.stdout.readline().strip()
        commands = {
            "zwidth": [program, "loop", port, str(RATE_HZ), str(ticks)],
            PROGRAM: [program, "program", str(RATE_HZ), str(ticks), sys.executable, str(LEVER)],
            "pySerial": [sys.executable, str(Path(__file__).with_name("peer.py")), port, str(RATE_HZ), str(ticks)],
            ALONE: [program, "clock", str(RATE_HZ), str(ticks)],
        }
        print(f"{number} rounds of {ticks:,} ticks at {RATE_HZ} Hz, in turns; each number is the median of the rounds', ticks left out their sum.\n")
        print("## Nothing else runs\n")
        table(rounds(commands, ticks, int(number)))
        print("\n## All cores are busy\n")
        busy = [subprocess.Popen(BUSY) for _ in range(CORES)]
        try:
            table(rounds(commands, ticks, int(number)))
        finally:
            for process in busy:
                process.kill()
    finally:
        board.kill()


if __name__ == "__main__":
    main(*sys.argv[1:])
