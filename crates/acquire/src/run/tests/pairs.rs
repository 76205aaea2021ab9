//! The pairs of a weighted TLX: asked once in a session, in an order of its own.

use super::*;
use crate::About;
use zwidth_study::{AnswerScale, AnswerValue};

const ITEMS: [&str; 6] = ["mental", "physical", "temporal", "performance", "effort", "frustration"];

/// The small study with a weighted TLX after the trials of one of its two environments.
fn tlx(blinded: bool) -> Desk {
    let questions = ITEMS.map(|id| {
        format!("[[questions]]\nid = \"{id}\"\ntext = \"How {id}?\"\nlabel = \"{id}\"\npoints = 11\nfrom = 0\n")
    });
    let list = ITEMS.map(|id| format!("\"{id}\"")).join(", ");
    let text = small("small", blinded).replacen(
        "question = \"felt_wall\"",
        &format!("questions = [{list}]"),
        1,
    );
    assert!(text.contains(&list), "the template lost a question");
    Desk::with(format!(
        "{text}\n{}\n[[scores]]\nid = \"load\"\nkind = \"nasa_tlx\"\nquestions = [{list}]\npairs = \"Which of the two?\"\n",
        questions.concat()
    ))
}

/// Somebody to whom each question is as much as its place in the list, who chooses the later one of each two, and whose
/// session is killed when this question of its trial is shown. `shown` are the labels of the pairs that were answered.
fn weighs<'a>(
    killed_at: &'a str,
    shown: &'a mut Vec<[String; 2]>,
) -> Somebody<impl FnMut(&View) -> Option<Input> + 'a> {
    let place = |label: &str| ITEMS.iter().position(|id| label.contains(id));
    let mut last = String::new();
    somebody(move |view: &View| {
        let Shown::Question { text, scale } = &view.phase else { return None };
        if !killed_at.is_empty() && text.starts_with(killed_at) {
            return Some(Input::Failed("killed".into()));
        }
        if let AnswerScale::Pair(labels) = scale {
            if last != *text {
                last.clone_from(text);
                shown.push(labels.clone());
            }
            let second = place(&labels[1]) > place(&labels[0]);
            return Some(Input::Answer(if second { 2 } else { 1 }));
        }
        place(text).map(|place| Input::Answer(place as i16))
    })
}

#[test]
fn pairs_are_asked_once_after_the_last_trial_and_a_session_killed_amid_them_goes_on_with_the_next()
{
    for blinded in [false, true] {
        let desk = tlx(blinded);
        let mut shown = Vec::new();
        // Of 21 questions after that trial the first six are the TLX's own.
        let mut front = weighs("(12 of 21)", &mut shown);
        desk.run(&mut Mock::default(), &Unsynced, &mut front).unwrap_err();
        drop(front);
        recover(&RealFiles, &desk.plan.layout, UTC);
        desk.run(&mut Mock::default(), &Unsynced, &mut weighs("", &mut shown)).unwrap();
        assert_eq!(verify(&desk.plan.layout), []);
        let data = desk.data();
        let log = &data.sessions[0];
        let pairs = &log.record.pairs;
        assert_eq!((pairs.len(), shown.len()), (15, 15));
        assert!(
            pairs.iter().any(|pair| pair.is_turned) && !pairs.iter().all(|pair| pair.is_turned)
        );
        // As it was drawn, over both lives of the session.
        for (pair, [first, second]) in pairs.iter().zip(&shown) {
            let id = match pair.is_turned {
                true => format!("{second}_or_{first}"),
                false => format!("{first}_or_{second}"),
            };
            assert_eq!(pair.question.as_str(), id);
        }
        let answers = log.events.iter().filter_map(|event| match event {
            Event::Answer { trial, question, value, .. } => Some((*trial, question, *value)),
            _ => None,
        });
        let given: Vec<_> = answers.collect();
        let study = &desk.plan.study;
        let weighed: Vec<_> = given
            .iter()
            .filter(|(_, id, _)| study.question(id).is_some_and(|question| question.is_pair()))
            .collect();
        // Each once, always for the one that is later in the list, whichever stood first.
        assert_eq!(weighed.len(), 15);
        for (_, id, value) in &weighed {
            let (first, second) = id.as_str().split_once("_or_").unwrap();
            assert!(first < second, "{id}: 1 is the first in the alphabet");
            let place = |own: &str| ITEMS.iter().position(|item| *item == own);
            let later = if place(second) > place(first) { 2 } else { 1 };
            assert_eq!(*value, AnswerValue::from(later), "{id}");
        }
        let walls =
            log.record.trials.iter().filter(|trial| trial.environment.as_str() == "spring_wall");
        let last = walls.map(|trial| trial.trial).max().unwrap();
        assert!(weighed.iter().all(|(trial, _, _)| *trial == last), "{weighed:?}");
        // By hand: ratings 0, 10, … 50 of 100, chosen 0, 1, … 5 times.
        let score = &study.scores[0];
        let after = |id: &_| {
            given.iter().find(|(trial, own, _)| *trial == last && *own == id).map(|found| found.2)
        };
        let items: Vec<_> = score
            .questions
            .iter()
            .map(|id| Some((&study.question(id).unwrap().scale, after(id)?)))
            .collect();
        let weights: Vec<_> = score.weighing().iter().map(after).collect();
        let expected = f64::from(10 + 40 + 90 + 160 + 250) / 15.0;
        assert!((score.of(&items, &weights).unwrap() - expected).abs() < 1e-12);
        assert_eq!(log.record.seed.is_none(), blinded);
    }
}

#[test]
fn a_last_trial_that_is_done_again_is_followed_by_the_pairs_again() {
    let desk = tlx(false);
    let mut shown = Vec::new();
    desk.run(&mut Mock::default(), &Unsynced, &mut weighs("", &mut shown)).unwrap();
    let record = desk.data().sessions[0].record.clone();
    let walls = record.trials.iter().filter(|trial| trial.environment.as_str() == "spring_wall");
    let last = walls.map(|trial| trial.trial).max().unwrap();
    let mut again = Some(Input::Of(last, About::Repeat));
    let mut front = weighs("", &mut shown);
    let mut whole = somebody(|view: &View| match view.phase {
        Shown::Done if again.is_some() => again.take(),
        _ => (front.0)(view),
    });
    desk.run(&mut Mock::default(), &Unsynced, &mut whole).unwrap();
    drop(whole);
    drop(front);
    assert_eq!(shown.len(), 30);
    // Those of the trial that counts.
    let data = desk.data();
    let counting = data.answers.iter().filter(|answer| answer.question.as_str().contains("_or_"));
    assert_eq!(counting.map(|answer| answer.trial).collect::<Vec<_>>(), [TRIALS as u32 + 1; 15]);
}
