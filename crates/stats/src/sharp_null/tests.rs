use super::*;
use zwidth_study::{Kind, OrderScheme, Study, StudyId, order, template};

const SAMPLING: Sampling = Sampling { draws: 2000, seed: 4 };
const ANY: Statistic = Statistic::BetweenModes;
const PAIR: Statistic = Statistic::Difference(0, 1);

fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-12, "{found} {expected}");
}

/// The study of the template with 3 modes, 6 repeats.
fn study(scheme: OrderScheme) -> Study {
    let mut study = Study::from_toml(&template(&StudyId::new("demo").unwrap())).unwrap();
    study.design.order = scheme;
    study
}

/// The modes of one participant's trials in the first environment.
fn drawn(study: &Study, participant: u32, seed: u64) -> Vec<usize> {
    let first = &study.environments[0].id;
    let trials = order::draw(study, participant, 1, seed);
    let of = trials.iter().filter(|t| t.kind == Kind::Trial && t.environment == *first);
    of.map(|t| study.modes.iter().position(|m| m.id == t.mode).unwrap()).collect()
}

/// Every sequence of the six orders of three modes: what a Williams block of six repeats can be.
fn williams_orders() -> Vec<Vec<usize>> {
    let rows = order::williams(3);
    let mut sequences: Vec<Vec<usize>> = vec![vec![]];
    for _ in 0..6 {
        let longer = |sequence: &Vec<usize>| {
            let unused = (0..6).filter(|row| !sequence.contains(row));
            unused.map(|row| [sequence.clone(), vec![row]].concat()).collect::<Vec<_>>()
        };
        sequences = sequences.iter().flat_map(longer).collect();
    }
    sequences.iter().map(|s| s.iter().flat_map(|row| rows[*row].clone()).collect()).collect()
}

/// Values without ties that no mode explains.
fn values(trials: usize, seed: u64) -> Vec<f64> {
    let mut rng = stream(seed, 0);
    (0..trials).map(|_| (rng.next_u64() >> 40) as f64 * 1e-5).collect()
}

fn one(values: &[f64], actual: &[usize], modes: usize) -> Trials {
    Trials::new(values, &vec![0; values.len()], actual, modes).unwrap()
}

/// The test of one statistic by orders drawn.
fn against_drawn(
    trials: &Trials,
    statistic: Statistic,
    sampling: Sampling,
    redraw: impl Fn(u64) -> Vec<usize> + Sync,
) -> Result<Randomised, Unestimable> {
    trials.each_against_drawn(&[statistic], sampling, redraw).remove(0)
}

/// Six trials of two modes: all 20 orders by hand. The three largest values came with one mode.
#[test]
fn a_small_design_counted_by_hand() {
    let orders: Vec<Vec<usize>> = (0..64_usize)
        .filter(|bits| bits.count_ones() == 3)
        .map(|bits| (0..6).map(|i| bits >> i & 1).collect())
        .collect();
    assert_eq!(orders.len(), 20);
    let trials = one(&[1.0, 7.0, 2.0, 9.0, 3.0, 8.0], &[0, 1, 0, 1, 0, 1], 2);
    let found = trials.against_all(PAIR, &orders).unwrap();
    near(found.statistic, -6.0);
    near(found.p_value, 2.0 / 20.0);
    near(found.smallest_p, 2.0 / 20.0);
    near(found.percentiles[0], -6.0);
    near(found.percentiles[99], 6.0);
    assert!(found.percentiles.is_sorted() && found.percentiles.len() == 100);
    let found = trials.against_all(ANY, &orders).unwrap();
    near(found.statistic, 3.0 * 9.0 * 2.0);
    near(found.p_value, 2.0 / 20.0);
    assert_eq!(found.null, Null::Exact);
}

/// The guard's facts for a session of three modes and six repeats: 720 orders an environment, any
/// effect at 6/720 (the modes may be renamed in six ways), one pair at 2/720, and at 2/8 if the
/// third mode is held.
#[test]
fn a_williams_session_has_720_orders_and_8_for_one_pair_with_the_third_held() {
    let orders = williams_orders();
    let mut distinct = orders.clone();
    distinct.sort();
    distinct.dedup();
    assert_eq!((orders.len(), distinct.len()), (720, 720));
    let actual = drawn(&study(OrderScheme::Williams), 1, 8);
    let trials = one(&values(18, 1), &actual, 3);
    near(trials.against_all(ANY, &orders).unwrap().smallest_p, 6.0 / 720.0);
    near(trials.against_all(PAIR, &orders).unwrap().smallest_p, 2.0 / 720.0);
    // Those in which the trials of the third mode have it, as they had.
    let held = orders
        .iter()
        .filter(|order| order.iter().zip(&actual).all(|(x, y)| x == y || (*x < 2 && *y < 2)));
    let held: Vec<Vec<usize>> = held.cloned().collect();
    assert_eq!(held.len(), 8);
    near(trials.against_all(PAIR, &held).unwrap().smallest_p, 0.25);
}

/// Orders redrawn by the study's own rules come out as often as all of them counted.
#[test]
fn drawn_orders_agree_with_all_orders() {
    let (study, orders) = (study(OrderScheme::Williams), williams_orders());
    for seed in 0..4 {
        let trials = one(&values(18, seed), &drawn(&study, 1, seed), 3);
        for statistic in [ANY, PAIR] {
            let all = trials.against_all(statistic, &orders).unwrap();
            let some =
                against_drawn(&trials, statistic, SAMPLING, |s| drawn(&study, 1, s)).unwrap();
            near(all.statistic, some.statistic);
            let scatter = (all.p_value * (1.0 - all.p_value) / 2000.0).sqrt();
            assert!((all.p_value - some.p_value).abs() < 4.0 * scatter + 1e-3, "{all:?} {some:?}");
        }
    }
}

/// Under the sharp null no p is too small too often: 1000 studies of two participants, each with
/// its own order, P(p ≤ 0.05) ≤ 0.05, within the 99.9 % bound of the binomial (0.075).
#[test]
fn nothing_is_found_where_no_trial_depends_on_its_mode() {
    let study = study(OrderScheme::Constrained);
    let sampling = Sampling { draws: 99, seed: 6 };
    let orders: Vec<Vec<usize>> =
        (0..500).map(|seed| [drawn(&study, 1, seed), drawn(&study, 2, seed)].concat()).collect();
    let both = |seed: u64| orders[(seed % 500) as usize].clone();
    let block: Vec<usize> = (0..36).map(|i| i / 18).collect();
    let rejects = |number: &u64| {
        let mut values = values(36, *number);
        values[18..].iter_mut().for_each(|v| *v += 1e4);
        let trials = Trials::new(&values, &block, &both(*number), 3).unwrap();
        against_drawn(&trials, ANY, sampling, both).unwrap().p_value <= 0.05
    };
    let found = (0..1000).into_par_iter().filter(rejects).count();
    assert!((25..=75).contains(&found), "{found} of 1000");
}

#[test]
fn an_effect_in_every_trial_is_found() {
    let study = study(OrderScheme::Constrained);
    let actual = drawn(&study, 1, 3);
    let values: Vec<f64> =
        values(18, 2).iter().zip(&actual).map(|(v, mode)| v + 100.0 * *mode as f64).collect();
    let trials = one(&values, &actual, 3);
    let found = against_drawn(&trials, ANY, SAMPLING, |seed| drawn(&study, 1, seed)).unwrap();
    assert!(found.p_value < 0.002 && found.null == Null::Sampled { draws: 2000 });
    near(found.p_value, found.smallest_p);
}

#[test]
fn one_thread_gives_the_bits_of_many() {
    let study = study(OrderScheme::Williams);
    let trials = one(&values(18, 5), &drawn(&study, 1, 1), 3);
    let run = || against_drawn(&trials, ANY, SAMPLING, |seed| drawn(&study, 1, seed)).unwrap();
    let on = |threads| {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(run)
    };
    assert_eq!(on(1), on(4));
}

/// Ten participants whose orders follow from two: every order is one of two lists of 18 modes.
#[test]
fn trials_that_move_together_count_as_one_and_change_no_p() {
    let study = study(OrderScheme::Williams);
    let sharing = |person: usize| person as u32 % 2;
    let all = |seed| (0..10).flat_map(|person| drawn(&study, sharing(person), seed)).collect();
    let two = |seed| (0..2).flat_map(|person| drawn(&study, person, seed)).collect::<Vec<_>>();
    let block: Vec<usize> = (0..180).map(|trial| trial / 18).collect();
    let group: Vec<usize> = (0..180).map(|trial| trial / 18 % 2 * 18 + trial % 18).collect();
    for seed in 0..3 {
        let actual: Vec<usize> = all(seed);
        let apart = Trials::new(&values(180, seed), &block, &actual, 3).unwrap();
        let together = apart.moving_together(&group).unwrap();
        let sampling = Sampling { draws: 500, seed };
        let statistics = [ANY, PAIR];
        let found = together.each_against_drawn(&statistics, sampling, two);
        let expected = apart.each_against_drawn(&statistics, sampling, all);
        for (found, expected) in found.into_iter().zip(expected) {
            let (found, expected) = (found.unwrap(), expected.unwrap());
            let bits = |test: &Randomised| [test.p_value, test.smallest_p].map(f64::to_bits);
            assert_eq!(bits(&found), bits(&expected));
            assert!((found.statistic / expected.statistic - 1.0).abs() < 1e-9);
        }
    }
    let trials = one(&[1.0, 2.0, 4.0], &[0, 1, 1], 2);
    let words = |group: &[usize]| trials.moving_together(group).unwrap_err().to_string();
    assert!(words(&[0, 0, 1]).contains("trial 1 has another mode"));
    assert!(words(&[0, 1]).contains("groups"));
}

#[test]
fn values_that_differ_by_rounding_tie() {
    let orders = [vec![0, 1], vec![1, 0]];
    let trials = one(&[0.3, 0.1 + 0.2 + 1e-3], &[0, 1], 2);
    near(trials.against_all(PAIR, &orders).unwrap().p_value, 1.0);
    near(trials.against_all(ANY, &orders).unwrap().p_value, 1.0);
}

#[test]
fn what_blocks_differ_by_does_not_blur_the_modes() {
    let (values, block) = ([1.0, 2.0, 101.0, 102.0, 101.0], [0, 0, 1, 1, 1]);
    let trials = Trials::new(&values, &block, &[0, 1, 0, 1, 0], 2).unwrap();
    let found = trials.observed(PAIR).unwrap();
    // less their blocks' means: −½, ½, −⅓, ⅔, −⅓
    near(found, -(0.5 + 2.0 / 3.0) / 2.0 - (0.5 + 2.0 / 3.0) / 3.0);
}

#[test]
fn data_without_an_answer_say_why() {
    let orders = [vec![0, 1], vec![1, 0]];
    let words = |values: &[f64], actual: &[usize]| {
        let trials = Trials::new(values, &vec![0; values.len()], actual, 2);
        trials.and_then(|trials| trials.against_all(PAIR, &orders)).unwrap_err().to_string()
    };
    assert_eq!(words(&[], &[]), "0 trials, 1 is needed");
    assert!(words(&[0.1, 0.1], &[0, 1]).contains("all trials of each participant are equal"));
    assert_eq!(words(&[1.0, 2.0], &[0, 0]), "0 trials of a mode, 1 is needed");
    assert!(words(&[1.0, f64::NAN], &[0, 1]).contains("NaN"));
    assert!(words(&[1.0, 2.0], &[0, 2]).contains("mode 2"));
    assert!(words(&[1.0, 2.0], &[0]).contains("1 values where 2"));
    let trials = one(&[1.0, 2.0], &[0, 1], 2);
    assert!(trials.against_all(PAIR, &[vec![1, 0]]).is_err());
    assert!(against_drawn(&trials, PAIR, SAMPLING, |_| vec![0]).is_err());
    let missing = against_drawn(&trials, PAIR, SAMPLING, |_| vec![0, 0]).unwrap();
    near(missing.p_value, 1.0);
}

#[test]
fn statistics_measured_together_are_those_measured_alone() {
    let study = study(OrderScheme::Williams);
    let trials = one(&values(18, 5), &drawn(&study, 1, 1), 3);
    let redraw = |seed| drawn(&study, 1, seed);
    let statistics = [PAIR, ANY, Statistic::Difference(2, 0)];
    let together = trials.each_against_drawn(&statistics, SAMPLING, redraw);
    for (statistic, found) in statistics.into_iter().zip(together) {
        assert_eq!(found, against_drawn(&trials, statistic, SAMPLING, redraw));
    }
    let none = one(&[1.0, 1.0], &[0, 1], 2);
    assert!(none.each_against_drawn(&[PAIR], SAMPLING, |_| unreachable!())[0].is_err());
}
