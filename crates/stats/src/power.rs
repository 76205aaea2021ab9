//! Power of a planned study, by simulating it and testing each simulated study as a real one is
//! tested.
//!
//! A trial is the participant's level, the mode's effect, the participant's own effect of the mode
//! and a residual, all normal. The test is the paired t of participants' means in two modes. Each
//! study draws from its own stream of the ChaCha8 cipher, keyed with the seed, so the result is the
//! same with any number of threads; the same seed draws the same people at any difference.

use crate::bootstrap::stream;
use crate::error::{StatsError, all_finite, check_level};
use crate::groups::{self, LEAST_FOR_A_CLAIM};
use crate::lmm::trials::{Trials, fit_trials};
use crate::rounded::rounded;
use crate::student_t::two_sided_p;
use crate::tested::{Unestimable, at_least, not_constant};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::Rng;
use rayon::prelude::*;
use statrs::function::beta::checked_beta_reg;
use zwidth_numerics::moments::Moments;

/// A search for participants ends here: no study of the kind has more.
pub const MOST_PARTICIPANTS: usize = 10_000;
/// Halvings of a searched difference: to a millionth of where it began.
pub const HALVINGS: usize = 20;

/// A planned study of one contrast: two modes, with the others beside them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// SD of participants' levels. The paired tests do not depend on it.
    pub participant_sd: f64,
    /// SD of a participant's own effect of a mode.
    pub interaction_sd: f64,
    /// SD of one trial about it.
    pub residual_sd: f64,
    /// Trials of each mode.
    pub repeats: usize,
    /// Modes; those beyond two matter to the mixed model alone.
    pub modes: usize,
    /// The true difference, last mode minus first.
    pub difference: f64,
    /// Participants.
    pub participants: usize,
}

/// The test that a simulated study is put to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlannedTest {
    /// Paired t of participants' means.
    PairedT,
    /// The largest mixed model that the design supports, after Kenward & Roger.
    KenwardRoger,
    /// Welch's t of two groups' differences, with so many of these participants in the first for every so many in
    /// the second. The true difference is that of the groups.
    Welch([usize; 2]),
}

impl PlannedTest {
    /// How many of so many participants have the true difference: the first group, or all.
    fn with_difference(self, participants: usize) -> usize {
        match self {
            Self::PairedT | Self::KenwardRoger => participants,
            Self::Welch([first, second]) => {
                let share = first as f64 / (first + second) as f64;
                (share * participants as f64).round() as usize
            }
        }
    }
}

/// How studies are simulated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Simulation {
    /// The test.
    pub test: PlannedTest,
    /// The p value below which a difference is claimed.
    pub alpha: f64,
    /// Studies.
    pub studies: usize,
    /// Seed of all draws.
    pub seed: u64,
}

/// A share of simulated studies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Power {
    /// Studies that claimed the difference.
    pub claims: usize,
    /// Studies that had a test.
    pub studies: usize,
    /// claims / studies.
    pub estimate: f64,
    /// Lower end of Clopper & Pearson's 95 % interval.
    pub ci_low: f64,
    /// Its upper end.
    pub ci_high: f64,
}

/// Level of the interval of power.
const POWER_LEVEL: f64 = 0.95;

impl Power {
    /// Of studies by whether they claimed the difference.
    pub(crate) fn of(studies: &[bool]) -> Result<Self, Unestimable> {
        let claims = studies.iter().filter(|claim| **claim).count();
        let (ci_low, ci_high) = clopper_pearson(claims, studies.len(), POWER_LEVEL)?;
        let estimate = claims as f64 / studies.len() as f64;
        Ok(Self { claims, studies: studies.len(), estimate, ci_low, ci_high })
    }
}

/// The share of simulated studies in which the test claims a difference.
///
/// # Errors
/// An SD that is negative or not finite, fewer than two modes, participants or studies, no repeats,
/// `alpha` outside (0, 1).
pub fn power(plan: &Plan, simulation: &Simulation) -> Result<Power, Unestimable> {
    check(plan, simulation)?;
    let claims: Vec<bool> = (0..simulation.studies)
        .into_par_iter()
        .map(|study| {
            let values = simulate(plan, simulation, study as u64);
            let p_value = match simulation.test {
                PlannedTest::PairedT => paired_t(plan, &values),
                PlannedTest::KenwardRoger => kenward_roger(plan, &values),
                PlannedTest::Welch(_) => welch(plan, simulation, &values),
            };
            // A study without a test claims nothing.
            p_value.is_ok_and(|p| p < simulation.alpha)
        })
        .collect();
    Power::of(&claims)
}

/// The progress of a search. It counts participants, because a simulated study takes as long as it
/// has participants.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Searched {
    /// Participants simulated until now, of all simulated studies.
    pub simulated: usize,
    /// Participants still to be simulated. While the search looks for its first bound, as if this
    /// was it.
    pub to_come: usize,
}

/// A search for the fewest participants that find a difference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParticipantSearch {
    /// The power that they are to have.
    pub target: f64,
    /// Studies that are simulated of each number of participants.
    pub studies: usize,
    /// Where the search ends.
    pub most: usize,
}

/// The fewest participants whose power is at least the target, with it; `None` if the most do not have
/// it. By doubling, then halving: power grows with participants. `at` simulates studies of so many
/// participants; `progress` is called each time that it did.
///
/// # Errors
/// Those of `at`, a target outside (0, 1).
pub fn participants_for(
    search: &ParticipantSearch,
    at: &dyn Fn(usize) -> Result<Power, Unestimable>,
    progress: &dyn Fn(Searched),
) -> Result<Option<(usize, Power)>, Unestimable> {
    let ParticipantSearch { target, studies, most } = *search;
    check_level(target)?;
    let mut simulated = 0;
    let mut searched = |participants: usize, low: usize, high: usize| {
        simulated += participants * studies;
        // Each halving tries about the middle.
        let halvings = (high - low).next_power_of_two().ilog2() as usize;
        let to_come = halvings * (low + high) / 2 * studies;
        progress(Searched { simulated, to_come });
    };
    let mut low = 1;
    let mut high = 2;
    let mut at_high = at(high)?;
    searched(high, low, high);
    while at_high.estimate < target {
        if high >= most {
            return Ok(None);
        }
        (low, high) = (high, (2 * high).min(most));
        at_high = at(high)?;
        searched(high, low, high);
    }
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        let at_middle = at(middle)?;
        if at_middle.estimate < target {
            low = middle;
        } else {
            (high, at_high) = (middle, at_middle);
        }
        searched(middle, low, high);
    }
    Ok(Some((high, at_high)))
}

/// A search for the smallest difference that a study finds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DifferenceSearch {
    /// The power that it is to have.
    pub target: f64,
    /// Where the search begins: about the standard error of the difference, in its unit.
    pub start: f64,
    /// How often the bounds are halved: the difference is found to 2⁻ⁿ of where they were.
    pub halvings: usize,
    /// Participants of all studies simulated at one difference, of which `progress` is told.
    pub participants: usize,
}

/// The smallest difference that is found with the target's power, in the unit of its start; none if even one of 2⁴⁰ times
/// the start is not. `at` simulates studies with a difference; `progress` is called each time that it did.
///
/// # Errors
/// Those of `at`, a target outside (0, 1), a start that is not above 0.
pub fn smallest_difference(
    search: &DifferenceSearch,
    at: &dyn Fn(f64) -> Result<Power, Unestimable>,
    progress: &dyn Fn(Searched),
) -> Result<Option<f64>, Unestimable> {
    /// Doublings of the start after which no difference is found.
    const MOST_DOUBLINGS: usize = 40;
    let DifferenceSearch { target, start, halvings, participants } = *search;
    check_level(target)?;
    not_constant("planned values", !(start.is_finite() && start > 0.0))?;
    let mut simulated = 0;
    let mut at = |difference: f64, halvings: usize| {
        let power = at(difference)?;
        simulated += participants;
        progress(Searched { simulated, to_come: halvings * participants });
        Ok::<_, Unestimable>(power)
    };
    let mut high = start;
    let mut low = 0.0;
    let mut doublings = 0;
    while at(high, halvings)?.estimate < target {
        (low, high) = (high, 2.0 * high);
        doublings += 1;
        if doublings > MOST_DOUBLINGS {
            return Ok(None);
        }
    }
    for halving in 1..=halvings {
        let middle = low + (high - low) / 2.0;
        if at(middle, halvings - halving)?.estimate < target {
            low = middle;
        } else {
            high = middle;
        }
    }
    Ok(Some(high))
}

impl Plan {
    /// Standard error of the mean of participants' differences of mode means: √(2 (σ²_mode + σ² / repeats) / n).
    pub fn difference_std_error(&self) -> f64 {
        let [interaction, residual] = [self.interaction_sd, self.residual_sd].map(|sd| sd * sd);
        let contrast_sd = (2.0 * (interaction + residual / self.repeats as f64)).sqrt();
        contrast_sd / (self.participants as f64).sqrt()
    }
}

fn check(plan: &Plan, simulation: &Simulation) -> Result<(), Unestimable> {
    let sds = [plan.participant_sd, plan.interaction_sd, plan.residual_sd];
    all_finite(&sds)?;
    all_finite(&[plan.difference])?;
    check_level(1.0 - simulation.alpha)?;
    if let PlannedTest::Welch([first, second]) = simulation.test {
        at_least("participants of a group", first.min(second), 1)?;
    }
    if let Some(index) = sds.iter().position(|sd| *sd < 0.0) {
        return Err(StatsError::NonFinite { index, value: sds[index] }.into());
    }
    for (units, found, needed) in [
        ("modes", plan.modes, 2),
        ("participants", plan.participants, 2),
        ("trials of a mode", plan.repeats, 1),
        ("simulated studies", simulation.studies, 1),
    ] {
        at_least(units, found, needed)?;
    }
    Ok(())
}

/// The values of one study, by participant, mode and repeat.
fn simulate(plan: &Plan, simulation: &Simulation, study: u64) -> Vec<f64> {
    let mut rng = stream(simulation.seed, study);
    let with_difference = simulation.test.with_difference(plan.participants);
    // No parameter but the counts changes which numbers are drawn: a search over the difference
    // compares the same people.
    let mut values = Vec::with_capacity(plan.participants * plan.modes * plan.repeats);
    for participant in 0..plan.participants {
        let own = plan.participant_sd * normal(&mut rng);
        for mode in 0..plan.modes {
            let last = mode + 1 == plan.modes;
            let has = last && participant < with_difference;
            let effect = if has { plan.difference } else { 0.0 };
            let level = own + effect + plan.interaction_sd * normal(&mut rng);
            values.extend((0..plan.repeats).map(|_| level + plan.residual_sd * normal(&mut rng)));
        }
    }
    values
}

/// A standard normal number (Box & Muller 1958), by libm: the same on any machine.
pub(crate) fn normal(rng: &mut ChaCha8Rng) -> f64 {
    /// 2⁻⁵³, so that 53 bits make a number in [0, 1).
    const UNIT: f64 = 1.0 / (1_u64 << 53) as f64;
    // Not `bootstrap::normal`: its numbers lie half a step further, and power is stored.
    let [first, second] = [(); 2].map(|()| (rng.next_u64() >> 11) as f64 * UNIT);
    // 1 − u, for u may be 0, which has no logarithm.
    let radius = (-2.0 * libm::log(1.0 - first)).sqrt();
    radius * libm::cos(2.0 * core::f64::consts::PI * second)
}

/// Everybody's difference of the last and the first mode in one study.
fn differences(plan: &Plan, values: &[f64]) -> Vec<f64> {
    let size = plan.modes * plan.repeats;
    let mut differences = Vec::with_capacity(plan.participants);
    for person in values.chunks(size) {
        let [last, first] = [&person[size - plan.repeats..], &person[..plan.repeats]]
            .map(|cell| cell.iter().sum::<f64>() / plan.repeats as f64);
        differences.push(last - first);
    }
    differences
}

/// p of the difference of two groups in one study, as it is claimed.
fn welch(plan: &Plan, simulation: &Simulation, values: &[f64]) -> Result<f64, Unestimable> {
    let differences = differences(plan, values);
    let (first, second) = differences.split_at(simulation.test.with_difference(plan.participants));
    at_least("participants of a group", first.len().min(second.len()), LEAST_FOR_A_CLAIM)?;
    Ok(groups::difference([first, second].map(groups::group), POWER_LEVEL)?.p_value)
}

/// p of the difference of the last and the first mode in one study, by the paired t test.
fn paired_t(plan: &Plan, values: &[f64]) -> Result<f64, Unestimable> {
    let differences = differences(plan, values);
    let n = differences.len() as f64;
    let moments = Moments::of(&differences);
    match moments.sd() {
        Some(sd) if sd > 0.0 => Ok(two_sided_p(moments.mean / (sd / n.sqrt()), n - 1.0)?),
        _ => Err(Unestimable::Constant { units: "differences" }),
    }
}

/// The same by the mixed model.
fn kenward_roger(plan: &Plan, values: &[f64]) -> Result<f64, Unestimable> {
    let rows = 0..values.len();
    let participant: Vec<usize> =
        rows.clone().map(|row| row / (plan.modes * plan.repeats)).collect();
    let mode: Vec<usize> = rows.map(|row| row / plan.repeats % plan.modes).collect();
    let session = vec![0; values.len()];
    let trials =
        Trials { participant: &participant, session: &session, mode: &mode, value: values };
    let fitted = fit_trials(trials)?;
    let weights = fitted.difference(plan.modes - 1, 0)?;
    Ok(fitted.fit.kenward_roger()?.test(&weights, POWER_LEVEL)?.p_value)
}

/// The exact interval of a share, `count` of `n` (Clopper & Pearson 1934, Biometrika 26:404): each
/// end is the share that makes a count as far out have probability (1 − level) / 2.
///
/// # Errors
/// `level` outside (0, 1), `n` zero or below `count`.
pub fn clopper_pearson(count: usize, n: usize, level: f64) -> Result<(f64, f64), StatsError> {
    check_level(level)?;
    if n == 0 || count > n {
        return Err(StatsError::DegreesOfFreedom { df: n as f64 });
    }
    let x = count as f64;
    let rest = (n - count) as f64;
    let tail = (1.0 - level) / 2.0;
    let low = if count == 0 { 0.0 } else { beta_quantile(tail, x, rest + 1.0) };
    let high = if count == n { 1.0 } else { beta_quantile(1.0 - tail, x + 1.0, rest) };
    Ok((rounded(low), rounded(high)))
}

/// The quantile of the beta distribution, by bisection down to neighbouring numbers.
fn beta_quantile(share: f64, a: f64, b: f64) -> f64 {
    let mut low = 0.0;
    let mut high = 1.0;
    loop {
        let middle: f64 = low + (high - low) / 2.0;
        if middle <= low || middle >= high {
            return middle;
        }
        if checked_beta_reg(a, b, middle).is_ok_and(|below| below < share) {
            low = middle;
        } else {
            high = middle;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;

    const PLAN: Plan = Plan {
        participant_sd: 1.0,
        interaction_sd: 0.5,
        residual_sd: 0.9,
        repeats: 6,
        modes: 3,
        difference: 0.6,
        participants: 12,
    };
    const SIMULATION: Simulation =
        Simulation { test: PlannedTest::PairedT, alpha: 0.05, studies: 4000, seed: 1 };

    /// R: `power.t.test(n, delta, sd, type = "paired", strict = TRUE)$power`, sd = √(2 (0.25 +
    /// 0.135)).
    /// R's `power.t.test(n = 16, delta = 0.8, sd = 1)`: 0.5915; Welch's degrees of freedom are a little fewer.
    #[test]
    fn the_power_of_two_groups_is_that_of_welchs_t() {
        let plan = Plan {
            participant_sd: 1.0,
            interaction_sd: 0.5_f64.sqrt(),
            residual_sd: 0.0,
            repeats: 1,
            modes: 2,
            difference: 0.8,
            participants: 32,
        };
        let simulation = Simulation { test: PlannedTest::Welch([1, 1]), ..SIMULATION };
        let found = power(&plan, &simulation).unwrap();
        assert!(found.ci_low < 0.5915 && 0.5895 < found.ci_high, "{found:?}");
        let none = power(&Plan { difference: 0.0, ..plan }, &simulation).unwrap();
        assert!(none.ci_low < 0.05 && 0.05 < none.ci_high, "{none:?}");
        // Three in a group make no claim, however large the difference.
        let few = Plan { participants: 12, difference: 50.0, ..plan };
        let of = |groups| {
            let simulation = Simulation { test: PlannedTest::Welch(groups), ..SIMULATION };
            power(&few, &simulation).unwrap().estimate
        };
        assert_eq!([of([3, 9]), of([4, 8])].map(|share| share > 0.99), [false, true]);
        let nobody = Simulation { test: PlannedTest::Welch([0, 8]), ..SIMULATION };
        assert!(power(&plan, &nobody).is_err());
    }

    #[test]
    fn power_is_that_of_the_noncentral_t() {
        for (participants, r) in POWER_OF_R {
            let found = power(&Plan { participants, ..PLAN }, &SIMULATION).unwrap();
            let (low, high) = clopper_pearson(found.claims, found.studies, 0.999).unwrap();
            assert!(low < r && r < high, "{participants}: {found:?} for {r}");
        }
    }

    #[test]
    fn without_a_difference_power_is_alpha() {
        let found = power(&Plan { difference: 0.0, ..PLAN }, &SIMULATION).unwrap();
        assert!(found.ci_low < 0.05 && 0.05 < found.ci_high, "{found:?}");
    }

    #[test]
    fn one_thread_gives_the_claims_of_many() {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| power(&PLAN, &SIMULATION).unwrap())
        };
        assert_eq!(on(1), on(4));
        let other = Simulation { seed: 2, ..SIMULATION };
        assert_ne!(on(1).claims, power(&PLAN, &other).unwrap().claims);
    }

    /// The power of a plan with other participants.
    fn of_participants(
        plan: Plan,
        simulation: Simulation,
    ) -> impl Fn(usize) -> Result<Power, Unestimable> {
        move |participants| power(&Plan { participants, ..plan }, &simulation)
    }

    /// The power of a plan with another difference.
    fn of_difference(
        plan: Plan,
        simulation: Simulation,
    ) -> impl Fn(f64) -> Result<Power, Unestimable> {
        move |difference| power(&Plan { difference, ..plan }, &simulation)
    }

    fn many(simulation: Simulation) -> ParticipantSearch {
        ParticipantSearch { target: 0.8, studies: simulation.studies, most: MOST_PARTICIPANTS }
    }

    fn search(plan: Plan, studies: usize) -> DifferenceSearch {
        DifferenceSearch {
            target: 0.8,
            start: plan.difference_std_error(),
            halvings: HALVINGS,
            participants: plan.participants * studies,
        }
    }

    #[test]
    fn the_fewest_participants_are_enough_and_one_fewer_are_not() {
        let at = of_participants(PLAN, SIMULATION);
        let (n, found) = participants_for(&many(SIMULATION), &at, &|_| {}).unwrap().unwrap();
        assert!(found.estimate >= 0.8, "{found:?}");
        let fewer = power(&Plan { participants: n - 1, ..PLAN }, &SIMULATION).unwrap();
        assert!(fewer.estimate < 0.8);
        let exact = PARTICIPANTS_OF_R;
        assert!(n.abs_diff(exact) <= 1, "{n} for {exact}");
        let hopeless = Plan { difference: 0.0, ..PLAN };
        let few = Simulation { studies: 5, ..SIMULATION };
        let at = of_participants(hopeless, few);
        assert_eq!(participants_for(&many(few), &at, &|_| {}).unwrap(), None);
    }

    #[test]
    fn the_smallest_difference_is_found_with_its_power() {
        let at = of_difference(PLAN, SIMULATION);
        let of_plan = search(PLAN, SIMULATION.studies);
        let found = smallest_difference(&of_plan, &at, &|_| {}).unwrap().unwrap();
        assert!((found / DIFFERENCE_OF_R - 1.0).abs() < 0.04, "{found}");
        let none = Plan { interaction_sd: 0.0, residual_sd: 0.0, ..PLAN };
        assert!(smallest_difference(&search(none, 1), &at, &|_| {}).is_err());
        // Where no difference makes a claim, none is found.
        let never = |_| power(&Plan { difference: 0.0, ..PLAN }, &SIMULATION);
        assert_eq!(smallest_difference(&of_plan, &never, &|_| {}).unwrap(), None);
    }

    #[test]
    fn a_search_counts_what_it_simulates_and_ends_with_nothing_to_come() {
        let few = Simulation { studies: 100, ..SIMULATION };
        let steps = RefCell::new(Vec::new());
        let keep = |searched| steps.borrow_mut().push(searched);
        let at = of_participants(PLAN, few);
        let (n, _) = participants_for(&many(few), &at, &keep).unwrap().unwrap();
        let of_participants = steps.take();
        let at = of_difference(PLAN, few);
        smallest_difference(&search(PLAN, few.studies), &at, &keep).unwrap();
        let of_difference = steps.take();
        assert!(n > 16 && n < 64, "doubled to 32 or 64: {n}");
        for all in [&of_participants, &of_difference] {
            assert!(all.windows(2).all(|pair| pair[0].simulated < pair[1].simulated), "{all:?}");
            assert_eq!(all.last().map(|last| last.to_come), Some(0), "{all:?}");
        }
        let first = of_difference[0];
        assert_eq!(first, Searched { simulated: 1200, to_come: HALVINGS * 1200 });
        // Once the number of participants has its bounds, what is to come is known but for where
        // between them the search goes.
        let bounded = of_participants.iter().rposition(|s| s.to_come > 0).unwrap();
        let last = of_participants.last().unwrap().simulated;
        let known = of_participants[bounded].simulated + of_participants[bounded].to_come;
        assert!(known.abs_diff(last) <= 200, "{of_participants:?}");
    }

    #[test]
    fn the_mixed_model_has_nearly_the_power_of_the_paired_test() {
        let few = Simulation { studies: 400, ..SIMULATION };
        let t = power(&PLAN, &few).unwrap();
        let mixed = power(&PLAN, &Simulation { test: PlannedTest::KenwardRoger, ..few }).unwrap();
        assert!((t.estimate - mixed.estimate).abs() < 0.08, "{t:?} {mixed:?}");
    }

    /// SciPy: `beta.ppf(0.025, x, n - x + 1)`, `beta.ppf(0.975, x + 1, n - x)`.
    #[test]
    fn exact_intervals_of_shares_are_those_of_scipy() {
        for (count, n, low, high) in SCIPY {
            let found = clopper_pearson(count, n, 0.95).unwrap();
            assert!((found.0 - low).abs() < 1e-9 && (found.1 - high).abs() < 1e-9, "{found:?}");
        }
        assert!(clopper_pearson(3, 2, 0.95).is_err() && clopper_pearson(0, 0, 0.95).is_err());
    }

    #[test]
    fn a_plan_that_cannot_be_meant_is_refused() {
        for plan in [
            Plan { residual_sd: -1.0, ..PLAN },
            Plan { interaction_sd: f64::NAN, ..PLAN },
            Plan { modes: 1, ..PLAN },
            Plan { participants: 1, ..PLAN },
            Plan { repeats: 0, ..PLAN },
        ] {
            assert!(power(&plan, &SIMULATION).is_err(), "{plan:?}");
        }
        assert!(power(&PLAN, &Simulation { alpha: 1.0, ..SIMULATION }).is_err());
        let at = of_participants(PLAN, SIMULATION);
        let beyond = ParticipantSearch { target: 80.0, ..many(SIMULATION) };
        assert!(participants_for(&beyond, &at, &|_| {}).is_err());
    }

    const POWER_OF_R: [(usize, f64); 3] =
        [(4, 0.164_258_021_698), (12, 0.579_115_270_454), (24, 0.893_798_790_809)];
    const PARTICIPANTS_OF_R: usize = 19;
    const DIFFERENCE_OF_R: f64 = 0.779_790_953;
    const SCIPY: [(usize, usize, f64, f64); 4] = [
        (0, 10, 0.0, 0.3084971078187607),
        (3, 10, 0.06673951117773447, 0.6524528500599973),
        (10, 10, 0.6915028921812392, 1.0),
        (480, 2000, 0.2214246405699285, 0.25934056691120344),
    ];
}
