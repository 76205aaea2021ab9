//! A region made ready: its flows over a ladder of spans, and bounds that prove a span free of
//! events.

use zwidth_numerics::expm::{self, Ladder, ORDER, Rung};
use zwidth_numerics::roots;

use super::parameters::DrivenParameters;
use super::region::{GUARDS, N, Region, StateRow, guards, matrix};

/// Events are located to this share of the lowest rung's span: some 1e-21 s.
const RESOLUTION: f64 = 1e-15;

/// Values of the guards at a state.
pub(super) type Guards = [f64; GUARDS];

/// Flows, guards and bounds of one region.
#[derive(Debug, Clone)]
pub(super) struct Compiled {
    ladder: Ladder<N>,
    guards: [StateRow; GUARDS],
    /// For each rung, how far each guard can sag below its chord, per |ż| at the start.
    sags: Vec<[StateRow; GUARDS]>,
}

/// Where a piece ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Piece {
    /// How long it was, s.
    pub(super) span_s: f64,
    /// The guard that fell below zero at its end.
    pub(super) event: Option<usize>,
}

impl Compiled {
    /// The region, ready for steps of up to `reach_s`.
    pub(super) fn new(parameters: &DrivenParameters, region: Region, reach_s: f64) -> Self {
        let ladder = Ladder::new(matrix(parameters, region), reach_s);
        let guards = guards(parameters, region);
        let sags = ladder.rungs.iter().map(|rung| guards.map(|w| sag(&ladder, &w, rung))).collect();
        Self { ladder, guards, sags }
    }

    /// Moves `z` as far as one step reaches within `rest_s`, or to the first event. Guards in
    /// `blind` are not looked at: the lever is at rest against a stop, which pushes back as
    /// hard as it must.
    #[inline]
    pub(super) fn step(&self, z: &mut StateRow, rest_s: f64, blind: Option<usize>) -> Piece {
        let rate = self.ladder.a.apply_affine(z).map(f64::abs);
        let before = self.values(z, blind);
        for (rung, sags) in self.ladder.rungs.iter().zip(&self.sags).rev() {
            if rung.span > rest_s {
                continue;
            }
            let next = rung.flow.apply_affine(z);
            if is_free(sags, &rate, &before, &self.values(&next, blind)) {
                *z = next;
                return Piece { span_s: rung.span, event: None };
            }
        }
        self.short_step(z, rest_s.min(self.ladder.rungs[0].span), blind)
    }

    /// The same over a span no longer than the lowest rung, by Taylor polynomials.
    fn short_step(&self, z: &mut StateRow, span_s: f64, blind: Option<usize>) -> Piece {
        let series = expm::taylor(&self.ladder.a, z);
        let mut piece = Piece { span_s, event: None };
        for (i, w) in self.guards.iter().enumerate().filter(|(i, _)| Some(*i) != blind) {
            let p: [f64; ORDER + 1] = series.map(|c| expm::dot(w, &c));
            let found =
                roots::first_descent(&p, piece.span_s, self.ladder.rungs[0].span * RESOLUTION);
            if let Some(t) = found.filter(|&t| t < piece.span_s || piece.event.is_none()) {
                piece = Piece { span_s: t, event: Some(i) };
            }
        }
        *z = expm::evaluate(&series, piece.span_s);
        piece
    }

    #[inline]
    fn values(&self, z: &StateRow, blind: Option<usize>) -> Guards {
        std::array::from_fn(|i| {
            if Some(i) == blind { f64::INFINITY } else { expm::dot(&self.guards[i], z) }
        })
    }
}

/// Most that a guard w can sag below its chord over a span, per |ż(0)|. With ż(t) = exp(A t) ż(0)
/// and an envelope E of the flows, |g''(t)| ≤ |w A| E |ż(0)|, and a curve sags at most max|g''|
/// span²/8.
fn sag(ladder: &Ladder<N>, w: &StateRow, rung: &Rung<N>) -> StateRow {
    let bend: StateRow = std::array::from_fn(|j| expm::dot(w, &ladder.a.columns[j]).abs());
    let eighth = rung.span * rung.span / 8.0;
    std::array::from_fn(|j| expm::dot(&bend, &rung.envelope.columns[j]) * eighth)
}

/// Whether no guard can have been below zero between two points.
#[inline]
fn is_free(sags: &[StateRow; GUARDS], rate: &StateRow, before: &Guards, after: &Guards) -> bool {
    (0..GUARDS).all(|i| before[i].min(after[i]) >= expm::dot(&sags[i], rate))
}
