//! Modelica: the equations with a state machine for the ways of moving, without a library.

use super::writer::{Comment, Form, Writer};

pub(super) const WRITER: Writer = Writer {
    files: &[Form { ending: "mo", comment: Comment::Slashes, templates: &[("", MODEL)] }],
    remarks: r"
            |theta is the lever's angle in rad, theta = 0 is upright, and forces are at the lever's end: M L theta'' = their sum. Above 0 is into the object.
            |Every change of the way of moving is a when-clause. Compilers locate these to their own tolerance, after which theta or omega is a rounding past the edge.
            |The start of motion belongs to the other starts and to the push: who changes these changes it too.
edges       |At an edge of the environment where both sides push back, a bounce of less than `near` is rest.
series      |The series is a function of time without events: let no step be longer than its samples.
    ",
    refused: &[
        (
            "hybrid lags",
            "a lagging actuator in a hybrid drive at rest shares the load in a way that needs its own search; leave the lag out, or write it as python or drake",
        ),
        (
            "bottoms consistent",
            "the blow at the tissue's rigid end, which a finger with law \"consistent\" shares with the lever, is not written in Modelica; leave finger.length_m out, or write it as python or drake",
        ),
    ],
};

const MODEL: &str = r#"
                    |@head@
                    |model Lever
                    |  parameter Real M(unit = "kg") = @mass@ "mass felt at the lever's end";
                    |  parameter Real L(unit = "m") = @lever@ "length of the lever";
stops               |  parameter Real low(unit = "rad") = @low@ "lower stop";
stops               |  parameter Real high(unit = "rad") = @high@ "upper stop";
motor               |  parameter Real motor_max(unit = "N") = @motor_max@;
motor_lag           |  parameter Real motor_lag(unit = "s") = @motor_lag@;
brake               |  parameter Real brake_max(unit = "N") = @brake_max@;
dead_zone           |  parameter Real dead_zone(unit = "N") = @dead_zone@;
brake_lag           |  parameter Real brake_on(unit = "s") = @brake_on@ "lag of a brake that engages";
let_go              |  parameter Real let_go(unit = "N") = @let_go@ "user's force below which a brake that holds lets go";
friction            |  parameter Real static(unit = "N") = @static@ "dry friction at rest";
friction            |  parameter Real kinetic(unit = "N") = @kinetic@ "dry friction in motion";
friction            |  parameter Real viscous(unit = "N.s/rad") = @viscous@;
finger              |  parameter Real finger_mass(unit = "kg") = @finger_mass@;
finger              |  parameter Real finger_stiffness(unit = "N/m") = @finger_stiffness@;
finger              |  parameter Real finger_damping(unit = "N.s/m") = @finger_damping@;
bottoms             |  parameter Real finger_length(unit = "m") = @finger_length@;
edges               |  parameter Real near(unit = "rad") = 1e-7 "a bounce that is rest";
gravity             |  parameter Real weight(unit = "N") = @weight@ "m g r / L";
                    |  Real theta(start = @theta@, fixed = true, unit = "rad");
                    |  Real omega(start = @omega@, fixed = true, unit = "rad/s");
                    |  Real acceleration(unit = "rad/s2");
finger              |  Real x(start = 0, fixed = true, unit = "m") "how far the tissue is pressed";
finger              |  Real x_dot(start = 0, fixed = true, unit = "m/s");
motor_lag           |  Real motor_force(start = 0, fixed = true, unit = "N");
brake_lag           |  Real level(start = 0, fixed = true, unit = "N") "of the brake";
                    |  discrete Integer motion(start = @first_motion@, fixed = true) "1: forward, -1: backward, 0: at rest, 2 and -2: at rest on the upper and on the lower stop";
bottoms             |  discrete Integer contact(start = 0, fixed = true) "1: the tissue is fully pressed, -1: fully stretched";
                    |  Real push(unit = "N") "the user's force";
                    |  Real single(unit = "N") "forces that do not depend on the side";
asked_motor         |  Real asked_motor(unit = "N") "of the motor";
asked_brake         |  Real asked_brake(unit = "N") "of the brake, on the way forward";
asked_back          |  Real asked_back(unit = "N") "of the brake, on the way backward";
                    |  Real forward(unit = "N") "net force of a lever that moves forward, less dry friction";
                    |  Real backward(unit = "N") "net force of a lever that moves backward, less dry friction";
                    |  Real leaving_forward(unit = "N") "net force of a lever at rest, were it to move forward, less dry friction";
                    |  Real leaving_backward(unit = "N") "the same backward";
edges               |  discrete Integer edge(start = 0, fixed = true) "of the environment on which the lever rests; 0: none";
edges               |@edge_variables@
series              |protected
series              |@functions@
                    |equation
                    |  push = @input_modelica@;
asked_motor         |  asked_motor = max(-motor_max, min(motor_max, @law_motor@));
asked_brake signed  |  asked_brake = max(-brake_max, min(brake_max, @law_brake@));
asked_brake coulomb |  asked_brake = max(0, min(brake_max, (@law_brake@)@less_dead_zone@));
asked_back          |  asked_back = max(0, min(brake_max, (@law_back@)@less_dead_zone@));
motor_lag           |  motor_lag * der(motor_force) = -asked_motor - motor_force;
brake_lag           |  brake_on * der(level) = (if motion == 1 then asked_brake else asked_back) - level;
!finger             |  single = push@single@;
finger !bottoms     |  single = finger_stiffness * x + finger_damping * x_dot@single@;
bottoms             |  single = (if contact == 0 then finger_stiffness * x + finger_damping * x_dot else push)@single@;
                    |  forward = single@forward@;
                    |  backward = single@backward@;
edges               |@edge_equations@
edges               |  leaving_forward = @leaving_forward@;
edges               |  leaving_backward = @leaving_backward@;
!edges              |  leaving_forward = forward;
!edges              |  leaving_backward = backward;
                    |  der(theta) = omega;
                    |  der(omega) = acceleration;
friction            |  M * L * acceleration = if motion == 1 then forward - kinetic elseif motion == -1 then backward + kinetic else 0;
!friction           |  M * L * acceleration = if motion == 1 then forward elseif motion == -1 then backward else 0;
finger              |  der(x) = x_dot;
consistent          |  finger_mass * (der(x_dot) + L * acceleration) = push - finger_stiffness * x - finger_damping * x_dot;
finger !consistent !bottoms|  finger_mass * der(x_dot) = push - finger_stiffness * x - finger_damping * x_dot;
bottoms             |  finger_mass * der(x_dot) = if contact == 0 then push - finger_stiffness * x - finger_damping * x_dot else 0;
bottoms             |  when pre(contact) == 0 and x > finger_length then
bottoms             |    contact = if push >= finger_stiffness * finger_length then 1 else 0;
bottoms             |  elsewhen pre(contact) == 0 and x < -finger_length then
bottoms             |    contact = if -push >= finger_stiffness * finger_length then -1 else 0;
bottoms             |  elsewhen pre(contact) == 1 and push < finger_stiffness * finger_length then
bottoms             |    contact = 0;
bottoms             |  elsewhen pre(contact) == -1 and -push < finger_stiffness * finger_length then
bottoms             |    contact = 0;
bottoms             |  end when;
bottoms             |  when x > finger_length or x < -finger_length then
bottoms             |    reinit(x, if x > 0 then finger_length else -finger_length);
bottoms             |    reinit(x_dot, 0);
bottoms             |  end when;
                    |  when pre(motion) == 1 and omega < 0 then
                    |    motion = 0;
edges               |    edge = 0;
                    |  elsewhen pre(motion) == -1 and omega > 0 then
                    |    motion = 0;
edges               |    edge = 0;
stops               |  elsewhen pre(motion) == 1 and theta > high then
stops               |    motion = 2;
stops edges         |    edge = 0;
stops               |  elsewhen pre(motion) == -1 and theta < low then
stops               |    motion = -2;
stops edges         |    edge = 0;
edges               |@edge_branches@
stops               |  elsewhen (pre(motion) == 0 or pre(motion) == 2) and @leaves_backward@ then
!stops              |  elsewhen pre(motion) == 0 and @leaves_backward@ then
                    |    motion = -1;
edges               |    edge = 0;
stops               |  elsewhen (pre(motion) == 0 or pre(motion) == -2) and @leaves_forward@ then
!stops              |  elsewhen pre(motion) == 0 and @leaves_forward@ then
                    |    motion = 1;
edges               |    edge = 0;
                    |  end when;
edges               |@edge_snaps@
stops consistent    |  when motion == 2 or motion == -2 then
stops consistent    |    reinit(x_dot, pre(x_dot) + L * pre(omega)) "the finger keeps its own velocity";
stops consistent    |  end when;
stops               |  when motion == 0 or motion == 2 or motion == -2 then
!stops              |  when motion == 0 then
                    |    reinit(omega, 0);
                    |  end when;
                    |  annotation(experiment(StartTime = 0, StopTime = @duration@, Interval = @step@));
                    |end Lever;
"#;
