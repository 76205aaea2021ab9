//! The pieces of the dynamics: in each the motion is linear, and a few functionals tell where it
//! ends.

use zwidth_numerics::expm::Matrix;

use super::parameters::{DrivenParameters, Hand};

/// Entries of the state.
pub(super) const N: usize = 12;
/// θ, rad.
pub(super) const THETA: usize = 0;
/// θ̇, rad/s.
pub(super) const OMEGA: usize = 1;
/// F_m, N.
pub(super) const MOTOR: usize = 2;
/// b, N.
pub(super) const BRAKE: usize = 3;
/// v_h, m/s.
pub(super) const HAND_V: usize = 4;
/// δ: how far the tissue is pressed, m.
pub(super) const DEPTH: usize = 5;
/// Air between tissue and lever, m; 0 in contact. The hand is at s_h = L θ + δ − gap.
pub(super) const GAP: usize = 6;
/// F_cmd, N, held.
pub(super) const MOTOR_COMMAND: usize = 7;
/// b_cmd, N, held.
pub(super) const BRAKE_COMMAND: usize = 8;
/// K p + B ṗ: the intent as a force, N.
pub(super) const INTENT: usize = 9;
/// Slope of the intent's force, N/s, held.
pub(super) const INTENT_RATE: usize = 10;
/// The constant 1.
pub(super) const ONE: usize = 11;

/// Functionals that are not below zero inside a region.
pub(super) const GUARDS: usize = 3;
/// First guard: in motion θ̇ keeps its direction; at rest the lever is not pushed forward.
pub(super) const FIRST: usize = 0;
/// Second guard: in motion the stop ahead is not reached; at rest the lever is not pushed backward.
pub(super) const SECOND: usize = 1;
/// Third guard: the tissue stays as it is, in contact or free.
pub(super) const CONTACT: usize = 2;

/// A linear functional of the state.
pub(super) type StateRow = [f64; N];

/// A lever at rest holds, and a tissue in contact clings, by this much more than it should, N: far
/// below any force that matters and far above rounding. What departs or lifts off is then pushed on
/// for certain; else rounding could send it back and forth without end.
const MARGIN_N: f64 = 1e-11;

/// Which way the lever moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Motion {
    /// θ̇ > 0, or about to be.
    Forward,
    /// θ̇ < 0, or about to be.
    Backward,
    /// θ̇ = 0.
    Rest,
}

impl Motion {
    /// Sign of θ̇.
    pub(super) fn sign(self) -> f64 {
        match self {
            Self::Forward => 1.0,
            Self::Backward => -1.0,
            Self::Rest => 0.0,
        }
    }
}

/// One piece of the dynamics.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Region {
    pub(super) motion: Motion,
    /// The tissue touches the lever.
    pub(super) contact: bool,
    /// The brake's level is falling, which has its own time constant.
    pub(super) letting_go: bool,
}

impl Region {
    /// At rest, nothing touching.
    pub(super) const START: Self = Self { motion: Motion::Rest, contact: false, letting_go: false };

    /// Its place among all regions.
    pub(super) fn index(self) -> usize {
        4 * (self.motion as usize) + 2 * usize::from(self.contact) + usize::from(self.letting_go)
    }

    /// Every region, in the order of [`Region::index`].
    pub(super) fn all() -> impl Iterator<Item = Self> {
        [Motion::Forward, Motion::Backward, Motion::Rest].into_iter().flat_map(|motion| {
            [(false, false), (false, true), (true, false), (true, true)]
                .map(|(contact, letting_go)| Self { motion, contact, letting_go })
        })
    }

    /// Whether a plant can be in it at all: without hand there is no contact, without lag one way
    /// of braking.
    pub(super) fn exists(self, parameters: &DrivenParameters) -> bool {
        (!self.contact || parameters.hand.is_some())
            && (!self.letting_go || parameters.brake_lag_on_off_s.is_some())
    }
}

/// `Σ terms` as a row.
fn row<const T: usize>(terms: [(usize, f64); T]) -> StateRow {
    let mut row = [0.0; N];
    for (entry, factor) in terms {
        row[entry] += factor;
    }
    row
}

fn plus(a: StateRow, b: StateRow) -> StateRow {
    std::array::from_fn(|j| a[j] + b[j])
}

fn times(a: StateRow, factor: f64) -> StateRow {
    a.map(|x| factor * x)
}

/// F_ex = K_F δ + B_F (v_h − L θ̇) in contact, 0 else.
pub(super) fn contact_force(parameters: &DrivenParameters, contact: bool) -> StateRow {
    let Some(hand) = parameters.hand.filter(|_| contact) else { return [0.0; N] };
    let (k, b) = (hand.tissue.stiffness_n_per_m, hand.tissue.damping_ns_per_m);
    row([(DEPTH, k), (HAND_V, b), (OMEGA, -b * parameters.lever_m)])
}

/// F_m + F_ex: what would move a lever that is held.
fn drive(parameters: &DrivenParameters, contact: bool) -> StateRow {
    plus(row([(MOTOR, 1.0)]), contact_force(parameters, contact))
}

/// b + F_s, and the margin: what can hold it.
fn holding(parameters: &DrivenParameters) -> StateRow {
    row([(BRAKE, 1.0), (ONE, parameters.dry().static_n + MARGIN_N)])
}

/// The matrix A of ż = A z in a region.
pub(super) fn matrix(parameters: &DrivenParameters, region: Region) -> Matrix<N> {
    let mut rows = [[0.0; N]; N];
    if region.motion != Motion::Rest {
        rows[THETA] = row([(OMEGA, 1.0)]);
        rows[OMEGA] = acceleration(parameters, region);
    }
    if let Some(lag) = parameters.motor_lag_s {
        rows[MOTOR] = row([(MOTOR_COMMAND, 1.0 / lag), (MOTOR, -1.0 / lag)]);
    }
    if let Some([on, off]) = parameters.brake_lag_on_off_s {
        let lag = if region.letting_go { off } else { on };
        rows[BRAKE] = row([(BRAKE_COMMAND, 1.0 / lag), (BRAKE, -1.0 / lag)]);
    }
    if let Some(hand) = &parameters.hand {
        hand_rows(parameters, hand, region, &mut rows);
    }
    Matrix::from_fn(|i, j| rows[i][j])
}

/// θ̈ of a lever in motion.
fn acceleration(parameters: &DrivenParameters, region: Region) -> StateRow {
    let sign = region.motion.sign();
    let resisting = row([
        (OMEGA, -parameters.viscous_ns_per_rad()),
        (BRAKE, -sign),
        (ONE, -sign * parameters.dry().kinetic_n),
    ]);
    times(plus(drive(parameters, region.contact), resisting), 1.0 / parameters.mass_kg_m())
}

fn hand_rows(parameters: &DrivenParameters, hand: &Hand, region: Region, rows: &mut [StateRow; N]) {
    let (k, b, l) = (hand.stiffness_n_per_m, hand.damping_ns_per_m, parameters.lever_m);
    let meant = row([(INTENT, 1.0), (THETA, -k * l), (DEPTH, -k), (GAP, k), (HAND_V, -b)]);
    let push = contact_force(parameters, region.contact);
    rows[HAND_V] = times(plus(meant, times(push, -1.0)), 1.0 / hand.mass_kg);
    rows[INTENT] = row([(INTENT_RATE, 1.0)]);
    let lever_v = if region.motion == Motion::Rest { 0.0 } else { l };
    if region.contact {
        rows[DEPTH] = row([(HAND_V, 1.0), (OMEGA, -lever_v)]);
    } else {
        let relaxing = hand.tissue.stiffness_n_per_m / hand.tissue.damping_ns_per_m;
        rows[DEPTH] = row([(DEPTH, -relaxing)]);
        rows[GAP] = row([(OMEGA, lever_v), (DEPTH, -relaxing), (HAND_V, -1.0)]);
    }
}

/// The guards of a region; one that cannot end it holds the constant 1.
pub(super) fn guards(parameters: &DrivenParameters, region: Region) -> [StateRow; GUARDS] {
    let always = row([(ONE, 1.0)]);
    let sign = region.motion.sign();
    let (first, second) = match (region.motion, parameters.stops_rad) {
        (Motion::Rest, _) => {
            let (holding, drive) = (holding(parameters), drive(parameters, region.contact));
            (plus(holding, times(drive, -1.0)), plus(holding, drive))
        }
        (_, None) => (row([(OMEGA, sign)]), always),
        (_, Some([low, high])) => {
            let ahead = if sign > 0.0 { high } else { low };
            (row([(OMEGA, sign)]), row([(ONE, sign * ahead), (THETA, -sign)]))
        }
    };
    let contact = match (region.contact, parameters.hand) {
        (_, None) => always,
        (true, Some(_)) => plus(contact_force(parameters, true), row([(ONE, MARGIN_N)])),
        (false, Some(_)) => row([(GAP, 1.0)]),
    };
    [first, second, contact]
}
