//! The numbers of the thesis' Table 3.

/// M_O: mass of the object, kg; "to resemble a steel spring".
pub const OBJECT_MASS_KG: f64 = 0.005;
/// M_F: mass of the fingertip, kg; half flexion, Bi et al., the thesis' reference 16.
pub const FINGER_MASS_KG: f64 = 0.021;
/// K_O: stiffness of the virtual spring, N at the lever's end per rad.
pub const OBJECT_STIFFNESS_N_PER_RAD: f64 = 4.0;
/// B_O: damping of the object, N s/rad; found by trial and error in the thesis.
pub const OBJECT_DAMPING_NS_PER_RAD: f64 = 1.0;
/// K_F: stiffness of the fingertip, N/m; same source as its mass.
pub const FINGER_STIFFNESS_N_PER_M: f64 = 584.6;
/// B_F: damping of the fingertip, kg/s; same source as its mass.
pub const FINGER_DAMPING_NS_PER_M: f64 = 1.53;
/// L_F0: thickness of the fingertip's tissue, m; measured on one person.
pub const FINGER_LENGTH_M: f64 = 0.006;
/// T: length of a run, s.
pub const DURATION_S: f64 = 4.0;
/// h: step, s; the prototype's control loop ran at it.
pub const STEP_S: f64 = 0.008_3;
/// Half the work space, rad: the stops are at ±45°.
pub const HALF_STROKE_RAD: f64 = std::f64::consts::FRAC_PI_4;
/// Lever length with which the thesis' figures are reproduced, m: (10) read as M_O θ̈. Inferred:
/// with less than 0.5889 m its step lies outside the stability region of its method.
pub const LEVER_M: f64 = 1.0;
/// Largest motor force of the simulation's chattering scene, N.
pub const MOTOR_N: f64 = 3.25;
/// A force of a finger's usual size, N: a of the simulation's chattering scene.
pub(crate) const FORCE_N: f64 = 2.15;
/// A velocity of the lever's usual size, rad/s: the stroke in some seconds.
pub(crate) const VELOCITY_RAD_S: f64 = 1.0;
/// A dry friction's usual size, N, and a viscous one's, N s/rad: the twin's.
pub(crate) const FRICTION_N: f64 = 0.2;
/// See [`FRICTION_N`].
pub(crate) const VISCOUS_NS_PER_RAD: f64 = 0.02;
/// The brake's usual lags of engaging and letting go, s: the twin's.
pub(crate) const BRAKE_LAGS_S: [f64; 2] = [0.015, 0.010];
/// Largest brake force, N at 8 V (§5.1).
pub const BRAKE_N: f64 = 13.0;
/// Angle of the virtual wall, rad: 26.6° (§5.3.2).
pub const WALL_RAD: f64 = 26.6 * std::f64::consts::PI / 180.0;
