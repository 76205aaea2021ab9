//! What the tests of factors say of studies in which no factor has an effect, and of some in which two interact.

use crate::drawn::normal;
use crate::judged::{ALPHA, Asked, Judged, LEVEL, MOST, Said, judge};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use zwidth_stats::{holm, paired, rm_anova};

/// Levels of each of the two factors.
const LEVELS: usize = 3;

/// People in 3 × 3 conditions, and how much they scatter in each: three times as much where both factors have
/// their last level, or everywhere alike.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Crossed {
    people: usize,
    last_scatters: f64,
    /// How much higher the condition is in which both factors have their last level.
    effect: f64,
}

pub(crate) fn kinds() -> Vec<Crossed> {
    let kinds = [6, 8, 12, 20].into_iter().flat_map(|people| {
        [(1.0, 0.0), (3.0, 0.0), (1.0, 2.0)].map(|(last_scatters, effect)| Crossed {
            people,
            last_scatters,
            effect,
        })
    });
    kinds.collect()
}

impl Crossed {
    pub(crate) fn name(&self) -> String {
        let effect = if self.effect > 0.0 { ", which is two SDs higher" } else { "" };
        format!("n = {}, SD in the last condition {} : 1{effect}", self.people, self.last_scatters)
    }
}

/// Weights of the conditions in the four contrasts of the interaction: a later level of both factors less the
/// first of both.
fn interaction() -> Vec<Vec<f64>> {
    let later =
        |level: usize, of: usize| f64::from(u8::from(of == level)) - f64::from(u8::from(of == 0));
    let pairs = (1..LEVELS).flat_map(|one| (1..LEVELS).map(move |other| (one, other)));
    let weights = pairs.map(|(one, other)| {
        let cells = (0..LEVELS * LEVELS).map(|cell| (cell / LEVELS, cell % LEVELS));
        cells.map(|(a, b)| later(one, a) * later(other, b)).collect()
    });
    weights.collect()
}

/// The last contrast of the interaction by t; any of its four after Holm; all of it by F, with and without a
/// correction for how far differences scatter unevenly.
pub(crate) fn tests(kind: Crossed, studies: usize) -> Vec<Judged> {
    let asked = |most| Asked::Approximate { most, coverage: [0.94, 0.96] };
    // How often an effect is found is its power.
    let approximate = if kind.effect > 0.0 { Asked::Nothing } else { asked(MOST) };
    let even = if kind.last_scatters > 1.0 { Asked::Nothing } else { approximate };
    let tests = [
        ("t of an interaction", if kind.effect > 0.0 { asked(1.0) } else { asked(MOST) }),
        ("any of four, after Holm", approximate),
        ("F, Greenhouse–Geisser", approximate),
        ("F, Huynh–Feldt", Asked::Nothing),
        ("F, uncorrected", even),
    ];
    let contrasts = interaction();
    judge(studies, tests, |study| {
        let mut rng = ChaCha8Rng::seed_from_u64(study);
        let people: Vec<Vec<f64>> = (0..kind.people)
            .map(|_| {
                let level = normal(&mut rng);
                let cells = (0..LEVELS * LEVELS).map(|cell| {
                    let last = cell + 1 == LEVELS * LEVELS;
                    let (effect, scatter) =
                        if last { (kind.effect, kind.last_scatters) } else { (0.0, 1.0) };
                    level + effect + scatter * normal(&mut rng)
                });
                cells.collect()
            })
            .collect();
        let tested: Vec<_> = contrasts
            .iter()
            .map(|weights| {
                let of = |cells: &Vec<f64>| cells.iter().zip(weights).map(|(c, w)| c * w).sum();
                let values: Vec<f64> = people.iter().map(of).collect();
                paired::mean_difference(&values, LEVEL).ok()
            })
            .collect();
        let p: Vec<f64> = tested.iter().flatten().map(|tested| tested.p_value).collect();
        let any = holm::adjusted(&p).is_ok_and(|p| p.iter().any(|p| *p < ALPHA));
        let anova = rm_anova::effect(&people, &contrasts).ok();
        [
            Said::about(tested.last().copied().flatten(), kind.effect),
            Said { rejects: Some(any), covers: None },
            Said::by_p(anova.map(|found| found.p_greenhouse_geisser)),
            Said::by_p(anova.map(|found| found.p_huynh_feldt)),
            Said::by_p(anova.map(|found| found.test.p_value)),
        ]
    })
}
