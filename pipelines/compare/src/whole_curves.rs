//! The comparison of whole curves: of several people, or of one participant's trials, and their claims.

use crate::claim::{Judging, judge};
use crate::curves::{CurveParameters, Curves, People, Row, SessionCurve, compared, rows};
use crate::{CompareError, curves_within};
use rayon::prelude::*;
use zwidth_study::Families;

/// Compares whole curves: everybody's sessions are averaged with equal weight, at the angles or times that all people of
/// a comparison reach in each of its modes, and a branch that one of them lacks is left out. Of one participant the
/// curves of trials are compared. Each curve is a family of its own, but for primary ones that are adjusted together.
///
/// # Errors
/// A level that cannot be one.
pub fn compare_curves(
    sessions: &[SessionCurve],
    parameters: &CurveParameters,
) -> Result<Curves, CompareError> {
    let mut compared_curves = Vec::new();
    for curve in &parameters.curves {
        let own: Vec<&SessionCurve> = sessions.iter().filter(|one| one.curve == *curve).collect();
        let rows = if own.iter().any(|one| one.trial.is_some()) {
            curves_within::rows(&own, parameters)
        } else {
            // The order of results is that of the comparisons, on any number of threads.
            let comparisons = compared(&own, parameters);
            let rows = comparisons.par_iter().map(|comparison| {
                let people = People::of(&own, &comparison.weights, parameters);
                rows(comparison, &people, parameters)
            });
            rows.collect::<Vec<Vec<Row>>>().into_iter().flatten().collect()
        };
        compared_curves.push((*curve, rows));
    }
    let CurveParameters { families, alpha, metric_claims: elsewhere, .. } = *parameters;
    let judging = Judging { families, alpha, elsewhere: 0 };
    let (joined, others) = compared_curves.iter_mut().partition::<Vec<_>, _>(|(curve, _)| {
        families == Families::Study && parameters.primary.contains(curve)
    });
    let joined = joined.into_iter().flat_map(|(_, rows)| rows).map(|row| &mut row.claim);
    judge(joined.collect(), Judging { elsewhere, ..judging })?;
    for (_, rows) in others {
        judge(rows.iter_mut().map(|row| &mut row.claim).collect(), judging)?;
    }
    let mut all = Curves::default();
    for (curve, rows) in compared_curves {
        for row in rows {
            row.add_to(&mut all, curve, parameters);
        }
    }
    Ok(all)
}
