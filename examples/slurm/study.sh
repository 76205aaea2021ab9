#!/bin/sh
# A whole study by SLURM: shards, merged, in two rounds, then tables, figures and page; docs/scale.md.
#
#   study.sh STUDY SHARDS
set -eu
study="$1" shards="$2"
task="$(dirname "$0")/shard.sbatch"

# zwidth ends with 3 where something of the study was left out, or of a round is missing, and lists it.
listed() { "$@" || [ $? = 3 ]; }

# Submits these tasks and waits for their end; what failed shows in what is missing. What SLURM does not take at all
# ends everything: else the run at the end would make the whole study on this machine.
submit() {
    job="$(sbatch --parsable --wait --array="$1" "$task" "$study" "$shards")" || true
    [ -n "$job" ] || { echo "study.sh: sbatch took no job for the shards $1 of $study" >&2; exit 1; }
}

missing() {
    lines="$(listed zwidth --quiet shards "$study" --missing --of "$shards")"
    printf '%s' "$lines" | cut -d/ -f1 | paste -sd, -
}

round() {
    submit "$1"
    left="$(missing)"
    [ -z "$left" ] || submit "$left"
    left="$(missing)"
    [ -z "$left" ] || echo "study.sh: still missing is something of the shards $left; it is made on this machine" >&2
    listed zwidth merge "$study"
}

round "1-$shards"
# The plant that all trials give. Then the shards again: what rests on it.
listed zwidth run "$study" --only identify
left="$(missing)"
[ -z "$left" ] || round "$left"
listed zwidth run "$study"
