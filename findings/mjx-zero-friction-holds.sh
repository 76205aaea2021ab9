#!/usr/bin/env bash
# MuJoCo MJX 3.17.0: a joint's frictionloss that is set to 0 in a model that was built with one holds the joint without limit, instead of letting it
# go; 1e-9 lets it go.
#
# Library: mujoco-mjx 3.17.0 with mujoco 3.17.0 and jax 0.10.2 (PyPI), `model.replace(dof_frictionloss=…)`, as one varies friction over worlds.
# Source: the documentation of MJX has models changed by `replace`, for instance to draw parameters anew for each world. The row of the friction stays in
# the constraints, and with the bound 0 it counts as one that has none: its force is what the reference acceleration needs.
# Seen: a hinge of 5e-3 kg m2, built with frictionloss 0.5 N m, 2.15 N m, 5 steps of 2 ms from rest. Frictionloss changed to 1e-9: 4.300 rad/s. To 0:
# 0.295 rad/s, and the constraint gives -2.06 N m. MuJoCo, with 0 set in the same way: 4.300 rad/s.
# Meaning for us: benches/engines gives MJX 1e-9 N where a friction's level is 0 (docs/engines.md).
set -euo pipefail
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check mujoco-mjx==3.17.0 mujoco==3.17.0 jax==0.10.2
cd "$work"
JAX_PLATFORMS=cpu "$work/venv/bin/python" - <<'PY'
import jax
import jax.numpy as jnp
import mujoco
from mujoco import mjx

MODEL = """<mujoco><option timestep="0.002" gravity="0 0 0"/><worldbody><body>
  <inertial pos="1 0 0" mass="0.005" diaginertia="1e-9 1e-9 1e-9"/><joint type="hinge" axis="0 0 1" frictionloss="0.5"/>
</body></worldbody></mujoco>"""
built = mujoco.MjModel.from_xml_string(MODEL)
start = mjx.make_data(built).replace(qfrc_applied=jnp.array([2.15]))
step = jax.jit(mjx.step)
speeds = {}
for friction in (0.0, 1e-9):
    model = mjx.put_model(built).replace(dof_frictionloss=jnp.array([friction]))
    state = start
    for _ in range(5):
        state = step(model, state)
    plain = mujoco.MjModel.from_xml_string(MODEL)
    plain.dof_frictionloss[0] = friction
    data = mujoco.MjData(plain)
    data.qfrc_applied[0] = 2.15
    for _ in range(5):
        mujoco.mj_step(plain, data)
    speeds[friction] = float(state.qvel[0]), data.qvel[0]
    print(f"frictionloss {friction}: MJX {speeds[friction][0]:.3f} rad/s, MuJoCo {speeds[friction][1]:.3f} rad/s")
assert speeds[0.0][0] < 0.4
assert all(abs(speed - 4.3) < 0.01 for speed in (speeds[0.0][1], *speeds[1e-9]))
PY
echo "as described"
