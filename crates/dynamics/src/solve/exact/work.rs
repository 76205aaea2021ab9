//! Work integrals of a region, exact like its flow: ∫ (f · z)(v · z) dt is a quadratic form of the
//! state at the start, and the form doubles along with the flow: W(2s) = W(s) + Φ(s)ᵀ W(s) Φ(s).

use zwidth_numerics::expm::{self, Ladder, Matrix, dot};

use crate::energy::PARTS;
use crate::solve::shorten;
use crate::system::region::Region;
use crate::system::{System, THETA};

/// Nodes and weights of Gauss–Legendre quadrature on [0, 1], exact to degree 11 (Abramowitz &
/// Stegun 25.4.30): as far as the Taylor series of the flow over the lowest rung matters.
const GAUSS: [(f64, f64); 6] = [
    (0.033_765_242_898_423_99, 0.085_662_246_189_585_17),
    (0.169_395_306_766_867_74, 0.180_380_786_524_069_3),
    (0.380_690_406_958_401_55, 0.233_956_967_286_345_52),
    (0.619_309_593_041_598_5, 0.233_956_967_286_345_52),
    (0.830_604_693_233_132_3, 0.180_380_786_524_069_3),
    (0.966_234_757_101_576, 0.085_662_246_189_585_17),
];

/// One part with a power: its force, its velocity, and its forms over the ladder's rungs.
#[derive(Debug, Clone)]
struct Part<const N: usize> {
    place: usize,
    force: [f64; N],
    velocity: [f64; N],
    rungs: Vec<Matrix<N>>,
}

/// The parts of a region that do work.
///
/// The angle is measured from where the region's spring rests: forces are then small where they
/// should be, and not differences of large numbers.
#[derive(Debug, Clone)]
pub(super) struct Work<const N: usize, const D: usize> {
    rest_rad: f64,
    ladder: Ladder<N, D>,
    parts: Vec<Part<N>>,
}

/// Work by part, in the order of the balance.
pub(super) type Sums = [f64; PARTS];

impl<const N: usize, const D: usize> Work<N, D> {
    pub(super) fn new(system: &System, region: &Region, a: &Matrix<N>, reach_s: f64) -> Self {
        let rest_rad = system.rest_rad(region);
        let rows: [[f64; N]; N] =
            std::array::from_fn(|i| shifted(std::array::from_fn(|j| a.at(i, j)), rest_rad));
        let ladder = Ladder::new(Matrix::from_fn(|i, j| rows[i][j]), reach_s);
        let mut parts = Vec::new();
        for (place, (force, velocity)) in system.powers(region).into_iter().enumerate() {
            let [force, velocity] =
                [force, velocity].map(|row| shifted(shorten::<N>(&row.0), rest_rad));
            // A part without force or velocity does no work, and its forms would cost as much.
            if [force, velocity].iter().all(|row| row.iter().any(|&x| x != 0.0)) {
                parts.push(Part::new(place, force, velocity, &ladder));
            }
        }
        Self { rest_rad, ladder, parts }
    }

    /// Adds the work over `span` seconds from `z` on.
    pub(super) fn add(&self, z: &[f64; N], span: f64, sums: &mut Sums) {
        let mut z = *z;
        let mut rest = span;
        z[THETA] -= self.rest_rad;
        for (level, rung) in self.ladder.rungs.iter().enumerate().rev() {
            if rung.span <= rest {
                for part in &self.parts {
                    sums[part.place] += part.rungs[level].quadratic(&z);
                }
                z = rung.flow.apply(&z);
                rest -= rung.span;
            }
        }
        // Less than the lowest rung is left: by quadrature along the Taylor series.
        if rest > 0.0 {
            let series = expm::taylor::<N, D>(&self.ladder.a, &z);
            for (node, weight) in GAUSS {
                let state = expm::evaluate(&series, node * rest);
                for part in &self.parts {
                    let power = dot(&part.force, &state) * dot(&part.velocity, &state);
                    sums[part.place] += weight * rest * power;
                }
            }
        }
    }
}

/// A row for states whose angle is measured from `rest_rad`: w · z = w · (z with θ − rest) + w_θ
/// rest, which joins the constant entry.
fn shifted<const N: usize>(row: [f64; N], rest_rad: f64) -> [f64; N] {
    std::array::from_fn(|j| if j == N - 1 { row[j] + row[THETA] * rest_rad } else { row[j] })
}

impl<const N: usize> Part<N> {
    fn new<const D: usize>(
        place: usize,
        force: [f64; N],
        velocity: [f64; N],
        ladder: &Ladder<N, D>,
    ) -> Self {
        // The power as a symmetric form.
        let power = Matrix::from_fn(|i, j| 0.5 * (force[i] * velocity[j] + force[j] * velocity[i]));
        let span = ladder.rungs[0].span;
        let mut lowest = Matrix::<N>::ZERO;
        for (node, weight) in GAUSS {
            let seen = ladder.flow(node * span).congruence(&power);
            lowest = lowest.zip(&seen, |a, b| a + weight * span * b);
        }
        let mut rungs = vec![lowest];
        for rung in &ladder.rungs[..ladder.rungs.len() - 1] {
            let form = &rungs[rungs.len() - 1];
            let next = form.zip(&rung.flow.congruence(form), |a, b| a + b);
            rungs.push(next);
        }
        Self { place, force, velocity, rungs }
    }
}
