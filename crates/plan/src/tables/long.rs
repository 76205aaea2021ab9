//! Tables that are too long to be read: they are written only for programs.

use crate::{compare, identify, replay};
use std::collections::BTreeSet;
use zwidth_store::{StudyData, TrialEntry};

/// Rows from which on a table that has more the more trials or participants there are is written for
/// programs alone: printed, these would be a hundred pages.
const MOST_READ: usize = 5000;

/// The names of the tables that may have more rows than anybody reads.
pub(crate) fn for_programs(data: &StudyData) -> BTreeSet<String> {
    longer_than(MOST_READ, data)
}

fn longer_than(most: usize, data: &StudyData) -> BTreeSet<String> {
    let study = &data.study;
    let trials = data.counting().count();
    let several = |part: fn(&TrialEntry) -> [&str; 4]| -> usize {
        // One by one: a set that is collected is a list of all trials first.
        let mut found = BTreeSet::new();
        found.extend(data.counting().map(part));
        found.len()
    };
    let people = several(|t| [t.meta.participant.as_str(), "", "", ""]);
    let conditions = several(|TrialEntry { meta: m, .. }| {
        [m.participant.as_str(), m.session.as_str(), m.environment.as_str(), m.mode.as_str()]
    });
    let contrasts = people * study.environments.len() * study.compare.contrasts.len();
    let rows = [
        ("metrics", trials),
        ("replay", trials * replay::rows_of_a_trial(data)),
        ("identify.trials", identify::taken(data).0.len()),
        ("conditions", conditions),
        ("answers", data.answers.len() + data.answers_left_out.len()),
    ];
    let rows = rows.map(|(name, rows)| (name.to_owned(), rows)).into_iter();
    let compared = compare::compared(data).into_iter();
    let compared = compared.map(|metric| (format!("participants_{metric}"), contrasts));
    let long = rows.chain(compared).filter(|(_, rows)| *rows > most);
    long.map(|(name, _)| name).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::data;

    #[test]
    fn a_table_with_more_rows_than_anybody_reads_is_for_programs_alone() {
        let study = data();
        assert_eq!(study.counting().count(), 2);
        let long = |most| longer_than(most, &study).into_iter().collect::<Vec<_>>();
        // Two trials, of one condition; each is replayed with two models three ways.
        assert_eq!((long(12), long(2)), (vec![], vec!["replay".to_owned()]));
        assert_eq!(long(1), ["metrics", "replay"]);
        assert_eq!(long(0)[..2], ["conditions", "metrics"]);
        assert!(for_programs(&study).is_empty());
    }
}
