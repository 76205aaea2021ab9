#!/bin/sh
# Builds all peers, tunes them, times them on one core, and writes one table to stdout and to RESULTS.md, whose second
# section (study/run.sh) stays as it is.
#
#   benches/peers/run.sh            some minutes
#   benches/peers/run.sh --plain    also SciPy's RK45 on the plain, chattering right-hand side: minutes more
#
# The Python environment is made once, in VENV (default: the build folder).
set -eu
cd "$(dirname "$0")"
target="${CARGO_TARGET_DIR:-target}"
venv="${VENV:-$target/venv}"
rows="$target/rows.tsv"

cargo build --release --quiet
[ -x "$venv/bin/python" ] || python3 -m venv "$venv"
"$venv/bin/python" -m pip install --quiet --requirement requirements.txt

# One core: the last, which other work uses least.
if command -v taskset >/dev/null; then one="taskset -c $(($(nproc) - 1))"; else one=""; fi
$one "$target/release/zwidth-peers" reference >"$target/reference.txt"
$one "$target/release/zwidth-peers" measure >"$rows"
OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $one "$venv/bin/python" peers.py "$target/reference.txt" "$@" >>"$rows"
"$venv/bin/python" table.py "$rows" | tee "$target/solvers.md"
study="$(sed -n '/<!-- Written by study\/run.sh. -->/,$p' RESULTS.md)"
{ cat "$target/solvers.md"; echo; printf '%s\n' "$study"; } >RESULTS.md
