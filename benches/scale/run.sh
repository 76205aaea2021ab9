#!/bin/sh
# The metrics of a large study by zwidth, by polars and by DuckDB, beside decoding its files alone; the size of its
# files beside pandas'. Writes RESULTS.md.
#
#   benches/scale/run.sh                        1,000 participants, 36 trials of 4 s each: an hour, 8 GB of disk
#   benches/scale/run.sh 100                    100 of them
#   benches/scale/run.sh 100 --rounds 5
#
# The Python environment is made once, in VENV (default: the build folder). The study is made once per size, below the
# build folder.
set -eu
cd "$(dirname "$0")/../.."
target="${CARGO_TARGET_DIR:-target}"
venv="${VENV:-$target/venv-scale}"
participants=1000
case "${1:-}" in [0-9]*) participants="$1"; shift ;; esac
cargo build --release --quiet --locked --package zwidth
cargo build --release --quiet --locked --package zwidth-benches --example decode --example compacted --example metrics
[ -x "$venv/bin/python" ] || python3 -m venv "$venv"
"$venv/bin/python" -m pip install --quiet --disable-pip-version-check --requirement benches/scale/requirements.txt

load() { cut -d ' ' -f 1-3 /proc/loadavg 2>/dev/null || uptime; }
before="$(load)"
mkdir -p "$target/scale-study"
"$venv/bin/python" benches/scale/bench.py "$target/release/zwidth" "$target/release/examples" \
    "$target/scale-study" --participants "$participants" "$@" >"$target/scale.md"
{
    echo "<!-- Written by run.sh. -->"
    echo "# A study of $participants participants, by zwidth, polars and DuckDB"
    echo
    echo "$(uname -m), $(nproc) cores, $(rustc --version); load average at the beginning $before, at the end $(load)."
    echo
    cat "$target/scale.md"
} >benches/scale/RESULTS.md
cat benches/scale/RESULTS.md
