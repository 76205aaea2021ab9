//! Whether recordings confirm the choices of a study.

use crate::held_out::{Knobs, Tried};
use zwidth_results::{
    BorneOut, HeldOutModel, LadderChoice, LadderCondition, Row, TermSet, TriedModel,
};
use zwidth_study::Perception;
use zwidth_tables::{Table, TableError};

/// The notes below the table of one condition, and below that of a study.
const NOTES: [&str; 3] = [
    "Every second trial of a condition is fitted; the others are predicted from their recorded force, and their error is given.",
    "Without a term: the choice without it, fitted anew. The term is missed if that predicts worse.",
    "Confirmed: neither the fullest model nor the choice without a term has an error smaller by more than a tenth.",
];
/// An error is another one if it is smaller by more than this share. Assumed: half of a condition's
/// repeats do not tell finer ones apart.
const SMALLER: f64 = 0.1;

/// Models compared with a condition's trials, one row per model.
pub fn held_out_models(
    condition: &LadderCondition,
    tried: &[Tried],
    trials: usize,
    bounds: &Perception,
) -> Vec<HeldOutModel> {
    tried
        .iter()
        .map(|Tried { role, held_out }| HeldOutModel {
            condition: condition.clone(),
            model: *role,
            terms: held_out.set,
            trials,
            inertia_factor: held_out.knobs.inertia,
            dry_factor: held_out.knobs.dry,
            viscous_factor: held_out.knobs.viscous,
            brake_lag_factor: held_out.knobs.brake_lag,
            weight_factor: held_out.knobs.weight,
            fitted_rmse_rad: finite(held_out.fitted_rad),
            held_out_rmse_rad: finite(held_out.held_out_rad),
            felt_share: finite(held_out.held_out_rad / bounds.angle_rad),
        })
        .collect()
}

/// The error of a model that does not run is infinite.
fn finite(number: f64) -> Option<f64> {
    Some(number).filter(|number| number.is_finite())
}

/// The table of [`held_out_models`], or of [`choices`].
///
/// # Errors
/// A number that is not finite where one must be.
pub fn held_out_table<R: Row>(rows: &[R]) -> Result<Table, TableError> {
    Ok(NOTES.into_iter().fold(Table::of_rows(rows)?, |table, note| table.with_note(note)))
}

/// The choice of each condition. `conditions` are of [`held_out_models`]; one without rows is left
/// out.
pub fn choices(conditions: &[Vec<HeldOutModel>]) -> Vec<LadderChoice> {
    conditions.iter().filter_map(|models| choice(models)).collect()
}

fn choice(models: &[HeldOutModel]) -> Option<LadderChoice> {
    let own = models.iter().find(|tried| tried.model == TriedModel::Choice)?;
    let fullest = models.iter().find(|tried| tried.model == TriedModel::Fullest);
    let mut less: Vec<&HeldOutModel> =
        models.iter().filter(|tried| tried.model.lacks().is_some()).collect();
    // The best first.
    less.sort_by(|a, b| error(a).total_cmp(&error(b)));
    let least = less.first().copied();
    let most = less.last().copied();
    Some(LadderChoice {
        condition: own.condition.clone(),
        terms: own.terms,
        trials: own.trials,
        fitted_rmse_rad: own.fitted_rmse_rad,
        held_out_rmse_rad: own.held_out_rmse_rad,
        felt_share: own.felt_share,
        fullest_rmse_rad: fullest.and_then(|tried| tried.held_out_rmse_rad),
        least_missed: least.and_then(|tried| tried.model.lacks()),
        least_missed_rmse_rad: least.and_then(|tried| tried.held_out_rmse_rad),
        most_missed: most.and_then(|tried| tried.model.lacks()),
        most_missed_rmse_rad: most.and_then(|tried| tried.held_out_rmse_rad),
        recordings: borne_out(own, least, fullest),
    })
}

/// The error on the trials held out; infinite where nothing was predicted or the model does not
/// run, so that it comes last.
fn error(tried: &HeldOutModel) -> f64 {
    tried.held_out_rmse_rad.unwrap_or(f64::INFINITY)
}

/// Whether the recordings confirm a choice; `None` where nothing was predicted, as with one trial.
fn borne_out(
    choice: &HeldOutModel,
    least_missed: Option<&HeldOutModel>,
    fullest: Option<&HeldOutModel>,
) -> Option<BorneOut> {
    let own = choice.held_out_rmse_rad?;
    let [least_missed, fullest] = [least_missed, fullest]
        .map(|tried| tried.filter(|tried| error(tried) < (1.0 - SMALLER) * own));
    let without = least_missed.and_then(|tried| tried.model.lacks());
    Some(match (without, fullest) {
        (Some(term), _) => BorneOut::BetterWithout(term),
        (None, Some(_)) => BorneOut::FullestIsBetter,
        (None, None) => BorneOut::Confirmed,
    })
}

/// The choice of a condition, and its fit; `None` if nothing was fitted.
pub fn fitted(models: &[HeldOutModel]) -> Option<(TermSet, Knobs)> {
    let choice = models.iter().find(|tried| tried.model == TriedModel::Choice)?;
    let knobs = Knobs {
        inertia: choice.inertia_factor,
        dry: choice.dry_factor,
        viscous: choice.viscous_factor,
        brake_lag: choice.brake_lag_factor,
        weight: choice.weight_factor,
    };
    Some((choice.terms, knobs))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::held_out::HeldOut;
    use zwidth_results::LadderTerm;

    const CHOICE: TermSet = TermSet::NONE.with(LadderTerm::Friction).with(LadderTerm::BrakeLag);

    fn row(role: TriedModel, set: TermSet, held_out_rad: f64) -> Tried {
        let knobs = Knobs { weight: 0.5, ..Knobs::USUAL };
        Tried { role, held_out: HeldOut { set, knobs, fitted_rad: 0.01, held_out_rad } }
    }

    /// Held-out errors of the choice, without friction, without the brake's lag, of the fullest.
    fn of(errors: [f64; 4]) -> Vec<HeldOutModel> {
        let [friction, lag] = [LadderTerm::Friction, LadderTerm::BrakeLag];
        let tried = [
            row(TriedModel::Choice, CHOICE, errors[0]),
            row(TriedModel::Without(friction), CHOICE.without(friction), errors[1]),
            row(TriedModel::Without(lag), CHOICE.without(lag), errors[2]),
            row(TriedModel::Fullest, TermSet::ALL, errors[3]),
        ];
        let condition = "spring hybrid".parse().unwrap();
        held_out_models(&condition, &tried, 6, &Perception::default())
    }

    fn joined(errors: [f64; 4]) -> LadderChoice {
        choices(&[of(errors), Vec::new()]).remove(0)
    }

    #[test]
    fn a_choice_that_nothing_betters_by_a_tenth_is_confirmed() {
        let found = joined([0.02, 0.09, 0.019, 0.0185]);
        assert_eq!(found.recordings, Some(BorneOut::Confirmed));
        assert_eq!(found.least_missed, Some(LadderTerm::BrakeLag));
        assert_eq!(found.most_missed, Some(LadderTerm::Friction));
    }

    #[test]
    fn a_term_that_the_recordings_do_not_want_is_named_before_the_fullest() {
        let verdict = |errors| joined(errors).recordings;
        let without_lag = BorneOut::BetterWithout(LadderTerm::BrakeLag);
        assert_eq!(verdict([0.02, 0.09, 0.01, 0.01]), Some(without_lag));
        assert_eq!(verdict([0.02, 0.09, 0.03, 0.01]), Some(BorneOut::FullestIsBetter));
        assert_eq!(verdict([f64::INFINITY; 4]), None);
    }

    #[test]
    fn what_was_fitted_is_read_back_for_the_replays() {
        let rows: Vec<HeldOutModel> = held_out_table(&of([0.02; 4])).unwrap().to_rows().unwrap();
        assert_eq!(rows, of([0.02; 4]));
        let (set, knobs) = fitted(&rows).unwrap();
        assert_eq!((set, knobs), (CHOICE, Knobs { weight: 0.5, ..Knobs::USUAL }));
        let share = rows[0].felt_share.unwrap();
        assert!((share - 0.02_f64.to_degrees() / 2.0).abs() < 1e-12);
    }
}
