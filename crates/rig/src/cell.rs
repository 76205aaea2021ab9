//! The load cell: its zero, its scale by known masses, and whether it stands still.

use zwidth_device::Weighed;
use zwidth_numerics::moments::Moments;

/// Standard gravity, m/s² (CGPM 1901).
pub(crate) const GRAVITY_M_S2: f64 = 9.806_65;

/// Fewer values say nothing about a load.
const LEAST_VALUES: usize = 10;

/// A load that is still changes by no more than this from one half of its values to the other, N…
const STILL_N: f64 = 0.02;

/// …or by so many standard errors of that difference, for a noisy cell.
const STILL_ERRORS: f64 = 6.0;

/// A mass may differ from the line through zero and all masses by this share of the largest force…
const MASS_SHARE: f64 = 0.01;

/// …or by so much, N.
const MASS_N: f64 = 0.01;

/// Force shown per force there beyond which `rig.toml` is wrong about the cell, as a share.
pub(crate) const SCALE_ERROR: f64 = 0.03;

/// Force shown per force there that no correction is made for: a digit of `rig.toml` is wrong.
const SCALE_RANGE: [f64; 2] = [0.5, 2.0];

/// A load at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Still {
    /// Mean force shown, N.
    pub force_n: f64,
    /// Its standard deviation, N.
    pub noise_n: f64,
    /// How much the second half differs from the first, N.
    pub drift_n: f64,
}

/// Why a load does not count.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CellFault {
    /// Hardly a value came.
    #[error("only {count} values of the load cell came: check its amplifier and its cable")]
    Few {
        /// How many.
        count: usize,
    },
    /// The load moved, or the cell drifts.
    #[error(
        "the force went by {drift_n:.3} N while nothing was to move: wait until the load hangs still and the cell is warm; if \
         it goes on, the cell drifts: check its cable, its glue and its supply"
    )]
    NotStill {
        /// By how much, N.
        drift_n: f64,
    },
    /// The masses do not lie on one line with zero.
    #[error(
        "the masses do not agree: by the others, the one called {mass_kg} kg is {seen_kg:.4} kg. Weigh it, give its true mass with \
         --mass, and begin again"
    )]
    WrongMass {
        /// The one that is farthest off, kg.
        mass_kg: f64,
        /// What the others make of it, kg.
        seen_kg: f64,
    },
    /// Two masses cannot say which of them is wrong.
    #[error(
        "the two masses do not agree: {first_kg} kg shows {first_n:.3} N and {second_kg} kg {second_n:.3} N. One of them is wrong; a \
         third with --mass shows which"
    )]
    TwoMasses {
        /// The first, kg.
        first_kg: f64,
        /// What it shows without zero, N.
        first_n: f64,
        /// The second, kg.
        second_kg: f64,
        /// What it shows without zero, N.
        second_n: f64,
    },
    /// The scale in `rig.toml` is far off.
    #[error(
        "the load cell shows {scale:.3} N for each newton there: write newtons_per_count = {newtons_per_count:e} into rig.toml (below 0: \
         the cell is mounted the wrong way round)"
    )]
    Scale {
        /// Force shown per force there.
        scale: f64,
        /// What it must be, N.
        newtons_per_count: f64,
    },
}

/// A known mass that hung from the cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Load {
    /// The mass, kg.
    pub mass_kg: f64,
    /// What the cell showed.
    pub seen: Still,
}

/// What is known of a load cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadCell {
    /// What it shows without a load, N.
    pub zero_n: f64,
    /// Force shown per force there.
    pub scale: f64,
    /// Standard error of the scale, from how the masses scatter about its line.
    pub scale_error: f64,
    /// Standard deviation of a value, N.
    pub noise_n: f64,
}

impl LoadCell {
    /// The force that is there when this one is shown, N.
    pub fn force_n(&self, shown_n: f64) -> f64 {
        (shown_n - self.zero_n) / self.scale
    }
}

/// Whether a load is still, and what it shows.
///
/// # Errors
/// Too few values; a force that moves.
pub fn still(values: &[Weighed]) -> Result<Still, CellFault> {
    if values.len() < LEAST_VALUES {
        return Err(CellFault::Few { count: values.len() });
    }
    let forces: Vec<f64> = values.iter().map(|value| value.force_n).collect();
    let whole = Moments::of(&forces);
    let noise_n = whole.sd().unwrap_or(0.0);
    let half = forces.len() / 2;
    let drift_n = Moments::of(&forces[half..]).mean - Moments::of(&forces[..half]).mean;
    let error_n = noise_n * 2.0 / (forces.len() as f64).sqrt();
    // The noise of a cell that drifts is its drift: held to what a load may move by at most.
    if drift_n.abs() > STILL_N.max(STILL_ERRORS * error_n.min(STILL_N)) {
        return Err(CellFault::NotStill { drift_n });
    }
    Ok(Still { force_n: whole.mean, noise_n, drift_n })
}

/// Zero and scale of the cell, by least squares through its zero: s = Σ w f / Σ w², with w = m g and
/// f the force shown less that without a load. `newtons_per_count` is that of `rig.toml`.
///
/// # Errors
/// Masses that do not agree; a scale that no correction is made for.
pub fn load_cell(
    zero: Still,
    loads: &[Load],
    newtons_per_count: f64,
) -> Result<LoadCell, CellFault> {
    let points: Vec<[f64; 2]> = loads
        .iter()
        .map(|load| [load.mass_kg * GRAVITY_M_S2, load.seen.force_n - zero.force_n])
        .collect();
    let scale = slope(points.iter());
    let largest_n = points.iter().map(|[weight_n, _]| weight_n.abs()).fold(0.0, f64::max);
    let tolerance_n = MASS_N.max(MASS_SHARE * largest_n);
    let is_off = |[weight_n, shown_n]: &[f64; 2], scale: f64| {
        ((shown_n - scale * weight_n) / scale.abs().max(f64::MIN_POSITIVE)).abs()
    };
    if points.iter().any(|point| is_off(point, scale) > tolerance_n) {
        return Err(wrong_mass(loads, &points));
    }
    if !(SCALE_RANGE[0]..=SCALE_RANGE[1]).contains(&scale) {
        let newtons_per_count = newtons_per_count / scale;
        return Err(CellFault::Scale { scale, newtons_per_count });
    }
    let weights: f64 = points.iter().map(|[weight_n, _]| weight_n * weight_n).sum();
    let residuals: f64 = points
        .iter()
        .map(|[weight_n, shown_n]| shown_n - scale * weight_n)
        .map(|residual| residual * residual)
        .sum();
    // The zero is measured too: as many masses, as many degrees of freedom but one.
    let df = points.len().saturating_sub(1).max(1) as f64;
    let scale_error = (residuals / df / weights).sqrt();
    let noise_n = loads.iter().map(|load| load.seen.noise_n).fold(zero.noise_n, f64::max);
    Ok(LoadCell { zero_n: zero.force_n, scale, scale_error, noise_n })
}

fn slope<'a>(points: impl Iterator<Item = &'a [f64; 2]>) -> f64 {
    let (mut up, mut down) = (0.0, 0.0);
    for [weight_n, shown_n] in points {
        up += weight_n * shown_n;
        down += weight_n * weight_n;
    }
    up / down
}

/// The mass without which the others agree best.
fn wrong_mass(loads: &[Load], points: &[[f64; 2]]) -> CellFault {
    if let ([first, second], [[_, first_n], [_, second_n]]) = (loads, points) {
        return CellFault::TwoMasses {
            first_kg: first.mass_kg,
            first_n: *first_n,
            second_kg: second.mass_kg,
            second_n: *second_n,
        };
    }
    let left = |out: usize| {
        let others: Vec<&[f64; 2]> =
            points.iter().enumerate().filter(|(i, _)| *i != out).map(|(_, point)| point).collect();
        let scale = slope(others.iter().copied());
        let rss: f64 = others
            .iter()
            .map(|[weight_n, shown_n]| shown_n - scale * weight_n)
            .map(|residual| residual * residual)
            .sum();
        (rss, scale)
    };
    let mut worst = (0, left(0));
    for i in 1..points.len() {
        let without = left(i);
        if without.0 < worst.1.0 {
            worst = (i, without);
        }
    }
    let (place, (_, scale)) = worst;
    let seen_kg = points[place][1] / scale / GRAVITY_M_S2;
    CellFault::WrongMass { mass_kg: loads[place].mass_kg, seen_kg }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(force_n: f64) -> Still {
        Still { force_n, noise_n: 0.002, drift_n: 0.0 }
    }

    /// What a cell of such a scale shows of masses, and what they are called.
    fn loads(scale: f64, masses: &[(f64, f64)]) -> Vec<Load> {
        let load = |(there_kg, called_kg): &(f64, f64)| Load {
            mass_kg: *called_kg,
            seen: at(0.05 + scale * there_kg * GRAVITY_M_S2),
        };
        masses.iter().map(load).collect()
    }

    #[test]
    fn masses_give_zero_and_scale() {
        let cell = load_cell(at(0.05), &loads(0.98, &[(0.1, 0.1), (0.2, 0.2)]), 1e-4).unwrap();
        assert!((cell.scale - 0.98).abs() < 1e-12 && cell.scale_error < 1e-12, "{cell:?}");
        assert!((cell.force_n(0.05 + 0.98 * 3.0) - 3.0).abs() < 1e-12);
    }

    #[test]
    fn of_two_masses_a_wrong_one_is_found_and_of_three_it_is_named() {
        let two = load_cell(at(0.05), &loads(1.0, &[(0.1, 0.1), (0.2, 0.25)]), 1e-4).unwrap_err();
        assert!(matches!(two, CellFault::TwoMasses { .. }), "{two}");
        let three = [(0.1, 0.1), (0.2, 0.25), (0.5, 0.5)];
        let three = load_cell(at(0.05), &loads(1.0, &three), 1e-4).unwrap_err();
        let CellFault::WrongMass { mass_kg, seen_kg } = three else { panic!("{three}") };
        assert_eq!(mass_kg.to_bits(), 0.25_f64.to_bits());
        assert!((seen_kg - 0.2).abs() < 1e-9, "{seen_kg}");
    }

    #[test]
    fn a_cell_that_counts_down_or_is_far_off_is_refused_with_what_to_write() {
        for scale in [-1.0, 0.1, 3.0] {
            let error =
                load_cell(at(0.05), &loads(scale, &[(0.1, 0.1), (0.2, 0.2)]), 1e-4).unwrap_err();
            let CellFault::Scale { newtons_per_count, .. } = error else { panic!("{error}") };
            assert!((newtons_per_count - 1e-4 / scale).abs() < 1e-12, "{error}");
        }
    }

    #[test]
    fn a_force_that_drifts_is_not_still_and_one_that_flickers_is() {
        let of = |force_n: &dyn Fn(f64) -> f64| {
            let value = |i: u32| Weighed {
                t_s: f64::from(i) * 0.0125,
                voltage_v: 0.0,
                force_n: force_n(f64::from(i)),
                theta_rad: None,
            };
            still(&(0..160).map(value).collect::<Vec<_>>())
        };
        let flickers = of(&|i| 1.0 + 0.01 * if i % 2.0 > 0.5 { 1.0 } else { -1.0 }).unwrap();
        assert!((flickers.force_n - 1.0).abs() < 1e-9);
        assert!(matches!(of(&|i| 1e-3 * i), Err(CellFault::NotStill { .. })));
        assert!(matches!(still(&[]), Err(CellFault::Few { count: 0 })));
    }
}
