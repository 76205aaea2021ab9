#!/bin/sh
# A study of a thousand simulated participants, from the device to the page, and its time and memory. Writes
# whole/RESULTS.md.
#
#   benches/scale/whole.sh                      1,000 participants, 36 trials of 4 s each: 13 min, 8 GB of disk
#   benches/scale/whole.sh 100                  100 of them
#   benches/scale/whole.sh 1000 --rounds 5
#
# The study lies below the build folder, in whole-study: its page is whole-study/reports/big/index.html.
set -eu
cd "$(dirname "$0")/../.."
target="${CARGO_TARGET_DIR:-target}"
participants=1000
case "${1:-}" in [0-9]*) participants="$1"; shift ;; esac
cargo build --release --quiet --locked --package zwidth

load() { cut -d ' ' -f 1-3 /proc/loadavg 2>/dev/null || uptime; }
before="$(load)"
python3 benches/scale/whole.py "$target/release/zwidth" "$target/whole-study" --participants "$participants" "$@" \
    >"$target/whole.md"
mkdir -p benches/scale/whole
{
    echo "<!-- Written by whole.sh. -->"
    echo "# A whole study of $participants participants"
    echo
    echo "$(uname -m), $(nproc) cores, $(rustc --version); load average at the beginning $before, at the end $(load)."
    echo
    cat "$target/whole.md"
} >benches/scale/whole/RESULTS.md
cat benches/scale/whole/RESULTS.md
echo "The page: $target/whole-study/reports/big/index.html"
