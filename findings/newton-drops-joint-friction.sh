#!/usr/bin/env bash
# Newton 1.8.0: five of its seven solvers for jointed bodies drop a joint's friction without a word: a lever under half of it runs away, bit for bit
# as without friction.
#
# Library: newton 1.8.0 with warp-lang 1.19.0, mujoco-warp 3.17.0 and mujoco 3.17.0 (PyPI), on the processor, in float32.
# Source: `ModelBuilder.add_joint_revolute` takes `friction` for every solver. The documentation of SolverFeatherstone, SolverSemiImplicit, SolverXPBD
# and SolverVBD lists Model.joint_friction under "not supported", and SolverSteel ignores it unless `enable_joint_friction`, which
# needs CUDA; no solver warns of a model that has it. The page of the builder does not tell.
# Seen: torque 0.025 N m, friction 0.05 N m, inertia 5e-4 kg m2, 50 steps of 1 ms: the pose after them is the same for friction 0.05 and 0 with
# Featherstone, SemiImplicit, XPBD, VBD and Steel (0.06 rad). SolverKamino stands (below 1e-6 rad); SolverMuJoCo creeps (0.052 rad/s).
# Meaning for us: docs/engines.md names the two solvers that a study of friction may use, and benches/engines runs all seven.
set -euo pipefail
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check newton==1.8.0 warp-lang==1.19.0 mujoco-warp==3.17.0 mujoco==3.17.0 numpy==2.4.6
cd "$work"
"$work/venv/bin/python" - <<'PY'
import newton
import numpy as np
import warp as wp

wp.config.quiet = True
INERTIA = 5e-4


def turned(name, friction):
    """Angle and speed of the lever by its pose, after 50 steps."""
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, 0.0))
    body = builder.add_link(mass=0.05, inertia=wp.mat33(np.eye(3) * INERTIA))
    builder.add_articulation([builder.add_joint_revolute(-1, body, axis=(0, 0, 1), friction=friction)])
    if name == "SolverVBD":
        builder.color()
    model = builder.finalize()
    solver = getattr(newton.solvers, name)(model)
    now, after, control = model.state(), model.state(), model.control()
    newton.eval_fk(model, model.joint_q, model.joint_qd, now)
    control.joint_f.assign(np.array([0.025], dtype=np.float32))
    for _ in range(50):
        now.clear_forces()
        solver.step(now, after, control, None, 1e-3)
        now, after = after, now
    q, qd = wp.zeros_like(model.joint_q), wp.zeros_like(model.joint_qd)
    newton.eval_ik(model, now, q, qd)
    return float(q.numpy()[0]), float(qd.numpy()[0])


with wp.ScopedDevice("cpu"):
    for name in ("SolverFeatherstone", "SolverSemiImplicit", "SolverXPBD", "SolverVBD", "SolverSteel"):
        with_friction, without = turned(name, 0.05), turned(name, 0.0)
        print(f"{name}: {with_friction[0]:.4f} rad with friction, {without[0]:.4f} rad without")
        assert with_friction == without and 0.04 < without[0] < 0.08
    (kamino, _), (_, mujoco) = turned("SolverKamino", 0.05), turned("SolverMuJoCo", 0.05)
    print(f"SolverKamino: {kamino:.1e} rad; SolverMuJoCo: {mujoco:.4f} rad/s")
    assert abs(kamino) < 1e-6 and 0.05 < mujoco < 0.055
PY
echo "as described"
