#!/bin/sh
# The statistics beside R's (one core), then a study of a thousand people (two cores); writes RESULTS.md.
#
#   benches/statistics/run.sh            some minutes
#
# R needs lme4, pbkrtest and ordinal. Nothing is timed before both sides have found the same.
set -eu
cd "$(dirname "$0")/../.."
target="${CARGO_TARGET_DIR:-target}"
data="$(mktemp -d)"
trap 'rm -rf "$data"' EXIT
cargo build --release --quiet --locked --workspace --bin statistics
statistics="$target/release/statistics"

# One core: the last, which other work uses least.
if command -v taskset >/dev/null; then one="taskset -c $(($(nproc) - 1))"; else one=""; fi
load() { cut -d ' ' -f 1-3 /proc/loadavg 2>/dev/null || uptime; }
{
    echo "<!-- Written by run.sh. -->"
    echo "# The statistics, by zwidth and by R"
    echo
    echo "$(uname -m), $(nproc) cores, $(rustc --version); load average at the beginning $(load)."
    echo
    echo "## The same fits, one core"
    echo
    echo "Both fit the same simulated trials in turns; a time is the median of a round's fits, then of the rounds, and the ratio"
    echo "is that of one round, both a moment apart. From the columns of the data to estimates, standard errors and degrees of"
    echo "freedom; loading packages and reading files is not on the clock. R's packages have the settings they come with."
    echo "Before anything is timed the criterion, estimates, standard errors and degrees of freedom must agree."
    echo
    RAYON_NUM_THREADS=1 OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $one "$statistics" peers benches/statistics/peer.R "$data"
    echo
    echo "## A thousand people, two cores"
    echo
    echo "The stage's own code on a simulated table of metrics: every metric that a study compares by default (ten tables each,"
    echo "mixed models and 9,999 orders redrawn among them), then the answers. 1 % of the values are missing."
    echo
    RAYON_NUM_THREADS=2 "$statistics" thousand "$data"
    echo
    echo "Load average at the end $(load)."
} >"$data/results.md"
cp "$data/results.md" benches/statistics/RESULTS.md
cat benches/statistics/RESULTS.md
