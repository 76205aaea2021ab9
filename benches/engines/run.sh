#!/bin/sh
# Makes an environment for each group of engines that fit together, runs all engines on all scenes on one core, has
# their trajectories judged, and writes docs/engines.md with its figures.
#
#   benches/engines/run.sh                 about an hour; some 4 GB for the environments
#   benches/engines/run.sh --engines scipy mujoco     these alone; what was run before stays
#   benches/engines/run.sh --read          only verdicts and page, from what was run last
#
# The environments are made once, in VENVS, and results are in OUT (default: both in the build folder). Siconos is
# Debian's python3-siconos: without it that engine fails with a word, and can be left out by --engines.
set -eu
cd "$(dirname "$0")"
root="$(cd ../.. && pwd)"
target="${CARGO_TARGET_DIR:-$root/target}"
venvs="${VENVS:-$target/engines/venvs}"
out="${OUT:-$target/engines/out}"
zwidth="${ZWIDTH:-$target/release/zwidth}"

[ -n "${ZWIDTH:-}" ] || (cd "$root" && cargo build --release --quiet --locked -p zwidth)
for list in requirements.*.txt; do
    name="${list#requirements.}"
    venv="$venvs/${name%.txt}"
    [ -x "$venv/bin/python" ] || python3 -m venv "$venv"
    "$venv/bin/python" -m pip install --quiet --disable-pip-version-check --requirement "$list"
done
"$venvs/main/bin/python" bench.py --zwidth "$zwidth" --venvs "$venvs" --out "$out" --page "$root/docs/engines.md" "$@"
