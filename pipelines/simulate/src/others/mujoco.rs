//! MJCF, the model file of MuJoCo, and a program beside it that sets what the file cannot hold.

use super::equations::{ACTUATORS, INPUTS, NUMBERS, WRITE};
use super::writer::{Comment, Form, Writer};

pub(super) const WRITER: Writer = Writer {
    files: &[
        Form { ending: "mujoco.xml", comment: Comment::Xml, templates: &[("", MODEL)] },
        Form {
            ending: "mujoco.py",
            comment: Comment::Hash,
            templates: &[
                ("", HEAD),
                ("", NUMBERS),
                ("", INPUTS),
                ("driven", ACTUATORS),
                ("", LOOP),
                ("", WRITE),
            ],
        },
    ],
    remarks: r"
            |theta is the angle of joint `hinge` in rad, theta = 0 is upright, above 0 is into the object; the axis has M L^2. The controls are forces at the lever's end in N: their gear is L.
            |MJCF holds no signal of time. The input (@input_words@) is the control of actuator `input`, which the program beside the model sets at each step: `python FILE.py trajectory.csv` runs it.
            |The start is keyframe 0: reset to it.
!gravity    |The scene has no weight, so the mass lies on the axis, where only its moment of inertia shows.
gravity     |Mass and centre of the lever are such that its moment of inertia and its weight's moment are the scene's: @body_mass@ kg at @body_radius@ m. theta = 0 is upright, gravity points to -z.
affine      |The environment (@asks@) is actuator `motor`, which forcerange limits.
driven      |MJCF has no zones of angle, no command that a limit clamps, and no actuator that works in one direction. The environment (@asks@) is in the program beside the model, which computes it once a step.
stops       |The stops are soft: a lever that is pushed into one sinks in a little and comes to rest slowly (solreflimit, solimplimit). The scene's are rigid.
dry         |Dry friction is soft: by MuJoCo's default a lever that should stand creeps. noslip_iterations, by default 0, holds it.
stiction    |frictionloss has one level, the one in motion (@kinetic@ N). That of rest (@static@ N) is left out: a lever between the two slides here and stands in the scene.
driven coulomb|MJCF has no brake whose level follows a command: the program sets frictionloss of joint `hinge` at each step.
driven passive signed|Where the lever should stand between the brake's force and none, the program turns back and forth at the step.
driven signed|The brake's force on the way forward is the control of actuator `brake`, which the program sets at each step.
driven hybrid|The program turns from brake to motor by the sign of the velocity, once a step. Where the lever should stand between the two it turns back and forth at the step.
driven brake_lag|The brake's lag is in the program.
driven motor_lag|The motor's lag is that of its activation (dyntype), of which MuJoCo takes a step at a time.
driven let_go|That a brake which holds lets go below @let_go@ N is in the program.
finger      |The finger is a body on the lever's axis, whose joint is the tissue: its angle is x2 / L. The input pushes the finger.
bottoms     |The end of the tissue is soft, as the stops are.
pull        |Where the moved spring's far end is (@pull_words@) is the control of actuator `terms`, in rad, which the program sets.
    ",
    refused: &[
        (
            "tiny",
            "MuJoCo takes no moment of inertia of 1e-15 kg m^2 or less; make plant.mass_kg, plant.lever_m or finger.mass_kg larger, or write it as python, drake or modelica",
        ),
        (
            "finger !consistent",
            "the finger's law \"thesis\" leaves the lever's acceleration out, which no body does; set finger.law to \"consistent\", or write it as python, drake or modelica",
        ),
    ],
};

const MODEL: &str = r#"
                |@head@
                |<mujoco model="lever">
                |  <compiler angle="radian" inertiafromgeom="false"/>
!holds          |  <option timestep="@step@" gravity="0 0 @g_z@" integrator="implicitfast"/>
holds           |  <option timestep="@step@" gravity="0 0 @g_z@" integrator="implicitfast" noslip_iterations="10"/>
                |  <worldbody>
                |    <body name="lever">
                |      <inertial pos="0 0 @body_radius@" mass="@body_mass@" diaginertia="@body_inertia@ @body_inertia@ @body_inertia@"/>
stops           |      <joint name="hinge" type="hinge" axis="0 1 0" range="@low@ @high@" damping="@viscous_nms@" frictionloss="@kinetic_nm@"/>
!stops          |      <joint name="hinge" type="hinge" axis="0 1 0" damping="@viscous_nms@" frictionloss="@kinetic_nm@"/>
                |      <geom type="capsule" fromto="0 0 0 0 0 @lever@" size="@shown_width@" contype="0" conaffinity="0"/>
finger          |      <body name="finger">
finger          |        <inertial pos="0 0 0" mass="@finger_mass@" diaginertia="@finger_inertia@ @finger_inertia@ @finger_inertia@"/>
bottoms         |        <joint name="tissue" type="hinge" axis="0 1 0" stiffness="@finger_nm_rad@" damping="@finger_nms_rad@" range="@finger_low@ @finger_rad@"/>
finger !bottoms |        <joint name="tissue" type="hinge" axis="0 1 0" stiffness="@finger_nm_rad@" damping="@finger_nms_rad@"/>
finger          |        <geom type="sphere" pos="0 0 @lever@" size="@shown_width@" contype="0" conaffinity="0"/>
finger          |      </body>
                |    </body>
                |  </worldbody>
finger          |  <tendon>
finger          |    <fixed name="fingertip">
finger          |      <joint joint="hinge" coef="1"/>
finger          |      <joint joint="tissue" coef="1"/>
finger          |    </fixed>
finger          |  </tendon>
                |  <actuator>
!finger         |    <general name="input" joint="hinge" gear="@lever@"/>
finger          |    <general name="input" tendon="fingertip" gear="@lever@"/>
affine          |    <general name="motor" joint="hinge" gear="@lever@" gainprm="0" biastype="affine" biasprm="@law_force@ @law_per_m@ @law_per_m_s@" forcerange="-@motor_max@ @motor_max@"/>
driven motor !motor_lag|    <general name="motor" joint="hinge" gear="@lever@" ctrlrange="-@motor_max@ @motor_max@"/>
driven motor_lag|    <general name="motor" joint="hinge" gear="@lever@" dyntype="filterexact" dynprm="@motor_lag@" ctrlrange="-@motor_max@ @motor_max@"/>
driven signed   |    <general name="brake" joint="hinge" gear="@lever@" ctrlrange="-@brake_max@ @brake_max@"/>
terms           |    <general name="terms" joint="hinge" gear="@lever@" gainprm="@term_input@" biastype="affine" biasprm="@term_constant@ @term_per_m@ @term_per_m_s@"/>
                |  </actuator>
                |  <keyframe>
!finger         |    <key name="start" qpos="@theta@" qvel="@omega@"/>
finger          |    <key name="start" qpos="@theta@ 0" qvel="@omega@ 0"/>
                |  </keyframe>
                |</mujoco>
"#;

const HEAD: &str = r#"
        |@head@
        |
series  |import bisect
        |import math
        |import sys
        |from pathlib import Path
        |
        |import mujoco
        |import numpy as np
        |
"#;

const LOOP: &str = r#"
                    |
                    |
driven              |STILL = 1e-6  # rad/s; what is slower stands: a constraint's solver leaves a rest
driven              |
driven              |
                    |def simulate():
                    |    """Times in steps of STEP, s, and the state at each."""
                    |    model = mujoco.MjModel.from_xml_path(str(Path(__file__).with_suffix(".xml")))
                    |    data = mujoco.MjData(model)
                    |    mujoco.mj_resetDataKeyframe(model, data, 0)
                    |    times = STEP * np.arange(math.floor(DURATION / STEP * (1 + 1e-9)) + 1)
                    |    states = np.empty((len(times), 2))
driven brake_lag    |    lagged = 0.0
driven let_go       |    held = False
                    |    for i, t in enumerate(times):
                    |        theta, omega = states[i] = data.qpos[0], data.qvel[0]
                    |        data.actuator("input").ctrl = external(t, t)
pull                |        data.actuator("terms").ctrl = displacement(t, t)
driven !let_go      |        side = 1 if omega > STILL else -1
driven let_go       |        held = omega > STILL or (held and external(t, t) >= LET_GO)
driven let_go       |        side = 1 if held else -1
driven              |        motor, brake, level = actuators(theta, omega, side, zone(theta, side))
driven motor        |        data.actuator("motor").ctrl = motor
driven signed       |        data.actuator("brake").ctrl = brake
driven brake_lag hybrid|        lagged += (level - lagged) * -math.expm1(-STEP / (BRAKE_ON if side > 0 else BRAKE_OFF))
driven brake_lag passive|        lagged += (level - lagged) * -math.expm1(-STEP / BRAKE_ON)
driven brake_lag    |        level = lagged
driven coulomb friction|        model.dof_frictionloss[0] = LEVER * (level + KINETIC)
driven coulomb !friction|        model.dof_frictionloss[0] = LEVER * level
                    |        mujoco.mj_step(model, data)
                    |    return times, states
"#;
