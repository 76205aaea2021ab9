"""Runs one engine on scenes, in the environment that has it, and writes its trajectories.

    python worker.py ENGINE OUT [--scenes NAME…] [--settings NAME…] [--rounds N]

Writes OUT/ENGINE.SETTING.SCENE.csv (t_s, theta_rad, theta_dot_rad_s) and OUT/ENGINE.json.
"""

import argparse
import importlib
import json
import statistics
import sys
from pathlib import Path

import numpy as np

from scene import CannotSay, scenes
from stepping import TooSlow

# A run that takes longer than this is not repeated, s.
ONCE_S = 5.0
# Settings that only the figure and a table of other settings show are not run on longer scenes, s.
LONGEST_MORE_S = 60.0
# Trajectories of more samples are written thinned: `exact` takes no more.
MOST_WRITTEN = 500_000


def thinned(steps):
    """Every how many samples one is written: a divisor of the steps, so that the last is."""
    every = 1
    while steps / every > MOST_WRITTEN or steps % every:
        every += 1
    return every


def measured(engine, scene, setting, rounds, path):
    row = {"scene": scene.id, "setting": setting.name}
    try:
        times, theta, theta_dot, seconds = engine.run(scene, setting)
        all_seconds = [seconds]
        while len(all_seconds) < rounds and seconds < ONCE_S:
            all_seconds.append(engine.run(scene, setting)[3])
    except (CannotSay, TooSlow) as why:
        return row | {"cannot": str(why)}
    except Exception as failure:  # an engine's own error is a result of the bench
        return row | {"failed": f"{type(failure).__name__}: {str(failure).strip().splitlines()[0] if str(failure).strip() else ''}"}
    kept = thinned(len(times) - 1)
    times, theta, theta_dot = times[::kept], theta[::kept], theta_dot[::kept]
    np.savetxt(path, np.column_stack([times, theta, theta_dot]), "%.17g", ",", header="t_s,theta_rad,theta_dot_rad_s", comments="")
    return row | {"file": path.name, "seconds": statistics.median(all_seconds), "rounds": len(all_seconds), "clock": "processor", "samples": len(times)}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("engine")
    parser.add_argument("out", type=Path)
    parser.add_argument("--scenes", nargs="*")
    parser.add_argument("--settings", nargs="*")
    parser.add_argument("--rounds", type=int, default=5)
    arguments = parser.parse_args()
    engine = importlib.import_module(f"engines.{arguments.engine}")
    wanted = [s for s in scenes() if not arguments.scenes or s.id in arguments.scenes]
    settings = [s for s in engine.SETTINGS if not arguments.settings or s.name in arguments.settings]
    arguments.out.mkdir(parents=True, exist_ok=True)
    file = arguments.out / f"{arguments.engine}.json"
    # What was run before and not now stays.
    names = {s.name for s in engine.SETTINGS}
    before = json.loads(file.read_text())["rows"] if file.exists() else []
    rows = {(row["setting"], row["scene"]): row for row in before if row["setting"] in names}
    told = {"engine": arguments.engine, "name": engine.NAME, "versions": engine.versions(),
            "settings": [{"name": s.name, "kind": s.kind, "about": s.about, "source": s.source} for s in engine.SETTINGS]}
    for setting in settings:
        for scene in wanted:
            if setting.kind == "more" and scene.duration_s > LONGEST_MORE_S:
                continue
            path = arguments.out / f"{arguments.engine}.{setting.name}.{scene.id}.csv"
            row = measured(engine, scene, setting, arguments.rounds, path)
            rows[setting.name, scene.id] = row
            print(f"{engine.NAME}, {setting.name}, {scene.id}: {row.get('seconds', row)}", file=sys.stderr, flush=True)
            file.write_text(json.dumps(told | {"rows": list(rows.values())}, indent=1))


if __name__ == "__main__":
    main()
