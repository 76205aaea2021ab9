"""What a study's `study.toml` says that the metrics rest on, and its trial files."""

import math
import tomllib
from pathlib import Path

KEYS = ["participant", "session", "trial"]
# Rules of the metrics that no file says (docs/analysis.md). Two branches share at least so much of the way:
LEAST_SHARE = 0.1
# A plateau: samples a side, share of the angles, its slope over the line's, its sum of squares over a line's.
LEAST_SAMPLES, LEAST_SPAN, FLAT, BETTER = 10, 0.05, 0.25, 0.5
# The step at the reversal rests on one in so many of the grid's angles.
STEP_WINDOW = 10
# A retreat from a stop, a share of the angles travelled; so much of the work space a lever may be outside of it.
RETREAT, OUTSIDE = 0.01, 0.01
# Smaller steps between angles are rounding, rad; angles so many steps of the sensor apart are one step apart.
LEAST_RAD, SAME = 1e-9, 1.001
# Bits of `state_bits`.
BRAKE_ON, MOTOR_ON = 128, 256


def parameters(folder):
    """Thresholds and lengths in SI units; the wall's angle by environment."""
    said = tomllib.loads((folder / "study.toml").read_text())
    analysis, device, resistances = said["analysis"], said["device"], said["resistances"]
    springs = {(e["rest_deg"], e["stiffness_n_per_rad"]) for e in said["environments"] if "rest_deg" in e}
    assert len(springs) == 1, "one spring"
    rest_deg, stiffness = springs.pop()
    walls = {e["id"]: math.radians(e["wall_deg"]) for e in said["environments"] if "wall_deg" in e}
    assert len(walls) == 1, "one wall"
    assert "brake_ohm" not in resistances, "no bound of the brake's energy"
    return {
        "onset": math.radians(analysis["onset_deg_s"]),
        "offset": math.radians(analysis["offset_deg_s"]),
        "slope_from": math.radians(analysis["slope_from_deg"]),
        "points": analysis["grid_points"],
        "limit": said["design"]["trial_limit_s"],
        "lever": device["lever_m"],
        "low": math.radians(device["theta_min_deg"]),
        "high": math.radians(device["theta_max_deg"]),
        "motor_ohm": resistances["motor_ohm"],
        "motor_alone": [mode["id"] for mode in said["modes"] if "motor_max_v" in mode and "brake_max_v" not in mode],
        "rest": math.radians(rest_deg),
        "stiffness": stiffness,
        "walled": next(iter(walls)),
        "wall": next(iter(walls.values())),
    }


def participants(folder):
    """The trial files of each participant."""
    return [sorted(map(str, one.glob("*/*.parquet"))) for one in sorted((Path(folder) / "trials").iterdir())]
