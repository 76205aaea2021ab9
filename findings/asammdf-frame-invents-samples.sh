#!/usr/bin/env bash
# asammdf 8.8.28: a data frame of an MF4 file with channels of two rates has values of the slower one that nobody measured.
#
# Library: asammdf 8.8.28 (PyPI), `MDF.to_dataframe` with its default arguments. Source: the frame has the
# union of all times, and `MDF.configure` (asammdf/mdf.py) says that `float_interpolation` is 1 unless it is told otherwise: a straight line.
# Seen: an angle is measured at 10 Hz (0, 10, 0) and a force at 20 Hz. The frame has five rows, in which the angle is
# 0, 5, 10, 5, 0: two of them were never measured, and nothing tells them from the others.
# Meaning for us: the line that `zwidth import` prints for an MF4 file keeps each channel with times of its own (docs/import.md,
# "AcqKnowledge and MF4"); `tests/interop/laboratory.py` tries it.
set -euo pipefail
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check asammdf==8.8.28 numpy==2.3.5 pandas==3.0.0
cat > "$work/probe.py" <<'PYTHON'
import asammdf
import numpy as np

measured = asammdf.MDF()
measured.append([asammdf.Signal(np.array([0.0, 10.0, 0.0]), np.array([0.0, 0.1, 0.2]), name="angle")])
measured.append([asammdf.Signal(np.arange(5.0), 0.05 * np.arange(5), name="F")])
frame = measured.to_dataframe()
print("angle in the frame:", frame["angle"].round(9).tolist(), "measured:", measured.get("angle").samples.tolist())
PYTHON
seen="$("$work/venv/bin/python" -W ignore "$work/probe.py")"
expected="angle in the frame: [0.0, 5.0, 10.0, 5.0, 0.0] measured: [0.0, 10.0, 0.0]"
printf '%s\n' "$seen"
[ "$seen" = "$expected" ] || { echo "changed: expected '$expected'" >&2; exit 1; }
