"""A study whose trials differ in everything that may differ: participants, sessions, conditions, columns, answers."""

import tempfile
from pathlib import Path

import pandas as pd

import folders
from checks import DONE_OR_WITH_CARE, equal, run

MAP = """
kind = "trials"
[trial]
participant = {{ column = "who" }}
session = {{ column = "session" }}
environment = {{ column = "environment" }}
mode = {{ column = "mode" }}
{likert}
{channel}
[time]
from = "t"
unit = "s"
[[column]]
to = "{signal}"
from = "x"
unit = "{unit}"
"""
GRIP = """
[[channel]]
to = "grip_n"
from = "x"
unit = "N"
scale = 2.0
"""
HEADER = "who,session,environment,mode,q,t,x\n"
FORCES = "P1,S1,spring,active,4,0,0.5\nP1,S1,spring,active,4,0.01,0.25\nP1,S2,spring_wall,hybrid,5,0,1\n"
ANGLES = "Q-7_x,S1,spring,passive,,0,30\nQ-7_x,S1,spring,passive,,0.02,60\n"


def check(zwidth):
    """Forces with answers in one import, angles without in another; both open as one folder."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        run(zwidth, "--root", root, "new", "mixed")
        with (root / "raw/mixed/study.toml").open("a") as study:
            study.write('[[channels]]\nid = "grip_n"\nunit = "N"\ndescription = "force of the grip"\n')
        bring(zwidth, root, FORCES, signal="force_ex_n", unit="N", likert='likert = { column = "q" }', channel=GRIP)
        bring(zwidth, root, ANGLES, signal="theta_rad", unit="deg", likert="", channel="")
        folders.study(zwidth, root, "mixed")
        frame = pd.read_parquet(root / "raw/mixed/trials").sort_values(["participant", "session", "t_s"])
        equal("mixed: forces, null where none was recorded", frame["force_ex_n"].fillna(-1).tolist(), [0.5, 0.25, 1, -1, -1])
        equal("mixed: a channel, null where none was recorded", frame["grip_n"].fillna(-1).tolist(), [1, 0.5, 2, -1, -1])
        given = [(e["question"], e["value"]) for e in folders.events(root / "raw/mixed") if e["event"] == "answer"]
        equal("mixed: answers by question", given, [("felt_spring", 4), ("felt_wall", 5)])
        equal("mixed: modes", frame["mode"].astype(str).tolist(), ["active", "active", "hybrid", "passive", "passive"])


def bring(zwidth, root, rows, **of_map):
    """Imports rows of text."""
    (root / "map.toml").write_text(MAP.format(**of_map))
    (root / "rows.csv").write_text(HEADER + rows)
    run(zwidth, "--root", root, "import", "mixed", "--map", root / "map.toml", root / "rows.csv", codes=DONE_OR_WITH_CARE)
