//! Studies drawn by the design itself, with and without an effect.

use super::*;
use crate::SessionOrder;
use crate::tests::{Printed, compare, measured, parameters};
use crate::{DrawnOrder, MetricParameters};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use zwidth_results::TrialKey;
use zwidth_study::{Contrast, OrderScheme, Source as Origin};
use zwidth_tables::Measured;

const FEW: Sampling = Sampling { draws: 199, seed: 3 };
const ENVIRONMENTS: [&str; 2] = ["spring", "wall"];
const MODES: [&str; 3] = ["active", "passive", "hybrid"];
const FAMILIARISATION: u32 = 3;
/// The seed of every study's orders.
const SEED: u64 = 8;

/// A trial that counts.
#[derive(Clone)]
pub(crate) struct Trial {
    who: String,
    number: u32,
    environment: usize,
    mode: usize,
    pub(crate) value: Option<f64>,
}

/// A study of some people in one session.
pub(crate) struct Demo {
    pub(crate) trials: Vec<Trial>,
    pub(crate) parameters: Parameters,
}

impl Demo {
    /// People as a design draws their orders with `seed`; each value is noise from 0 to 1, and
    /// `effect` for every step from one mode to the next.
    pub(crate) fn new(
        scheme: OrderScheme,
        modes: usize,
        people: u32,
        seed: u64,
        effect: f64,
    ) -> Self {
        let mut noise = ChaCha8Rng::seed_from_u64(seed);
        let (mut trials, mut orders) = (Vec::new(), Vec::new());
        for person in 1..=people {
            let who = format!("P{person:02}");
            let rules = Rules {
                scheme,
                repeats: 6,
                environments: ENVIRONMENTS.len(),
                modes,
                participant_number: person,
                session_number: 1,
            };
            let mut number = FAMILIARISATION;
            for block in draw_modes(&rules, seed).blocks {
                for mode in block.modes {
                    number += 1;
                    let noise = (noise.next_u64() >> 32) as f64 / f64::from(u32::MAX);
                    let value = Some(noise + effect * mode as f64);
                    let (who, environment) = (who.clone(), block.environment);
                    trials.push(Trial { who, number, environment, mode, value });
                }
            }
            let drawn = DrawnOrder {
                rules,
                seed: Some(seed),
                familiarisation: FAMILIARISATION,
                environments: ENVIRONMENTS.map(|id| id.parse().unwrap()).to_vec(),
                modes: MODES[..modes].iter().map(|id| id.parse().unwrap()).collect(),
                repeated: Vec::new(),
            };
            let (participant, session) = (who.parse().unwrap(), "S01".parse().unwrap());
            orders.push(SessionOrder { participant, session, drawn: Some(drawn) });
        }
        let mode = |id: &str| id.parse().unwrap();
        let last = MODES[modes - 1];
        let contrast = |with: &&str| Contrast { mode: mode(last), against: mode(with) };
        let step = MetricParameters {
            bounds: vec![None; ENVIRONMENTS.len()],
            ..parameters().metrics[0].clone()
        };
        let parameters = Parameters {
            metrics: vec![step],
            environments: ENVIRONMENTS.map(|id| id.parse().unwrap()).to_vec(),
            modes: MODES[..modes].iter().map(|id| mode(id)).collect(),
            contrasts: MODES[..modes - 1].iter().map(contrast).collect(),
            effect_sizes: Vec::new(),
            orders,
            ..parameters()
        };
        Self { trials, parameters }
    }

    pub(crate) fn of(scheme: OrderScheme, people: u32, effect: f64) -> Self {
        Self::new(scheme, 3, people, SEED, effect)
    }

    pub(crate) fn keys(&self) -> Vec<TrialKey> {
        let key = |t: &Trial| TrialKey {
            participant: t.who.parse().unwrap(),
            session: "S01".parse().unwrap(),
            trial: t.number,
            repeat: 1,
            environment: ENVIRONMENTS[t.environment].parse().unwrap(),
            mode: MODES[t.mode].parse().unwrap(),
            source: Origin::Recorded,
        };
        self.trials.iter().map(key).collect()
    }

    fn metrics(&self) -> Measured {
        measured(&self.keys(), self.trials.iter().map(|t| t.value))
    }

    /// The tests of both environments.
    fn tests(&self, sampling: Sampling) -> Vec<SharpNull> {
        sharp_nulls(&self.counting(), &self.parameters, sampling)
    }

    fn counting(&self) -> Trials {
        let metrics = self.metrics();
        let measure = Measure::new(&metrics, &self.parameters.metrics[0]).unwrap();
        Trials::of(&metrics, &measure, &self.parameters).unwrap()
    }

    fn compared(&self) -> Printed {
        compare(&self.metrics(), &self.parameters).unwrap()
    }

    /// How the first session was drawn.
    fn drawn(&mut self) -> &mut DrawnOrder {
        self.parameters.orders[0].drawn.as_mut().unwrap()
    }

    /// The first trial of the first block.
    fn first(&mut self) -> &mut Trial {
        self.trials.iter_mut().find(|t| t.number == FAMILIARISATION + 1).unwrap()
    }

    /// Why the environment of the first block has no test.
    fn why_not(&self, first: usize) -> String {
        let tests = self.tests(FEW);
        assert!(tests[1 - first].any_effect.is_ok(), "the other environment has one");
        let why = tests[first].any_effect.clone().unwrap_err();
        assert!(tests[first].contrasts.iter().all(|test| test.as_ref() == Err(&why)));
        why.to_string()
    }
}

/// 400 sessions in which no trial depends on its mode. With 199 draws p < 0.05 has probability
/// 0.045, p ≤ 0.5 has ½ where orders do not tie; the counts lie where the 99.9 % interval of
/// Clopper and Pearson contains these.
#[test]
fn a_session_without_an_effect_gives_any_p_alike() {
    let p_values = |seed| {
        let demo = Demo::new(OrderScheme::Constrained, 3, 1, seed, 0.0);
        let tests = demo.tests(FEW);
        [tests[0].any_effect.clone(), tests[1].contrasts[0].clone()]
            .map(|test| test.unwrap().p_value)
    };
    let found: Vec<[f64; 2]> = (0..400).map(p_values).collect();
    for test in 0..2 {
        let below = |limit: f64| found.iter().filter(|p| p[test] < limit).count();
        assert!((6..=33).contains(&below(0.05)), "{} of 400 below 0.05", below(0.05));
        assert!((168..=232).contains(&below(0.502)), "{} of 400 below 0.5", below(0.502));
    }
}

/// The orders of a block of three modes and six repeats are 720; six of them separate the modes as
/// well as the actual one, two of them one pair.
#[test]
fn a_strong_effect_reaches_the_smallest_p_of_the_design() {
    for test in Demo::of(OrderScheme::Williams, 1, 100.0).tests(Sampling { draws: 1999, seed: 3 }) {
        assert_eq!((test.sessions, test.trials), (1, 18));
        for (found, expected) in
            [(&test.any_effect, 6.0 / 720.0), (&test.contrasts[0], 2.0 / 720.0)]
        {
            let found = found.as_ref().unwrap();
            assert!((found.p_value - found.smallest_p).abs() < 1e-12);
            // Three deviations of a count of 1999 draws.
            let scatter = 3.0 * (expected / 1999.0_f64).sqrt();
            assert!((found.p_value - expected).abs() < scatter + 1.0 / 2000.0, "{found:?}");
        }
    }
}

fn design(parameters: &Parameters) -> Design<'_> {
    let Parameters { environments, modes, orders, .. } = parameters;
    Design { environments, modes, orders }
}

#[test]
fn orders_redrawn_with_the_seed_that_drew_them_are_those_of_all_sessions() {
    for scheme in [OrderScheme::Williams, OrderScheme::Constrained] {
        let demo = Demo::of(scheme, 4, 0.0);
        let counting = demo.counting();
        let mut sessions: BTreeMap<_, Vec<Place<f64>>> = BTreeMap::new();
        for trial in &counting.trials {
            let session = (trial.environment, trial.participant, trial.session);
            let places = sessions.entry(session).or_default();
            places.push(Place { number: trial.number, mode: trial.mode, value: trial.value });
        }
        for ((environment, participant, session), places) in sessions {
            let who = (&counting.participants[participant], &counting.sessions[session]);
            let found = redrawn(environment, who, &places, design(&demo.parameters)).unwrap();
            assert_eq!(found.source.redraw(SEED), found.source.actual);
            assert_ne!(found.source.redraw(SEED + 1), found.source.actual);
        }
    }
}

#[test]
fn sessions_of_another_seed_are_redrawn_with_another_seed() {
    let mut demo = Demo::of(OrderScheme::Williams, 2, 0.0);
    demo.drawn().seed = Some(SEED + 5);
    let seeds = [Some(SEED), Some(SEED + 5), None];
    assert_eq!(seeds.map(|seed| seed_number(seed, design(&demo.parameters))), [0, 1, 0]);
}

#[test]
fn where_a_trial_is_missing_there_is_no_test_and_the_table_says_why() {
    let mut demo = Demo::of(OrderScheme::Williams, 1, 100.0);
    let (first, number) = (demo.first().environment, demo.first().number);
    demo.trials.retain(|trial| trial.number != number);
    let words = "P01 S01 has 17 trials that count where its order has 18";
    let compared = demo.compared();
    let remarks = compared.orders.texts("remark").unwrap();
    let verdicts = compared.contrasts.texts("verdict").unwrap();
    let of = |environment: usize, rows: usize| rows * environment..rows * (environment + 1);
    assert!(remarks[of(first, 3)].iter().all(|remark| remark.as_deref() == Some(words)));
    assert!(remarks[of(1 - first, 3)].iter().all(Option::is_none));
    let is_untested = |verdict: &Option<String>| verdict.as_deref() == Some("not tested");
    assert!(verdicts[of(first, 2)].iter().all(is_untested));
    let why = compared.contrasts.texts("remark").unwrap();
    assert!(why[of(first, 2)].iter().all(|remark| remark.as_deref() == Some(words)));
    assert_eq!(verdicts[of(1 - first, 2)][0].as_deref(), Some("different"));
    let note = format!("{}: no test of the sharp null: {words}.", ENVIRONMENTS[first]);
    assert!(compared.contrasts.notes().contains(&note));
}

#[test]
fn an_order_of_others_or_one_that_the_design_could_not_have_drawn_has_no_test() {
    let mut imported = Demo::of(OrderScheme::Williams, 1, 0.0);
    imported.parameters.orders[0].drawn = None;
    let tests = imported.tests(FEW);
    let words = "the order of P01 S01 was not drawn by this program";
    assert!(tests.iter().all(|of| of.any_effect.as_ref().unwrap_err().to_string() == words));

    let other = "the trials of P01 S01 came in an order that its design could not have drawn";
    let mut elsewhere = Demo::of(OrderScheme::Williams, 1, 0.0);
    let first = elsewhere.first().environment;
    elsewhere.first().number = 40;
    assert_eq!(elsewhere.why_not(first), other);
    // Each row has each mode once.
    let mut exchanged = Demo::of(OrderScheme::Williams, 1, 0.0);
    let first = exchanged.first().clone();
    let is_other = |t: &&mut Trial| {
        (t.environment, t.number > first.number + 3) == (first.environment, true)
            && t.mode != first.mode
    };
    let second = exchanged.trials.iter_mut().find(is_other).unwrap();
    let mode = std::mem::replace(&mut second.mode, first.mode);
    exchanged.first().mode = mode;
    assert_eq!(exchanged.why_not(first.environment), other);
}

#[test]
fn a_trial_that_was_done_again_has_the_place_of_the_first() {
    let whole = Demo::of(OrderScheme::Williams, 1, 1.0);
    let mut again = Demo::of(OrderScheme::Williams, 1, 1.0);
    let first = again.first().number;
    again.first().number = 40;
    again.drawn().repeated = vec![[40, first]];
    assert_eq!(again.tests(FEW), whole.tests(FEW));
}

#[test]
fn a_trial_without_the_metric_is_left_out_of_every_order() {
    let mut demo = Demo::of(OrderScheme::Williams, 1, 100.0);
    let first = demo.first().environment;
    demo.first().value = None;
    let test = &demo.tests(FEW)[first];
    assert_eq!(test.trials, 17);
    assert!(test.any_effect.as_ref().unwrap().p_value < 0.05);
}

#[test]
fn with_one_participant_the_claim_rests_on_the_orders_and_welchs_interval_stands_beside() {
    let compared = Demo::of(OrderScheme::Williams, 1, 100.0).compared();
    let contrasts = &compared.contrasts;
    let numbers = |name| contrasts.floats(name).unwrap().into_iter().flatten().collect::<Vec<_>>();
    let (p, adjusted) = (numbers("p_sharp_null"), numbers("p_adjusted"));
    let holm = zwidth_stats::holm::adjusted(&p).unwrap();
    assert_eq!((adjusted.len(), adjusted), (4, holm));
    assert_eq!(numbers("difference_ci_low_n").len(), 4);
    assert!(contrasts.column("p_value").is_err() && contrasts.column("statistic").is_err());
    let verdicts = contrasts.texts("verdict").unwrap();
    for (verdict, p) in verdicts.iter().zip(&numbers("p_adjusted")) {
        assert_eq!(verdict.as_deref() == Some("different"), *p < 0.05);
    }
    // The extreme modes; those in between differ less than others would in other orders.
    assert_eq!([0, 2].map(|row| verdicts[row].as_deref()), [Some("different"); 2]);
    let notes = contrasts.notes().join("\n");
    assert!(notes.contains("Within P01") && notes.contains("orders reach p = 0.00"), "{notes}");
    assert_eq!(compared.orders.texts("effect").unwrap()[0].as_deref(), Some("any effect"));
}

/// Two modes in Williams' rows are A B, B A, A B, … or the other way round: two orders, which no
/// statistic tells apart.
#[test]
fn a_claim_that_the_orders_cannot_carry_is_refused_in_words() {
    let compared = Demo::new(OrderScheme::Williams, 2, 1, SEED, 100.0).compared();
    let verdicts = compared.contrasts.texts("verdict").unwrap();
    assert!(verdicts.iter().all(|verdict| verdict.as_deref() == Some("undecided")), "{verdicts:?}");
    let words = "the design's orders reach an adjusted p of 1.0000 at best";
    let remarks = compared.contrasts.texts("remark").unwrap();
    assert!(remarks.iter().all(|remark| remark.as_deref() == Some(words)), "{remarks:?}");
    let notes = compared.contrasts.notes().join("\n");
    assert!(notes.contains("No claim can be made of 2 of 2 contrasts"), "{notes}");
}

#[test]
fn with_several_participants_the_claim_rests_on_their_differences() {
    let compared = Demo::of(OrderScheme::Williams, 4, 100.0).compared();
    let numbers = |name| compared.contrasts.floats(name).unwrap();
    // Under one seed they share the rows of one square: as many orders as one participant has.
    let sharp = numbers("p_sharp_null")[0].unwrap();
    assert!((sharp - 2.0 / 720.0).abs() < 0.002, "{sharp}");
    let p: Vec<f64> = numbers("p_value").into_iter().flatten().collect();
    let adjusted: Vec<f64> = numbers("p_adjusted").into_iter().flatten().collect();
    assert_eq!(adjusted, zwidth_stats::holm::adjusted(&p).unwrap());
    assert!(compared.contrasts.column("smallest_p_adjusted").is_err());
    assert_eq!(compared.orders.integers("sessions").unwrap()[0], Some(4));
}
