//! URDF: the lever as a robot of one joint, or of two with a finger.

use super::writer::{Comment, Form, Writer};

pub(super) const WRITER: Writer = Writer {
    files: &[Form { ending: "urdf", comment: Comment::Xml, templates: &[("", MODEL)] }],
    remarks: r"
            |theta is the angle of joint `hinge` in rad, theta = 0 is upright, above 0 is into the object; the axis has M L^2. A force at the lever's end is a torque of @lever@ m times it about the joint.
            |URDF is a robot and no run: the start (@theta@ rad, @omega@ rad/s), the step (@step@ s) and the input (@input_words@) are for whoever runs it.
!free       |URDF has no environment: apply its force yourself, with the actuators' limits. Zone by zone the actuators are asked for u N against a push into the object: @asks@.
motor       |The joint's effort is the motor's largest torque. Many programs apply it to nothing but their own motors.
!free motor_lag|The motor's lag of @motor_lag@ s is left out: URDF has none.
!free brake  |URDF has no brake: a force of at most @brake_max@ N against the motion, which the environment asks for, is for whoever runs it.
!free dead_zone|The brake loses the first @dead_zone@ N of what it is asked for.
!free brake_lag|The brake's lags of @brake_on@ s and @brake_off@ s are left out with it.
!free let_go|That a brake which holds lets go below @let_go@ N is left out with it.
friction    |damping and friction of the joint are the scene's, in N m s/rad and N m. What a program makes of them differs: some ignore friction, some let it creep.
stiction    |URDF has one level of friction, the one in motion (@kinetic@ N). That of rest (@static@ N) is left out.
stops       |What happens at the limits is left to the program; the scene's stops are rigid and inelastic.
            |URDF asks for a largest velocity: a large number stands there.
!gravity    |The scene has no weight: switch gravity off, or leave it; the mass lies on the axis, where it turns nothing.
gravity     |Mass and centre of the lever are such that its moment of inertia and its weight's moment are the scene's, with gravity of @g@ m/s^2 towards -z, which URDF cannot say.
finger      |The finger is a link on the lever's axis, whose joint is the tissue: its angle is x2 / L. The input pushes the finger, so its torque acts on both joints.
finger      |URDF has no springs: the tissue's stiffness, @finger_nm_rad@ N m/rad about joint `tissue`, is for whoever runs it.
pull        |URDF has no springs: that of the moved spring, whose far end is at @pull_words@, is for whoever runs it: @term_constant@ + @term_rad@ theta + @term_input@ d N.
    ",
    refused: &[(
        "finger !consistent",
        "the finger's law \"thesis\" leaves the lever's acceleration out, which no body does; set finger.law to \"consistent\", or write it as python, drake or modelica",
    )],
};

const MODEL: &str = r#"
                |<?xml version="1.0"?>
                |@head@
                |<robot name="lever">
                |  <link name="world"/>
                |  <link name="lever">
                |    <inertial>
                |      <origin xyz="0 0 @body_radius@"/>
                |      <mass value="@body_mass@"/>
                |      <inertia ixx="@body_inertia@" ixy="0" ixz="0" iyy="@body_inertia@" iyz="0" izz="@body_inertia@"/>
                |    </inertial>
                |    <visual>
                |      <origin xyz="0 0 @shown_half@"/>
                |      <geometry>
                |        <cylinder radius="@shown_width@" length="@lever@"/>
                |      </geometry>
                |    </visual>
                |  </link>
stops           |  <joint name="hinge" type="revolute">
!stops          |  <joint name="hinge" type="continuous">
                |    <parent link="world"/>
                |    <child link="lever"/>
                |    <axis xyz="0 1 0"/>
stops           |    <limit lower="@low@" upper="@high@" effort="@motor_nm@" velocity="1e9"/>
!stops          |    <limit effort="@motor_nm@" velocity="1e9"/>
                |    <dynamics damping="@viscous_nms@" friction="@kinetic_nm@"/>
                |  </joint>
finger          |  <link name="finger">
finger          |    <inertial>
finger          |      <mass value="@finger_mass@"/>
finger          |      <inertia ixx="@finger_inertia@" ixy="0" ixz="0" iyy="@finger_inertia@" iyz="0" izz="@finger_inertia@"/>
finger          |    </inertial>
finger          |  </link>
bottoms         |  <joint name="tissue" type="revolute">
finger !bottoms |  <joint name="tissue" type="continuous">
finger          |    <parent link="lever"/>
finger          |    <child link="finger"/>
finger          |    <axis xyz="0 1 0"/>
bottoms         |    <limit lower="@finger_low@" upper="@finger_rad@" effort="0" velocity="1e9"/>
finger          |    <dynamics damping="@finger_nms_rad@" friction="0"/>
finger          |  </joint>
                |</robot>
"#;
