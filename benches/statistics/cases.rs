//! The studies that both sides are given: participants × sessions × modes × repeats.

use crate::draws::Draws;
use std::path::{Path, PathBuf};

/// The key of every draw.
const SEED: u8 = 7;
/// What the modes add to the answer or the metric.
const EFFECTS: [f64; 3] = [0.0, -0.4, 0.6];
/// Standard deviations of a participant's level, of their own effect of a mode, of their level in a
/// session, and of their own effect of a mode in a session.
const SPREAD: [f64; 4] = [1.0, 0.6, 0.4, 0.5];
/// Thresholds of the five-point scale, in logits.
const THRESHOLDS: [f64; 4] = [-1.6, -0.5, 0.6, 1.8];
/// Share of the trials that are missing from all but the smallest studies: nothing is in closed
/// form there.
const MISSING: f64 = 0.05;
/// The smallest studies.
const SMALLEST: usize = 12;
/// Standard deviation of repeats.
const RESIDUAL: f64 = 0.9;

/// What is fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// The linear mixed model, tested after Kenward and Roger.
    Mixed,
    /// The cumulative-link mixed model, by Laplace's approximation.
    Ordinal,
}

/// The size of a study.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Case {
    pub(crate) kind: Kind,
    pub(crate) participants: usize,
    pub(crate) sessions: usize,
    pub(crate) repeats: usize,
}

/// Trials as columns.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Data {
    pub(crate) participant: Vec<usize>,
    pub(crate) session: Vec<usize>,
    pub(crate) mode: Vec<usize>,
    pub(crate) value: Vec<f64>,
    pub(crate) answer: Vec<u8>,
}

/// All studies.
pub(crate) const CASES: [Case; 6] =
    [mixed(12, 1), mixed(12, 2), mixed(48, 1), mixed(100, 1), ordinal(12), ordinal(48)];

const fn mixed(participants: usize, sessions: usize) -> Case {
    Case { kind: Kind::Mixed, participants, sessions, repeats: 6 }
}

const fn ordinal(participants: usize) -> Case {
    Case { kind: Kind::Ordinal, participants, sessions: 1, repeats: 6 }
}

impl Case {
    /// `mixed_12x1x3x6`.
    pub(crate) fn name(&self) -> String {
        let kind = match self.kind {
            Kind::Mixed => "mixed",
            Kind::Ordinal => "ordinal",
        };
        let Self { participants, sessions, repeats, .. } = self;
        format!("{kind}_{participants}x{sessions}x{}x{repeats}", EFFECTS.len())
    }

    /// Its trials.
    pub(crate) fn data(&self) -> Data {
        let mut draws = Draws::new(SEED, self.participants as u64 + 1000 * self.sessions as u64);
        let mut data = Data::default();
        for participant in 0..self.participants {
            let own = SPREAD[0] * draws.normal();
            let own_effects = EFFECTS.map(|effect| effect + SPREAD[1] * draws.normal());
            for session in 0..self.sessions {
                // one session cannot tell its own effects from the participant's
                let share = if self.sessions > 1 { 1.0 } else { 0.0 };
                let level = own + share * SPREAD[2] * draws.normal();
                for (mode, effect) in own_effects.iter().enumerate() {
                    let level = level + effect + share * SPREAD[3] * draws.normal();
                    for _ in 0..self.repeats {
                        let latent = level + draws.logistic();
                        let missing = draws.uniform() < MISSING;
                        let value = level + RESIDUAL * draws.normal();
                        if missing && self.participants > SMALLEST {
                            continue;
                        }
                        data.participant.push(participant);
                        data.session.push(session);
                        data.mode.push(mode);
                        data.value.push(value);
                        data.answer
                            .push(1 + THRESHOLDS.iter().fold(0, |n, t| n + u8::from(latent > *t)));
                    }
                }
            }
        }
        data
    }

    /// Writes its trials where the peer reads them.
    pub(crate) fn write(&self, folder: &Path) -> std::io::Result<PathBuf> {
        let data = self.data();
        let mut text = "participant,session,mode,value,answer\n".to_owned();
        for row in 0..data.value.len() {
            // Rust writes as many digits as lead back to the same number
            text += &format!(
                "{},{},{},{},{}\n",
                data.participant[row],
                data.session[row],
                data.mode[row],
                data.value[row],
                data.answer[row]
            );
        }
        let path = folder.join(format!("{}.csv", self.name()));
        std::fs::write(&path, text)?;
        Ok(path)
    }
}
