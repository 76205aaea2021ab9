#!/bin/sh
# The processor time of a trial at the beginning and at the end of a session of 2,019 trials; writes RESULTS.md.
#
#   benches/session/run.sh          a minute; Linux only
set -eu
cd "$(dirname "$0")/../.."
target="${CARGO_TARGET_DIR:-target}"
cargo build --release --quiet --locked --workspace --bin zwidth
python3 benches/session/session.py --zwidth "$target/release/zwidth" "$@" >"$target/session.md"
{
    echo "<!-- Written by run.sh. -->"
    echo "# A session of two thousand trials"
    echo
    echo "$(uname -m), $(nproc) cores, $(rustc --version)."
    echo
    echo "Processor time of a trial of 4 s at 1 kHz on the simulated device, with all that is stored of it."
    echo
    cat "$target/session.md"
} >benches/session/RESULTS.md
