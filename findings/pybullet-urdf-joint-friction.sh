#!/usr/bin/env bash
# PyBullet 3.2.7 reads a joint's dry friction from a URDF, tells it by getJointInfo, and simulates none.
#
# Library: pybullet 3.2.7 (PyPI), `loadURDF` of a joint with `<dynamics friction="…"/>`, `getJointInfo`, `stepSimulation`.
# Source: URDF's specification has `friction` as the joint's physical static friction, N m; the Quickstart Guide lists jointFriction among what
# getJointInfo returns. Neither the guide nor a message says that it is not used. Every joint begins with a velocity motor, which hides it: until
# that is switched off (as the guide says for torque control) the joint stands against any torque of this size.
# Seen: 0.025 N m on a joint of 5e-4 kg m2 turns it by the same angle with a friction of 0, 0.05 and 5 N m, to the last bit. With the
# motor (VELOCITY_CONTROL, targetVelocity 0, force 0.05) it stands.
# Meaning for us: benches/engines gives PyBullet friction by the motor; a URDF's friction is lost on the way (docs/engines.md).
set -euo pipefail
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check pybullet==3.2.7 numpy==2.4.6
cd "$work"
"$work/venv/bin/python" - <<'PY'
from pathlib import Path

import pybullet as p

ROBOT = """<robot name="rig">
  <link name="base"><inertial><mass value="0"/><inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="lever"><inertial><origin xyz="0.1 0 0"/><mass value="0.05"/><inertia ixx="1e-6" iyy="1e-6" izz="1e-6" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="lever" type="continuous"><parent link="base"/><child link="lever"/><axis xyz="0 0 1"/><dynamics damping="0" friction="{friction}"/></joint>
</robot>"""


def turned(friction, motor_nm=0.0):
    p.connect(p.DIRECT)
    p.setTimeStep(1e-3)
    Path("rig.urdf").write_text(ROBOT.format(friction=friction))
    body = p.loadURDF("rig.urdf", useFixedBase=True, flags=p.URDF_USE_INERTIA_FROM_FILE)
    told = p.getJointInfo(body, 0)[7]
    p.setJointMotorControl2(body, 0, p.VELOCITY_CONTROL, targetVelocity=0, force=motor_nm)
    for _ in range(500):
        p.setJointMotorControl2(body, 0, p.TORQUE_CONTROL, force=0.025)
        p.stepSimulation()
    angle = p.getJointState(body, 0)[0]
    p.disconnect()
    return told, angle


found = [turned(friction) for friction in (0, 0.05, 5.0)]
stands = turned(0, motor_nm=0.05)[1]
print(f"friction as told: {[told for told, _ in found]}; turned: {[angle for _, angle in found]} rad; with the motor {stands} rad")
assert [told for told, _ in found] == [0, 0.05, 5.0]
assert found[0][1] > 5 and len({angle for _, angle in found}) == 1
assert stands == 0
PY
echo "as described"
