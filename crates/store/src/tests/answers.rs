//! Answers on any scale, and the time that they took, from the journal into the log.

use crate::tests::crashes::{UTC, folder_with_study, meta, protocol, rows};
use crate::{Journal, RealFiles, TrialFile, read_events, recover};
use zwidth_study::{Event, Given};

#[test]
fn an_answer_below_zero_and_its_time_come_from_the_journal_into_the_log() {
    for given in [
        Given { value: -3, time_ms: Some(1_234) },
        Given { value: -1_000, time_ms: None },
        Given { value: 100, time_ms: Some(0) },
        Given { value: 300, time_ms: None },
    ] {
        let (_folder, layout) = folder_with_study();
        let mut journal =
            Journal::create(&RealFiles, &layout, &meta(1), &TrialFile::new(), &protocol()).unwrap();
        journal.append(&rows(0, 20)).unwrap();
        journal.end().unwrap();
        journal.finish(&RealFiles, &layout, Some(given), UTC).unwrap().unwrap();
        let log = layout.events(&meta(1).participant, &meta(1).session);
        let (question, value) = (protocol().question.unwrap(), given.value.into());
        let answer = Event::Answer { trial: 1, question, value, time_ms: given.time_ms };
        assert_eq!(read_events(&log).unwrap().last(), Some(&answer));
        assert!(recover(&RealFiles, &layout, UTC).is_empty());
    }
}
