//! Studies without an effect, in which people differ in how they take each mode.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Trials of each participant in each mode.
const REPEATS: usize = 6;
/// SD of participants' levels, and of a trial: beside scatters of 0.3 to 1.2.
const PARTICIPANT_SD: f64 = 0.8;
const RESIDUAL_SD: f64 = 0.7;
/// The scatters of answers are larger by this, on the scale of logits, where a trial's SD is 1.8.
const LOGITS: f64 = 1.5;
/// Thresholds of the five answers, symmetric: so neither mode is above the other, whatever their
/// scatters.
const THRESHOLDS: [f64; 4] = [-2.2, -0.8, 0.8, 2.2];
/// One cell in so many is missing.
const MISSING: u64 = 10;

/// What is measured in each trial.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Measured {
    /// A number with normal scatter.
    Metric,
    /// An answer from 1 to 5, by the proportional-odds model.
    Answer,
}

/// How the studies of one kind are made.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Kind {
    pub(crate) people: usize,
    pub(crate) measured: Measured,
    /// Participant × mode standard deviation of each mode.
    pub(crate) scatter: [f64; 3],
    /// Whether everyone did every mode; else one participant and mode in ten is missing.
    pub(crate) is_complete: bool,
}

/// A study: repeats by participant and mode, none where the cell is missing.
pub(crate) type Study = Vec<[Vec<f64>; 3]>;

/// 6 and 12 participants; scatter equal, or four times as large in the mode that the contrast (last
/// mode − first) leaves out, or in the last; complete or not.
pub(crate) fn kinds(measured: Measured) -> Vec<Kind> {
    let mut kinds = Vec::new();
    for people in [6, 12] {
        for scatter in [[0.5; 3], [0.3, 1.2, 0.3], [0.3, 0.3, 1.2]] {
            for is_complete in [true, false] {
                kinds.push(Kind { people, measured, scatter, is_complete });
            }
        }
    }
    kinds
}

impl Kind {
    /// Whether all modes scatter alike, as the pooled models and Friedman's test take it.
    pub(crate) fn is_even(&self) -> bool {
        self.scatter.iter().all(|sd| (sd - self.scatter[0]).abs() < 1e-9)
    }

    /// Its name in a table.
    pub(crate) fn name(&self) -> String {
        let [a, b, c] = self.scatter;
        let cells = if self.is_complete { "complete" } else { "cells missing" };
        format!("n = {}, SDs {a}, {b}, {c}, {cells}", self.people)
    }

    /// A study of this kind; its number is its seed.
    pub(crate) fn draw(&self, study: u64) -> Study {
        let mut rng = ChaCha8Rng::seed_from_u64(study);
        rng.set_stream(self.stream());
        let person = |_| {
            let own = normal(&mut rng);
            self.scatter.map(|sd| {
                let taken = normal(&mut rng);
                let trial = |_| match self.measured {
                    Measured::Metric => {
                        let residual = RESIDUAL_SD * normal(&mut rng);
                        3.0 + PARTICIPANT_SD * own + sd * taken + residual
                    }
                    Measured::Answer => {
                        answer(PARTICIPANT_SD * own + LOGITS * sd * taken + logistic(&mut rng))
                    }
                };
                let repeats: Vec<f64> = (0..REPEATS).map(trial).collect();
                let is_there = self.is_complete || !rng.next_u64().is_multiple_of(MISSING);
                if is_there { repeats } else { Vec::new() }
            })
        };
        (0..self.people).map(person).collect()
    }

    /// Kinds draw from streams of their own.
    fn stream(&self) -> u64 {
        let scatter: u64 = self.scatter.iter().fold(0, |sum, sd| 100 * sum + (10.0 * sd) as u64);
        let flags = u64::from(self.is_complete) + 2 * u64::from(self.measured == Measured::Answer);
        (scatter * 100 + self.people as u64) * 4 + flags
    }
}

fn answer(latent: f64) -> f64 {
    1.0 + THRESHOLDS.iter().filter(|threshold| latent > **threshold).count() as f64
}

/// A number of the standard normal distribution (Box & Muller 1958, Ann. Math. Stat. 29:610).
pub(crate) fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let radius = (-2.0 * libm::log(uniform(rng))).sqrt();
    radius * libm::cos(core::f64::consts::TAU * uniform(rng))
}

/// A number of the standard logistic distribution.
fn logistic(rng: &mut ChaCha8Rng) -> f64 {
    let share = uniform(rng);
    libm::log(share / (1.0 - share))
}

/// A number within (0, 1).
pub(crate) fn uniform(rng: &mut ChaCha8Rng) -> f64 {
    ((rng.next_u64() >> 11) as f64 + 0.5) / 2_f64.powi(53)
}

/// A participant's mean in a mode.
fn mean(repeats: &[f64]) -> Option<f64> {
    (!repeats.is_empty()).then(|| repeats.iter().sum::<f64>() / repeats.len() as f64)
}

/// Each participant's mean in the last mode less that in the first, of those who did both.
pub(crate) fn differences(study: &Study) -> Vec<f64> {
    study.iter().filter_map(|[first, _, last]| Some(mean(last)? - mean(first)?)).collect()
}

/// The means of those who did all modes.
pub(crate) fn complete(study: &Study) -> Vec<[f64; 3]> {
    let row = |[a, b, c]: &[Vec<f64>; 3]| Some([mean(a)?, mean(b)?, mean(c)?]);
    study.iter().filter_map(row).collect()
}

/// The trials as columns of a tidy table: participant, mode, value.
pub(crate) fn tidy(study: &Study) -> (Vec<usize>, Vec<usize>, Vec<f64>) {
    let (mut participants, mut modes, mut values) = (Vec::new(), Vec::new(), Vec::new());
    for (participant, row) in study.iter().enumerate() {
        for (mode, repeats) in row.iter().enumerate() {
            participants.extend(repeats.iter().map(|_| participant));
            modes.extend(repeats.iter().map(|_| mode));
            values.extend(repeats);
        }
    }
    (participants, modes, values)
}
