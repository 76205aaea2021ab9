//! What a map can be drawn over.

use serde::Serialize;
use zwidth_dynamics::{DryLimits, RidingFinger, SampledWall};

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

/// A quantity of a map's axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// h, the step of a solver.
    Step,
    /// M_O, the mass at the lever's end.
    Mass,
    /// b, the device's own damping.
    Damping,
    /// B_O, the wall's damping.
    WallDamping,
    /// K_O, the wall's stiffness.
    Stiffness,
    /// L, with stiffness and dampings in N/rad kept.
    Lever,
    /// K_F, the stiffness of a fingertip that rides on the lever.
    Finger,
    /// Delay from a measurement to its force.
    Delay,
    /// Rate of the controller.
    Rate,
}

/// The fingertip of Table 3 without its stiffness: M_F, kg; B_F, N s/m.
const FINGER: (f64, f64) = (0.021, 1.53);

/// What is known of a quantity: its word, symbol, unit on screens and how many of them one SI unit
/// is, ends of a usual axis in SI units, whether that is logarithmic.
struct About(&'static str, &'static str, &'static str, f64, [f64; 2], bool);

impl Quantity {
    /// Every quantity.
    pub const ALL: [Self; 9] = [
        Self::Step,
        Self::Mass,
        Self::Damping,
        Self::WallDamping,
        Self::Stiffness,
        Self::Lever,
        Self::Finger,
        Self::Delay,
        Self::Rate,
    ];

    fn about(self) -> About {
        match self {
            Self::Step => About("step", "step *h*", "ms", 1e3, [1e-4, 0.1], true),
            Self::Mass => About("mass", "mass *M*_{O}", "kg", 1.0, [0.002, 2.0], true),
            Self::Damping => {
                About("damping", "device damping *b*", "N s/m", 1.0, [0.1, 20.0], true)
            }
            Self::WallDamping => {
                About("wall_damping", "wall damping *B*", "N s/m", 1.0, [0.0, 20.0], false)
            }
            Self::Stiffness => {
                About("stiffness", "wall stiffness *K*", "N/m", 1.0, [10.0, 30_000.0], true)
            }
            Self::Lever => About("lever", "lever *L*", "mm", 1e3, [0.01, 1.0], true),
            Self::Finger => {
                About("finger", "finger stiffness *K*_{F}", "N/m", 1.0, [10.0, 10_000.0], true)
            }
            Self::Delay => About("delay", "delay", "ms", 1e3, [0.0, 0.05], false),
            Self::Rate => About("rate", "rate", "Hz", 1.0, [50.0, 5000.0], true),
        }
    }

    /// Its word on the command line and in tables.
    pub fn as_str(self) -> &'static str {
        self.about().0
    }

    /// Its name on an axis, as markup.
    pub fn label(self) -> &'static str {
        self.about().1
    }

    /// Its unit on screens.
    pub fn unit(self) -> &'static str {
        self.about().2
    }

    /// So many of the screen's units are one SI unit.
    pub fn per_si(self) -> f64 {
        self.about().3
    }

    /// Ends of a usual axis, SI.
    pub fn usual(self) -> [f64; 2] {
        self.about().4
    }

    /// Whether its axis is logarithmic.
    pub fn is_logarithmic(self) -> bool {
        self.about().5
    }

    /// Its value at a point; `None` for a finger or a wall that the point does not have.
    pub fn value(self, point: &Point) -> Option<f64> {
        let wall = &point.wall;
        Some(match self {
            Self::Step => point.step_s,
            Self::Mass => wall.mass_kg,
            Self::Damping => wall.damping_ns_per_m,
            Self::WallDamping => wall.wall_damping_ns_per_m,
            Self::Stiffness => Some(wall.stiffness_n_per_m).filter(|k| *k > 0.0)?,
            Self::Lever => point.lever_m,
            Self::Finger => wall.finger?.stiffness_n_per_m,
            Self::Delay => wall.delay_s,
            Self::Rate => 1.0 / wall.period_s,
        })
    }

    /// A point with another value of the quantity.
    pub fn put(self, point: &Point, value: f64) -> Point {
        let mut point = *point;
        let wall = &mut point.wall;
        match self {
            Self::Step => point.step_s = value,
            Self::Mass => wall.mass_kg = value,
            Self::Damping => wall.damping_ns_per_m = value,
            Self::WallDamping => wall.wall_damping_ns_per_m = value,
            Self::Stiffness => wall.stiffness_n_per_m = value,
            Self::Lever => {
                let share = point.lever_m / value;
                wall.stiffness_n_per_m *= share;
                wall.wall_damping_ns_per_m *= share;
                wall.damping_ns_per_m *= share;
                point.lever_m = value;
            }
            Self::Finger => {
                let (mass_kg, damping_ns_per_m) =
                    wall.finger.map_or(FINGER, |f| (f.mass_kg, f.damping_ns_per_m));
                let finger = RidingFinger { mass_kg, stiffness_n_per_m: value, damping_ns_per_m };
                wall.finger = Some(finger);
            }
            Self::Delay => wall.delay_s = value,
            Self::Rate => wall.period_s = 1.0 / value,
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
        assert_eq!(Quantity::Finger.value(&bare), None);
        assert_eq!(Quantity::Stiffness.value(&bare), None, "a device without a wall");
        for quantity in Quantity::ALL {
            let value = quantity.value(&quantity.put(&bare, 0.25)).unwrap();
            assert!((value - 0.25).abs() < 1e-12, "{quantity:?}: {value}");
        }
    }
}
