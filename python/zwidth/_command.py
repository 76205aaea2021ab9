"""The command that comes with the module."""

from __future__ import annotations

from zwidth._errors import ZwidthError

TYPE_CHECKING = False  # that of typing, whose import takes longer than ours
if TYPE_CHECKING:
    import os
    import pathlib
    import subprocess


def command(*arguments: str | os.PathLike[str]) -> pathlib.Path | subprocess.CompletedProcess[str]:
    """The command `zwidth`: its path, or with arguments what it says to them.

    `zwidth.command("--root", "data", "run", "my-study")` runs it and gives what it printed; an exit code other than 0 (done)
    and 3 (done but for something, which it says) raises `ZwidthError` with what it said. Commands that only it has, and all
    that write, are reached like this.
    """
    import subprocess  # here, because it takes longer to import than all else that the module needs

    program = _program()
    if not arguments:
        return program
    done = subprocess.run([program, *arguments], capture_output=True, text=True)
    if done.returncode not in (0, 3):
        raise ZwidthError((done.stderr or done.stdout).strip())
    return done


def _program() -> pathlib.Path:
    """Where the installer has put it: it is among the files of the package."""
    import importlib.metadata
    import pathlib

    for file in importlib.metadata.files("zwidth") or []:
        if file.stem == "zwidth" and file.suffix in ("", ".exe") and file.parent.name in ("bin", "Scripts", "scripts"):
            found = pathlib.Path(file.locate()).resolve()
            if found.is_file():
                return found
    raise ZwidthError("the command is not installed beside the module; install the wheel of zwidth", remedy="pip install zwidth")
