//! The pieces of the dynamics: in each, the motion is linear, and a few functionals tell where it
//! ends.

use zwidth_numerics::expm::{Ladder, Matrix};

use super::parameters::DrivenParameters;
use crate::affine;
use crate::system::region::Motion;

/// Entries of the state.
pub(super) const N: usize = 12;
/// Entries that the later ones, commands and intent, do not depend on.
pub(super) const DYNAMIC: usize = 7;
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
type Row = affine::Row<N>;

/// A region made ready.
pub(super) type ReadyFlow = affine::ReadyFlow<N, DYNAMIC, GUARDS>;

/// A lever at rest holds, and a tissue in contact clings, by this much more than it should, N: far
/// below any force that matters and far above rounding. What departs or lifts off is then pushed on
/// for certain; else rounding could send it back and forth without end.
const MARGIN_N: f64 = 1e-11;

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
        // `Region::all` repeats the order of the motions by hand.
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
fn row<const T: usize>(terms: [(usize, f64); T]) -> Row {
    terms.iter().fold(Row::ZERO, |sum, &(entry, factor)| sum.plus(Row::entry(entry, factor)))
}

/// F_ex = K_F δ + B_F (v_h − L θ̇) in contact, 0 else.
pub(super) fn contact_force(parameters: &DrivenParameters, contact: bool) -> Row {
    let Some(hand) = parameters.hand.filter(|_| contact) else { return Row::ZERO };
    let k = hand.tissue.stiffness_n_per_m;
    let b = hand.tissue.damping_ns_per_m;
    row([(DEPTH, k), (HAND_V, b), (OMEGA, -b * parameters.lever_m)])
}

/// F_m + F_ex: what would move a lever that is held.
fn drive(parameters: &DrivenParameters, contact: bool) -> Row {
    Row::entry(MOTOR, 1.0).plus(contact_force(parameters, contact))
}

/// A region made ready for steps of up to `reach_s`.
pub(super) fn flow(parameters: &DrivenParameters, region: Region, reach_s: f64) -> ReadyFlow {
    ReadyFlow::new(Ladder::new(matrix(parameters, region), reach_s), guards(parameters, region))
}

/// The matrix A of ż = A z in a region.
fn matrix(parameters: &DrivenParameters, region: Region) -> Matrix<N> {
    let mut rows = [Row::ZERO; N];
    if region.motion != Motion::Rest {
        rows[THETA] = Row::entry(OMEGA, 1.0);
        let sign = region.motion.sign();
        let resisting = row([
            (OMEGA, -parameters.viscous_ns_per_rad()),
            (BRAKE, -sign),
            (ONE, -sign * parameters.dry().kinetic_n),
        ]);
        let net = drive(parameters, region.contact).plus(resisting);
        rows[OMEGA] = net.times(1.0 / parameters.mass_kg_m());
    }
    if let Some(lag) = parameters.motor_lag_s {
        rows[MOTOR] = row([(MOTOR_COMMAND, 1.0 / lag), (MOTOR, -1.0 / lag)]);
    }
    if let Some([on, off]) = parameters.brake_lag_on_off_s {
        let lag = if region.letting_go { off } else { on };
        rows[BRAKE] = row([(BRAKE_COMMAND, 1.0 / lag), (BRAKE, -1.0 / lag)]);
    }
    if let Some(hand) = &parameters.hand {
        let k = hand.stiffness_n_per_m;
        let b = hand.damping_ns_per_m;
        let l = parameters.lever_m;
        let pull = row([(INTENT, 1.0), (THETA, -k * l), (DEPTH, -k), (GAP, k), (HAND_V, -b)]);
        let push = contact_force(parameters, region.contact);
        rows[HAND_V] = pull.plus(push.times(-1.0)).times(1.0 / hand.mass_kg);
        rows[INTENT] = Row::entry(INTENT_RATE, 1.0);
        let lever_v = if region.motion == Motion::Rest { 0.0 } else { l };
        if region.contact {
            rows[DEPTH] = row([(HAND_V, 1.0), (OMEGA, -lever_v)]);
        } else {
            // A free tissue has no force: K_F δ + B_F δ̇ = 0, whatever the hand does.
            let relaxing = hand.tissue.stiffness_n_per_m / hand.tissue.damping_ns_per_m;
            rows[DEPTH] = Row::entry(DEPTH, -relaxing);
            rows[GAP] = row([(OMEGA, lever_v), (DEPTH, -relaxing), (HAND_V, -1.0)]);
        }
    }
    Matrix::from_fn(|i, j| rows[i].0[j])
}

/// The guards of a region; one that cannot end it holds the constant 1.
fn guards(parameters: &DrivenParameters, region: Region) -> [[f64; N]; GUARDS] {
    let always = Row::entry(ONE, 1.0);
    let sign = region.motion.sign();
    let (first, second) = match (region.motion, parameters.stops_rad) {
        (Motion::Rest, _) => {
            // b + F_s, and the margin: what can hold the lever.
            let holding = row([(BRAKE, 1.0), (ONE, parameters.dry().static_n + MARGIN_N)]);
            let drive = drive(parameters, region.contact);
            (holding.plus(drive.times(-1.0)), holding.plus(drive))
        }
        (_, None) => (Row::entry(OMEGA, sign), always),
        (_, Some([low, high])) => {
            let ahead = if sign > 0.0 { high } else { low };
            (Row::entry(OMEGA, sign), row([(ONE, sign * ahead), (THETA, -sign)]))
        }
    };
    let contact = match (region.contact, parameters.hand) {
        (_, None) => always,
        (true, Some(_)) => contact_force(parameters, true).plus(Row::entry(ONE, MARGIN_N)),
        (false, Some(_)) => Row::entry(GAP, 1.0),
    };
    [first.0, second.0, contact.0]
}
