"""Runs every engine on every scene, has the trajectories judged, and writes the page docs/engines.md.

    python bench.py --zwidth PATH --venvs DIR --out DIR [--engines NAME…] [--rounds N] [--page FILE] [--read]

OUT gets the trajectories (ENGINE.SETTING.SCENE.csv), ENGINE.json for each engine, and results.csv. With --read nothing
is run: verdicts, page and figure are made again from OUT. An engine that was not run now, and is in OUT, stays as it is.
"""

import argparse
import csv
import json
import os
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from judged import judged
from scene import scenes

HERE = Path(__file__).parent
# Each engine, and the Python that has it: a folder of VENVS, or the system's for what Debian packages.
ENGINES = {
    "mujoco": "main", "mjx": "jax", "mujoco_warp": "warp", "newton": "newton", "drake": "drake", "pybullet": "main", "dart": "main",
    "siconos": None, "diffrax": "jax", "casadi": "main", "diffsol": "main", "scipy": "main", "loop": "main",
}


def command(name, arguments):
    """A worker on one core: the last, which other work uses least."""
    venv = ENGINES[name]
    python = "/usr/bin/python3" if venv is None else str(arguments.venvs / venv / "bin/python")
    one = ["taskset", "-c", str(os.cpu_count() - 1)] if shutil.which("taskset") else []
    return [*one, python, str(HERE / "worker.py"), name, str(arguments.out), "--rounds", str(arguments.rounds)]


def judge_all(told, zwidth, known, out):
    """Rows of results.csv. Verdicts are kept beside the trajectories, and given anew where a trajectory or the program is newer."""
    kept_at = out / "verdicts.json"
    kept = json.loads(kept_at.read_text()) if kept_at.exists() else {}

    def verdict(row):
        path = out / row["file"]
        key = [Path(zwidth).stat().st_mtime_ns, path.stat().st_mtime_ns]
        if kept.get(row["file"], [None])[0] != key:
            kept[row["file"]] = [key, *judged(zwidth, known[row["scene"]], path)]
        words, error_rad, is_felt = kept[row["file"]][1:]
        return {"verdict": words, "error_rad": error_rad, "is_felt": is_felt}

    rows = [{"engine": engine["engine"], **row} for engine in told for row in engine["rows"]]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        verdicts = list(pool.map(lambda row: verdict(row) if "file" in row else {"verdict": row.get("cannot") or "failed: " + row["failed"], "error_rad": "", "is_felt": None}, rows))
    kept_at.write_text(json.dumps(kept))
    return [row | verdict for row, verdict in zip(rows, verdicts)]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--zwidth", required=True)
    parser.add_argument("--venvs", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--engines", nargs="*", default=list(ENGINES))
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--page", type=Path)
    parser.add_argument("--read", action="store_true")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    if not arguments.read:
        quiet = dict(os.environ, OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1", XLA_FLAGS="--xla_cpu_multi_thread_eigen=false")
        for name in arguments.engines:
            if subprocess.run(command(name, arguments), cwd=HERE, env=quiet).returncode != 0:
                sys.exit(f"{name}: the worker failed; see above")
    told = [json.loads(path.read_text()) for name in ENGINES if (path := arguments.out / f"{name}.json").exists()]
    rows = judge_all(told, arguments.zwidth, {s.id: s for s in scenes()}, arguments.out)
    columns = ["engine", "setting", "scene", "samples", "rounds", "seconds", "error_rad", "verdict", "is_felt", "file"]
    with open(arguments.out / "results.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, columns, extrasaction="ignore")
        writer.writeheader()
        writer.writerows(rows)
    (arguments.out / "results.json").write_text(json.dumps({"engines": [{k: v for k, v in t.items() if k != "rows"} for t in told], "rows": rows}, indent=1))
    if arguments.page:
        venv = arguments.venvs / "main/bin/python"
        subprocess.run([venv, HERE / "page.py", arguments.out / "results.json", arguments.page], cwd=HERE, check=True)


if __name__ == "__main__":
    main()
