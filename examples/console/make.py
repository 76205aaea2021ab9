"""Recordings as a surgical console writes them, by formula: pose and three-axis force of one instrument.

    python make.py FOLDER

FOLDER gets a CSV file for each trial (P01_assisted_1.csv, …) and participants.csv; six people, three of them
experts, each with and without assistance, twice each, 60 s at 100 Hz. It needs nothing but Python 3.11 or later. How
to import them is in docs/import.md, "A surgical console".

The tip moves along a helix: at rest for REST_S, then from rest to a constant speed and back to rest within RAMP_S
(a raised cosine), then at rest again until the recording ends. So path, distance, completion time, work, |F| and the
share of force across the push are known: `Trial` has them.
"""

import csv
import math
import sys
from dataclasses import dataclass
from pathlib import Path

RATE_HZ = 100
LENGTH_S = 60.0
REST_S = 2.0
RAMP_S = 0.5
# The helix: its middle in the console's frame, its radius and its rise, m.
MIDDLE = (0.05, 0.12, -0.08)
RADIUS = 0.03
RISE = -0.04
# Forces while it moves: tangential, and along the push (0, 0, -1), as shares of |F|; at rest along the push alone.
TANGENTIAL, ALONG = 0.6, 0.8
FORCE_AT_REST_N = 0.2
# Speeds at which zwidth takes a movement to begin and to end, m/s: defaults of [axes].
ONSET, OFFSET = 0.01, 0.005

PEOPLE = {
    # code: group, turns and seconds without assistance, |F| in N
    "P01": ("novice", 22, 54.0, 2.4),
    "P02": ("novice", 25, 56.0, 2.9),
    "P03": ("novice", 20, 52.0, 2.6),
    "P04": ("expert", 14, 40.0, 1.6),
    "P05": ("expert", 16, 43.0, 1.9),
    "P06": ("expert", 13, 38.0, 1.5),
}
# What assistance leaves of turns, time and force.
ASSISTED = (0.8, 0.85, 0.7)
MODES = ("unassisted", "assisted")
REPEATS = 2


@dataclass
class Trial:
    """One trial, and what is true of it."""

    person: str
    mode: str
    repeat: int
    turns: float
    moves_s: float
    force_n: float

    @property
    def path_m(self):
        """Length of the helix: of a turn it is the hypotenuse of the circle and the rise."""
        return math.hypot(2 * math.pi * RADIUS * self.turns, RISE)

    @property
    def speed(self):
        """The constant speed between the ramps, each of which is worth half of its time."""
        return self.path_m / (self.moves_s - RAMP_S)

    @property
    def completion_s(self):
        """From where the ramp passes ONSET to where it falls below OFFSET."""
        late = [RAMP_S / math.pi * math.acos(1 - 2 * threshold / self.speed) for threshold in (ONSET, OFFSET)]
        return self.moves_s - sum(late)

    @property
    def work_j(self):
        """Tangential force along the circle, and the push along the rise."""
        circle = 2 * math.pi * RADIUS * self.turns
        return self.force_n * (TANGENTIAL * circle - ALONG * RISE)

    def share(self, t):
        """How much of the path has been travelled at a time."""
        x = t - REST_S
        if x <= 0:
            return 0.0
        if x >= self.moves_s:
            return 1.0

        def ramp(u):
            return (u - RAMP_S / math.pi * math.sin(math.pi * u / RAMP_S)) / 2

        whole = self.moves_s - RAMP_S
        if x < RAMP_S:
            return ramp(x) / whole
        left = self.moves_s - x
        return 1.0 - ramp(left) / whole if left < RAMP_S else (x - RAMP_S / 2) / whole

    def row(self, t):
        """Position, m, and force, N."""
        share = self.share(t)
        phase = 2 * math.pi * self.turns * share
        x, y, z = MIDDLE
        place = (x + RADIUS * math.cos(phase), y + RADIUS * math.sin(phase), z + RISE * share)
        if not 0 < share < 1:
            return place, (0.0, 0.0, -FORCE_AT_REST_N)
        across = TANGENTIAL * self.force_n
        return place, (-across * math.sin(phase), across * math.cos(phase), -ALONG * self.force_n)


def trials():
    """All trials."""
    for person, (_, turns, moves_s, force_n) in PEOPLE.items():
        for mode in MODES:
            shares = ASSISTED if mode == "assisted" else (1.0, 1.0, 1.0)
            for repeat in range(1, REPEATS + 1):
                # The second time it is a little shorter.
                practice = 1.0 - 0.03 * (repeat - 1)
                yield Trial(
                    person,
                    mode,
                    repeat,
                    turns * shares[0] * practice,
                    moves_s * shares[1] * practice,
                    force_n * shares[2],
                )


def write(folder):
    """Writes all files."""
    folder.mkdir(parents=True, exist_ok=True)
    header = ["time_ms", "pos_x (mm)", "pos_y (mm)", "pos_z (mm)", "ForceX (N)", "ForceY (N)", "ForceZ (N)", "roll_deg"]
    for trial in trials():
        name = f"{trial.person}_{trial.mode}_{trial.repeat}.csv"
        with open(folder / name, "w", newline="", encoding="utf-8") as file:
            lines = csv.writer(file)
            lines.writerow(header)
            for i in range(int(LENGTH_S * RATE_HZ) + 1):
                place, force = trial.row(i / RATE_HZ)
                cells = [f"{1000 * x:.4f}" for x in place] + [f"{f:.4f}" for f in force]
                lines.writerow([f"{1000 * i // RATE_HZ}", *cells, "0.0"])
    with open(folder / "participants.csv", "w", newline="", encoding="utf-8") as file:
        lines = csv.writer(file)
        lines.writerow(["participant", "group"])
        lines.writerows([person, about[0]] for person, about in PEOPLE.items())


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    write(Path(sys.argv[1]))
