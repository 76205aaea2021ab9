"""A study whose trials differ in everything that may differ: participants, sessions, conditions, columns, answers."""

import tempfile
from pathlib import Path

import pandas as pd

import folders
from checks import equal, run

MAP = """
kind = "trials"
[trial]
participant = {{ column = "who" }}
session = {{ column = "session" }}
environment = {{ column = "environment" }}
mode = {{ column = "mode" }}
{likert}
[time]
from = "t"
unit = "s"
[[column]]
to = "{signal}"
from = "x"
unit = "{unit}"
"""
HEADER = "who,session,environment,mode,q,t,x\n"
FORCES = "P1,S1,spring,active,4,0,0.5\nP1,S1,spring,active,4,0.01,0.25\nP1,S2,spring_wall,hybrid,5,0,1\n"
ANGLES = "Q-7_x,S1,spring,passive,,0,30\nQ-7_x,S1,spring,passive,,0.02,60\n"


def check(zwidth):
    """Forces with answers in one import, angles without in another; both open as one folder."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        run(zwidth, "--root", root, "new", "mixed")
        bring(zwidth, root, FORCES, signal="force_ex_n", unit="N", likert='likert = { column = "q" }')
        bring(zwidth, root, ANGLES, signal="theta_rad", unit="deg", likert="")
        folders.study(zwidth, root, "mixed")
        frame = pd.read_parquet(root / "raw/mixed/trials").sort_values(["participant", "session", "t_s"])
        equal("mixed: forces, null where none was recorded", frame["force_ex_n"].fillna(-1).tolist(), [0.5, 0.25, 1, -1, -1])
        equal("mixed: answers, null where none was given", frame["likert"].fillna(-1).tolist(), [4, 4, 5, -1, -1])
        equal("mixed: modes", frame["mode"].astype(str).tolist(), ["active", "active", "hybrid", "passive", "passive"])


def bring(zwidth, root, rows, **of_map):
    """Imports rows of text."""
    (root / "map.toml").write_text(MAP.format(**of_map))
    (root / "rows.csv").write_text(HEADER + rows)
    run(zwidth, "--root", root, "import", "mixed", "--map", root / "map.toml", root / "rows.csv")
