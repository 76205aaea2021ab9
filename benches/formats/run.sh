#!/bin/sh
# Files of laboratories of 100 MB, read by zwidth and by each format's own library; writes RESULTS.md.
#
#   benches/formats/run.sh             some minutes; needs 1 GB of disk for temporary files
#
# The Python environment is that of tests/interop, made once in VENV (default: the build folder).
set -eu
cd "$(dirname "$0")/../.."
target="${CARGO_TARGET_DIR:-target}"
venv="${VENV:-$target/venv-interop}"
cargo build --release --quiet --locked --package zwidth
cargo build --release --quiet --locked --package zwidth-import --features testing --example formats
[ -x "$venv/bin/python" ] || { python3 -m venv "$venv"; "$venv/bin/python" -m pip install --quiet --requirement tests/interop/requirements.txt; }

load() { cut -d ' ' -f 1-3 /proc/loadavg 2>/dev/null || uptime; }
before="$(load)"
"$venv/bin/python" benches/formats/formats.py --reader "$target/release/examples/formats" --zwidth "$target/release/zwidth" "$@" >"$target/formats.md"
{
    echo "<!-- Written by run.sh. -->"
    echo "# Files of laboratories, by zwidth and by each format's own library"
    echo
    echo "$(uname -m), $(nproc) cores, $(rustc --version); load average at the beginning $before, at the end $(load)."
    echo
    echo "A time and seven channels, whose sums agree. Seconds of the processor, medians of three turns: of our reader's whole process, and of"
    echo "each library from the opening of the file to arrays of doubles."
    echo "A whole import reads, converts, checks and writes a time and one channel; of LVM, which is text, it stands for the reading too."
    echo
    cat "$target/formats.md"
} >benches/formats/RESULTS.md
