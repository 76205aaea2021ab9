//! The commented `study.toml` that `zwidth new` writes.

use crate::{SceneKind, StudyId};

/// A commented `study.toml` for a new study: the thesis' design, ready to edit, and valid
/// unchanged.
pub fn template(id: &StudyId) -> String {
    // It names the kinds that the study that comes along was made with: the hash of its text is in every file of that study.
    // `docs/data.md` has all kinds, and the numbers of each.
    TEMPLATE.replace("@ID@", id.as_str())
}

/// A shorter `study.toml`, for recordings that another program made: it assumes nothing of a device.
pub fn template_of_imports(id: &StudyId) -> String {
    IMPORTED.replace("@ID@", id.as_str()).replace("@KINDS@", &kinds())
}

/// The kinds of environment as a list; the last one is "none".
fn kinds() -> String {
    let [none, kinds @ ..] = SceneKind::ALL.map(|kind| format!("\"{}\"", kind.as_str()));
    format!("{} or {none}", kinds.join(", "))
}

const IMPORTED: &str = r#"# A study of recordings that another program made. Edit the words below before the first import:
# afterwards what the recordings rest on (ids, modes, environments, questions) stays as it is.
# Keys end in their unit. `zwidth verify @ID@` checks this file.
schema = 2

[study]
# The folder's name under raw/.
id = "@ID@"
title = "@ID@"

[design]
# Repeats of each condition (environment × mode) per participant and session, as planned.
repeats = 3
# Practice trials before a session: kept, marked, left out of the analysis.
familiarisation = 0
# Longest a trial took, and the shortest pause after it.
trial_limit_s = 60.0
pause_s = 0.0

[coordinate]
# "rotational": figures and tables speak of degrees. "linear": of millimetres, with x = L θ; the keys below
# then end in _mm instead of _deg and in _n_per_mm instead of _n_per_rad (lever_m = 1.0 for a slide).
kind = "rotational"

# Leave out what you do not know: nothing is assumed in its place.
[device]
name = "our device"
# Lever length from the axis to the finger: with it, forces and torques can be changed into each other.
# lever_m = 0.05
# Work space, between the stops.
# theta_min_deg = -45.0
# theta_max_deg = 45.0

# What was rendered. kind = @KINDS@; "none" assumes nothing of it.
[[environments]]
id = "task"
label = "Task"
kind = "none"
# What is asked after a trial in it, a question below:
# question = "clear"
# If it was a spring of known stiffness, the rendered stiffness is compared with it:
# kind = "spring"
# stiffness_n_per_rad = 4.0
# rest_deg = 0.0
# A wall alone is kind = "wall" with wall_deg, a spring with a wall "spring_wall" with all three numbers, a constant
# force "force" with force_n. If it was rendered late: delay_ms.

# Where a trial's movement begins and ends. Set onset_deg_s well above the noise of a lever at rest.
# [analysis]
# onset_deg_s = 10.0
# offset_deg_s = 5.0

# How it was rendered: the conditions that are compared. Figures give each its colour by this order.
[[modes]]
id = "a"
label = "A"

[[modes]]
id = "b"
label = "B"

# What was asked after each trial: on a five-point scale of agreement, or on one of your own.
# [[questions]]
# id = "clear"
# text = "I felt the force clearly."
# points = 7

# What is compared. Without it the last mode is compared with each other one, the primary metric is
# discrepancy_user_mean_n (metrics keep their names on a slide), and exploratory are wall_past_max_rad, stiffness_n_per_rad, loop_area_j, force_rms_error_n,
# returned_energy_share and duration_s, each where the recordings allow it. Another primary one leaves the others;
# `metrics = [...]` lists your own in their place.
# [compare]
# contrasts = [["b", "a"]]
# primary = "stiffness_n_per_rad"
# groups = "group"

# What is recorded per sample besides, if a mapping file gives it: a column of each trial file. Of a set-point named
# reference_rad (unit rad) each trial has the step response: primary = "step_rise_s", metrics = ["step_overshoot_share"].
# [[channels]]
# id = "current_a"
# unit = "A"
# description = "current of the motor"

# A device that moves in space, with positions x_m, y_m, z_m or forces force_x_n, force_y_n, force_z_n: schema = 3 above, and
# which way its axes point. push is where the object is ("Several axes" of docs/import.md).
# [axes]
# frame = "x right, y up, z to the person"
# push = [0.0, 0.0, -1.0]

# Groups of people: participants.csv beside this file has a line for each, such as P01,expert below participant,group
# ("Groups" of docs/analysis.md), and [compare] above names the column.
# [[people]]
# id = "group"
# levels = ["novice", "expert"]
# assigned = false
"#;

const TEMPLATE: &str = r#"# What this study is: design, device, environments, modes, questions.
# Keys end in their unit. `zwidth verify @ID@` checks this file and everything recorded for it.

# Version of the form of the study's trial files. A study keeps the one it began with.
schema = 2

[study]
# The folder's name under raw/.
id = "@ID@"
title = "Coupling a motor and a brake: @ID@"

[design]
# Repeats of each condition (environment × mode) in a session.
repeats = 6
# Practice trials before a session: kept, marked, left out of the analysis.
familiarisation = 3
# Longest a trial may take, and the shortest pause after it.
trial_limit_s = 4.0
pause_s = 5.0
# How the order of the modes is drawn: "williams" (rows of Williams squares, one a repeat) or "constrained" (at
# random, no mode more than twice in a row). Blocks of one environment follow each other, counterbalanced.
order = "williams"
# true: modes are sealed. Files and screens show codes until `zwidth unseal`; nothing is analysed before.
blinded = false

[coordinate]
# "rotational": figures and tables speak of degrees. "linear": of millimetres, with x = L θ; the keys below
# then end in _mm instead of _deg and in _n_per_mm instead of _n_per_rad (lever_m = 1.0 for a slide).
kind = "rotational"

[device]
name = "motor and brake on a capstan lever"
# Lever length from the axis to the finger. Leave it out if unknown: torque then stays torque.
lever_m = 0.045
# Work space, between the stops.
theta_min_deg = -45.0
theta_max_deg = 45.0
# New values of the force sensor per second.
force_rate_hz = 80.0

# Numbers of the control loop; these are the defaults, the table may be left out.
[control]
# Ticks per second. A device that gives fewer samples sets its own rate.
rate_hz = 1000.0
# The brake lets go when the user's force falls below this while the lever does not move on.
let_go_n = 2.0
# Limit of the force on a finger: a motor that can give more is refused, a larger measured force stops the trial.
force_limit_n = 10.0
# Velocity from angles: "second_order" (a differentiator with a second-order low-pass; its delay is
# 1/(pi velocity_cutoff_hz) seconds) or "difference" (of the last two angles).
velocity = "second_order"
velocity_cutoff_hz = 40.0

# Actuator masses, for the weight calculation. Leave the table out if unknown.
[masses]
motor_g = 88.0
brake_g = 27.0

# Resistances of the actuators' windings, for what a trial takes from its supply at most. Leave out what is unknown.
# The motor's is an estimate: a winding of its series, scaled from 12 V to 48 V.
[resistances]
motor_ohm = 30.4
# brake_ohm = 20.0

# Numbers of the analysis; these are the defaults, the table may be left out.
[analysis]
# Movement begins where |velocity| first exceeds onset, and ends where it last falls below offset.
onset_deg_s = 10.0
offset_deg_s = 5.0
# A spring's slope is fitted on samples at least this far past its rest.
slope_from_deg = 0.0
# Points of a common grid, and the level of every interval.
grid_points = 401
confidence = 0.95

# How figures average repeats against time. Unless told otherwise, means begin with every repeat's movement ("onset"); by
# "landmarks" time is stretched besides, so that start, wall contact, reversal, return and end meet. Force against position is
# averaged at the angle. A choice is for all figures, for those of a kind, or for one: [figures.modes],
# [figures.modes.P01.S01.spring].
# [figures]
# alignment = "onset"
# Sessions that have figures of their own: "all" or a list. Unless told otherwise all of a study of up to 24 sessions, and
# none of a larger one: `zwidth figure @ID@ NAME` makes one of them.
# sessions = ["P01.S01"]

# What is compared, set before the data are taken; these are the defaults, the table may be left out.
# [compare]
# Pairs of modes, the one minus the other: the last mode against each other one.
# contrasts = [["hybrid", "active"], ["hybrid", "passive"]]
# The metric whose claims count; claims of every other one are exploratory. alpha is shared by its contrasts (Holm).
# primary = "discrepancy_user_mean_n"
# alpha = 0.05
# Differences up to this size do not matter: a number in the metric's unit, or a Weber fraction of what is commanded.
# [compare.bounds]
# stiffness_n_per_rad = { weber = 0.08 }

# Which model recorded trials are replayed with: "by_eye", the thesis' mass and damping, or "auto", the cheapest that
# nobody could tell from the fullest, which takes minutes a condition (docs/ladder.md).
# [replay]
# model = "by_eye"

# What a person can feel, for the trade of speed and accuracy (docs/trade.md has the sources); these are the defaults,
# the table may be left out. Shares of a force, a compliance, a viscosity; the smallest force and angle that are told
# apart; by how much a vibration must exceed the right one to be another.
# [perception]
# force = 0.07
# force_floor_n = 0.05
# compliance = 0.08
# viscosity = 0.19
# angle_deg = 2.0
# excess = 0.2
# Vibration that is just felt: "fingertip", "grasped" (strict), or pairs of Hz and um: [[10.0, 10.0], [200.0, 0.1]].
# vibration = "fingertip"

# What is rendered. kind = "free", "spring", "wall", "spring_wall" or "none" (a questionnaire alone).
[[environments]]
id = "spring"
label = "Spring"
kind = "spring"
stiffness_n_per_rad = 4.0
rest_deg = -45.0
question = "felt_spring"

[[environments]]
id = "spring_wall"
label = "Spring + wall"
kind = "spring_wall"
stiffness_n_per_rad = 4.0
rest_deg = -45.0
wall_deg = 26.6
question = "felt_wall"

# How it is rendered. Figures give each mode its colour by this order.
[[modes]]
id = "active"
label = "Active"
motor_max_v = 16.0

[[modes]]
id = "passive"
label = "Passive"
brake_max_v = 8.0

[[modes]]
id = "hybrid"
label = "Hybrid"
motor_max_v = 8.0
brake_max_v = 8.0

# What is asked after each trial: on a five-point scale of agreement, or on one of your own (points, from, step and labels).
# reversed = true: agreement speaks against.
[[questions]]
id = "felt_spring"
text = "During this test I clearly felt forces I would associate with interacting with a linear stiffness."

[[questions]]
id = "felt_wall"
text = "During this test I clearly felt forces I would associate with interacting with an infinitely rigid object, such as a wall, in addition to a linear stiffness."

# Figures of runs of the model beside those of the data. Scene files lie in this study's folder (docs/data.md).
# draw = "runs" (up to three side by side), "inputs" or "bow_tie".
# [[scenes]]
# id = "sine"
# files = ["scenes/sine.toml"]
# solver = "exact"
# step_s = 0.001

# What is recorded per sample besides, if the device or a mapping file gives it: a column of each trial file. To be
# listed before the first trial.
# [[channels]]
# id = "grip_n"
# unit = "N"
# description = "force of the grip"
"#;
