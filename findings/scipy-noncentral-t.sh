#!/usr/bin/env bash
# SciPy 1.17.1's distribution function of the noncentral t is not a number for some noncentralities of the other sign than t,
# where its value is next to 0 or 1, so that a search for the interval of an effect size can fail.
#
# Library: scipy 1.17.1 (PyPI), `scipy.stats.nct.cdf`, with numpy 2.4.
# Seen: of 1,600 noncentralities from -40 to 40, t = -8.35 and t = 20, df = 1 to 11, 187 give nan, all of the other sign
# than t; `brentq` for the ends of an interval, from an interval that holds both ends, raises "The function value at x=... is NaN".
# The definition, the mean of Phi(t S - noncentrality) over S, is finite at all of them.
# Meaning for us: crates/stats/src/effect.rs sums over the definition, and tests/interop/stats/exact.py holds it against
# another quadrature of the same, not against nct.cdf.
set -euo pipefail
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check scipy==1.17.1
"$work/venv/bin/python" - <<'PY'
import numpy as np
from scipy import stats
from scipy.integrate import simpson
from scipy.special import ndtr


def by_definition(t, df, noncentrality):
    s = np.linspace(0, 1 + 9 / np.sqrt(df), 20001)
    density = stats.chi.pdf(s * np.sqrt(df), df) * np.sqrt(df)
    return simpson(ndtr(t * s - noncentrality) * density, x=s)


lost, same_sign = 0, 0
for df in (1, 2, 5, 11):
    for t in (-8.35, 20.0):
        for noncentrality in np.linspace(-40, 40, 200):
            with np.errstate(all="ignore"):
                value = stats.nct.cdf(t, df, noncentrality)
            if np.isnan(value):
                lost += 1
                same_sign += t * noncentrality > 0
                right = by_definition(t, df, noncentrality)
                assert np.isfinite(right) and min(right, 1 - right) < 1e-6, (t, df, noncentrality, right)
print(f"{lost} of 1600 are not a number, {same_sign} of these have the sign of t")
assert lost > 100 and same_sign == 0
PY
echo "as described"
