#!/usr/bin/env bash
# CasADi 3.8.2: an integrator whose DAE has an event and no `transition` sets the whole state to 0 at the event, and goes on.
#
# Library: casadi 3.8.2 (PyPI), `integrator` with the output "zero" of its DAE, plugins cvodes, idas, rk and collocation.
# Source: the documentation of `integrator` has "zero" as event indicators and "transition" as a function to be called at events, and does not
# say that one needs the other; what is missing there is taken as 0, as an input that is omitted. The one warning ("Event support is
# experimental") comes in any case.
# Seen: a ball that falls from 1 m with the floor as its event has height 0 *and speed 0* at the event, with the horizontal position and
# the clock that are further states, and falls on through the floor. With `transition` the states are as it says.
# Meaning for us: a state that jumps to 0 in a trajectory is a `reset`, not an event (docs/engines.md).
set -euo pipefail
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check casadi==3.8.2
"$work/venv/bin/python" - 2>/dev/null <<'PY'
import casadi as ca
import numpy as np

# Height, its speed, distance, its speed.
x, t, index = ca.SX.sym("x", 4), ca.SX.sym("t"), ca.SX.sym("index")
model = {"x": x, "t": t, "ode": ca.vertcat(x[1], -10, x[3], 0), "zero": x[0]}
hits_s = np.sqrt(0.2)
after_s = 0.5 - hits_s
bounce = ca.Function("bounce", {"index": index, "t": t, "x": x, "post_x": ca.vertcat(0, -x[1], x[2], x[3])}, ca.event_in(), ca.event_out())
grid = np.linspace(0.1, 0.5, 5)
for plugin in ("cvodes", "idas", "rk", "collocation"):
    def end(options):
        return np.array(ca.integrator("ball", plugin, model, 0, grid, options)(x0=[1, 0, 0, 3])["xf"])[:, -1]
    zeroed, bounced = end({}), end({"transition": bounce})
    print(f"{plugin}: at 0.5 s {zeroed.round(4)} without, {bounced.round(4)} with a transition")
    assert np.allclose(zeroed, [-5 * after_s**2, -10 * after_s, 0, 0], atol=1e-3)
    assert np.allclose(bounced, [10 * hits_s * after_s - 5 * after_s**2, 10 * hits_s - 10 * after_s, 1.5, 3], atol=1e-3)
PY
echo "as described"
