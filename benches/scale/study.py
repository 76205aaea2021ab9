"""What a study's `study.toml` says that the metrics rest on, and its trial files."""

import math
import tomllib
from pathlib import Path

KEYS = ["participant", "session", "trial"]
# Rules of the metrics that no file says (docs/analysis.md). Two branches share at least so much of the way:
LEAST_SHARE = 0.1
# A plateau: samples a side, share of the angles, its slope over the line's, its sum of squares over a line's.
LEAST_SAMPLES, LEAST_SPAN, FLAT, BETTER = 10, 0.05, 0.25, 0.5
# The bit of `state_bits`.
BRAKE_ON = 128


def parameters(folder):
    """Thresholds and lengths in SI units; the wall's angle by environment."""
    said = tomllib.loads((folder / "study.toml").read_text())
    analysis, springs = said["analysis"], [e for e in said["environments"] if "rest_deg" in e]
    rests = {e["rest_deg"] for e in springs}
    assert len(rests) == 1, "springs with one rest"
    walls = {e["id"]: math.radians(e["wall_deg"]) for e in said["environments"] if "wall_deg" in e}
    assert len(walls) == 1, "one wall"
    return {
        "onset": math.radians(analysis["onset_deg_s"]),
        "offset": math.radians(analysis["offset_deg_s"]),
        "slope_from": math.radians(analysis["slope_from_deg"]),
        "points": analysis["grid_points"],
        "lever": said["device"]["lever_m"],
        "rest": math.radians(rests.pop()),
        "walled": next(iter(walls)),
        "wall": next(iter(walls.values())),
    }


def participants(folder):
    """The trial files of each participant."""
    return [sorted(map(str, one.glob("*/*.parquet"))) for one in sorted((Path(folder) / "trials").iterdir())]
