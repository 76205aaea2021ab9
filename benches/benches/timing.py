"""The control loop that people write in Python: sleep until the next deadline, read, compute, write.

    python3 timing.py SECONDS

Prints percentiles of the lateness (50, 99, 99.9 %), its maximum and the 99th percentile of the work, all in s, then
ticks and missed deadlines: what `cargo bench -p zwidth-benches --bench timing` shows beside ours.
"""

import math
import sys
import time

PERIOD_S = 0.001
STIFFNESS, REST, WALL = 4.0, -math.pi / 4, -0.1


def read(t):
    return -0.5 * math.pi / 4 * (1.0 + math.cos(2.0 * t)), 1.0


def control(theta, velocity, force, braking):
    """The hybrid mode: brake forward, motor back, full voltage past the wall."""
    braking = velocity > 0.1 or (braking and force >= 2.0)
    demand = STIFFNESS * (theta - REST)
    if braking:
        return 0.0, 8.0 if theta >= WALL else min(1.0 + demand * 7.0 / 13.0, 8.0), braking
    return -8.0 if theta >= WALL else -min(demand / 0.26, 8.0), 0.0, braking


def percentile(ordered, percent):
    return ordered[min(len(ordered) - 1, math.ceil(percent / 100 * len(ordered)) - 1)]


def main():
    seconds = float(sys.argv[1])
    late, work, rows = [], [], []
    missed, last, braking = 0, None, False
    start = time.perf_counter()
    k = 0
    while True:
        deadline = start + k * PERIOD_S
        wait = deadline - time.perf_counter()
        if wait > 0:
            time.sleep(wait)
        now = time.perf_counter()
        if now - start >= seconds:
            break
        theta, force = read(now - start)
        velocity = 0.0 if last is None else (theta - last[1]) / (now - last[0])
        last = now, theta
        motor, brake, braking = control(theta, velocity, force, braking)
        rows.append((now - start, theta, velocity, force, motor, brake))
        late.append(now - deadline)
        work.append(time.perf_counter() - now)
        skipped = int((now - deadline) / PERIOD_S)
        missed += skipped
        k += 1 + skipped
    late.sort()
    work.sort()
    print(*(percentile(late, p) for p in (50, 99, 99.9)), late[-1], percentile(work, 99), len(late), missed, sep="\t")


if __name__ == "__main__":
    main()
