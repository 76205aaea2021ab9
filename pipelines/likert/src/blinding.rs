//! The blinding index: how often participants knew the mode when asked for it.

use crate::LikertError;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use zwidth_results::BlindingIndex;
use zwidth_stats::interval;
use zwidth_study::{AnswerValue, ModeId, ParticipantId};
use zwidth_tables::{NoteKind, Table, TableError};

/// One trial after which a question asked for the mode.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Guess {
    /// Who was asked.
    pub participant: ParticipantId,
    /// The mode that it was.
    pub mode: ModeId,
    /// Its number among the answers, from 1.
    pub number: u8,
    /// How many modes there were to choose from.
    pub choices: u8,
    /// The answer: a mode's number, or 0 for "do not know"; `None` if there is none.
    pub answer: Option<AnswerValue>,
}

/// Everything that the blinding index depends on.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Blinding {
    /// The study's modes, in its order.
    pub modes: Vec<ModeId>,
    /// The trials after which the mode was asked for, in the order of participants.
    pub guesses: Vec<Guess>,
    /// Trials of sealed sessions that would be among them.
    pub sealed: usize,
    /// Level of the intervals, as a fraction.
    pub level: f64,
}

/// The row of a mode for the answers after some trials of it, as those of one participant.
fn row(mode: &ModeId, guesses: &[&Guess]) -> BlindingIndex {
    let mut row = BlindingIndex {
        participant: None,
        mode: mode.clone(),
        participants: 0,
        trials: guesses.len(),
        right: 0,
        wrong: 0,
        do_not_know: 0,
        index: None,
        index_ci_low: None,
        index_ci_high: None,
    };
    let mut sum = 0.0;
    for guess in guesses {
        let (count, score) = match guess.answer.map(AnswerValue::whole) {
            None => continue,
            Some(Some(0)) => (&mut row.do_not_know, 0.0),
            Some(number) if number == Some(guess.number.into()) => (&mut row.right, 1.0),
            Some(_) => (&mut row.wrong, all_wrong(guess.choices)),
        };
        *count += 1;
        sum += score;
    }
    let answered = row.right + row.wrong + row.do_not_know;
    row.index = (answered > 0).then(|| sum / answered as f64);
    row.participants = usize::from(answered > 0);
    row
}

/// The index of somebody who is always wrong with k modes to choose from: −1/(k − 1). There are at
/// least two.
fn all_wrong(choices: u8) -> f64 {
    -1.0 / (f64::from(choices) - 1.0)
}

/// The blinding index: for each participant and mode, and, if there are several participants, for
/// each mode over them, the trials after which the mode was asked for, the answers that were right,
/// wrong, and "do not know", and the index.
///
/// The index is the mean over the answered trials of 1 if right, −1/(k − 1) if wrong, 0 for "do not
/// know", with k modes to choose from: 0 at chance, 1 if always right, −1/(k − 1) if always wrong.
/// For k = 2 it is (right − wrong)/n, the index of Bang, Ni & Davis 2004 (Controlled Clinical Trials
/// 25:143). Over participants it is the mean of their indices, with a t interval over participants,
/// cut off at the limits of an index: repeats are not people. No interval for fewer than two
/// participants, or if all have the same index.
///
/// # Errors
/// An answer that was not offered; a level outside (0, 1).
pub fn blinding(input: &Blinding) -> Result<Vec<BlindingIndex>, LikertError> {
    let mut people: BTreeMap<&ParticipantId, BTreeMap<&ModeId, Vec<&Guess>>> = BTreeMap::new();
    for guess in &input.guesses {
        let offered = 0..=i16::from(guess.choices);
        if let Some(value) = guess.answer
            && !value.whole().is_some_and(|number| offered.contains(&number))
        {
            return Err(LikertError::NoMode {
                participant: guess.participant.clone(),
                value,
                choices: guess.choices,
            });
        }
        let own = people.entry(&guess.participant).or_default();
        own.entry(&guess.mode).or_default().push(guess);
    }
    let mut rows: Vec<BlindingIndex> = Vec::new();
    for (participant, own) in &people {
        // No row for a mode of which nobody asked this participant.
        let own = input.modes.iter().filter_map(|mode| Some((mode, own.get(mode)?)));
        rows.extend(own.map(|(mode, guesses)| BlindingIndex {
            participant: Some((*participant).clone()),
            ..row(mode, guesses)
        }));
    }
    if people.len() > 1 {
        let over =
            input.modes.iter().filter_map(|mode| over_participants(input, mode, &rows).transpose());
        let over = over.collect::<Result<Vec<BlindingIndex>, LikertError>>()?;
        rows.extend(over);
    }
    Ok(rows)
}

/// The same as a table, with notes on the definition of the index and on what is not in it.
///
/// # Errors
/// A number that is not finite.
pub fn blinding_table(rows: &[BlindingIndex], input: &Blinding) -> Result<Table, TableError> {
    let people: BTreeSet<&ParticipantId> = input.guesses.iter().map(|g| &g.participant).collect();
    let notes = notes(input, people.len()).into_iter();
    let table = Table::of_rows(rows)?;
    Ok(notes.fold(table, |table, (kind, note)| table.with_note_of(kind, note)))
}

/// The row of a mode over participants, from their own rows; `None` without one.
fn over_participants(
    input: &Blinding,
    mode: &ModeId,
    own: &[BlindingIndex],
) -> Result<Option<BlindingIndex>, LikertError> {
    let own = own.iter().filter(|row| row.participant.is_some() && row.mode == *mode);
    let indices: Vec<f64> = own.filter_map(|row| row.index).collect();
    let mean = interval::mean(&indices, input.level)?;
    let guesses: Vec<&Guess> = input.guesses.iter().filter(|g| g.mode == *mode).collect();
    // With the fewest modes to choose from a wrong answer counts most: no index lies below that.
    let fewest = guesses.iter().map(|g| g.choices).min();
    let lowest = fewest.map_or(-1.0, all_wrong);
    // People who all have one index tell nothing of how people differ.
    let spread = mean.interval.filter(|interval| interval.std_error > 0.0);
    Ok((!guesses.is_empty()).then(|| BlindingIndex {
        participants: mean.n,
        index: mean.estimate,
        index_ci_low: spread.map(|interval| interval.ci_low.clamp(lowest, 1.0)),
        index_ci_high: spread.map(|interval| interval.ci_high.clamp(lowest, 1.0)),
        ..row(mode, &guesses)
    }))
}

fn notes(input: &Blinding, participants: usize) -> Vec<(NoteKind, String)> {
    // Sessions may differ in how many modes there were to choose from.
    let choices = input.guesses.iter().map(|guess| guess.choices);
    let few = choices.clone().min().unwrap_or_default();
    let many = choices.max().unwrap_or_default();
    let k = if few == many { few.to_string() } else { format!("{few} to {many}") };
    let form = match many {
        2 => "It is the index of Bang, Ni & Davis 2004",
        _ => {
            "With two modes it is the index of Bang, Ni & Davis 2004; the form for more modes is this program's own"
        }
    };
    let mut notes = vec![(
        NoteKind::General,
        format!(
            "Index: mean over the answered trials of 1 (right), -1/(k - 1) (wrong) and 0 (do not know), k = {k} \
             modes to choose from: 0 at chance, 1 if always right. {form}."
        ),
    )];
    if participants > 1 {
        let text = format!(
            "Rows without a participant: the mean of the participants' indices, with its {} % interval \
             (Student's t over participants), held to what an index can be.",
            100.0 * input.level
        );
        notes.push((NoteKind::General, text));
    }
    let open = input.guesses.iter().filter(|guess| guess.answer.is_none()).count();
    if open > 0 {
        let text = format!("After {} it was left open: in no index.", counted(open));
        notes.push((NoteKind::General, text));
    }
    if input.sealed > 0 {
        let sealed = counted(input.sealed);
        let text = format!("Without {sealed} of sealed sessions, until they are unsealed.");
        notes.push((NoteKind::LeftOut, text));
    }
    notes
}

fn counted(trials: usize) -> String {
    match trials {
        1 => "1 trial".to_owned(),
        n => format!("{n} trials"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mode(number: u8) -> ModeId {
        ModeId::new(format!("m{number}")).unwrap()
    }

    /// So many equal answers of a participant after trials of a mode.
    fn said(who: &str, number: u8, choices: u8, answer: Option<i16>, times: usize) -> Vec<Guess> {
        let participant = ParticipantId::new(who).unwrap();
        let guess = Guess {
            participant,
            mode: mode(number),
            number,
            choices,
            answer: answer.map(Into::into),
        };
        vec![guess; times]
    }

    fn of(choices: u8, guesses: &[Vec<Guess>]) -> Blinding {
        let modes = (1..=choices).map(mode).collect();
        Blinding { modes, guesses: guesses.concat(), sealed: 0, level: 0.95 }
    }

    fn table_of(of: &Blinding) -> Table {
        blinding_table(&blinding(of).unwrap(), of).unwrap()
    }

    fn indices(of: &Blinding) -> Vec<f64> {
        blinding(of).unwrap().iter().map(|row| row.index.unwrap()).collect()
    }

    fn is(found: &[f64], expect: &[f64]) {
        let near = found.iter().zip(expect).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(near && found.len() == expect.len(), "{found:?} {expect:?}");
    }

    /// The counts of James et al. 1996 and their indices in the readme of BlindingIndex.jl (after
    /// the R package BI): 0.115 and 0.022. BI computes (2 r − 1)(right + wrong)/n with r = right/(right
    /// + wrong), as Bang, Ni & Davis 2004 have it.
    #[test]
    fn with_two_modes_it_is_the_index_of_bang() {
        let counts = [[48_usize, 4, 330], [30, 22, 319]];
        let guesses: Vec<Vec<Guess>> = (1..=2)
            .zip(counts)
            .flat_map(|(m, [right, wrong, unknown])| {
                [
                    said("P01", m, 2, Some(i16::from(m)), right),
                    said("P01", m, 2, Some(i16::from(3 - m)), wrong),
                    said("P01", m, 2, Some(0), unknown),
                ]
            })
            .collect();
        let bang = counts.map(|[right, wrong, unknown]| {
            let [right, wrong, unknown] = [right, wrong, unknown].map(|n| n as f64);
            let named = right + wrong;
            (2.0 * right / named - 1.0) * (named / (named + unknown))
        });
        let found = indices(&of(2, &guesses));
        is(&found, &bang);
        let printed: Vec<String> = found.iter().map(|index| format!("{index:.3}")).collect();
        assert_eq!(printed, ["0.115", "0.022"]);
    }

    #[test]
    fn it_is_0_at_chance_1_for_who_knows_and_lowest_for_who_is_always_wrong() {
        for k in 2..=5_u8 {
            let all = |answers: Vec<i16>| {
                let guesses: Vec<_> =
                    answers.into_iter().map(|a| said("P01", 1, k, Some(a), 3)).collect();
                indices(&of(k, &guesses))
            };
            is(&all((1..=i16::from(k)).collect()), &[0.0]);
            is(&all((0..=i16::from(k)).collect()), &[0.0]);
            is(&all(vec![0]), &[0.0]);
            is(&all(vec![1]), &[1.0]);
            is(&all((2..=i16::from(k)).collect()), &[-1.0 / (f64::from(k) - 1.0)]);
        }
    }

    /// t with one degree of freedom at 95 %: tan(0.475 π) = 12.706…
    #[test]
    fn over_participants_it_is_the_mean_of_theirs_however_many_trials_each_had() {
        let guesses = [
            said("P01", 1, 3, Some(1), 9),
            said("P01", 1, 3, Some(2), 1),
            said("P02", 1, 3, Some(1), 1),
            said("P02", 1, 3, Some(0), 1),
        ];
        let rows = blinding(&of(3, &guesses)).unwrap();
        let table = table_of(&of(3, &guesses));
        assert_eq!(table.to_rows::<BlindingIndex>().unwrap(), rows);
        let own = [0.85, 0.5];
        is(&indices(&of(3, &guesses)), &[own[0], own[1], 0.675]);
        assert_eq!(table.texts("participant").unwrap()[2], None);
        assert_eq!(table.integers("participants").unwrap(), [Some(1), Some(1), Some(2)]);
        assert_eq!(table.integers("trials").unwrap(), [Some(10), Some(2), Some(12)]);
        // 0.175 · tan(0.475 π) to either side, held to −1/2 … 1
        assert_eq!(table.floats("index_ci_low").unwrap(), [None, None, Some(-0.5)]);
        assert_eq!(table.floats("index_ci_high").unwrap(), [None, None, Some(1.0)]);
        let half = Blinding { level: 0.5, ..of(3, &guesses) };
        let low = blinding(&half).unwrap()[2].index_ci_low.unwrap();
        assert!((low - 0.5).abs() < 1e-8, "tan(π/4) = 1: {low}");
    }

    #[test]
    fn one_participant_says_nothing_of_people_and_equal_ones_have_no_interval() {
        let alone = table_of(&of(2, &[said("P01", 1, 2, Some(1), 4)]));
        assert_eq!(alone.texts("participant").unwrap(), [Some("P01".to_owned())]);
        assert!(alone.notes().iter().all(|note| !note.contains("participants")), "{alone:?}");
        let alike = of(2, &[said("P01", 1, 2, Some(1), 4), said("P02", 1, 2, Some(1), 2)]);
        let alike = blinding(&alike).unwrap();
        assert_eq!(alike.len(), 3);
        assert!(alike.iter().all(|row| row.index_ci_low.is_none()));
    }

    #[test]
    fn what_was_left_open_and_what_is_sealed_is_in_no_index_and_told() {
        let guesses = [said("P01", 1, 2, Some(1), 1), said("P01", 1, 2, None, 2)];
        let open = Blinding { sealed: 5, ..of(2, &guesses) };
        let table = table_of(&open);
        is(&indices(&open), &[1.0]);
        assert_eq!(table.integers("trials").unwrap(), [Some(3)]);
        let notes = table.notes().join("\n");
        assert!(notes.contains("After 2 trials it was left open"), "{notes}");
        assert!(notes.contains("Without 5 trials of sealed sessions"), "{notes}");
        let none = of(2, &[said("P01", 1, 2, None, 2)]);
        assert_eq!(blinding(&none).unwrap()[0].index, None);
    }

    #[test]
    fn an_answer_that_was_not_offered_is_refused_with_the_range() {
        for answer in ["-1", "4", "1.5"] {
            let mut guesses = said("P01", 1, 3, None, 1);
            guesses[0].answer = Some(answer.parse().unwrap());
            let error = blinding(&of(3, &[guesses])).unwrap_err();
            assert!(error.to_string().contains("0 to 3"), "{error}");
        }
    }
}
