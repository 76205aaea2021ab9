//! What everybody's own slope, or bend, over a dose says of studies in which a fifth of the cells is missing.

use crate::drawn::normal;
use crate::judged::{Asked, Judged, LEVEL, MOST, Said, judge};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use zwidth_stats::over_doses::own_coefficient;
use zwidth_stats::paired;
use zwidth_study::{DoseScale, OverDose, Trend};

/// One cell in so many is missing.
const MISSING: u64 = 5;
/// SD of a cell's mean about its person's own line.
const CELL_SD: f64 = 0.3;

/// People whose own slopes (per 100 N/m), or bends (per square of that), scatter.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Doses {
    people: usize,
    /// 1: a slope; 2: a bend.
    coefficient: usize,
    own_sd: f64,
    /// The mean over people.
    effect: f64,
}

/// Somebody's mean at a level.
#[derive(Debug, Clone, Copy)]
struct Cell {
    mean: f64,
    is_missing: bool,
}

pub(crate) fn kinds() -> Vec<Doses> {
    let mut kinds = Vec::new();
    for (coefficient, effect) in [(1, 0.0), (1, 0.2), (2, 0.0), (2, 0.2)] {
        for own_sd in [0.0, 0.1, 0.3] {
            let people = [6, 8, 12, 20].into_iter();
            kinds.extend(people.map(|people| Doses { people, coefficient, own_sd, effect }));
        }
    }
    kinds
}

impl Doses {
    pub(crate) fn name(&self) -> String {
        let what = if self.coefficient == 1 { "slope" } else { "bend" };
        let effect = if self.effect > 0.0 { "an effect of 0.2" } else { "no effect" };
        format!("n = {}, {what}, SD {} over people, {effect}", self.people, self.own_sd)
    }

    /// The doses: of a slope four, as in docs/analysis.md; of a bend, which takes one more, five.
    fn over(&self) -> OverDose {
        let doses: &[f64] = match self.coefficient {
            1 => &[100.0, 150.0, 250.0, 400.0],
            _ => &[100.0, 150.0, 250.0, 350.0, 400.0],
        };
        let degree = if self.coefficient == 1 { 1 } else { 2 };
        OverDose {
            trend: Trend { degree, scale: DoseScale::Linear },
            doses: doses.to_vec(),
            unit: "N/m".to_owned(),
            levels: vec![Vec::new(); doses.len()],
        }
    }

    /// Everybody's levels.
    fn draw(&self, over: &OverDose, study: u64) -> Vec<Vec<Cell>> {
        let mut rng = ChaCha8Rng::seed_from_u64(study);
        let person = |_| {
            let level = normal(&mut rng);
            let own = self.effect + self.own_sd * normal(&mut rng);
            let cell = |x: f64| {
                let along = own * x.powi(self.coefficient as i32);
                let mean = level + along + CELL_SD * normal(&mut rng);
                Cell { mean, is_missing: rng.next_u64().is_multiple_of(MISSING) }
            };
            over.scaled().into_iter().map(cell).collect()
        };
        (0..self.people).map(person).collect()
    }
}

/// t of everybody's own coefficients over the levels that they have, as the program claims; beside it of those alone who
/// have every level, and of everybody if no cell were missing.
pub(crate) fn tests(kind: Doses, studies: usize) -> Vec<Judged> {
    let approximate = Asked::Approximate { most: MOST, coverage: [0.94, 0.985] };
    // Where there is an effect the rate is the power.
    let asked = if kind.effect > 0.0 { Asked::Nothing } else { approximate };
    let tests = [
        ("own lines over what each has", asked),
        ("only those with every level", Asked::Nothing),
        ("nothing missing", asked),
    ];
    let over = kind.over();
    judge(studies, tests, |study| {
        let people = kind.draw(&over, study);
        let has_all = |cells: &[Cell]| cells.iter().all(|cell| !cell.is_missing);
        let as_they_are = people.iter().filter_map(|cells| own(kind, &over, cells));
        let complete = people.iter().filter(|cells| has_all(cells));
        let complete = complete.filter_map(|cells| own(kind, &over, cells));
        let whole = people.iter().filter_map(|cells| {
            let whole = cells.iter().map(|cell| Cell { is_missing: false, ..*cell });
            own(kind, &over, &whole.collect::<Vec<_>>())
        });
        [
            said(&as_they_are.collect::<Vec<_>>(), kind.effect),
            said(&complete.collect::<Vec<_>>(), kind.effect),
            said(&whole.collect::<Vec<_>>(), kind.effect),
        ]
    })
}

/// Somebody's own coefficient over the levels that they have.
fn own(kind: Doses, over: &OverDose, cells: &[Cell]) -> Option<f64> {
    let means: Vec<Option<f64>> =
        cells.iter().map(|cell| (!cell.is_missing).then_some(cell.mean)).collect();
    let found = own_coefficient(over, kind.coefficient, &means)?;
    Some(found.terms.iter().map(|term| term.weight * term.mean).sum())
}

/// The test of "it is 0", and whether the interval holds the truth.
fn said(values: &[f64], truth: f64) -> Said {
    Said::about(paired::mean_difference(values, LEVEL).ok(), truth)
}
