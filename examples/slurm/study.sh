#!/bin/sh
# A whole study by SLURM: shards, merged, in two rounds, then tables, figures and page; docs/scale.md.
#
#   study.sh STUDY SHARDS
set -eu
study="$1" shards="$2"
task="$(dirname "$0")/shard.sbatch"

# zwidth ends with 3 where something of the study was left out, or of a round is missing, and lists it.
listed() { "$@" || [ $? = 3 ]; }

# Submits these tasks and waits for their end; what failed shows in what is missing.
submit() { sbatch --wait --array="$1" "$task" "$study" "$shards" || true; }

missing() { zwidth --quiet shards "$study" --missing --of "$shards" | cut -d/ -f1 | paste -sd, -; }

round() {
    submit "$1"
    left="$(missing)"
    [ -z "$left" ] || submit "$left"
    listed zwidth merge "$study"
}

round "1-$shards"
# The plant that all trials give. Then the shards again: what rests on it.
listed zwidth run "$study" --only identify
left="$(missing)"
[ -z "$left" ] || round "$left"
listed zwidth run "$study"
