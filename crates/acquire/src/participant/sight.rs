//! What a participant may see of a session, as plain values.
//!
//! Nothing in it reveals a mode: no mode, voltage, force or trace, no number of a trial, no
//! message, and no reason for a stop, because a reason may name an actuator.

use crate::{Phase, View};
use serde::{Deserialize, Serialize};
use zwidth_study::{AnswerScale, Kind, printable};

/// Longest text that is shown of what came over a line, characters: more than any screen has room
/// for.
const MOST_TEXT: usize = 4_000;

/// What a participant sees.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub(super) struct Sight {
    /// What is to be done now.
    pub(super) now: Now,
    /// The environment's label; none where there is no trial.
    pub(super) environment: Option<String>,
    /// Whether the trial is a familiarisation.
    pub(super) practice: bool,
    /// The interval of a presentation, from 1, and how many there are; none where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) interval: Option<[u8; 2]>,
    /// Whether the answer was right, where that is told.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) feedback: Option<bool>,
    /// Trials that are done.
    pub(super) done: usize,
    /// Trials of the session.
    pub(super) total: usize,
}

/// What a participant is to do.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Now {
    /// The device is being prepared.
    #[default]
    Wait,
    /// The next trial waits for its start.
    Ready,
    /// A trial runs.
    Go,
    /// A question waits for its answer.
    Question(OpenQuestion),
    /// The pause after a trial.
    Pause {
        /// Time left, s, rounded up.
        left_s: u32,
    },
    /// The pause goes on until the experimenter ends it.
    Held,
    /// The session is stopped.
    Stopped,
    /// Every trial is done.
    Done,
    /// The session is over.
    Left,
}

/// A question, and what may be answered to it.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub(super) struct OpenQuestion {
    /// Which question of this life of the session: an answer names it, so that one that comes too
    /// late is none to the next question.
    pub(super) number: u64,
    /// Its wording.
    pub(super) text: String,
    /// Its answers as a range: `1 to 5`.
    pub(super) range: String,
    /// Its answers.
    pub(super) choices: Vec<Choice>,
}

/// One answer that may be given.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub(super) struct Choice {
    /// Its number.
    pub(super) value: i16,
    /// Its word, where it has one.
    pub(super) word: Option<String>,
}

impl Sight {
    /// What a participant may see of a view; an open question has this number.
    pub(super) fn of(view: &View, number: u64) -> Self {
        let trial = view.trial.as_ref();
        Self {
            now: Now::of(view, number),
            environment: trial.map(|trial| printable(&trial.environment).into_owned()),
            practice: trial.is_some_and(|trial| trial.kind == Kind::Familiarisation),
            interval: view.task.as_ref().map(|task| task.interval).filter(|[_, of]| *of > 1),
            feedback: view.feedback,
            done: view.done,
            total: view.total,
        }
    }

    /// The same as it may be shown where it came over a line: no text of it steers a terminal, and
    /// none is endless.
    pub(super) fn cleaned(mut self) -> Self {
        self.environment = self.environment.map(cleaned);
        if let Now::Question(question) = &mut self.now {
            for text in [&mut question.text, &mut question.range] {
                *text = cleaned(std::mem::take(text));
            }
            for choice in &mut question.choices {
                choice.word = choice.word.take().map(cleaned);
            }
        }
        self
    }

    /// Whether the next interval of a presentation follows by itself.
    pub(super) fn is_between(&self) -> bool {
        matches!(self.now, Now::Pause { .. }) && self.interval.is_some_and(|[n, _]| n > 1)
    }

    /// Whether the answer was right, in a word, where that is told.
    pub(super) fn told(&self) -> Option<&'static str> {
        self.feedback.map(|is_right| if is_right { "Right." } else { "Wrong." })
    }

    /// The question that is open.
    pub(super) fn question(&self) -> Option<&OpenQuestion> {
        match &self.now {
            Now::Question(question) => Some(question),
            _ => None,
        }
    }
}

fn cleaned(text: String) -> String {
    let text: String = text.chars().take(MOST_TEXT).collect();
    printable(&text).into_owned()
}

impl Now {
    fn of(view: &View, number: u64) -> Self {
        match &view.phase {
            Phase::Check | Phase::Step { .. } | Phase::AtStop | Phase::Homing => Self::Wait,
            Phase::Ready => Self::Ready,
            Phase::Trial { .. } => Self::Go,
            Phase::Question { text, scale } => {
                Self::Question(OpenQuestion::of(number, text, scale))
            }
            Phase::Pause { .. } if view.held => Self::Held,
            // A pause is seconds to minutes: the cast cannot lose anything that a screen shows.
            Phase::Pause { left_s, .. } => Self::Pause { left_s: left_s.ceil().max(0.0) as u32 },
            Phase::Stopped { .. } => Self::Stopped,
            Phase::Done => Self::Done,
            // It is to go on: the screen waits for that.
            Phase::Left if view.is_cut_off => Self::Stopped,
            Phase::Left => Self::Left,
        }
    }
}

impl OpenQuestion {
    fn of(number: u64, text: &str, scale: &AnswerScale) -> Self {
        let choices = scale.answers().into_iter().map(|value| {
            let word = scale.word(value).map(|word| printable(word).into_owned());
            Choice { value, word }
        });
        let text = printable(text).into_owned();
        Self { number, text, range: scale.range(), choices: choices.collect() }
    }

    /// Whether this is an answer.
    pub(super) fn has(&self, value: i16) -> bool {
        self.choices.iter().any(|choice| choice.value == value)
    }

    /// Whether each answer is a digit, whose key gives it; else the number is typed.
    pub(super) fn has_keys(&self) -> bool {
        self.choices.iter().all(|choice| (0..=9).contains(&choice.value))
    }

    /// The answers to be shown: all of a short scale; of a long one the ends and those with a word.
    pub(super) fn shown(&self) -> impl Iterator<Item = &Choice> {
        let last = self.choices.len().saturating_sub(1);
        let is_short = self.choices.len() <= usize::from(AnswerScale::MOST_CATEGORIES);
        let shown = self.choices.iter().enumerate().filter(move |(at, choice)| {
            is_short || *at == 0 || *at == last || choice.word.is_some()
        });
        shown.map(|(_, choice)| choice)
    }
}

impl Choice {
    /// Number and word: `4 agree`.
    pub(super) fn words(&self) -> String {
        match &self.word {
            Some(word) => format!("{} {word}", self.value),
            None => self.value.to_string(),
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::{Cell, CheckLine, Current};

    /// A session in a phase, with a name of a mode, a number and a voltage wherever one fits.
    pub(crate) fn telling(phase: Phase) -> View {
        let cell =
            Cell { environment: "Spring".into(), mode: Some("SECRET".into()), done: 1, of: 6 };
        let check = CheckLine { name: "SECRET".into(), value: "SECRET".into(), ok: true };
        let trial = Current {
            trial: 8_888,
            place: 8_888,
            kind: Kind::Trial,
            environment: "Spring".into(),
            mode: Some("SECRET".into()),
            repeats: Some(8_888),
        };
        let mut view = View {
            phase,
            trial: Some(trial),
            cells: vec![cell],
            checks: vec![check],
            step: Some("SECRET".into()),
            device: "SECRET".into(),
            participant: "SECRET".into(),
            done: 3,
            total: 39,
            ..View::default()
        };
        view.say("SECRET");
        view
    }

    pub(crate) fn phases() -> Vec<Phase> {
        vec![
            Phase::Check,
            Phase::Step { what: "SECRET".into(), moves: true },
            Phase::AtStop,
            Phase::Homing,
            Phase::Ready,
            Phase::Trial { t_s: 8_888.0, limit_s: 8_888.0 },
            Phase::Question { text: "Was it rigid?".into(), scale: AnswerScale::FivePoint },
            Phase::Pause { left_s: 2.2, pause_s: 5.0 },
            Phase::Stopped { why: "SECRET".into() },
            Phase::Done,
            Phase::Left,
        ]
    }

    #[test]
    fn no_mode_voltage_number_of_a_trial_message_or_reason_is_in_it() {
        for phase in phases() {
            let told = serde_json::to_string(&Sight::of(&telling(phase), 1)).unwrap();
            assert!(!told.contains("SECRET") && !told.contains("8888"), "{told}");
        }
    }

    /// Which interval has the level is told by nothing: neither the view nor the sight has it.
    #[test]
    fn of_a_presentation_the_interval_is_told_and_what_was_right() {
        let progress = crate::Progress { counted: crate::Counted::Reversals, done: 3, of: 12 };
        let task = crate::TaskNow {
            task: "stiffer".parse().unwrap(),
            presentation: 8_888,
            of: 8_888,
            is_most: true,
            interval: [2, 2],
            progress,
        };
        let pause = Phase::Pause { left_s: 0.4, pause_s: 1.0 };
        let view = View { task: Some(task), feedback: Some(false), ..telling(pause) };
        let sight = Sight::of(&view, 1);
        assert_eq!((sight.interval, sight.is_between()), (Some([2, 2]), true));
        assert_eq!(sight.told(), Some("Wrong."));
        let told = serde_json::to_string(&sight).unwrap();
        assert!(!told.contains("8888") && !told.contains("12"), "{told}");
        assert_eq!(serde_json::from_str::<Sight>(&told).unwrap(), sight);
    }

    #[test]
    fn a_pause_is_told_in_whole_seconds_and_only_while_it_runs_out() {
        let pause = Phase::Pause { left_s: 2.2, pause_s: 5.0 };
        assert_eq!(Sight::of(&telling(pause.clone()), 1).now, Now::Pause { left_s: 3 });
        let held = View { held: true, ..telling(pause) };
        assert_eq!(Sight::of(&held, 1).now, Now::Held);
    }

    #[test]
    fn a_short_scale_is_shown_whole_and_a_long_one_by_its_ends_and_words() {
        let values = |asked: &OpenQuestion| asked.shown().map(|c| c.value).collect::<Vec<_>>();
        let five = OpenQuestion::of(1, "", &AnswerScale::FivePoint);
        assert_eq!(values(&five), [1, 2, 3, 4, 5]);
        assert!(five.has_keys() && five.has(5) && !five.has(6));
        let labels = ["soft", "middling", "hard"].map(str::to_owned).to_vec();
        let scale = zwidth_study::NumberScale { points: 21, from: 0, step: 5, labels };
        let long = OpenQuestion::of(1, "", &AnswerScale::Numbers(scale));
        assert_eq!(values(&long), [0, 50, 100]);
        assert!(!long.has_keys());
        assert_eq!(long.choices[20].words(), "100 hard");
    }

    #[test]
    fn asked_for_the_mode_every_mode_is_a_choice_and_so_is_not_to_know() {
        let modes = AnswerScale::Modes(["Motor", "Brake"].map(str::to_owned).to_vec());
        let asked = OpenQuestion::of(1, "", &modes);
        let shown: Vec<String> = asked.shown().map(Choice::words).collect();
        assert_eq!(shown, ["0 do not know", "1 Motor", "2 Brake"]);
        assert!(asked.has_keys() && asked.has(0) && !asked.has(3));
    }

    #[test]
    fn a_text_that_steers_a_terminal_is_shown_not_sent() {
        let asked = OpenQuestion::of(1, "a\u{1b}[2Jb\nc", &AnswerScale::FivePoint);
        assert_eq!(asked.text, "a\\u{1b}[2Jb\\nc");
    }
}
