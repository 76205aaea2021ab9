"""Ours and the plain loop in turns at one board: python bench.py RIG_BENCH [ROUNDS [SECONDS]] prints the tables of RESULTS.md."""

import subprocess
import sys
from pathlib import Path
from statistics import median

RATE_HZ = 1000
SHARES = [("median", 0.5), ("99 %", 0.99), ("99.9 %", 0.999), ("most", 1.0)]
BUSY = [sys.executable, "-c", "while True: pass"]
CORES = 2


def at(sorted_values, share):
    return sorted_values[min(len(sorted_values) - 1, int(share * len(sorted_values)))]


def run(command, ticks):
    """Lateness and time of each tick of a loop, µs, sorted; and the ticks that it left out."""
    lines = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split("\n")
    looks = [tuple(map(float, line.split())) for line in lines if line]
    late, took = (sorted(column) for column in zip(*looks))
    return late, took, ticks - len(looks)


def rounds(ours, peer, ticks, number):
    """So many rounds of one after the other: each one's columns."""
    found = {"zwidth": [], "pySerial": []}
    for _ in range(number):
        for name, command in (("zwidth", ours), ("pySerial", peer)):
            found[name].append(run(command, ticks))
    return found


def table(found):
    print("| | " + " | ".join(f"late, {name}" for name, _ in SHARES) + " | " + " | ".join(f"answered, {name}" for name, _ in SHARES) + " | ticks left out |")
    print("|---" * (2 * len(SHARES) + 2) + "|")
    rows = {}
    for name, columns in found.items():
        rows[name] = [median(at(column[which], share) for column in columns) for which in (0, 1) for _, share in SHARES]
        left_out = sum(column[2] for column in columns)
        print(f"| {name} | " + " | ".join(f"{value:,.0f} µs" for value in rows[name]) + f" | {left_out} |")
    ratios = [
        median(at(peer[which], share) / max(at(own[which], share), 0.1) for own, peer in zip(found["zwidth"], found["pySerial"]))
        for which in (0, 1)
        for _, share in SHARES
    ]
    print("| pySerial : zwidth | " + " | ".join(f"{ratio:.2g}" for ratio in ratios) + " | |")


def main(program, number=5, seconds=10):
    ticks = int(RATE_HZ * float(seconds))
    board = subprocess.Popen([program, "board"], stdout=subprocess.PIPE, text=True)
    try:
        port = board.stdout.readline().strip()
        ours = [program, "loop", port, str(RATE_HZ), str(ticks)]
        peer = [sys.executable, str(Path(__file__).with_name("peer.py")), port, str(RATE_HZ), str(ticks)]
        print(f"{number} rounds of {ticks:,} ticks at {RATE_HZ} Hz, zwidth and pySerial in turns; each number is the median of the rounds'.\n")
        print("## Nothing else runs\n")
        table(rounds(ours, peer, ticks, int(number)))
        print("\n## Both cores are busy\n")
        busy = [subprocess.Popen(BUSY) for _ in range(CORES)]
        try:
            table(rounds(ours, peer, ticks, int(number)))
        finally:
            for process in busy:
                process.kill()
    finally:
        board.kill()


if __name__ == "__main__":
    main(*sys.argv[1:])
