#!/usr/bin/env bash
# pingouin 0.7.0 drops people who lack an answer from Cronbach's alpha, and still counts them in its interval.
#
# Library: pingouin 0.7.0 (PyPI), `pingouin.cronbach_alpha(data, nan_policy="listwise")`.
# Source: the number of people is taken from the table before its incomplete rows are dropped, and gives the degrees of freedom of Feldt's
# interval; under the default, "pairwise", it is that of all rows, too.
# Seen: 9 of the 12 rows of its own example cronbach_wide_missing are complete. Alpha of these is 0.8017 either way; its interval is 0.533 to 0.947
# if they are given alone, and 0.581 to 0.933 if pingouin drops the others itself.
# Meaning for us: `reliability` counts those who answered every question, and its interval rests on them (crates/stats/src/reliability.rs).
set -euo pipefail
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check pingouin==0.7.0
"$work/venv/bin/python" - <<'PY'
import pingouin as pg

data = pg.read_dataset("cronbach_wide_missing")
whole = data.dropna()
dropped, [low, high] = pg.cronbach_alpha(data, nan_policy="listwise")
alone, [alone_low, alone_high] = pg.cronbach_alpha(whole)
print(f"{len(data)} rows, {len(whole)} of them complete")
print(f"dropped by pingouin: alpha {dropped:.6f}, interval {low} to {high}")
print(f"complete rows alone: alpha {alone:.6f}, interval {alone_low} to {alone_high}")
assert abs(dropped - alone) < 1e-12
assert len(whole) < len(data) and alone_low < low and high < alone_high
PY
echo "as described"
