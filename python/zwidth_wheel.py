"""The backend of PEP 517: builds the command, lays it where maturin packs it as a script, and leaves the rest to maturin.

A command behind an entry point of Python would start in 46 ms instead of 6, and Ctrl-C would do nothing while it computes.
There is no source distribution: the clone is the source.
"""

import json
import pathlib
import shutil
import subprocess

import maturin
from maturin import get_requires_for_build_editable, get_requires_for_build_wheel  # noqa: F401

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCRIPTS = ROOT / "python" / "zwidth.data" / "scripts"


def lay_command():
    """Builds the command as `Cargo.lock` says, and lays it where maturin looks for it."""
    cargo = ["cargo", "build", "--release", "--locked", "--package", "zwidth", "--message-format=json-render-diagnostics"]
    told = subprocess.run(cargo, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout
    built = [line["executable"] for line in map(json.loads, told.splitlines()) if line.get("executable")]
    SCRIPTS.mkdir(parents=True, exist_ok=True)
    for executable in built:
        shutil.copy2(executable, SCRIPTS)


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    lay_command()  # maturin wants the folder to be there
    return maturin.prepare_metadata_for_build_wheel(metadata_directory, config_settings)


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    lay_command()
    return maturin.build_wheel(wheel_directory, config_settings, metadata_directory)


def prepare_metadata_for_build_editable(metadata_directory, config_settings=None):
    lay_command()
    return maturin.prepare_metadata_for_build_editable(metadata_directory, config_settings)


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    lay_command()
    return maturin.build_editable(wheel_directory, config_settings, metadata_directory)
