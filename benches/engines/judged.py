"""What `zwidth judge` says of a trajectory."""

import json
import subprocess

import numpy as np


def judged(zwidth, scene, trajectory):
    """The verdict on a file in a few words, the largest error of theta in rad, and whether a person could tell (None if not known)."""
    told = subprocess.run([zwidth, "judge", scene.path, "--trajectory", trajectory, "--json"], capture_output=True, text=True)
    if not told.stdout:
        return f"refused: {told.stderr.strip().splitlines()[0]}", float("inf"), None
    judged, faults = json.loads(told.stdout)["tables"]
    row = judged["rows"][0]
    return worded(row["verdict"], faults["rows"]), row["theta_error_max_rad"], row["is_felt"]


def worded(verdict, faults):
    """A verdict with the size of the first fault that is it."""
    fault = next((fault for fault in faults if fault["fault"] == verdict), {})
    sizes = []
    if fault.get("event"):
        sizes.append(fault["event"])
    if fault.get("creep_rad_s") is not None:
        sizes.append(f"{np.degrees(abs(fault['creep_rad_s'])):.2g}°/s")
    elif fault.get("late_s") is not None:
        sizes.append(f"{1e3 * abs(fault['late_s']):.2g} ms")
    elif fault.get("theta_rad") is not None:
        sizes.append(f"{np.degrees(abs(fault['theta_rad'])):.2g}°")
    return ": ".join([verdict, ", ".join(sizes)]) if sizes else verdict
