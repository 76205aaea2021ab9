//! A point of a map, and its quantities.

use zwidth_dynamics::{DryLimits, RidingFinger, SampledWall};
use zwidth_results::WallQuantity;

/// A device with its wall, as one point of every map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// The sampled wall, at the lever's end.
    pub wall: SampledWall,
    /// L, m: what stiffnesses and dampings in N/rad become ones in N/m by.
    pub lever_m: f64,
    /// h: step of the solvers, s.
    pub step_s: f64,
    /// Dry friction and one count of the angle, for the formulas that ask for them.
    pub dry: Option<DryLimits>,
}

/// The fingertip of Table 3 without its stiffness: M_F, kg; B_F, N s/m.
const FINGER: (f64, f64) = (0.021, 1.53);

impl Point {
    /// The value of a quantity here; `None` for a finger or a wall that the point does not have.
    pub fn value(&self, quantity: WallQuantity) -> Option<f64> {
        let wall = &self.wall;
        Some(match quantity {
            WallQuantity::Step => self.step_s,
            WallQuantity::Mass => wall.mass_kg,
            WallQuantity::Damping => wall.damping_ns_per_m,
            WallQuantity::WallDamping => wall.wall_damping_ns_per_m,
            WallQuantity::Stiffness => Some(wall.stiffness_n_per_m).filter(|k| *k > 0.0)?,
            WallQuantity::Lever => self.lever_m,
            WallQuantity::Finger => wall.finger?.stiffness_n_per_m,
            WallQuantity::Delay => wall.delay_s,
            WallQuantity::Rate => 1.0 / wall.period_s,
        })
    }

    /// The point with another value of a quantity.
    #[must_use]
    pub fn with(&self, quantity: WallQuantity, value: f64) -> Self {
        let mut point = *self;
        let wall = &mut point.wall;
        match quantity {
            WallQuantity::Step => point.step_s = value,
            WallQuantity::Mass => wall.mass_kg = value,
            WallQuantity::Damping => wall.damping_ns_per_m = value,
            WallQuantity::WallDamping => wall.wall_damping_ns_per_m = value,
            WallQuantity::Stiffness => wall.stiffness_n_per_m = value,
            WallQuantity::Lever => {
                // Stiffness and damping about the axis stay: per metre at the end they fall with L.
                let share = point.lever_m / value;
                wall.stiffness_n_per_m *= share;
                wall.wall_damping_ns_per_m *= share;
                wall.damping_ns_per_m *= share;
                point.lever_m = value;
            }
            WallQuantity::Finger => {
                let (mass_kg, damping_ns_per_m) =
                    wall.finger.map_or(FINGER, |f| (f.mass_kg, f.damping_ns_per_m));
                let finger = RidingFinger { mass_kg, stiffness_n_per_m: value, damping_ns_per_m };
                wall.finger = Some(finger);
            }
            WallQuantity::Delay => wall.delay_s = value,
            WallQuantity::Rate => wall.period_s = 1.0 / value,
        }
        point
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_put_into_a_point_is_read_from_it() {
        let bare = Point {
            wall: SampledWall::bare(0.1, 2.0, 0.001),
            lever_m: 0.05,
            step_s: 0.001,
            dry: None,
        };
        assert_eq!(bare.value(WallQuantity::Finger), None);
        assert_eq!(bare.value(WallQuantity::Stiffness), None, "a device without a wall");
        for quantity in WallQuantity::ALL.iter().copied() {
            let value = bare.with(quantity, 0.25).value(quantity).unwrap();
            assert!((value - 0.25).abs() < 1e-12, "{quantity:?}: {value}");
        }
    }
}
