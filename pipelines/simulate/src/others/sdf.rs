//! SDFormat: the lever as a world with one model.

use super::writer::{Comment, Form, Writer};

pub(super) const WRITER: Writer = Writer {
    files: &[Form { ending: "sdf", comment: Comment::Xml, templates: &[("", MODEL)] }],
    remarks: r"
            |theta is the angle of joint `hinge` in rad, theta = 0 is upright, above 0 is into the object; the axis has M L^2. A force at the lever's end is a torque of @lever@ m times it about the joint.
            |SDFormat is a world and no run: the start (@theta@ rad, @omega@ rad/s) and the input (@input_words@) are for whoever runs it. The step is that of its physics; a program may take neither that nor the world's gravity from here.
spring      |The environment's spring and damper are those of joint `hinge`. The limit of the motor, @motor_max@ N, is left out: where the scene's spring asks for more, this one goes on.
!free !spring|SDFormat has no zones of angle, and no force that a command asks for: apply it yourself, with the actuators' limits. Zone by zone the actuators are asked for u N against a push into the object: @asks@.
motor !spring|The joint's effort is the motor's largest torque. Many programs apply it to nothing but their own motors.
!free motor_lag|The motor's lag of @motor_lag@ s is left out: SDFormat has none.
!free brake  |SDFormat has no brake: a force of at most @brake_max@ N against the motion, which the environment asks for, is for whoever runs it.
!free dead_zone|The brake loses the first @dead_zone@ N of what it is asked for.
!free brake_lag|The brake's lags of @brake_on@ s and @brake_off@ s are left out with it.
!free let_go|That a brake which holds lets go below @let_go@ N is left out with it.
dry         |friction of the joint is the scene's, in N m. What a program makes of it differs: some ignore it, some let it creep.
stiction    |SDFormat has one level of friction, the one in motion (@kinetic@ N). That of rest (@static@ N) is left out.
stops       |What happens at the limits is left to the program; the scene's stops are rigid and inelastic.
!gravity    |The scene has no weight: the world has no gravity, and the mass lies on the axis, where it turns nothing.
gravity     |Mass and centre of the lever are such that its moment of inertia and its weight's moment are the scene's.
finger      |The finger is a link on the lever's axis, whose joint is the tissue: its angle is x2 / L. The input pushes the finger, so its torque acts on both joints.
pull        |The moved spring is left out, because a joint has one spring whose end stands still: with its far end at @pull_words@ it gives @term_constant@ + @term_rad@ theta + @term_input@ d N.
    ",
    refused: &[(
        "finger !consistent",
        "the finger's law \"thesis\" leaves the lever's acceleration out, which no body does; set finger.law to \"consistent\", or write it as python, drake or modelica",
    )],
};

const MODEL: &str = r#"
                |<?xml version="1.0"?>
                |@head@
                |<sdf version="1.9">
                |  <world name="lever">
                |    <gravity>0 0 @g_z@</gravity>
                |    <physics name="step" type="ignored">
                |      <max_step_size>@step@</max_step_size>
                |    </physics>
                |    <model name="lever">
                |      <link name="lever">
                |        <inertial>
                |          <pose>0 0 @body_radius@ 0 0 0</pose>
                |          <mass>@body_mass@</mass>
                |          <inertia>
                |            <ixx>@body_inertia@</ixx>
                |            <iyy>@body_inertia@</iyy>
                |            <izz>@body_inertia@</izz>
                |          </inertia>
                |        </inertial>
                |        <visual name="rod">
                |          <pose>0 0 @shown_half@ 0 0 0</pose>
                |          <geometry>
                |            <cylinder>
                |              <radius>@shown_width@</radius>
                |              <length>@lever@</length>
                |            </cylinder>
                |          </geometry>
                |        </visual>
                |      </link>
                |      <joint name="hinge" type="revolute">
                |        <parent>world</parent>
                |        <child>lever</child>
                |        <axis>
                |          <xyz>0 1 0</xyz>
                |          <limit>
stops           |            <lower>@low@</lower>
stops           |            <upper>@high@</upper>
motor !spring   |            <effort>@motor_nm@</effort>
                |          </limit>
                |          <dynamics>
!spring         |            <damping>@viscous_nms@</damping>
spring          |            <damping>@spring_damping_nms@</damping>
                |            <friction>@kinetic_nm@</friction>
spring          |            <spring_reference>@spring_rest@</spring_reference>
spring          |            <spring_stiffness>@spring_nm_rad@</spring_stiffness>
                |          </dynamics>
                |        </axis>
                |      </joint>
finger          |      <link name="finger">
finger          |        <inertial>
finger          |          <mass>@finger_mass@</mass>
finger          |          <inertia>
finger          |            <ixx>@finger_inertia@</ixx>
finger          |            <iyy>@finger_inertia@</iyy>
finger          |            <izz>@finger_inertia@</izz>
finger          |          </inertia>
finger          |        </inertial>
finger          |      </link>
finger          |      <joint name="tissue" type="revolute">
finger          |        <parent>lever</parent>
finger          |        <child>finger</child>
finger          |        <axis>
finger          |          <xyz>0 1 0</xyz>
finger          |          <limit>
bottoms         |            <lower>@finger_low@</lower>
bottoms         |            <upper>@finger_rad@</upper>
finger          |          </limit>
finger          |          <dynamics>
finger          |            <damping>@finger_nms_rad@</damping>
finger          |            <spring_reference>0</spring_reference>
finger          |            <spring_stiffness>@finger_nm_rad@</spring_stiffness>
finger          |          </dynamics>
finger          |        </axis>
finger          |      </joint>
                |    </model>
                |  </world>
                |</sdf>
"#;
