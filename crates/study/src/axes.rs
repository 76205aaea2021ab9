//! The axes of space in which a device with several of them records: `[axes]` of `study.toml`.

use serde::{Deserialize, Serialize};

/// Where axes point, and which way is a push. The one coordinate of a trial, θ L, and its force are projections on that.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "struct AxesTable")]
pub struct Axes {
    /// Where each of the axes x, y and z points, in words.
    pub frame: String,
    /// The direction of a push into the object: x, y and z of a vector of length 1.
    pub push: [f64; 3],
    /// Cut-off of the low-pass after which speed and path in space are taken, Hz.
    #[serde(default = "usual_low_pass_hz")]
    pub low_pass_hz: f64,
    /// A movement in space begins where its speed first exceeds this, m/s.
    #[serde(default = "usual_onset_m_s")]
    pub onset_m_s: f64,
    /// It ends where the speed last falls below this, m/s (at most that of the onset: hysteresis).
    #[serde(default = "usual_offset_m_s")]
    pub offset_m_s: f64,
}

impl Axes {
    /// By how much the length of [`Axes::push`] may differ from 1.
    pub const UNIT: f64 = 1e-9;
    /// Cut-offs that a low-pass may have, Hz.
    pub const LOW_PASS_HZ: core::ops::RangeInclusive<f64> = 0.1..=1000.0;
}

/// Voluntary movements of a hand have next to nothing above 10 Hz, where tremor begins (Winter 2009, *Biomechanics and
/// Motor Control of Human Movement*, 4th ed.; Stiles & Randall 1967, J. Appl. Physiol. 23:324, on tremor).
fn usual_low_pass_hz() -> f64 {
    10.0
}

/// Twice what 0.1 mm of noise in each axis at 100 Hz leaves of speed behind the low-pass.
fn usual_onset_m_s() -> f64 {
    0.01
}

fn usual_offset_m_s() -> f64 {
    0.005
}

#[cfg(test)]
mod tests {
    use super::Axes;
    use crate::Study;
    use crate::tests::{check_refused, check_round_trip, text};

    fn with(axes: &str) -> Result<Study, Vec<crate::StudyError>> {
        let text = text().replacen("schema = 2", "schema = 3", 1);
        Study::from_toml(&format!("{text}\n[axes]\n{axes}\n"))
    }

    #[test]
    fn the_direction_of_a_push_has_the_length_1() {
        let frame = "frame = \"x right, y up, z to the person\"\n";
        let study = with(&format!("{frame}push = [0, 0, -1]")).unwrap();
        assert!(study.axes.as_ref().unwrap().push[2] < 0.0);
        check_round_trip(&study);
        for (push, words) in [
            ("[0, 3, 4]", "write [0, 0.6, 0.8]"),
            ("[0, 0, 0]", "no direction"),
            ("[nan, 0, 1]", "no direction"),
        ] {
            check_refused(with(&format!("{frame}push = {push}")), "axes.push", words);
        }
        check_refused(with("frame = \" \"\npush = [0, 0, 1]"), "axes.frame", "is empty");
    }

    #[test]
    fn the_low_pass_and_the_speeds_are_the_usual_ones_where_none_are_given() {
        let axes = "frame = \"x right\"\npush = [1, 0, 0]\n";
        let numbers = |axes: &Axes| vec![axes.low_pass_hz, axes.onset_m_s, axes.offset_m_s];
        let usual = with(axes).unwrap().axes.unwrap();
        assert_eq!(numbers(&usual), [10.0, 0.01, 0.005]);
        let own =
            with(&format!("{axes}low_pass_hz = 6\nonset_m_s = 0.05\noffset_m_s = 0.05")).unwrap();
        assert_eq!(numbers(own.axes.as_ref().unwrap()), [6.0, 0.05, 0.05]);
        check_round_trip(&own);
        for (key, value, words) in [
            ("low_pass_hz", "0", "from 0.1 to 1000"),
            ("low_pass_hz", "nan", "from 0.1 to 1000"),
            ("onset_m_s", "-1", "above 0"),
            ("offset_m_s", "0.02", "at most onset_m_s"),
        ] {
            let study = with(&format!("{axes}{key} = {value}"));
            check_refused(study, &format!("axes.{key}"), words);
        }
    }

    #[test]
    fn trial_files_of_schema_2_have_no_columns_for_axes() {
        let text = format!("{}\n[axes]\nframe = \"x\"\npush = [1, 0, 0]\n", text());
        check_refused(Study::from_toml(&text), "schema", "write schema = 3");
    }
}
