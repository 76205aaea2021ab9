//! Answers on any scale, and the time that they took, from the journal into the log.

use crate::tests::crashes::{FOUR, UTC, ended, folder_with_study, meta, protocol};
use crate::{RealFiles, StudyData, append_events, read_events, recover};
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
        let journal = ended(&RealFiles, &layout, 20);
        journal.finish(&RealFiles, &layout, Some(given), UTC).unwrap().unwrap();
        let log = layout.events(&meta(1).participant, &meta(1).session);
        let (question, value) = (protocol().question.unwrap(), given.value.into());
        let answer = Event::Answer { trial: 1, question, value, time_ms: given.time_ms };
        assert_eq!(read_events(&log).unwrap().last(), Some(&answer));
        assert!(recover(&RealFiles, &layout, UTC).is_empty());
    }
}

#[test]
fn an_answer_that_does_not_count_says_why() {
    let (_folder, layout) = folder_with_study();
    ended(&RealFiles, &layout, 20).finish(&RealFiles, &layout, FOUR, UTC).unwrap().unwrap();
    let log = layout.events(&meta(1).participant, &meta(1).session);
    let question = protocol().question.unwrap();
    let answer = |value: i16| {
        let (question, value) = (question.clone(), value.into());
        Event::Answer { trial: 1, question, value, time_ms: None }
    };
    let check = |events: &[Event], counting: &[i16], left_out: &[(i16, &str)]| {
        append_events(&RealFiles, &log, UTC, events).unwrap();
        let data = StudyData::load(&layout).unwrap();
        assert_eq!(
            data.answers.iter().map(|a| a.value).collect::<Vec<_>>(),
            counting.iter().map(|value| (*value).into()).collect::<Vec<_>>()
        );
        let others = data.answers_left_out.iter().map(|a| (a.answer.value, a.why_not.as_str()));
        assert_eq!(
            others.collect::<Vec<_>>(),
            left_out.iter().map(|(value, why)| ((*value).into(), *why)).collect::<Vec<_>>()
        );
    };
    check(&[], &[4], &[]);
    let replaced = "a later answer took its place";
    check(&[answer(4), answer(2), answer(2)], &[2], &[(4, replaced)]);
    let excluded = "excluded: the phone rang";
    let exclusion = Event::Excluded { trial: 1, reason: "the phone rang".to_owned() };
    check(&[exclusion], &[], &[(4, excluded), (2, excluded)]);
}
