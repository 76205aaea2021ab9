//! A participant's screen that lies, beside the person who runs a session: strangers who do not
//! know the secret, overheard proofs, answers to other questions and off the scale, floods, half
//! lines, arbitrary bytes, and an end at any moment. Now and then it answers as a screen of ours
//! does.

use super::world::Draw;
use std::sync::Arc;
use std::time::Duration;
use zwidth_acquire::{
    AcquireError, Beside, Front, Input, Knock, Reception, Secret, Teller, View, Visit,
};

/// What the session and its screens know.
const SECRET: [u8; 32] = [5; 32];
/// The first of the streams that it draws from, one a life.
const STREAM: u64 = 40;
/// Answers in a flood.
const FLOOD: u64 = 300;
/// Bytes of a line that does not end: more than any line has.
const ENDLESS: usize = 4096;

/// A front end, and a screen beside it that lies.
pub(super) struct Liar<'a> {
    beside: Beside<'a>,
    reception: Arc<Reception>,
    /// Without it there is no screen in this life.
    draw: Option<Draw>,
    inside: Option<(Visit, Teller)>,
    /// A proof that was given before.
    overheard: Option<String>,
    /// The open question, as far as the screen was told.
    asked: Option<u64>,
    /// What was answered to it that is one of its answers.
    given: Vec<i16>,
    /// Answers of it that the session heard.
    pub(super) heard: u64,
    /// What was promised and did not hold.
    pub(super) broken: Option<String>,
}

impl<'a> Liar<'a> {
    /// Beside a person, in the lives in which the seed draws one.
    pub(super) fn beside(person: &'a mut dyn Front, seed: u64, life: u64) -> Self {
        let draw = Self::is_drawn(seed, life).then(|| Draw::new(seed, STREAM + life));
        let reception = Reception::new(Secret::new(SECRET));
        Self {
            beside: Beside::new(Box::new(person), Arc::clone(&reception), None),
            reception,
            draw,
            inside: None,
            overheard: None,
            asked: None,
            given: Vec::new(),
            heard: 0,
            broken: None,
        }
    }

    /// Whether there is a screen in a life.
    pub(super) fn is_drawn(seed: u64, life: u64) -> bool {
        (seed + life).is_multiple_of(2)
    }

    fn act(&mut self) {
        let Some(mut draw) = self.draw.take() else { return };
        if self.inside.is_some() {
            self.say(&mut draw);
        } else {
            self.come(&mut draw);
        }
        self.draw = Some(draw);
    }

    /// Somebody comes, who may be let in or not.
    fn come(&mut self, draw: &mut Draw) {
        let mut visit = Visit::new(&self.reception, bytes(draw));
        let knock = Knock::new(Secret::new(SECRET), bytes(draw));
        let first = match draw.below(6) {
            0 => return,
            1 => bytes(draw).to_vec(),
            _ => (knock.hello() + "\n").into_bytes(),
        };
        let Ok(session) = visit.take(&first) else { return };
        let Some(proof) = knock.proof(session.trim_end()) else { return };
        let proof = proof + "\n";
        let replayed = self.overheard.replace(proof.clone());
        let second = match (draw.below(4), replayed) {
            (0, Some(replayed)) => replayed,
            (1, _) => session,
            _ => proof.clone(),
        };
        if visit.take(second.as_bytes()).is_err() {
            return;
        }
        match visit.teller() {
            Some(_) if second != proof => {
                self.broken = Some("a screen that proved nothing was let in".to_owned());
            }
            Some(teller) => self.inside = Some((visit, teller)),
            None => {}
        }
    }

    /// The screen that is in says something, or goes.
    fn say(&mut self, draw: &mut Draw) {
        let Some((mut visit, mut teller)) = self.inside.take() else { return };
        if let Some(line) = teller.news() {
            let asked = question(&line);
            if asked != self.asked {
                self.asked = asked;
                self.given.clear();
            }
        }
        let asked = self.asked.unwrap_or(draw.below(4));
        let on_scale = 1 + draw.below(5) as i16;
        let words = match draw.below(12) {
            0 => return,
            1 | 2 => {
                self.given.push(on_scale);
                format!("answer {asked} {on_scale}\n")
            }
            3 => format!("answer {} {on_scale}\n", asked + 1 + draw.below(3)),
            4 => format!("answer {} {on_scale}\n", asked.saturating_sub(1 + draw.below(3))),
            5 => format!("answer {asked} {}\n", draw.of(&["-1", "0", "6", "32767", "99999", "x"])),
            6 => (1..=FLOOD).map(|n| format!("answer {} {on_scale}\n", asked + n)).collect(),
            7 => "answer ".to_owned(),
            8 => String::from_utf8_lossy(&bytes(draw)).into_owned(),
            9 => "9".repeat(ENDLESS),
            _ => String::new(),
        };
        if visit.take(words.as_bytes()).is_ok() {
            self.inside = Some((visit, teller));
        }
    }
}

impl Front for Liar<'_> {
    fn show(&mut self, view: &View) -> Result<(), AcquireError> {
        self.beside.show(view)?;
        self.act();
        Ok(())
    }

    fn next(&mut self, wait: Duration) -> Result<Option<Input>, AcquireError> {
        self.act();
        let input = self.beside.next(wait)?;
        if let Some(Input::AnswerThere(value)) = input {
            self.heard += 1;
            if !self.given.contains(&value) {
                self.broken = Some(format!("{value} was heard, which answers no open question"));
            }
        }
        Ok(input)
    }
}

/// The number of the open question in what a screen is told.
fn question(line: &str) -> Option<u64> {
    let line: serde_json::Value = serde_json::from_str(line).ok()?;
    line["sight"]["now"]["question"]["number"].as_u64()
}

fn bytes(draw: &mut Draw) -> [u8; 32] {
    std::array::from_fn(|_| draw.below(256) as u8)
}
