//! The results of model runs.

use crate::column::{Column, Type, Values};
use crate::row::{ReadError, Row, rows};
use crate::value::words;

words! {
    /// How the lever moves.
    LeverMotion {
        /// Into the object.
        Forward = "forward",
        /// Not at all.
        Rest = "rest",
        /// Out of it.
        Backward = "backward",
    }
}

rows! {
    /// A sample of a run of the model. Forces act on the lever's end; above 0 they push into the
    /// object. What the scene does not have is null.
    ModelSample = "trajectory", "A run of the model" {
        /// time
        t_s: f64 = "s",
        /// lever angle
        theta_rad: f64 = "rad",
        /// lever velocity
        theta_dot_rad_s: f64 = "rad/s",
        /// compression of the fingertip's tissue
        finger_m or absent: Option<f64> = "m",
        /// force of the user
        force_ex_n: f64 = "N",
        /// what arrives of it at the lever
        force_tip_n or absent: Option<f64> = "N",
        /// share of the finger's tissue
        force_tissue_n or absent: Option<f64> = "N",
        /// force of the motor
        force_motor_n: f64 = "N",
        /// force of the brake
        force_brake_n: f64 = "N",
        /// friction of the drive train
        force_friction_n or absent: Option<f64> = "N",
        /// force of a mechanical stop
        force_stop_n or absent: Option<f64> = "N",
        /// how the lever moves: forward, rest or backward
        motion: LeverMotion,
    }

    /// An event of a run of the model.
    ModelEvent = "events", "Events of a run of the model" {
        /// when it happened
        t_s: f64 = "s",
        /// what happened
        event: String,
        /// lever angle there
        theta_rad: f64 = "rad",
        /// how the lever moves from then on
        motion: LeverMotion,
        /// the fingertip from then on
        tissue or absent: Option<String>,
    }

    /// A sample of a lever whose motion is given.
    BowTieSample = "bow_tie", "Force against angle of a given motion" {
        /// time
        t_s: f64 = "s",
        /// lever angle, given
        theta_rad: f64 = "rad",
        /// lever velocity, given
        theta_dot_rad_s: f64 = "rad/s",
        /// force of the user that the motion needs
        force_ex_n: f64 = "N",
        /// brake and motor together
        force_total_n: f64 = "N",
        /// force of the brake
        force_brake_n: f64 = "N",
        /// force of the motor
        force_motor_n: f64 = "N",
    }

    /// A scene by one solver at one step. Null where the run failed.
    ChatteringRun = "chattering", "Chattering" {
        /// the solver
        solver: String,
        /// its step; adaptive solvers sample by it
        step_s: f64 = "s",
        /// sign changes of the velocity between samples, zeros skipped
        reversals: Option<usize>,
        /// largest angle
        theta_max_rad: Option<f64> = "rad",
        /// largest angle less the exact solver's
        theta_excess_rad: Option<f64> = "rad",
        /// of an oscillation: ways from one end of a motion to the next, 0 for fewer than six
        swings: Option<usize>,
        /// median of half a swing's angle; 0 without any
        swing_amplitude_rad: Option<f64> = "rad",
        /// what the run is worth
        verdict: String,
    }
}

/// A run of the model: its samples, and the force of each of the scene's terms.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelRun {
    /// The scene's name.
    pub scene: String,
    /// What is to be read with its numbers.
    pub notes: Vec<String>,
    /// The samples.
    pub samples: Vec<ModelSample>,
    /// The forces of terms, as long as the samples.
    pub terms: Vec<TermForce>,
}

/// The force of a term of the scene.
#[derive(Debug, Clone, PartialEq)]
pub struct TermForce {
    /// The column, `force_gravity_n`.
    pub column: String,
    /// What it is.
    pub about: String,
    /// The force at each sample, N.
    pub force_n: Vec<f64>,
}

impl TermForce {
    /// That of a term by its name, `gravity`.
    pub fn new(term: &str, about: impl Into<String>, force_n: Vec<f64>) -> Self {
        Self { column: format!("force_{term}_n"), about: about.into(), force_n }
    }

    /// The term's name.
    pub fn term(&self) -> &str {
        let name = self.column.strip_prefix("force_").and_then(|name| name.strip_suffix("_n"));
        name.unwrap_or(&self.column)
    }
}

impl ModelRun {
    /// As a table has it: the samples, then a column for each term.
    pub fn columns(&self) -> Vec<Column> {
        let mut columns = ModelSample::columns(&self.samples);
        columns.extend(self.terms.iter().map(|term| {
            let values = term.force_n.iter().copied().map(Some);
            let mut column = Column::float("force_n", "N", "", values);
            column.field.name = term.column.clone().into();
            column.field.description = term.about.clone().into();
            column
        }));
        columns
    }

    /// Back from the columns of a table; numbers that are not declared are of terms.
    ///
    /// # Errors
    /// Columns of anything else.
    pub fn read(scene: String, notes: Vec<String>, columns: &[Column]) -> Result<Self, ReadError> {
        let declared = ModelSample::fields();
        let others = columns.iter().filter(|column| {
            column.field.kind == Type::Float
                && declared.iter().all(|field| field.name != column.field.name)
        });
        let terms = others
            .filter_map(|column| {
                let Values::Float(values) = &column.values else { return None };
                Some(TermForce {
                    column: column.field.name.to_string(),
                    about: column.field.description.to_string(),
                    force_n: values.iter().map(|force| force.unwrap_or(0.0)).collect(),
                })
            })
            .collect();
        Ok(Self { scene, notes, samples: ModelSample::read(columns)?, terms })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_comes_back_from_its_columns_with_its_terms() {
        let sample = |t_s| ModelSample {
            t_s,
            theta_rad: 0.5,
            theta_dot_rad_s: 0.0,
            finger_m: None,
            force_ex_n: 1.0,
            force_tip_n: None,
            force_tissue_n: None,
            force_motor_n: -1.0,
            force_brake_n: 0.0,
            force_friction_n: Some(0.1),
            force_stop_n: None,
            motion: LeverMotion::Rest,
        };
        let terms = vec![TermForce::new("spring_bed", "a bed of springs", vec![0.2, 0.3])];
        let samples = [0.0, 1.0].map(sample).to_vec();
        let run = ModelRun { scene: "S".to_owned(), notes: Vec::new(), samples, terms };
        assert_eq!(run.terms[0].term(), "spring_bed");
        let again = ModelRun::read("S".to_owned(), Vec::new(), &run.columns()).unwrap();
        assert_eq!(again, run);
    }
}
