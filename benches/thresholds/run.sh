#!/bin/sh
# Thresholds by zwidth, by PsychoPy's handlers and by psignifit on the same simulated people, one core; writes RESULTS.md.
#
#   benches/thresholds/run.sh            some minutes
#
# Python's packages are installed beside the build; PsychoPy without its windows and sounds.
set -eu
cd "$(dirname "$0")/../.."
target="${CARGO_TARGET_DIR:-target}"
venv="$target/venv-thresholds"
data="$(mktemp -d)"
trap 'rm -rf "$data"' EXIT
[ -x "$venv/bin/python" ] || python3 -m venv "$venv"
"$venv/bin/pip" install --quiet --disable-pip-version-check --no-deps psychopy==2026.1.3
grep -v '^psychopy\|^#' benches/thresholds/requirements.txt >"$data/requirements.txt"
"$venv/bin/pip" install --quiet --disable-pip-version-check -r "$data/requirements.txt"
cargo build --release --quiet --locked --workspace --bin thresholds
thresholds="$target/release/thresholds"

# One core: the last, which other work uses least.
if command -v taskset >/dev/null; then one="taskset -c $(($(nproc) - 1))"; else one=""; fi
load() { cut -d ' ' -f 1-3 /proc/loadavg 2>/dev/null || uptime; }
export RAYON_NUM_THREADS=1 OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
{
    echo "<!-- Written by run.sh. -->"
    echo "# Thresholds, by zwidth and by others"
    echo
    echo "$(uname -m), $(getconf _NPROCESSORS_ONLN) cores, $(rustc --version); psychopy 2026.1.3, psignifit 4.3; load average at the beginning $(load)."
    echo
    echo "## Trials to a threshold within 10 %"
    echo
    echo "Sixty simulated people tell in which of two intervals there was something: Weibull's curve with β = 2, 2 % lapses, thresholds"
    echo "from 0.054 to 0.119 N. Both sides see the same people and the same chances. Each procedure estimates the level of its own share"
    echo "of right answers, and is compared with that; the difference threshold in steps above a standard is such a level. Staircases of"
    echo "PsychoPy have the equal steps they come with, and the target that is written of equal steps (70.7 and 79.4 % right). QuestHandler"
    echo "is told β and λ, which are those of these people; both QUEST+ have to find β. A median over sixty people is uncertain by one or two"
    echo "of the percents that stand here, so that the trials differ by some tens from one set of people to another."
    echo
    $one "$thresholds" trials "$venv/bin/python" benches/thresholds/peer.py
    echo
    echo "## The same fits"
    echo
    echo "A thousand simulated people in four conditions, seven levels, 20 trials each: which of two was more."
    echo
    $one "$thresholds" fits "$venv/bin/python" benches/thresholds/peer.py "$data"
    echo
    echo "Load average at the end $(load)."
} >"$data/results.md"
cp "$data/results.md" benches/thresholds/RESULTS.md
cat benches/thresholds/RESULTS.md
