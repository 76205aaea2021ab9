//! `[perception]` of a `study.toml`: its defaults, its checks, and the way back.

use super::check::Check;
use super::units::{decimal, degrees};
use crate::{Perception, VibrationCurve};
use serde::{Deserialize, Serialize};

/// Micrometres are typed.
const MICRO: f64 = 1e-6;
/// No joint tells angles further apart than this from each other, degrees.
const WIDEST_DEG: f64 = 90.0;

#[derive(Serialize, Deserialize, Default, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub(super) struct PerceptionTable {
    force: Option<f64>,
    force_floor_n: Option<f64>,
    compliance: Option<f64>,
    viscosity: Option<f64>,
    angle_deg: Option<f64>,
    excess: Option<f64>,
    vibration: Option<CurveValue>,
    jnd: Option<String>,
}

/// Whose just noticeable differences count: those of the study's people, where tasks measured them.
const MEASURED: &str = "measured";
/// Others' findings, and what the table says, which is the default.
const KNOWN: &str = "known";

/// The name of a curve, or Hz and µm.
#[derive(Serialize, Deserialize, Clone, PartialEq)]
#[serde(
    untagged,
    expecting = "a curve is \"fingertip\", \"grasped\", or pairs of Hz and µm: [[10.0, 10.0], [200.0, 0.1]]"
)]
enum CurveValue {
    Named(String),
    Points(Vec<[f64; 2]>),
}

impl Check<'_> {
    pub(super) fn perception(&mut self, table: PerceptionTable) -> Perception {
        let usual = Perception::default();
        let [force_share, compliance_share, viscosity_share, excess_share] = [
            ("force", table.force, usual.force_share),
            ("compliance", table.compliance, usual.compliance_share),
            ("viscosity", table.viscosity, usual.viscosity_share),
            ("excess", table.excess, usual.excess_share),
        ]
        .map(|(key, value, usual)| {
            let value = value.unwrap_or(usual);
            if !(value > 0.0 && value < 1.0) {
                let problem = format!("{value} must be a share between 0 and 1, such as {usual}");
                self.error(&format!("perception.{key}"), problem);
            }
            value
        });
        let angle_rad = table.angle_deg.map_or(usual.angle_rad, |deg| {
            self.within("perception.angle_deg", deg, WIDEST_DEG).to_radians()
        });
        let force_floor_n = table
            .force_floor_n
            .map_or(usual.force_floor_n, |n| self.positive("perception.force_floor_n", n));
        let vibration = table.vibration.map_or(usual.vibration, |curve| self.curve(curve));
        let jnd = table.jnd.as_deref().unwrap_or(KNOWN);
        if ![KNOWN, MEASURED].contains(&jnd) {
            let problem = format!("'{jnd}' is neither \"{KNOWN}\" nor \"{MEASURED}\"");
            self.error("perception.jnd", problem);
        }
        Perception {
            is_measured: jnd == MEASURED,
            measured: Vec::new(),
            force_share,
            force_floor_n,
            compliance_share,
            viscosity_share,
            angle_rad,
            excess_share,
            vibration,
        }
    }

    fn curve(&mut self, curve: CurveValue) -> VibrationCurve {
        const KEY: &str = "perception.vibration";
        let points = match curve {
            CurveValue::Named(name) => {
                let curve = VibrationCurve::NAMED.into_iter().find(|c| c.name() == Some(&name));
                return curve.unwrap_or_else(|| {
                    let problem =
                        format!("there is no curve '{name}'; there are fingertip, grasped");
                    self.error(KEY, problem);
                    VibrationCurve::default()
                });
            }
            CurveValue::Points(points) => points,
        };
        if points.is_empty() {
            self.error(KEY, "the list is empty; leave it out for the fingertip's");
        }
        self.at_most_listed(KEY, points.len());
        for (i, [frequency_hz, amplitude_um]) in points.iter().enumerate() {
            let key = format!("{KEY}[{i}]");
            self.positive(&key, *frequency_hz);
            self.positive(&key, *amplitude_um);
            let before = i.checked_sub(1).map_or(0.0, |before| points[before][0]);
            if *frequency_hz <= before {
                let problem = format!("{frequency_hz} Hz must lie above {before} Hz before it");
                self.error(&key, problem);
            }
        }
        VibrationCurve::Points(points.into_iter().map(|[f, a]| [f, MICRO * a]).collect())
    }
}

/// Back to the table of the file: what is not the default.
pub(super) fn table(perception: &Perception) -> PerceptionTable {
    let usual = Perception::default();
    let differs =
        |value: f64, default: f64| (value.to_bits() != default.to_bits()).then_some(value);
    let curve = match &perception.vibration {
        VibrationCurve::Points(points) => {
            CurveValue::Points(points.iter().map(|[f, a]| [*f, decimal(a / MICRO)]).collect())
        }
        named => CurveValue::Named(named.name().unwrap_or_default().to_owned()),
    };
    PerceptionTable {
        force: differs(perception.force_share, usual.force_share),
        force_floor_n: differs(perception.force_floor_n, usual.force_floor_n),
        compliance: differs(perception.compliance_share, usual.compliance_share),
        viscosity: differs(perception.viscosity_share, usual.viscosity_share),
        angle_deg: differs(perception.angle_rad, usual.angle_rad).map(degrees),
        excess: differs(perception.excess_share, usual.excess_share),
        vibration: (perception.vibration != usual.vibration).then_some(curve),
        jnd: perception.is_measured.then(|| MEASURED.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use crate::tests::{check_refused, check_round_trip, demo, with};
    use crate::{Perception, VibrationCurve};

    #[test]
    fn a_study_without_the_section_has_the_defaults_and_writes_none() {
        let study = demo();
        assert_eq!(study.perception, Perception::default());
        assert!(!study.to_toml().unwrap().contains("perception"));
    }

    #[test]
    fn degrees_and_micrometres_become_si_and_survive_a_round_trip() {
        let study = with(
            "[perception]",
            "force = 0.1\nforce_floor_n = 0.02\nangle_deg = 2.5\nvibration = [[10.0, 8.0], [200.0, 0.07]]",
        )
        .unwrap();
        let perception = &study.perception;
        assert!((perception.angle_rad.to_degrees() - 2.5).abs() < 1e-12);
        assert!((perception.vibration.points()[1][1] - 0.07e-6).abs() < 1e-18);
        assert!((perception.force_share - 0.1).abs() < 1e-15);
        check_round_trip(&study);
        let strict = with("[perception]", "vibration = \"grasped\"").unwrap();
        assert_eq!(strict.perception.vibration, VibrationCurve::Grasped);
        check_round_trip(&strict);
    }

    #[test]
    fn what_makes_no_sense_is_one_error_that_names_its_key() {
        for (text, key, words) in [
            ("force = 7.0", "perception.force", "a share between 0 and 1"),
            ("excess = nan", "perception.excess", "a share"),
            ("force_floor_n = 0.0", "perception.force_floor_n", "above 0"),
            ("angle_deg = 400.0", "perception.angle_deg", "at most 90"),
            ("vibration = \"toe\"", "perception.vibration", "there are fingertip, grasped"),
            ("vibration = []", "perception.vibration", "leave it out"),
            (
                "vibration = [[10.0, 1.0], [5.0, 1.0]]",
                "perception.vibration[1]",
                "must lie above 10 Hz",
            ),
            ("vibration = [[10.0, -1.0]]", "perception.vibration[0]", "above 0"),
        ] {
            check_refused(with("[perception]", text), key, words);
        }
    }
}
