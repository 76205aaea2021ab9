#!/usr/bin/env bash
# SciPy 1.17.1: an event that stays at 0 counts as a crossing, with a direction too: max(0, x - wall), as a script writes a contact, ends
# a run at its first step, with the wall out of reach.
#
# Library: scipy 1.17.1 (PyPI), `scipy.integrate.solve_ivp(events=…)` with `terminal = True` and `direction = 1`.
# Source: the documentation says "direction of a zero crossing. If direction is positive, event will only trigger when going from
# negative to positive". The function of the example is never negative, and does not go up; the test is g <= 0 before and g >= 0 after.
# Seen: x' = 0.1 from 0 with a wall at 0.5 (right: never within 1 s): status 1, "A termination event occurred", at t = 0, x = 0. With
# x - wall in place of max(0, x - wall): no event within 1 s, and the event at 5 s within 10.
# Meaning for us: the engines' bench writes guards as differences (benches/engines/machine.py); docs/engines.md tells of it.
set -euo pipefail
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check scipy==1.17.1 numpy==2.4.6
"$work/venv/bin/python" - <<'PY'
from scipy.integrate import solve_ivp

WALL = 0.5


def ended(contact, until):
    contact.terminal, contact.direction = True, 1
    solution = solve_ivp(lambda t, y: [0.1], (0, until), [0.0], events=contact)
    return solution.status, solution.t_events[0].tolist()


clipped, plain = ended(lambda t, y: max(0.0, y[0] - WALL), 1), ended(lambda t, y: y[0] - WALL, 1)
late = ended(lambda t, y: y[0] - WALL, 10)
print(f"max(0, x - wall): {clipped}; x - wall: {plain}, and within 10 s {late}")
assert clipped == (1, [0.0]) and plain == (0, [])
assert late[0] == 1 and abs(late[1][0] - 5) < 1e-9
PY
echo "as described"
