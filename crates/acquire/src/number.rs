//! The numbers by which a session is counterbalanced.
//!
//! The digits at the end of an id are its number. An id without digits gets its place among all
//! such ids that have appeared in the study so far, and keeps it: every session's record holds both
//! numbers.

use std::collections::BTreeMap;
use std::path::Path;
use zwidth_store::{Files, Layout, StoreError, read_records};
use zwidth_study::{ParticipantId, SessionId};

/// The numbers of a session, and remarks on them for the operator.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Numbers {
    pub(crate) participant: u32,
    pub(crate) session: u32,
    pub(crate) remarks: Vec<String>,
}

/// The number at the end of an id, if it has one below 2³².
pub fn number(id: &str) -> Option<u32> {
    let letters = id.trim_end_matches(|c: char| c.is_ascii_digit()).len();
    id[letters..].parse().ok()
}

/// The numbers of a session that begins, by the records of those before it.
///
/// # Errors
/// A record that cannot be read, where an id without a number could stand in it.
pub(crate) fn numbers(
    files: &dyn Files,
    layout: &Layout,
    participant: &ParticipantId,
    session: &SessionId,
) -> Result<Numbers, StoreError> {
    let all = number(participant.as_str()).is_none() || number(session.as_str()).is_none();
    // Where every id has its number, nothing need be read: a whole simulated study is as fast as
    // its trials.
    let records = read_records(files, layout, &|path| all || may_lack_a_number(path))?;
    let mut participants = BTreeMap::new();
    let mut sessions = BTreeMap::new();
    for record in &records {
        // An imported session has no order, and so no numbers.
        let Some(order) = record.order else { continue };
        participants.insert(record.participant.as_str(), order.participant_number);
        sessions.insert(record.session.as_str(), order.session_number);
    }
    let (participant, first) = number_of("participant", participant.as_str(), &participants);
    let (session, second) = number_of("session", session.as_str(), &sessions);
    Ok(Numbers { participant, session, remarks: first.into_iter().chain(second).collect() })
}

/// Whether the ids in a record's name, `<participant>_<session>`, may be without a number; an id
/// may hold a `_`, too.
fn may_lack_a_number(record: &Path) -> bool {
    let name =
        record.file_stem().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    name.match_indices('_')
        .any(|(at, _)| number(&name[..at]).is_none() || number(&name[at + 1..]).is_none())
}

/// The number of an id, and a remark on it; `earlier` has the numbers of the ids before it.
fn number_of(kind: &str, id: &str, earlier: &BTreeMap<&str, u32>) -> (u32, Option<String>) {
    if let Some(digits) = number(id) {
        let namesake = earlier.iter().find(|(other, n)| **n == digits && number(other).is_none());
        return (digits, namesake.map(|(other, _)| {
            format!(
                "{kind} {id} has number {digits} in the counterbalancing, as {kind} {other} has, which got it by order of \
                 appearance; give new ids numbers of their own"
            )
        }));
    }
    let (n, how) = match earlier.get(id) {
        Some(n) => (*n, "as before"),
        None => {
            let place = u32::try_from(earlier.len()).unwrap_or(u32::MAX).saturating_add(1);
            // An id with digits may have the number of that place already.
            let free = (place..=u32::MAX).find(|n| !earlier.values().any(|other| other == n));
            (free.unwrap_or(place), "by order of appearance")
        }
    };
    let remark =
        format!("{kind} {id} ends in no number: it is counterbalanced as number {n}, {how}");
    (n, Some(remark))
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_store::{RealFiles, write_new};
    use zwidth_study::{OrderRecord, OrderScheme, SessionRecord, Source};

    #[test]
    fn the_digits_at_the_end_of_an_id_are_its_number_and_an_id_without_any_has_none() {
        for (id, expect) in
            [("P01", Some(1)), ("S12", Some(12)), ("P2b7", Some(7)), ("007", Some(7))]
        {
            assert_eq!(number(id), expect, "{id}");
        }
        for id in ["anna", "pre", "P1x", "P99999999999999999999"] {
            assert_eq!(number(id), None, "{id}");
        }
    }

    /// A study in which sessions are laid down one after another.
    struct Study {
        _folder: tempfile::TempDir,
        layout: Layout,
    }

    impl Study {
        fn new() -> Self {
            let folder = tempfile::tempdir().unwrap();
            let layout = Layout::new(folder.path(), "s".parse().unwrap());
            Self { _folder: folder, layout }
        }

        fn asked(&self, participant: &str, session: &str) -> Numbers {
            numbers(
                &RealFiles,
                &self.layout,
                &participant.parse().unwrap(),
                &session.parse().unwrap(),
            )
            .unwrap()
        }

        /// Lays a session down; its numbers, and how many remarks there are.
        fn add(&self, participant: &str, session: &str) -> (u32, u32, usize) {
            let numbers = self.asked(participant, session);
            let (participant, session) = (participant.parse().unwrap(), session.parse().unwrap());
            let path = self.layout.session(&participant, &session);
            let mut record =
                SessionRecord::new(participant, session, Source::Twin, "", "", Vec::new());
            let scheme = OrderScheme::Williams;
            let Numbers { participant: participant_number, session: session_number, remarks } =
                numbers;
            record.order = Some(OrderRecord { scheme, participant_number, session_number });
            write_new(&RealFiles, &path, record.to_json().unwrap().as_bytes()).unwrap();
            (participant_number, session_number, remarks.len())
        }
    }

    #[test]
    fn ids_without_a_number_are_numbered_by_order_of_appearance_and_keep_their_number() {
        let study = Study::new();
        assert_eq!(study.add("bert", "pre"), (1, 1, 2));
        assert_eq!(study.add("anna", "post"), (2, 2, 2));
        assert_eq!(study.add("anna", "pre"), (2, 1, 2));
        assert_eq!(study.add("bert", "post"), (1, 2, 2));
        assert_eq!(study.add("carl", "S01"), (3, 1, 2), "S01 has the number of pre");
        let remarks = study.asked("anna", "later").remarks;
        assert_eq!(
            remarks,
            [
                "participant anna ends in no number: it is counterbalanced as number 2, as before",
                "session later ends in no number: it is counterbalanced as number 4, by order of appearance",
            ]
        );
    }

    #[test]
    fn ids_with_a_number_have_it_and_those_without_take_none_that_is_taken() {
        let study = Study::new();
        assert_eq!(study.add("P01", "S01"), (1, 1, 0));
        assert_eq!(study.add("P03", "S01"), (3, 1, 0));
        assert_eq!(study.add("anna", "S02"), (4, 2, 1), "third to appear, and 3 is taken");
        assert_eq!(study.add("P02", "S01"), (2, 1, 0));
        let late = study.asked("P04", "S01");
        assert!(
            late.participant == 4 && late.remarks[0].contains("as participant anna has"),
            "{late:?}"
        );
    }

    #[test]
    fn sessions_of_numbered_ids_read_no_record_and_a_damaged_one_is_told_to_others() {
        let study = Study::new();
        write_new(&RealFiles, &study.layout.sessions().join("P01_S01.json"), b"{").unwrap();
        assert_eq!(study.asked("P02", "S01").participant, 2);
        let error =
            numbers(&RealFiles, &study.layout, &"anna".parse().unwrap(), &"S01".parse().unwrap())
                .unwrap_err();
        assert!(error.to_string().contains("P01_S01.json"), "{error}");
        assert!(
            !may_lack_a_number(Path::new("x/P01_S01.json"))
                && may_lack_a_number(Path::new("a_b1_S01.json"))
        );
    }
}
