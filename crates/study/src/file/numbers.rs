//! The numbers of an environment: their keys in `study.toml`, between the units of these and SI.

use super::units::{MILLI, decimal, degrees};
use crate::model::{Coordinate, Environment};
use crate::scene::SceneNumber;

impl SceneNumber {
    /// Every number, in the order in which problems are reported.
    pub(super) const ALL: [Self; 5] =
        [Self::Stiffness, Self::Rest, Self::Wall, Self::Force, Self::Delay];

    /// Its keys in a rotational and in a linear study. What is not measured along the coordinate has the same key in
    /// both.
    pub(super) fn keys(self) -> [&'static str; 2] {
        match self {
            Self::Stiffness => ["stiffness_n_per_rad", "stiffness_n_per_mm"],
            Self::Rest => ["rest_deg", "rest_mm"],
            Self::Wall => ["wall_deg", "wall_mm"],
            Self::Force => ["force_n"; 2],
            Self::Delay => ["delay_ms"; 2],
        }
    }

    /// Its key in a study.
    fn key(self, coordinate: Coordinate) -> &'static str {
        let [rotational, linear] = self.keys();
        match coordinate {
            Coordinate::Rotational => rotational,
            Coordinate::Linear { .. } => linear,
        }
    }

    /// The unit of its key in a study.
    fn unit(self, coordinate: Coordinate) -> &'static str {
        match (self, coordinate) {
            (Self::Stiffness, Coordinate::Rotational) => "N/rad",
            (Self::Stiffness, Coordinate::Linear { .. }) => "N/mm",
            (Self::Rest | Self::Wall, Coordinate::Rotational) => "deg",
            (Self::Rest | Self::Wall, Coordinate::Linear { .. }) => "mm",
            (Self::Force, _) => "N",
            (Self::Delay, _) => "ms",
        }
    }

    /// The number in the unit of its key, from SI units.
    pub(super) fn typed(self, si: f64, coordinate: Coordinate) -> f64 {
        match (self, coordinate) {
            (Self::Rest | Self::Wall, Coordinate::Rotational) => degrees(si),
            (Self::Rest | Self::Wall, Coordinate::Linear { lever_m }) => {
                decimal(si * lever_m / MILLI)
            }
            (Self::Stiffness, Coordinate::Linear { lever_m }) => decimal(si / lever_m * MILLI),
            (Self::Stiffness, Coordinate::Rotational) | (Self::Force, _) => si,
            (Self::Delay, _) => decimal(si / MILLI),
        }
    }

    /// The number in SI units, from the unit of its key.
    pub(super) fn si(self, typed: f64, coordinate: Coordinate) -> f64 {
        match (self, coordinate) {
            (Self::Rest | Self::Wall, Coordinate::Rotational) => typed.to_radians(),
            (Self::Rest | Self::Wall, Coordinate::Linear { lever_m }) => typed * MILLI / lever_m,
            (Self::Stiffness, Coordinate::Linear { lever_m }) => typed * (lever_m / MILLI),
            (Self::Stiffness, Coordinate::Rotational) | (Self::Force, _) => typed,
            (Self::Delay, _) => typed * MILLI,
        }
    }
}

impl Environment {
    /// The keys of the numbers that its kind takes, such as `stiffness_n_per_rad`, and their units: what can be varied.
    pub fn keys(&self, coordinate: Coordinate) -> Vec<(&'static str, &'static str)> {
        let taken = SceneNumber::ALL.into_iter().filter(|n| self.scene.kind().takes(*n));
        taken.map(|n| (n.key(coordinate), n.unit(coordinate))).collect()
    }

    /// The number of a key, in the unit of this key; `None` if its kind does not take it.
    pub fn value(&self, key: &str, coordinate: Coordinate) -> Option<f64> {
        let number = self.number_of(key, coordinate)?;
        Some(number.typed(self.number(number)?, coordinate))
    }

    /// The same environment with another value of a number, in the unit of its key; `None` if its kind does not take it.
    /// The value is not judged: what a study accepts is the check of its file.
    pub fn varied(&self, key: &str, value: f64, coordinate: Coordinate) -> Option<Self> {
        let varied = self.number_of(key, coordinate)?;
        let value = varied.si(value, coordinate);
        let of = |number| match number == varied {
            true => value,
            // What its kind is made of is there.
            false => self.number(number).unwrap_or_default(),
        };
        let delay_s = of(SceneNumber::Delay);
        Some(Self { scene: self.scene.kind().scene(of), delay_s, ..self.clone() })
    }

    /// One of its numbers, in SI units; `None` if its kind does not take it.
    pub(super) fn number(&self, number: SceneNumber) -> Option<f64> {
        match number {
            SceneNumber::Delay => self.scene.kind().takes(number).then_some(self.delay_s),
            _ => self.scene.value(number),
        }
    }

    pub(super) fn number_of(&self, key: &str, coordinate: Coordinate) -> Option<SceneNumber> {
        let mut taken = SceneNumber::ALL.into_iter().filter(|n| self.scene.kind().takes(*n));
        taken.find(|number| number.key(coordinate) == key)
    }
}

#[cfg(test)]
mod tests {
    use crate::tests::demo;
    use crate::{Coordinate, Scene};

    #[test]
    fn a_number_is_read_and_varied_by_its_key_and_nothing_else_changes() {
        let study = demo();
        let walled = &study.environments[1];
        let keys = walled.keys(study.coordinate);
        let units: Vec<&str> = keys.iter().map(|(_, unit)| *unit).collect();
        assert_eq!(units, ["N/rad", "deg", "deg", "ms"]);
        for (key, _) in &keys {
            let other = walled.varied(key, 12.5, study.coordinate).unwrap();
            for (read, _) in &keys {
                let expect = match read == key {
                    true => Some(12.5),
                    false => walled.value(read, study.coordinate),
                };
                assert_eq!(other.value(read, study.coordinate), expect, "{read} with {key} varied");
            }
        }
        assert_eq!(walled.varied("force_n", 1.0, study.coordinate), None);
        assert_eq!(walled.value("wall_mm", study.coordinate), None);
        let free = crate::Environment { scene: Scene::Free, ..walled.clone() };
        assert_eq!(free.keys(study.coordinate), []);
    }

    #[test]
    fn along_a_slide_the_keys_are_those_of_millimetres() {
        let slide = Coordinate::Linear { lever_m: 0.5 };
        let walled = demo().environments[1].clone();
        let nearer = walled.varied("wall_mm", 10.0, slide).unwrap();
        assert!((nearer.scene.wall_rad().unwrap() - 0.02).abs() < 1e-15);
        let softer = walled.varied("stiffness_n_per_mm", 0.2, slide).unwrap();
        assert!((softer.scene.spring().unwrap().stiffness_n_per_rad - 100.0).abs() < 1e-12);
        assert_eq!(softer.value("stiffness_n_per_mm", slide), Some(0.2));
    }
}
