//! Power as predicted, and as studies that were drawn and tested apart from the prediction have it.

use crate::drawn::normal;
use crate::judged::{ALPHA, LEVEL, Share};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rayon::prelude::*;
use zwidth_stats::paired;
use zwidth_stats::power::{Plan, PlannedTest, Simulation, clopper_pearson, power};

/// The level of the interval of the observed share.
const OBSERVED: f64 = 0.99;
/// The prediction rests on so many times the studies observed: its own error is a quarter of
/// theirs.
const TIMES: usize = 16;

/// A plan, the power predicted, and the claims of the studies observed.
pub(crate) struct Compared {
    pub(crate) plan: Plan,
    pub(crate) predicted: f64,
    pub(crate) observed: Share,
}

impl Compared {
    /// The exact interval of the observed share.
    pub(crate) fn interval(&self) -> (f64, f64) {
        clopper_pearson(self.observed.count, self.observed.of, OBSERVED).unwrap()
    }

    pub(crate) fn is_held(&self) -> bool {
        let (low, high) = self.interval();
        low <= self.predicted && self.predicted <= high
    }
}

/// Few and more participants, differences that are seldom and that are mostly found.
pub(crate) fn plans() -> Vec<Plan> {
    let plan = Plan {
        participant_sd: 1.0,
        interaction_sd: 0.5,
        residual_sd: 0.9,
        repeats: 6,
        modes: 3,
        difference: 0.0,
        participants: 0,
    };
    let differences = [0.3, 0.6, 1.0];
    let all = |participants| {
        differences.map(|difference| Plan { difference, participants, ..plan }).to_vec()
    };
    [6, 12, 24].into_iter().flat_map(all).collect()
}

/// Compares one plan by so many studies.
pub(crate) fn compare(plan: Plan, studies: usize) -> Compared {
    let simulation =
        Simulation { test: PlannedTest::PairedT, alpha: ALPHA, studies: TIMES * studies, seed: 1 };
    let count = (0..studies as u64).into_par_iter().filter(|study| claims(&plan, *study)).count();
    Compared {
        plan,
        predicted: power(&plan, &simulation).unwrap().estimate,
        observed: Share { count, of: studies },
    }
}

/// Whether one study claims the difference: two modes, trial by trial.
fn claims(plan: &Plan, study: u64) -> bool {
    let mut rng = ChaCha8Rng::seed_from_u64(study);
    rng.set_stream(plan.participants as u64 * 1000 + (plan.difference * 100.0) as u64);
    let pair = |_| {
        let own = plan.participant_sd * normal(&mut rng);
        [plan.difference, 0.0].map(|effect| {
            let level = own + effect + plan.interaction_sd * normal(&mut rng);
            let trials = (0..plan.repeats).map(|_| level + plan.residual_sd * normal(&mut rng));
            trials.sum::<f64>() / plan.repeats as f64
        })
    };
    let pairs: Vec<[f64; 2]> = (0..plan.participants).map(pair).collect();
    let found = paired::mean_difference(&paired::differences(&pairs), LEVEL);
    found.is_ok_and(|found| found.p_value < ALPHA)
}
