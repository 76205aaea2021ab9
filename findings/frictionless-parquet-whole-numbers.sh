#!/usr/bin/env bash
# frictionless 5.21.0: a whole number that may be missing, in a Parquet file, is not valid by its own type.
#
# Library: frictionless 5.21.0 with the plugin for Parquet (PyPI). Source: `frictionless/formats/parquet/parser.py`, which makes a pandas frame of
# the file; in such a frame a column of whole numbers with a gap holds numbers with decimals, and NaN for the gap.
# Seen: a table with the whole numbers 1, none, 3 is valid as CSV with the type "integer", and as Parquet it is not: the cell
# "nan" has another type than "integer". With the type "number" both are valid.
# Meaning for us: `zwidth export` declares columns of whole numbers that may be missing as "number" where the resource is a Parquet file
# (docs/export.md); `tests/interop/exports.py` has frictionless validate each export.
set -euo pipefail
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check "frictionless[parquet]==5.21.0" pandas==3.0.0 pyarrow==26.0.1
cat > "$work/probe.py" <<'PYTHON'
import os
import sys

import pyarrow as pa
import pyarrow.parquet as pq
from frictionless import Resource, Schema

os.chdir(sys.argv[1])
pq.write_table(pa.table({"who": ["a", "b", "c"], "n": pa.array([1, None, 3], pa.int64())}), "t.parquet")
with open("t.csv", "w", encoding="utf-8") as file:
    file.write("who,n\na,1\nb,\nc,3\n")
for kind in ("integer", "number"):
    for path in ("t.csv", "t.parquet"):
        schema = Schema.from_descriptor({"fields": [{"name": "who", "type": "string"}, {"name": "n", "type": kind}]})
        report = Resource(path=path, schema=schema).validate()
        errors = report.flatten(["type", "cell"])
        print(kind, path, "valid" if report.valid else sorted({tuple(map(str, error)) for error in errors}))
PYTHON
seen="$("$work/venv/bin/python" -W ignore "$work/probe.py" "$work")"
expected="integer t.csv valid
integer t.parquet [('type-error', 'nan')]
number t.csv valid
number t.parquet valid"
printf '%s\n' "$seen"
[ "$seen" = "$expected" ] || { echo "changed: expected '$expected'" >&2; exit 1; }
