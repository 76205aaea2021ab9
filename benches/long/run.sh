#!/bin/sh
# One recording of 10⁴ to 2·10⁷ rows, imported, verified and run, beside the same job in pandas; writes RESULTS.md.
#
#   benches/long/run.sh             some minutes; needs 4 GB of disk for temporary files
#
# The Python environment is that of tests/interop, made once in VENV (default: the build folder).
set -eu
cd "$(dirname "$0")/../.."
target="${CARGO_TARGET_DIR:-target}"
venv="${VENV:-$target/venv-interop}"
cargo build --release --quiet --locked --workspace --bin zwidth
[ -x "$venv/bin/python" ] || { python3 -m venv "$venv"; "$venv/bin/python" -m pip install --quiet --requirement tests/interop/requirements.txt; }

load() { cut -d ' ' -f 1-3 /proc/loadavg 2>/dev/null || uptime; }
before="$(load)"
"$venv/bin/python" benches/long/long.py --zwidth "$target/release/zwidth" "$@" >"$target/long.md"
{
    echo "<!-- Written by run.sh. -->"
    echo "# A long recording, by zwidth and by pandas"
    echo
    echo "$(uname -m), $(nproc) cores, $(rustc --version); load average at the beginning $before, at the end $(load)."
    echo
    echo "Time, angle, velocity and force of a lever pressed into a spring at 1 kHz, as CSV. \`run\` makes every metric with its"
    echo "interval, means, replays, the identified plant, figures as SVG, PDF and PNG, tables and the page; the script in pandas"
    echo "reads the CSV, finds onset and reversal, peaks, the loop's area and the slope of the spring, and writes Parquet."
    echo "Beside the import stands what \`read_csv\` of pandas and of polars alone take for the same file. Seconds of a clock,"
    echo "from a process' start to its end, medians of three turns; MB: its largest resident set."
    echo
    cat "$target/long.md"
} >benches/long/RESULTS.md
