//! The contrasts of every metric in one table, as a paper prints them.

use crate::notes::of_whom;
use crate::{CompareError, Parameters};
use zwidth_results::{Compared, ModeDifference, PrintedDifference, Role, UnitOfAnalysis};
use zwidth_study::Families;
use zwidth_tables::Table;

/// The contrasts of all metrics one below the other, each in its own unit: what a paper prints of
/// them.
///
/// # Errors
/// A number that is none.
pub fn together(
    metrics: &[Compared],
    contrasts: &[ModeDifference],
    parameters: &Parameters,
) -> Result<Table, CompareError> {
    let has_groups = parameters.groups.is_some();
    let printed = Table::of_rows(contrasts)?.to_rows::<PrintedDifference>()?;
    let table = Table::of_rows(&printed)?.without_empty_columns();
    let Some(first) = metrics.first() else { return Ok(table) };
    let test = match first.unit_of_analysis {
        UnitOfAnalysis::TrialsOf(_) => {
            "p: the sharp null, that no trial depended on mode. Intervals describe the trials."
        }
        UnitOfAnalysis::Participants if has_groups => {
            "t and p: the participants' differences, each group with the same weight, degrees of freedom of \
             Satterthwaite."
        }
        UnitOfAnalysis::Participants => {
            "t and p: the participants' differences, n − 1 degrees of freedom."
        }
    };
    let primary = metrics.iter().filter(|metric| metric.role == Role::Primary);
    let primary: Vec<&str> = primary.map(|metric| metric.words.as_str()).collect();
    let claims = match primary.as_slice() {
        [] => "The primary metric is not among these: all are exploratory.".to_owned(),
        [words] => {
            format!("Claims rest on the primary metric, {words}; the others are exploratory.")
        }
        several => format!(
            "Claims rest on the primary metrics ({}); the others are exploratory.",
            several.join("; ")
        ),
    };
    let family = match parameters.families {
        Families::Study if primary.len() > 1 => {
            "the primary metrics one family, each other metric one"
        }
        Families::Metric | Families::Study => "each metric a family",
        Families::Environment => "each environment of a metric a family",
    };
    let family = match has_groups && first.unit_of_analysis == UnitOfAnalysis::Participants {
        true => format!("{family} of its own, with its differences between groups"),
        false => format!("{family} of its own"),
    };
    let shares = match (parameters.curve_claims, primary.len()) {
        (0, _) | (_, 0) => "",
        (_, 1) => "; the primary metric shares alpha with primary curves (Bonferroni)",
        _ => "; the primary metrics share alpha with primary curves (Bonferroni)",
    };
    let family = &*format!("p adjusted after Holm, {family}{shares}; intervals are not adjusted.");
    let table = table.with_note(of_whom(&first.unit_of_analysis)).with_note(test);
    Ok(table.with_note(claims).with_note(family))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{four, metrics, parameters};
    use crate::{MetricParameters, compare};
    use zwidth_tables::{Column, Measured, for_people};

    fn both(primary: &[&str], families: Families) -> (Table, Vec<ModeDifference>) {
        let steps = metrics(&four());
        let angles = steps.numbers("step_n").unwrap();
        let angles = Column::float("past_rad", "rad", "an angle", angles);
        let columns = [steps.table().columns(), &[angles]];
        let of = |metric: &str| MetricParameters {
            metric: metric.parse().unwrap(),
            primary: primary.contains(&metric),
            ..parameters().metrics[0].clone()
        };
        let both = ["past_rad", "step_n"].map(of).to_vec();
        let parameters = crate::Parameters { metrics: both, families, ..parameters() };
        let table = Table::new("metrics", "", columns.concat()).unwrap();
        let found = compare(&Measured::of(table).unwrap(), &parameters).unwrap();
        let table = together(&found.metrics, &found.contrasts, &parameters).unwrap();
        (table, found.contrasts)
    }

    #[test]
    fn every_metric_has_its_rows_in_its_unit_and_the_claims_are_named() {
        let (table, _) = both(&["step_n"], Families::Metric);
        let texts = |name| table.texts(name).unwrap().into_iter().flatten().collect::<Vec<_>>();
        assert_eq!(texts("metric"), ["past_rad", "past_rad", "step_n", "step_n"]);
        assert_eq!(texts("unit"), ["rad", "rad", "N", "N"]);
        let notes: Vec<&str> = table.notes_by_kind().map(|(_, note)| note).collect();
        assert!(notes[0].starts_with("n counts participants"), "{notes:?}");
        assert!(notes[2].starts_with("Claims rest on the primary metric, a step;"), "{notes:?}");
        let people = for_people(&table, zwidth_study::Coordinate::Rotational).unwrap();
        assert_eq!(people.texts("unit").unwrap()[0].as_deref(), Some("°"));
        let (own, told) =
            (table.floats("difference").unwrap(), people.floats("difference").unwrap());
        assert!((told[0].unwrap() - own[0].unwrap().to_degrees()).abs() < 1e-12);
        assert_eq!(told[2], own[2]);
    }

    #[test]
    fn what_no_metric_has_is_no_column_and_without_the_primary_one_nothing_is_claimed() {
        let (table, _) = both(&["other_n"], Families::Metric);
        assert!(table.column("d_av").is_err() && table.column("difference_jnd").is_err());
        assert!(table.notes_by_kind().any(|(_, note)| note.ends_with("all are exploratory.")));
        assert_eq!(together(&[], &[], &parameters()).unwrap().height(), 0);
    }

    /// The two metrics have the same values, so each adjusted p of one metric is met twice in the family of
    /// both: Holm's factors are 4 and 3 for the smaller p, 2 and 1 for the larger one, of which the first counts.
    #[test]
    fn the_claims_of_several_primary_metrics_are_adjusted_together() {
        let metrics = ["past_rad", "step_n"];
        let (_, apart) = both(&metrics, Families::Metric);
        let (table, joined) = both(&metrics, Families::Study);
        let mut raw: Vec<f64> = apart[..2].iter().map(|row| row.p_value.unwrap()).collect();
        raw.sort_by(f64::total_cmp);
        for (row, alone) in joined.iter().zip(&apart) {
            let p = row.p_value.unwrap();
            let by_hand = if p.to_bits() == raw[0].to_bits() {
                4.0 * p
            } else {
                f64::max(4.0 * raw[0], 2.0 * p)
            };
            assert!((row.p_adjusted.unwrap() - by_hand.min(1.0)).abs() < 1e-15);
            assert!(row.p_adjusted > alone.p_adjusted);
        }
        let notes: Vec<&str> = table.notes_by_kind().map(|(_, note)| note).collect();
        assert!(
            notes[2].starts_with("Claims rest on the primary metrics (an angle; a step);"),
            "{notes:?}"
        );
        assert!(
            notes[3].contains("the primary metrics one family, each other metric one of its own"),
            "{notes:?}"
        );
    }

    #[test]
    fn claims_on_primary_curves_take_their_share_of_alpha() {
        let of = |curve_claims| {
            let own = MetricParameters { primary: true, ..parameters().metrics[0].clone() };
            let parameters = crate::Parameters {
                metrics: vec![own],
                families: Families::Study,
                curve_claims,
                ..parameters()
            };
            let found = compare(&metrics(&four()), &parameters).unwrap();
            let table = together(&found.metrics, &found.contrasts, &parameters).unwrap();
            let notes: Vec<String> =
                table.notes_by_kind().map(|(_, note)| note.to_owned()).collect();
            (found.contrasts, notes[3].clone(), found.notes)
        };
        let (alone, _, _) = of(0);
        let (beside, note, notes) = of(6);
        for (alone, beside) in alone.iter().zip(&beside) {
            let [alone, beside] = [alone, beside].map(|row| row.p_adjusted.unwrap());
            assert!((beside - (4.0 * alone).min(1.0)).abs() < 1e-15, "two claims beside six");
        }
        assert!(note.contains("the primary metric shares alpha with primary curves"), "{note}");
        let is_told = |note: &zwidth_results::MetricNote| {
            note.note.to_string().contains("after Bonferroni for 6 claims on primary curves")
        };
        assert!(notes.iter().any(is_told));
    }

    #[test]
    fn an_exploratory_metric_is_a_family_of_its_own_beside_primary_ones() {
        let (_, apart) = both(&["step_n"], Families::Metric);
        let (_, beside) = both(&["step_n"], Families::Study);
        let adjusted =
            |rows: &[ModeDifference]| rows.iter().map(|row| row.p_adjusted).collect::<Vec<_>>();
        assert_eq!(adjusted(&apart), adjusted(&beside));
    }
}
