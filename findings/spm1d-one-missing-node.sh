#!/usr/bin/env bash
# One missing value in one curve makes spm1d 0.4.55's permutation test find nothing, without a word; its test by random field
# theory drops the node from its clusters.
#
# Library: spm1d 0.4.55 (PyPI), `spm1d.stats.nonparam.ttest` and `spm1d.stats.ttest`, with numpy 2.4.
# Source: t is not a number at that node, so the largest |t| of a flip is none either, and nothing exceeds a threshold that is no number.
# Seen: of the differences in its own example PlantarArchAngle p is 0.0020 with 1,024 flips; with one person's value missing at one of 101
# nodes (as where a recording is shorter) zstar is nan, there is no cluster and no p, and nothing is raised.
# Meaning for us: curves are compared at the angles that everybody reaches in every mode, people who lack a mode are named, and a way back
# that somebody lacks is left out with a remark (pipelines/compare/src/curves.rs); a value that is not finite is refused
# (crates/stats/src/curve.rs).
set -euo pipefail
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check spm1d==0.4.55 numpy==2.4.6
"$work/venv/bin/python" - <<'PY'
import warnings

import numpy as np
import spm1d

first, second = spm1d.data.uv1d.tpaired.PlantarArchAngle().get_data()
whole = np.asarray(first) - np.asarray(second)


def flipped(differences):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        test = spm1d.stats.nonparam.ttest(differences, 0)
        return test.inference(0.05, two_tailed=True, iterations=-1)


found = flipped(whole)
lacking = whole.copy()
lacking[3, 50] = np.nan
lost = flipped(lacking)
print(f"whole: zstar {found.zstar:.3f}, p {found.p}; one value missing: zstar {lost.zstar}, p {lost.p}")
assert len(found.clusters) == 1 and abs(found.p[0] - 2 / 1024) < 1e-9
assert np.isnan(lost.zstar) and len(lost.clusters) == 0 and len(lost.p) == 0
PY
echo "as described"
