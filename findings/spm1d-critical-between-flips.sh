#!/usr/bin/env bash
# spm1d 0.4.55's permutation test of whole curves puts its critical value between two flips of signs, where no flip is: above
# it lies a larger share of flips than alpha.
#
# Library: spm1d 0.4.55 (PyPI), `spm1d.stats.nonparam.ttest_paired(...).inference(0.05, two_tailed=True)`, with numpy 2.4.
# Source: the critical value is a percentile of the largest |t| of all flips, which NumPy interpolates.
# Seen: of its own example PlantarArchAngle (10 people, 1,024 flips) zstar is 3.5969 and 52 flips lie above it, 5.08 %; the value that
# 5 % of flips exceed at most is the 52nd largest, 3.6083, with 50 above it. Its clusters begin at zstar, ours at the pointwise t.
# Meaning for us: crates/stats/src/curve.rs takes the order statistic; tests/interop/stats/exact.py holds our t and p against
# spm1d, and critical values against the order statistic of its flips. docs/analysis.md, "Whole curves", says so.
set -euo pipefail
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check spm1d==0.4.55 numpy==2.4.6
"$work/venv/bin/python" - <<'PY'
import numpy as np
import spm1d

first, second = spm1d.data.uv1d.tpaired.PlantarArchAngle().get_data()
found = spm1d.stats.nonparam.ttest_paired(first, second).inference(0.05, two_tailed=True, iterations=-1)
largest = np.repeat(np.abs(np.ravel(found.PDF0)), 2)  # of each flip and its mirror
order = np.sort(largest)[::-1][int(0.05 * largest.size)]
above, beyond = (largest > found.zstar).sum(), (largest > order).sum()
print(f"{largest.size} flips; zstar {found.zstar:.4f}, {above} above it; order statistic {order:.4f}, {beyond} above it")
assert largest.size == 1024 and found.zstar not in largest
assert above > 0.05 * largest.size > beyond
assert abs(found.zstar - 3.5969375) < 1e-6 and abs(order - 3.6083434) < 1e-6
PY
echo "as described"
