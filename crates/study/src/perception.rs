//! What a person can feel: bounds on errors of models and recordings.

use serde::{Serialize, Serializer};

/// `[perception]` of a study, with its defaults filled in. `docs/trade.md` gives the source of
/// each; unconfirmed values are called assumed there and here.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Perception {
    /// Difference of two forces that is just noticed, as a share of the force. 7 % from 2.5 to
    /// 10 N: Pang, Tan & Durlach 1991.
    pub force_share: f64,
    /// Below this a difference of two forces is not noticed, however small they are, N. Assumed.
    pub force_floor_n: f64,
    /// Difference of two compliances that is just noticed, as a share. 8 % where force and work
    /// tell of it too: Tan, Pang & Durlach 1992, as Tan et al. 1993 give it.
    pub compliance_share: f64,
    /// Difference of two viscosities that is just noticed, as a share. 19 %, at 4 to 512 N s/m:
    /// Jones, Hunter & Lafontaine 1997.
    pub viscosity_share: f64,
    /// Just noticeable difference of two angles, rad. 2.0°, that of the wrist by Tan et al. 1994 as
    /// others cite it; that the lever's angle may be treated as a joint's is assumed.
    pub angle_rad: f64,
    /// A vibration is another one if it exceeds the right one's level by this share. Assumed.
    pub excess_share: f64,
    /// Amplitudes of vibration that are just felt.
    pub vibration: VibrationCurve,
    /// Whether the differences that these people notice take the place of others', wherever a task of the study measured
    /// them: `jnd = "measured"`.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub is_measured: bool,
    /// Those that did ([`Perception::with_measured`]).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub measured: Vec<MeasuredJnd>,
}

/// What the people of a study just notice, by the answers to a task.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeasuredJnd {
    /// Of numbers in which unit: rad, N, N/rad or N·s/rad. What is said of a force holds for work, and of an angle for ways.
    pub unit: String,
    /// The geometric mean over people and modes: a share of the standard, of an angle rad.
    pub jnd: f64,
    /// Its interval; none of one person.
    pub ends: Option<[f64; 2]>,
    /// How many people.
    pub n: usize,
}

impl MeasuredJnd {
    /// Of numbers in which unit a JND of levels in another unit says what is noticed; `None` where it says nothing.
    pub fn unit_of(levels: &str) -> Option<&'static str> {
        match levels {
            "rad" | "°" => Some("rad"),
            "N" => Some("N"),
            "N/rad" | "N/m" | "N/mm" => Some("N/rad"),
            "N·s/rad" | "N·s/m" => Some("N·s/rad"),
            _ => None,
        }
    }

    /// `8 people of this study, 7.7 to 10.5 %`.
    fn in_words(&self) -> String {
        let people = crate::counted(self.n, "participants");
        let shown = |value: f64| match self.unit.as_str() {
            "rad" => (1e2 * value.to_degrees()).round() / 1e2,
            _ => (1e3 * value).round() / 10.0,
        };
        let unit = if self.unit == "rad" { "°" } else { " %" };
        let ends =
            self.ends.map(|[low, high]| format!(", {} to {}{unit}", shown(low), shown(high)));
        format!("measured: {people} of this study{}", ends.unwrap_or_default())
    }
}

impl Default for Perception {
    fn default() -> Self {
        Self {
            force_share: 0.07,
            force_floor_n: 0.05,
            compliance_share: 0.08,
            viscosity_share: 0.19,
            angle_rad: 2_f64.to_radians(),
            excess_share: 0.2,
            vibration: VibrationCurve::Fingertip,
            is_measured: false,
            measured: Vec::new(),
        }
    }
}

impl Perception {
    /// The difference of two forces that is just noticed at a force, N.
    pub fn force_bound_n(&self, force_n: f64) -> f64 {
        (self.force_share * force_n.abs()).max(self.force_floor_n)
    }

    /// The difference of two numbers in `unit` that is just noticed at one of them, for a lever of
    /// `lever_m`; `None` if it is not known for that unit.
    pub fn bound(&self, value: f64, unit: &str, lever_m: f64) -> Option<f64> {
        let [share, floor] = self.share_and_floor(unit, lever_m)?;
        Some((share * value.abs()).max(floor))
    }

    /// Of numbers in `unit` the share that is just noticed, and the difference below which nothing is,
    /// in that unit. A way is the angle's on the lever's arc; work is force along a way: the force's
    /// share of it, and no less than the smallest force along the smallest way.
    pub fn share_and_floor(&self, unit: &str, lever_m: f64) -> Option<[f64; 2]> {
        match unit {
            "rad" => Some([0.0, self.angle_rad]),
            "m" => Some([0.0, lever_m * self.angle_rad]),
            "N" => Some([self.force_share, self.force_floor_n]),
            "J" => Some([self.force_share, self.force_floor_n * lever_m * self.angle_rad]),
            "N/rad" => Some([self.compliance_share, 0.0]),
            "N·s/rad" => Some([self.viscosity_share, 0.0]),
            _ => None,
        }
    }

    /// The same with what the people of the study notice, where the study asks for that.
    #[must_use]
    pub fn with_measured(&self, measured: Vec<MeasuredJnd>) -> Self {
        let mut own = self.clone();
        if !self.is_measured {
            return own;
        }
        for jnd in &measured {
            match jnd.unit.as_str() {
                "rad" => own.angle_rad = jnd.jnd,
                "N" => own.force_share = jnd.jnd,
                "N/rad" => own.compliance_share = jnd.jnd,
                "N·s/rad" => own.viscosity_share = jnd.jnd,
                _ => {}
            }
        }
        own.measured = measured;
        own
    }

    /// What [`Perception::bound`] takes for a unit, and whose finding that is.
    pub fn source(&self, unit: &str) -> Option<String> {
        let usual = Self::default();
        let (value, usual, paper) = match unit {
            "rad" | "m" => (self.angle_rad, usual.angle_rad, "of the wrist, Tan et al. 1994"),
            "N" | "J" => (self.force_share, usual.force_share, "Pang, Tan & Durlach 1991"),
            "N/rad" => (self.compliance_share, usual.compliance_share, "Tan, Pang & Durlach 1992"),
            "N·s/rad" => {
                (self.viscosity_share, usual.viscosity_share, "Jones, Hunter & Lafontaine 1997")
            }
            _ => return None,
        };
        // To the last bit: a study that gives the usual value itself means the same finding.
        // What is said of a force holds for work, and of an angle for ways.
        let of = match unit {
            "J" => "N",
            "m" => "rad",
            own => own,
        };
        let measured = self.measured.iter().find(|jnd| jnd.unit == of).map(MeasuredJnd::in_words);
        let source = match &measured {
            Some(words) => words.as_str(),
            None if value.to_bits() == usual.to_bits() => paper,
            None => "study.toml",
        };
        let percent = (1e4 * value).round() / 100.0;
        let degrees = (1e4 * value.to_degrees()).round() / 1e4;
        Some(match unit {
            "rad" => format!("{degrees}° ({source})"),
            "m" => format!("the lever's way over {degrees}° ({source})"),
            "N" => {
                format!("{percent} % of the force ({source}), at least {} N", self.force_floor_n)
            }
            "J" => format!("{percent} % of the force ({source})"),
            "N/rad" => format!("{percent} % of the stiffness ({source})"),
            _ => format!("{percent} % of the viscosity ({source})"),
        })
    }

    /// How far a number is off the right one, over the difference that is just noticed; `None`
    /// where that is not known for the unit. Where one of the two is missing it is off without
    /// limit, and where both are, not at all.
    pub fn off(
        &self,
        value: Option<f64>,
        right: Option<f64>,
        unit: &str,
        lever_m: f64,
    ) -> Option<f64> {
        let bound = self.bound(right.unwrap_or(0.0), unit, lever_m)?;
        Some(match (value, right) {
            (None, None) => 0.0,
            (Some(value), Some(right)) => {
                let apart = (value - right).abs();
                if apart > 0.0 { apart / bound } else { 0.0 } // nothing is nothing, whatever the bound
            }
            _ => f64::INFINITY,
        })
    }
}

/// A number of a course or a recording, as a study's metrics have it.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// Its name, which ends in its unit.
    pub name: String,
    /// Its unit as tables have it.
    pub unit: String,
    /// Null if it does not apply.
    pub value: Option<f64>,
}

/// Whether a metric describes something that a person could feel: nobody feels the precision of a
/// number, a bound set by the resolution of a sensor, the error of a stiffness relative to its
/// command, or what adds up a whole movement, for which the thresholds of an angle and of a force say
/// nothing.
pub fn is_felt(metric: &str) -> bool {
    const KNOWLEDGE: [&str; 5] =
        ["std_error", "ci_low", "ci_high", "hold_rigidity_min", "stiffness_error"];
    const SUMS: [&str; 2] = ["path_rad", "force_rms_n"];
    // What can be felt of a movement or a force in several axes is not known here.
    const IN_SPACE: [&str; 10] = [
        "completion_s",
        "path_m",
        "distance_m",
        "path_over_distance",
        "path_gap_s",
        "force_magnitude_largest_n",
        "force_magnitude_mean_n",
        "force_magnitude_rest_n",
        "force_across_share",
        "work_j",
    ];
    !IN_SPACE.contains(&metric)
        && !SUMS.contains(&metric)
        && !KNOWLEDGE.iter().any(|part| metric.contains(part))
}

/// Vibration that is just felt, over frequency.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum VibrationCurve {
    /// A median fingertip on a small contact. Its form is U, lowest at some 200 Hz; its numbers are
    /// assumed.
    #[default]
    Fingertip,
    /// A cylinder in the hand, the strict choice: some of 19 people felt less than 0.01 µm, most
    /// sensitive between 150 and 200 Hz (Brisben, Hsiao & Johnson 1999). That is its lowest point;
    /// its other numbers are assumed.
    Grasped,
    /// The study's own: frequency, Hz, and amplitude, m, zero to peak.
    Points(Vec<[f64; 2]>),
}

/// Hz and m. See [`VibrationCurve::Fingertip`].
const FINGERTIP: [[f64; 2]; 7] = [
    [1.0, 40e-6],
    [10.0, 10e-6],
    [40.0, 1.4e-6],
    [100.0, 0.3e-6],
    [200.0, 0.1e-6],
    [400.0, 0.3e-6],
    [1000.0, 3e-6],
];
/// Hz and m. See [`VibrationCurve::Grasped`].
const GRASPED: [[f64; 2]; 7] = [
    [1.0, 40e-6],
    [10.0, 10e-6],
    [20.0, 3e-6],
    [40.0, 0.45e-6],
    [100.0, 0.03e-6],
    [175.0, 0.01e-6],
    [1000.0, 1e-6],
];

impl VibrationCurve {
    /// The curves that have a name.
    pub const NAMED: [Self; 2] = [Self::Fingertip, Self::Grasped];

    /// Its name in `study.toml`; `None` for a study's own points.
    pub fn name(&self) -> Option<&'static str> {
        match self {
            Self::Fingertip => Some("fingertip"),
            Self::Grasped => Some("grasped"),
            Self::Points(_) => None,
        }
    }

    /// Frequency, Hz, increasing, and amplitude, m, zero to peak.
    pub fn points(&self) -> &[[f64; 2]] {
        match self {
            Self::Fingertip => &FINGERTIP,
            Self::Grasped => &GRASPED,
            Self::Points(points) => points,
        }
    }
}

/// By its points, whatever it is called: what depends on it depends on these.
impl Serialize for VibrationCurve {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.points().serialize(serializer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stiffness_is_felt_and_how_well_it_is_known_is_not() {
        assert!(is_felt("stiffness_n_per_rad") && is_felt("wall_rigidity_n_per_rad"));
        assert!(!is_felt("stiffness_std_error_n_per_rad"));
        assert!(is_felt("theta_max_rad") && !is_felt("path_rad"));
        assert!(is_felt("force_mean_n") && !is_felt("force_rms_n"));
        assert!(!is_felt("wall_stiffness_ci_high_n_per_rad"));
    }

    #[test]
    fn a_number_is_off_by_its_difference_over_what_is_just_noticed_in_its_unit() {
        let felt = Perception::default();
        let off = |value, right, unit| felt.off(Some(value), Some(right), unit, 0.05).unwrap();
        assert!((off(4.4, 4.0, "N/rad") - 0.1 / 0.08).abs() < 1e-9);
        assert!((off(0.1, 0.0, "N") - 2.0).abs() < 1e-12);
        assert!((off(10.7, 10.0, "N") - 1.0).abs() < 1e-9);
        let floor_j = 0.05 * 0.05 * 2_f64.to_radians();
        assert!((off(floor_j, 0.0, "J") - 1.0).abs() < 1e-12);
        assert!(off(1.0, 1.0, "N/rad").abs() < 1e-300 && off(0.1, 0.0, "N/rad").is_infinite());
        assert_eq!(felt.off(None, Some(1.0), "rad", 0.05), Some(f64::INFINITY));
        assert_eq!(felt.off(None, None, "m", 0.05), Some(0.0));
        assert_eq!(felt.bound(1.0, "s", 0.05), None);
    }

    #[test]
    fn a_bound_names_whose_finding_it_is_unless_the_study_chose_it() {
        let own = Perception { compliance_share: 0.1, ..Perception::default() };
        let usual = Perception::default().source("N/rad").unwrap();
        assert_eq!(usual, "8 % of the stiffness (Tan, Pang & Durlach 1992)");
        assert_eq!(own.source("N/rad").unwrap(), "10 % of the stiffness (study.toml)");
        assert_eq!(own.source("rad").unwrap(), "2° (of the wrist, Tan et al. 1994)");
        for unit in ["rad", "m", "N", "J", "N/rad", "N·s/rad", "s", "1"] {
            assert_eq!(own.source(unit).is_some(), own.bound(1.0, unit, 0.05).is_some(), "{unit}");
        }
    }

    #[test]
    fn what_the_people_of_a_study_notice_takes_the_place_of_others_findings_where_it_is_asked_for()
    {
        let jnd = |unit: &str, jnd: f64| MeasuredJnd {
            unit: unit.to_owned(),
            jnd,
            ends: Some([0.9 * jnd, 1.2 * jnd]),
            n: 8,
        };
        let all = || vec![jnd("N/rad", 0.1065), jnd("rad", 1_f64.to_radians())];
        let usual = Perception::default();
        assert_eq!(usual.with_measured(all()), usual);
        let own = Perception { is_measured: true, ..usual.clone() }.with_measured(all());
        assert_eq!(own.bound(4.0, "N/rad", 0.05), Some(0.426));
        assert_eq!(own.force_bound_n(10.0).to_bits(), usual.force_bound_n(10.0).to_bits());
        let told = own.source("N/rad").unwrap();
        assert_eq!(
            told,
            "10.65 % of the stiffness (measured: 8 participants of this study, 9.6 to 12.8 %)"
        );
        let told = own.source("m").unwrap();
        assert!(
            told.contains("1° (measured: 8 participants of this study, 0.9 to 1.2°)"),
            "{told}"
        );
        assert_eq!(MeasuredJnd::unit_of("N/m"), Some("N/rad"));
        assert_eq!(MeasuredJnd::unit_of("s"), None);
    }

    #[test]
    fn named_curves_grow_in_frequency_and_the_grasped_one_is_nowhere_less_strict() {
        let lowest = |curve: &VibrationCurve| {
            curve.points().iter().map(|point| point[1]).fold(f64::INFINITY, f64::min)
        };
        for curve in VibrationCurve::NAMED {
            let points = curve.points();
            assert!(points.windows(2).all(|pair| pair[0][0] < pair[1][0]), "{curve:?}");
            assert!(points.iter().flatten().all(|x| *x > 0.0));
        }
        assert!(lowest(&VibrationCurve::Grasped) < 0.2 * lowest(&VibrationCurve::Fingertip));
        assert!((lowest(&VibrationCurve::Grasped) - 0.01e-6).abs() < 1e-15);
    }
}
