//! How differences between modes change with a number of people, such as their age.

use crate::Parameters;
use crate::cells::Cells;
use crate::contrasts::Row;
use crate::measure::Measure;
use zwidth_results::CovariateSlope;
use zwidth_stats::line::common_slope;
use zwidth_study::counted;

/// With fewer people there is no slope: one of them would make it.
const LEAST: usize = 10;

/// The slope of people's differences over each number that the study names.
pub(crate) fn slopes(
    contrasts: &[Row],
    cells: &Cells,
    measure: &Measure,
    parameters: &Parameters,
) -> Vec<CovariateSlope> {
    let mut rows = Vec::new();
    for row in contrasts {
        for covariate in &parameters.covariates {
            let known = row.differences.iter().filter_map(|one| {
                let number = covariate.numbers.get(&cells.participants[one.participant])?;
                Some([*number, one.estimate])
            });
            let points: Vec<[f64; 2]> = known.collect();
            let n = points.len();
            let count = n.max(1) as f64;
            let [number, difference] =
                [0, 1].map(|i| points.iter().map(|point| point[i]).sum::<f64>() / count);
            let squares: f64 = points.iter().map(|point| (point[0] - number).powi(2)).sum();
            let found = match n {
                LEAST.. => common_slope(&[points], parameters.level).map_err(|why| why.to_string()),
                _ => Err(format!(
                    "{} with a known {}, {LEAST} are needed",
                    counted(n, "participants"),
                    covariate.column
                )),
            };
            let tested = found.as_ref().ok();
            rows.push(CovariateSlope {
                metric: measure.parameters.metric.clone(),
                unit: measure.unit.clone(),
                environment: parameters.environments[row.claim.environment].clone(),
                contrast: row.contrast.clone(),
                covariate: covariate.column.clone(),
                covariate_unit: covariate.unit.clone(),
                n,
                difference_per_unit: tested.map(|t| t.estimate),
                difference_per_unit_std_error: tested.map(|t| t.std_error),
                difference_per_unit_ci_low: tested.map(|t| t.ci_low),
                difference_per_unit_ci_high: tested.map(|t| t.ci_high),
                statistic: tested.map(|t| t.statistic),
                df: tested.map(|t| t.df),
                p_value: tested.map(|t| t.p_value),
                covariate_mean: (n > 0).then_some(number),
                difference_at_mean: (n > 0).then_some(difference),
                difference_at_mean_std_error: tested
                    .map(|t| t.std_error * (squares / count).sqrt()),
                remark: found.as_ref().err().map(|why| why.clone().into()),
            });
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use crate::groups::tests::{code, comparison, near};
    use crate::tests::parameters;
    use crate::{Covariate, Parameters};

    /// Ages of so many of the twelve people.
    fn over_age(people: u64) -> Parameters {
        let age = Covariate {
            column: "age_years".parse().unwrap(),
            unit: "years".to_owned(),
            numbers: (1..=people).map(|p| (code(p), (19 + 7 * p % 23) as f64)).collect(),
        };
        Parameters { covariates: vec![age], ..parameters() }
    }

    /// R 4.2: `summary(lm(c ~ I(age - mean(age))))`; NumPy.
    #[test]
    fn the_slope_over_a_number_of_people_is_that_of_r() {
        let found = comparison(&over_age(12)).covariates;
        let row = &found[0];
        assert_eq!((row.n, found.len()), (12, 2));
        near(row.difference_per_unit, -0.0400901549);
        near(row.difference_per_unit_std_error, 0.0247294347);
        near(row.df, 10.0);
        near(row.p_value, 0.136052006);
        near(row.difference_at_mean, 0.665875);
        near(row.difference_at_mean_std_error, 0.151772394);
    }

    #[test]
    fn fewer_than_ten_people_have_no_slope_and_a_reason() {
        let found = comparison(&over_age(9)).covariates;
        assert_eq!((found[0].n, found[0].difference_per_unit, found[0].p_value), (9, None, None));
        let why = found[0].remark.as_ref().unwrap().to_string();
        assert_eq!(why, "9 participants with a known age_years, 10 are needed");
        assert!(comparison(&parameters()).covariates.is_empty());
    }
}
