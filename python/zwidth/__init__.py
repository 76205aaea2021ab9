"""zwidth for Python: studies of force feedback, and what zwidth computes on one's own arrays.

The module reads and computes; the command, which comes with it (`zwidth.command`), writes. SI units, angles in radians.

>>> import array, math, zwidth
>>> t = array.array("d", (i / 1000 for i in range(1001)))
>>> speed = array.array("d", (30 * x**2 * (1 - x) ** 2 for x in t))
>>> round(zwidth.smoothness(t, speed), 3)  # of a minimum-jerk movement
-1.402
"""

from zwidth._command import command
from zwidth._errors import ZwidthError
from zwidth._native import (
    Characteristic,
    Column,
    Judgement,
    Psychometric,
    Runs,
    Samples,
    Study,
    Table,
    Trial,
    __version__,
    fit_characteristic,
    fit_psychometric,
    judge,
    means_by_branch,
    onset,
    read_study,
    read_trial,
    simulate,
    smoothness,
    stability_limits,
    stability_map,
    trial_metrics,
)

__all__ = [
    "Characteristic",
    "Column",
    "Judgement",
    "Psychometric",
    "Runs",
    "Samples",
    "Study",
    "Table",
    "Trial",
    "ZwidthError",
    "__version__",
    "command",
    "fit_characteristic",
    "fit_psychometric",
    "judge",
    "means_by_branch",
    "onset",
    "read_study",
    "read_trial",
    "simulate",
    "smoothness",
    "stability_limits",
    "stability_map",
    "trial_metrics",
]
