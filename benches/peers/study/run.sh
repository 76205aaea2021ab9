#!/bin/sh
# Builds zwidth, makes a Python environment, times `zwidth run` beside the script on the default study, and writes the
# second section of RESULTS.md.
#
# The Python environment is made once, in VENV (default: the build folder).
set -eu
cd "$(dirname "$0")"
target="${CARGO_TARGET_DIR:-../../../target}"
venv="${VENV:-$target/venv-study}"
results=../RESULTS.md

cargo build --release --quiet --locked --manifest-path ../../../Cargo.toml --package zwidth
[ -x "$venv/bin/python" ] || python3 -m venv "$venv"
"$venv/bin/python" -m pip install --quiet --requirement requirements.txt

section="$target/study.md"
"$venv/bin/python" bench.py "$target/release/zwidth" ../../.. "$target/study-roots" "$@" | tee "$section"
first="$(sed '/<!-- Written by study\/run.sh. -->/,$d' "$results")"
{ printf '%s\n' "$first"; echo; cat "$section"; } >"$results"
