//! The answer to a task: by a psychometric function that is known, so that what an analysis finds can be held against it.
//!
//! A comparison is judged as "more", right or "yes" with the chance ψ(x) = γ + (1 − γ − λ) Φ((x − m)/σ) at the level x,
//! with λ = 0.02 and γ = λ, ½ of two intervals of which one is right, or 0.05 of yes and no. Of the level in other units
//! nothing is known here, so m and σ follow from the task:
//!
//! | task | m | σ |
//! |---|---|---|
//! | which was more, more or less, set: a standard s that is not 0 | 1.00 s, 0.96 s, 1.02 s | 0.10 \|s\|, 0.16 \|s\|, 0.12 \|s\| |
//! | all others, of levels from a to b | a + 0.40, 0.50, 0.45 (b − a) | 0.12, 0.16, 0.14 (b − a) |
//!
//! in modes of the motor alone, of the brake alone, and of both; everybody has the same. A person who sets a level wants
//! less, or more, of one that is farther than σ/2 (or half a step) from a place that each setting draws about m with the
//! spread σ.
//!
//! An answer depends on the task, the mode, the sequence and the number of the presentation: one that is done again is
//! answered as before. **Nothing that was rendered enters it, so no finding about perception can come from it.**

use super::Person;
use super::draw::{Draw, Purpose};
use zwidth_study::{Asks, Method, ModeId, ModeLaw, QuestionId, Task, TaskLevel};

/// λ.
const LAPSE: f64 = 0.02;
/// γ of yes and no: whoever says yes to nothing guesses.
const YES_TO_NOTHING: f64 = 0.05;

/// A presentation, as a device's own participant is asked about it.
#[derive(Debug, Clone, PartialEq)]
pub struct Judged {
    /// The task.
    pub task: Task,
    /// The mode of the presentation.
    pub mode: ModeId,
    /// Which actuators render it when.
    pub law: Option<ModeLaw>,
    /// The level that was compared with the standard.
    pub level: TaskLevel,
    /// Whether the last of two intervals held the standard.
    pub last_is_standard: bool,
    /// Which of several sequences of levels it is of.
    pub track: u8,
    /// The presentation of the task and mode, from 1.
    pub presentation: u32,
    /// The trial before the question.
    pub trial: u32,
}

/// What a simulated participant perceives of a task in a mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// m, in the unit of the level.
    pub threshold: f64,
    /// σ, in the unit of the level.
    pub scale: f64,
    /// γ.
    pub guess: f64,
    /// λ.
    pub lapse: f64,
}

impl Truth {
    /// That of a task in a mode of that law.
    pub fn of(task: &Task, law: Option<ModeLaw>) -> Self {
        let standard = task.standard.map_or(0.0, TaskLevel::value);
        let is_compared = matches!(task.asks, Asks::MoreOfTwo | Asks::MoreLess | Asks::Set);
        let (threshold, scale) = if is_compared && standard != 0.0 {
            let (share, weber) = match law {
                Some(ModeLaw::Active) | None => (1.0, 0.10),
                Some(ModeLaw::Passive) => (0.96, 0.16),
                Some(ModeLaw::Hybrid) => (1.02, 0.12),
            };
            (share * standard, weber * standard.abs())
        } else {
            let (place, spread) = match law {
                Some(ModeLaw::Active) | None => (0.40, 0.12),
                Some(ModeLaw::Passive) => (0.50, 0.16),
                Some(ModeLaw::Hybrid) => (0.45, 0.14),
            };
            let [low, high] = range(&task.method);
            (low + place * (high - low), spread * (high - low))
        };
        let guess = match task.asks {
            Asks::OneOfTwo => 0.5,
            Asks::YesNo => YES_TO_NOTHING,
            Asks::MoreOfTwo | Asks::MoreLess | Asks::Set => LAPSE,
        };
        Self { threshold, scale, guess, lapse: LAPSE }
    }

    /// ψ at a level.
    pub fn share(&self, level: f64) -> f64 {
        let Self { threshold, scale, guess, lapse } = *self;
        let below = (threshold - level) / (scale * std::f64::consts::SQRT_2);
        guess + (1.0 - guess - lapse) * 0.5 * libm::erfc(below)
    }
}

/// The lowest and the highest level of a method.
fn range(method: &Method) -> [f64; 2] {
    let ends = match method {
        Method::Constant { levels, .. } | Method::QuestPlus { levels, .. } => {
            [levels.first(), levels.last()].map(Option::<&TaskLevel>::copied)
        }
        Method::Staircase(plan) => plan.bounds.map(Some),
        Method::Adjustment { bounds, .. } => bounds.map(Some),
    };
    ends.map(|level| level.map_or(0.0, TaskLevel::value))
}

impl Person {
    /// The answer to a presentation, a number of [`Asks::answers`].
    pub(crate) fn judge(&self, judged: &Judged) -> i16 {
        let Judged { task, level, last_is_standard, presentation, track, .. } = judged;
        let truth = Truth::of(task, judged.law);
        let seed = own_seed(self.seed, &task.id, &judged.mode);
        let numbered = |number: u32| u64::from(*track) << u32::BITS | u64::from(number);
        // A setting is a sequence: its place is the same for all of its presentations.
        if task.asks == Asks::Set {
            let place = Draw::new(seed, Purpose::Judgement, numbered(0)).moderate();
            let off = level.value() - (truth.threshold + truth.scale * place);
            // So wide that some level is within it, however large the steps.
            let near = truth.scale.max(step(&task.method)) / 2.0;
            return if off.abs() <= near { 3 } else { 1 + i16::from(off > 0.0) };
        }
        let chance = Draw::new(seed, Purpose::Judgement, numbered(*presentation)).unit();
        // What is shown of a presentation of nothing is the standard, too: the guesses alone.
        let is_nothing = task.asks == Asks::YesNo && Some(*level) == task.standard;
        let share = if is_nothing { truth.guess } else { truth.share(level.value()) };
        let is_positive = chance < share;
        match task.asks {
            Asks::YesNo | Asks::MoreLess | Asks::Set => 1 + i16::from(!is_positive),
            // The interval that held the level, or the other one.
            Asks::MoreOfTwo | Asks::OneOfTwo => 1 + i16::from(is_positive != *last_is_standard),
        }
    }
}

/// The step of an adjustment; none of other methods.
fn step(method: &Method) -> f64 {
    if let Method::Adjustment { step, .. } = method { step.value() } else { 0.0 }
}

/// FNV-1a of the task's and the mode's names, from the seed on.
fn own_seed(seed: u64, task: &QuestionId, mode: &ModeId) -> u64 {
    let names = [task.as_str(), "\n", mode.as_str()];
    names.iter().flat_map(|name| name.bytes()).fold(seed ^ 0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_study::{TaskEstimate, TaskFit};

    fn level(value: f64) -> TaskLevel {
        TaskLevel::nearest(value).unwrap()
    }

    fn judged(asks: Asks, standard: f64, at: f64) -> Judged {
        let levels = [2.0, 4.0, 6.0].map(level).to_vec();
        Judged {
            task: Task {
                id: "stiffer".parse().unwrap(),
                text: String::new(),
                asks,
                environment: "spring".parse().unwrap(),
                varies: "stiffness_n_per_rad".to_owned(),
                standard: Some(level(standard)),
                method: Method::Constant { levels, trials: 10 },
                catch: 0.0,
                feedback: false,
                fit: TaskFit::default(),
                estimate: TaskEstimate::Likelihood,
            },
            mode: "active".parse().unwrap(),
            law: Some(ModeLaw::Active),
            level: level(at),
            last_is_standard: false,
            track: 0,
            presentation: 1,
            trial: 1,
        }
    }

    /// Four standard deviations of a share of ½ of 4,000 are 0.032.
    #[test]
    fn shares_of_answers_are_those_of_the_function() {
        for (asks, standard, at) in [
            (Asks::MoreOfTwo, 4.0, 4.2),
            (Asks::MoreLess, 4.0, 3.5),
            (Asks::OneOfTwo, 0.0, 4.0),
            (Asks::YesNo, 0.0, 3.0),
            (Asks::YesNo, 0.0, 0.0),
        ] {
            for last_is_standard in [false, true] {
                let one = Judged { last_is_standard, ..judged(asks, standard, at) };
                let person = Person::typical(3);
                let positive = (1..=4000).filter(|number| {
                    let answer = person.judge(&Judged { presentation: *number, ..one.clone() });
                    asks.is_positive(answer.into(), Some(last_is_standard)).unwrap()
                });
                let share = positive.count() as f64 / 4000.0;
                let truth = Truth::of(&one.task, one.law);
                let expect = if at == 0.0 { truth.guess } else { truth.share(at) };
                assert!((share - expect).abs() < 0.032, "{asks:?} {at}: {share} not {expect}");
            }
        }
    }

    #[test]
    fn a_presentation_that_is_done_again_is_answered_as_before() {
        let person = Person::typical(9);
        let one = judged(Asks::MoreLess, 4.0, 4.0);
        let again = Judged { trial: 77, ..one.clone() };
        assert_eq!(person.judge(&one), person.judge(&again));
        // Another mode and another sequence have answers of their own.
        let answers = |change: fn(&mut Judged)| -> Vec<i16> {
            let mut other = one.clone();
            change(&mut other);
            (1..60).map(|n| person.judge(&Judged { presentation: n, ..other.clone() })).collect()
        };
        let all = [
            answers(|_| ()),
            answers(|judged| judged.mode = "passive".parse().unwrap()),
            answers(|judged| judged.track = 1),
        ];
        assert!(all[0] != all[1] && all[0] != all[2] && all[1] != all[2]);
    }

    #[test]
    fn who_sets_a_level_comes_to_it_from_both_sides() {
        let person = Person::typical(4);
        for start in [2.0, 6.0] {
            let mut one = judged(Asks::Set, 4.0, start);
            let steps = (0..100).take_while(|_| {
                let answer = person.judge(&one);
                let change = match answer {
                    1 => 0.1,
                    2 => -0.1,
                    _ => 0.0,
                };
                one.level = level(one.level.value() + change);
                answer != 3
            });
            assert!((5..40).contains(&steps.count()), "{start}");
            assert!((one.level.value() - 4.0).abs() < 1.1, "{start}: {:?}", one.level);
        }
    }

    #[test]
    fn the_brake_alone_is_told_apart_less_well_than_the_motor() {
        let task = judged(Asks::MoreOfTwo, 4.0, 4.0).task;
        let [motor, brake] =
            [ModeLaw::Active, ModeLaw::Passive].map(|law| Truth::of(&task, Some(law)));
        assert!((motor.threshold - 4.0).abs() < 1e-12 && (motor.scale - 0.4).abs() < 1e-12);
        assert!(brake.scale > motor.scale && brake.threshold < motor.threshold);
        assert!((motor.share(4.0) - 0.5).abs() < 1e-12);
        assert!((motor.share(100.0) - 0.98).abs() < 1e-12);
    }
}
