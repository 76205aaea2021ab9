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
}

impl Axes {
    /// By how much the length of [`Axes::push`] may differ from 1.
    pub const UNIT: f64 = 1e-9;
}

#[cfg(test)]
mod tests {
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
    fn trial_files_of_schema_2_have_no_columns_for_axes() {
        let text = format!("{}\n[axes]\nframe = \"x\"\npush = [1, 0, 0]\n", text());
        check_refused(Study::from_toml(&text), "schema", "write schema = 3");
    }
}
