//! The results of the stage as rows: models, parameters, curve.

use crate::curve::mean_response;
use crate::models::{Model, way};
use crate::{Branch, CharacteriseError, Characteristic, Chosen, Sweep, curve, first_order};
use zwidth_results::{
    CandidateVerdict, CurvePoint, FittedModel, FittedParameter, Row, UNIT_OF_COMMAND,
    UNIT_OF_RESPONSE,
};
use zwidth_tables::{Table, TableError};

/// The subject of the characterisation: names and units for the tables.
#[derive(Debug, Clone, Copy)]
pub struct Subject<'a> {
    /// The actuator or sensor.
    pub actuator: &'a str,
    /// Unit of the command.
    pub command_unit: &'a str,
    /// Unit of the response.
    pub response_unit: &'a str,
}

impl Subject<'_> {
    /// The table of its candidate models; notes below give the reason of the choice, the amount of
    /// data and the noise.
    ///
    /// # Errors
    /// A number that is not finite.
    pub fn models_table(&self, characteristic: &Characteristic) -> Result<Table, TableError> {
        let table = self.table(&fitted_models(characteristic), "candidate models")?;
        let sweeps = characteristic.sweeps;
        let points = characteristic.points;
        let folds = characteristic.folds;
        let plural = if sweeps == 1 { "" } else { "s" };
        let grouping = characteristic.grouping;
        let data = format!(
            "{sweeps} sweep{plural}, {points} points; left out in turn: {folds} {grouping}s."
        );
        let table = table.with_note(characteristic.reason.clone()).with_note(data);
        Ok(match characteristic.noise {
            Some(noise) => table.with_note(format!(
                "Scatter that no curve explains: {noise:.3} {}.",
                self.response_unit
            )),
            None => table,
        })
    }

    /// The table of their parameters.
    ///
    /// # Errors
    /// A number that is not finite.
    pub fn parameters_table(&self, characteristic: &Characteristic) -> Result<Table, TableError> {
        self.table(&fitted_parameters(characteristic), "parameters")
    }

    /// The table of the chosen curve.
    ///
    /// # Errors
    /// A number that is not finite.
    pub fn curve_table(&self, points: &[CurvePoint]) -> Result<Table, TableError> {
        self.table(points, "fitted curve")
    }

    /// Rows under the subject's name and in its units.
    fn table<R: Row>(&self, rows: &[R], what: &str) -> Result<Table, TableError> {
        let actuator = self.actuator.replace('_', " ");
        let name = format!("{}.{}", R::NAME, self.actuator);
        Ok(Table::of_rows(rows)?
            .called(name, format!("Characteristic of the {actuator}: {what}"))
            .with_unit(UNIT_OF_COMMAND, self.command_unit)
            .with_unit(UNIT_OF_RESPONSE, self.response_unit))
    }
}

/// The candidate models: their errors, and why each was chosen or rejected.
pub fn fitted_models(characteristic: &Characteristic) -> Vec<FittedModel> {
    let mut rows = Vec::new();
    for candidate in &characteristic.candidates {
        let quality = candidate.quality.as_ref();
        rows.push(FittedModel {
            model: candidate.name,
            formula: candidate.formula.clone(),
            rms: quality.map(|q| q.rms),
            left_out_rms: quality.map(|q| q.cv_rms),
            rms_over_noise: quality.and_then(|q| q.rms_over_noise),
            r2: quality.and_then(|q| q.r2),
            autocorrelation: quality.and_then(|q| q.autocorrelation),
            aicc: quality.and_then(|q| q.aicc),
            verdict: candidate.verdict,
            reason: candidate.reason.clone().into(),
        });
    }
    rows
}

/// The parameters of every candidate model, with their bootstrap intervals.
pub fn fitted_parameters(characteristic: &Characteristic) -> Vec<FittedParameter> {
    let candidates = characteristic.candidates.iter();
    candidates.flat_map(|candidate| candidate.parameters.iter().cloned()).collect()
}

/// Points of the curve's grid.
const GRID_POINTS: usize = 201;

/// The chosen fit with its bands, the mean of the samples and the first-order fit, on an even grid
/// over the commands; up and then down if the chosen model has hysteresis.
///
/// # Errors
/// A confidence level outside (0, 1); sweeps that no line can be fitted to.
pub fn curve_points(
    sweeps: &[Sweep],
    characteristic: &Characteristic,
    level: f64,
) -> Result<Vec<CurvePoint>, CharacteriseError> {
    let step = (characteristic.command_max - characteristic.command_min) / (GRID_POINTS - 1) as f64;
    let grid: Vec<f64> =
        (0..GRID_POINTS).map(|i| characteristic.command_min + step * i as f64).collect();
    let line = first_order(sweeps, level)?.curve(&grid);
    let chosen = &characteristic.candidates[characteristic.chosen];
    let mut points = Vec::new();
    for branch in Model::of(chosen.name).branches() {
        let own = curve(chosen, &grid, branch.unwrap_or(Branch::Up), level)?;
        let own = own.as_ref().unwrap_or(&line);
        let means = mean_response(sweeps, &grid, *branch);
        for ((at, mean), line) in own.iter().zip(means).zip(&line) {
            points.push(CurvePoint {
                branch: way(*branch),
                command: at.command,
                mean,
                fit: at.fit,
                ci_low: at.mean[0],
                ci_high: at.mean[1],
                prediction_low: at.new[0],
                prediction_high: at.new[1],
                first_order: line.fit,
            });
        }
    }
    Ok(points)
}

/// The results for an actuator, with the units of its sweeps.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The candidate models.
    pub models: Vec<FittedModel>,
    /// Their parameters.
    pub parameters: Vec<FittedParameter>,
    /// The chosen curve.
    pub curve: Vec<CurvePoint>,
    /// Unit of the command.
    pub command_unit: String,
    /// Unit of the response.
    pub response_unit: String,
}

impl Fit {
    /// The chosen curve of `actuator` (`motor` or `brake`).
    ///
    /// # Errors
    /// Units other than N against V, no chosen model.
    pub fn chosen(&self, actuator: &'static str) -> Result<Chosen, CharacteriseError> {
        let command = self.command_unit.as_str();
        let response = self.response_unit.as_str();
        let refused = |problem: &str| CharacteriseError::no_calibration(actuator, problem);
        if (command, response) != ("V", "N") {
            let problem = format!(
                "its sweeps hold {response} against {command}, not N against V: convert them on import, or give them another actuator's name"
            );
            return Err(refused(&problem));
        }
        let chosen = self.models.iter().find(|row| row.verdict == CandidateVerdict::Chosen);
        if let (Some(row), Some(first), Some(last)) =
            (chosen, self.curve.first(), self.curve.last())
        {
            let model = Model::of(row.model);
            let own = self.parameters.iter().filter(|parameter| parameter.model == row.model);
            let parameters: Vec<f64> = own.map(|parameter| parameter.estimate).collect();
            if parameters.len() == model.parameters().len() {
                return Ok(Chosen { model, parameters, voltage_v: (first.command, last.command) });
            }
        }
        Err(refused("its tables do not hold a chosen model; make them again"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::characterise;
    use crate::characteristic::tests::settings;
    use zwidth_results::CurveModel;

    /// A straight line up and down, with a scatter of a hundredth.
    fn found() -> (Subject<'static>, Characteristic, Vec<CurvePoint>) {
        let command: Vec<f64> = (0..=40).chain((0..40).rev()).map(|i| 0.1 * f64::from(i)).collect();
        let scatter = |i: usize| ((7 * i) % 11) as f64 * 2e-3;
        let response: Vec<f64> =
            command.iter().enumerate().map(|(i, x)| 0.3 + 2.0 * x + scatter(i)).collect();
        let sweeps = [Sweep { command: &command, response: &response }];
        let found = characterise(&sweeps, &settings(40, 1)).unwrap();
        let points = curve_points(&sweeps, &found, 0.95).unwrap();
        (Subject { actuator: "brake_2", command_unit: "V", response_unit: "N" }, found, points)
    }

    #[test]
    fn rows_come_back_from_their_tables_with_the_units_of_the_sweeps() {
        let (subject, found, points) = found();
        let (models, parameters, curve) = (
            subject.models_table(&found).unwrap(),
            subject.parameters_table(&found).unwrap(),
            subject.curve_table(&points).unwrap(),
        );
        assert_eq!(models.to_rows::<FittedModel>().unwrap(), fitted_models(&found));
        assert_eq!(parameters.to_rows::<FittedParameter>().unwrap(), fitted_parameters(&found));
        assert_eq!(curve.to_rows::<CurvePoint>().unwrap(), points);
        assert_eq!(curve.unit_for::<CurvePoint>(UNIT_OF_COMMAND), Some("V"));
        assert_eq!(curve.unit_for::<CurvePoint>(UNIT_OF_RESPONSE), Some("N"));
        assert_eq!(models.name(), "characteristic.brake_2");
        assert_eq!(models.title(), "Characteristic of the brake 2: candidate models");
        assert_eq!(models.column("rms").unwrap().field.unit, "N");
        assert_eq!(models.notes().len(), 3);
    }

    #[test]
    fn a_chosen_curve_is_of_newtons_against_volts_and_has_all_its_parameters() {
        let (_, found, curve) = found();
        let fit = Fit {
            models: fitted_models(&found),
            parameters: fitted_parameters(&found),
            curve,
            command_unit: "V".to_owned(),
            response_unit: "N".to_owned(),
        };
        let chosen = fit.chosen("motor").unwrap();
        assert_eq!(chosen.model.name, CurveModel::Line);
        assert_eq!((chosen.parameters.len(), chosen.voltage_v), (2, (0.0, 4.0)));
        let refused = |fit: Fit| fit.chosen("motor").err().unwrap().to_string();
        let counts = Fit { response_unit: "counts".to_owned(), ..fit.clone() };
        assert!(refused(counts).contains("counts against V"));
        let few = Fit { parameters: Vec::new(), ..fit.clone() };
        assert!(refused(few).contains("make them again"));
        assert!(refused(Fit { models: Vec::new(), ..fit }).contains("make them again"));
    }
}
