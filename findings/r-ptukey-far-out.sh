#!/usr/bin/env bash
# R 4.2.2: the tail of the studentised range is up to 10 % too small where few people took part.
#
# Library: R 4.2.2 (Debian 12, r-base-core 4.2.2.20221110-2), function `ptukey` of package stats; source: src/nmath/ptukey.c.
# Of two means the studentised range is Student's t: its tail at q is the two-sided tail of t at q / sqrt(2), which R has, too.
# Seen: at 3 degrees of freedom and q = 30 a tail of 2.055e-4, where that of t is 2.292e-4; at 5 and q = 20 one of 3.195e-5 for 3.182e-5.
# Meaning for us: `emmeans` adjusts after Tukey by it, so that `zwidth compare --peers`, whose p is right, may differ from what emmeans prints where
# p is below 1e-3 (docs/analysis.md, "What other programs print").
set -euo pipefail
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
(cd "$work" && apt-get download -qq "r-base-core=4.2.2.20221110-2")
dpkg -x "$work"/r-base-core_*.deb "$work"
export R_HOME="$work/usr/lib/R" LD_LIBRARY_PATH="$work/usr/lib/R/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"
"$R_HOME/bin/exec/R" --vanilla --no-echo -e '
cat(R.version.string, "\n")
for (case in list(c(3, 30), c(5, 20), c(8, 8))) {
    df <- case[1]; q <- case[2]
    range <- ptukey(q, 2, df, lower.tail = FALSE)
    t <- 2 * pt(q / sqrt(2), df, lower.tail = FALSE)
    cat(sprintf("df %d q %d: %.3e for %.3e, %+.1f %%\n", df, q, range, t, 100 * (range / t - 1)))
}' | tee "$work/seen"
grep -q '^R version 4.2.2 ' "$work/seen"
grep -q '^df 3 q 30: 2.055e-04 for 2.292e-04, -10.3 %$' "$work/seen"
grep -q '^df 5 q 20: 3.195e-05 for 3.182e-05, +0.4 %$' "$work/seen"
grep -q '^df 8 q 8: 4.776e-04 for 4.776e-04, +0.0 %$' "$work/seen"
echo "as described"
