"""A caller as mypy --strict sees it: what the stubs promise. Not run."""

import array
import pathlib
import subprocess

import zwidth

study: zwidth.Study = zwidth.read_study(pathlib.Path("data"), "thesis-twin")
table: zwidth.Table = study.metrics()
column: zwidth.Column = table["onset_s"]
units: dict[str, str] = table.units
numbers = array.array("d", [0.0, 1.0])
smooth: float | None = zwidth.smoothness(numbers, numbers)
begins, ends = zwidth.onset(numbers, numbers)
first: float | None = begins
runs: zwidth.Runs = zwidth.simulate("scene.toml", plant__mass_kg=numbers, samples=True)
verdict: str = zwidth.judge({"name": "a scene"}, numbers, numbers).verdict
interval: tuple[float | None, float | None] = zwidth.fit_psychometric(numbers, numbers, numbers).jnd_interval
command: pathlib.Path | subprocess.CompletedProcess[str] = zwidth.command("--version")
try:
    study.trial("P01", "S01", 1)
except zwidth.ZwidthError as error:
    place: tuple[str | None, str | None, int | None] = (error.file, error.column, error.row)
