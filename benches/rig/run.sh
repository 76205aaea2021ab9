#!/bin/sh
# A loop at 1 kHz over the framed link, by zwidth and plainly by pySerial, and by zwidth with a program as its device, at one board in software on one pseudo-terminal; idle, then
# with all cores busy. Writes RESULTS.md.
#
#   benches/rig/run.sh [ROUNDS [SECONDS]]     5 rounds of 10 s: six minutes
set -eu
cd "$(dirname "$0")/../.."
target="${CARGO_TARGET_DIR:-target}"
venv="${VENV:-$target/venv-rig}"
cargo build --release --quiet --locked --package zwidth-link --example rig-bench
[ -x "$venv/bin/python" ] || python3 -m venv "$venv"
"$venv/bin/python" -m pip install --quiet --disable-pip-version-check --requirement benches/rig/requirements.txt

load() { cut -d ' ' -f 1-3 /proc/loadavg 2>/dev/null || uptime; }
before="$(load)"
"$venv/bin/python" benches/rig/bench.py "$target/release/examples/rig-bench" "$@" >"$target/rig.md"
{
    echo "<!-- Written by run.sh. -->"
    echo "# A loop over a serial line, by zwidth and by pySerial"
    echo
    echo "$(uname -m), $(nproc) cores, $(rustc --version), $("$venv/bin/python" --version), pySerial $("$venv/bin/python" -c 'import serial; print(serial.__version__)'); load average at the beginning $before, at the end $(load)."
    echo
    echo "Both ask the same board in software, at the same pseudo-terminal, once a tick, and command 0 V. Late: from a tick's deadline to"
    echo "when the loop is there. Answered: from then until the answer is decoded and the command given to the system. The"
    echo "plain loop sleeps until its deadline; ours sleeps to 0.2 ms before it, looks at the clock from there on, and asks the system for"
    echo "a higher priority. The board has one, too: what runs at a host does not slow a board. The clock alone: a loop without a line,"
    echo "which looks at the clock and never sleeps; no program on this machine is less late than that. A program in Python: our loop, with"
    echo "examples/device/lever.py as its device over pipes, which simulates its lever meanwhile. Taken by others: the share of"
    echo "the time that a virtual machine's host gave to others while this one wanted to run (steal)."
    echo
    cat "$target/rig.md"
} >benches/rig/RESULTS.md
cat benches/rig/RESULTS.md
