//! What differences between modes along everybody's own line over trials say of studies in which people get better with
//! practice and modes do nothing.

use crate::drawn::normal;
use crate::judged::{Asked, Judged, LEVEL, MOST, Said, judge};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use zwidth_stats::over_trials::{
    Line, MOST_INFLATED, TrialPoint, WeighedCondition, inflation, moved,
};
use zwidth_stats::paired;
use zwidth_study::order::williams;

/// Trials of each person in each mode.
const REPEATS: usize = 6;
/// SDs of people's levels in each mode, and of a trial.
const MODE_SD: f64 = 0.5;
const TRIAL_SD: f64 = 0.7;

/// How modes follow each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Order {
    /// Each repeat is a row of a Williams square, as zwidth draws them.
    Williams,
    /// All trials of a mode in one block; the first mode changes from person to person.
    RotatedBlocks,
    /// The same blocks for three of four people, for the others those that begin with the second mode.
    MostlySameBlocks,
    /// The same blocks for everybody.
    SameBlocks,
}

/// How people get better.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Practice {
    /// By 0.05 from trial to trial, SD over people 0.03.
    Line,
    /// By 1 in all (SD 0.4), of which after six trials a third is left.
    DiesAway,
}

/// People, the order of their modes, and how they get better.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Practised {
    people: usize,
    order: Order,
    modes: usize,
    /// The modes compared: the one less the other.
    contrast: [usize; 2],
    practice: Practice,
}

pub(crate) fn kinds() -> Vec<Practised> {
    let orders = [
        (Order::Williams, 3, [2, 0]),
        (Order::RotatedBlocks, 2, [1, 0]),
        (Order::RotatedBlocks, 3, [2, 0]),
        (Order::RotatedBlocks, 4, [2, 0]),
        (Order::MostlySameBlocks, 3, [1, 0]),
        (Order::MostlySameBlocks, 3, [2, 0]),
        (Order::SameBlocks, 3, [1, 0]),
        (Order::SameBlocks, 3, [2, 0]),
    ];
    let mut kinds = Vec::new();
    for (order, modes, contrast) in orders {
        for practice in [Practice::Line, Practice::DiesAway] {
            let people = [6, 8, 12, 20].into_iter();
            kinds.extend(people.map(|people| Practised {
                people,
                order,
                modes,
                contrast,
                practice,
            }));
        }
    }
    kinds
}

impl Practised {
    pub(crate) fn name(&self) -> String {
        let practice = match self.practice {
            Practice::Line => "practice a line",
            Practice::DiesAway => "practice dies away",
        };
        let order = match (self.order, self.contrast) {
            (Order::Williams, _) => "Williams rows",
            (Order::RotatedBlocks, _) => "rotated blocks",
            (Order::MostlySameBlocks, [1, 0]) => "the same blocks for three of four, neighbours",
            (Order::MostlySameBlocks, _) => "the same blocks for three of four, first and last",
            (Order::SameBlocks, [1, 0]) => "the same blocks for all, neighbours",
            (Order::SameBlocks, _) => "the same blocks for all, first and last",
        };
        format!("n = {}, {} modes, {order}, {practice}", self.people, self.modes)
    }

    /// The modes of a person's trials, in their order.
    fn modes_of(&self, person: usize) -> Vec<usize> {
        let first = match self.order {
            Order::RotatedBlocks => person,
            Order::MostlySameBlocks => usize::from(person % 4 == 3),
            Order::Williams | Order::SameBlocks => 0,
        };
        match self.order {
            Order::Williams => {
                let rows = williams(self.modes);
                let of_repeat = |repeat: usize| rows[(person + repeat) % rows.len()].clone();
                (0..REPEATS).flat_map(of_repeat).collect()
            }
            Order::RotatedBlocks | Order::MostlySameBlocks | Order::SameBlocks => {
                (0..self.modes).flat_map(|block| [(block + first) % self.modes; REPEATS]).collect()
            }
        }
    }

    /// Everybody's trials.
    fn draw(&self, study: u64) -> Vec<Vec<TrialPoint>> {
        let mut rng = ChaCha8Rng::seed_from_u64(study);
        let person = |person| {
            let by_mode: Vec<f64> = (0..self.modes).map(|_| MODE_SD * normal(&mut rng)).collect();
            let own = normal(&mut rng);
            let trials = self.modes_of(person).into_iter().enumerate().map(|(number, mode)| {
                let number = number as f64;
                let practised = match self.practice {
                    Practice::Line => -(0.05 + 0.03 * own) * number,
                    Practice::DiesAway => (1.0 + 0.4 * own) * libm::exp(-number / 6.0),
                };
                let value = practised + by_mode[mode] + TRIAL_SD * normal(&mut rng);
                TrialPoint { session: 0, mode, place: number, number, value }
            });
            trials.collect()
        };
        (0..self.people).map(person).collect()
    }
}

/// The difference between modes of values as they are, along everybody's own line where the order lets the program claim
/// it, and along the lines whatever the order.
pub(crate) fn tests(kind: Practised, studies: usize) -> Vec<Judged> {
    let approximate = Asked::Approximate { most: MOST, coverage: [0.94, 0.985] };
    let balanced = if kind.order == Order::Williams { approximate } else { Asked::Nothing };
    // A line leaves what it cannot bend to, which nothing evens out where most people had one order.
    let has_one = matches!(kind.order, Order::SameBlocks | Order::MostlySameBlocks);
    let is_left = has_one && kind.practice == Practice::DiesAway;
    let tests = [
        ("claim along own lines", if is_left { Asked::Nothing } else { approximate }),
        ("own lines, claimed or not", Asked::Nothing),
        ("as they are", balanced),
    ];
    judge(studies, tests, |study| {
        let people = kind.draw(study);
        let lines: Vec<Line> = people.iter().filter_map(|trials| Line::of(trials)).collect();
        let weights = [1.0, -1.0]
            .into_iter()
            .zip(kind.contrast)
            .map(|(weight, mode)| WeighedCondition { session: None, environment: 0, mode, weight });
        let weights: Vec<_> = weights.collect();
        let each = lines.iter().filter_map(|line| moved(&weights, |_| Some(line)));
        let inflated = inflation(&each.collect::<Vec<_>>());
        let adjusted: Vec<f64> = people
            .iter()
            .zip(&lines)
            .map(|(trials, line)| {
                let values = trials.iter().map(|trial| (trial.mode, line.adjusted(trial).unwrap()));
                difference(values, kind.contrast)
            })
            .collect();
        let as_they_are: Vec<f64> = people
            .iter()
            .map(|trials| {
                difference(trials.iter().map(|trial| (trial.mode, trial.value)), kind.contrast)
            })
            .collect();
        let along = Said::by_estimate(paired::mean_difference(&adjusted, LEVEL).ok());
        let refused = Said { rejects: Some(false), covers: None };
        [
            if inflated > MOST_INFLATED { refused } else { along },
            along,
            Said::by_estimate(paired::mean_difference(&as_they_are, LEVEL).ok()),
        ]
    })
}

/// The mean in the one mode less that in the other.
fn difference(values: impl Iterator<Item = (usize, f64)>, [one, other]: [usize; 2]) -> f64 {
    let mut sums = [0.0, 0.0];
    for (mode, value) in values {
        if mode == one {
            sums[0] += value;
        } else if mode == other {
            sums[1] += value;
        }
    }
    (sums[0] - sums[1]) / REPEATS as f64
}
