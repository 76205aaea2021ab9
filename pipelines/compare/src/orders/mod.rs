//! Randomisation over orders: had the trials come in another order that the design could have
//! drawn, would the modes have differed as much?
//!
//! The hypothesis is the sharp null: *no trial of anyone* depended on mode, carry-over included. It
//! is not the hypothesis of no average effect. Orders are redrawn for all participants and sessions
//! together, by the rules and with the probabilities that drew theirs ([`zwidth_study::order`]).

use crate::measure::Measure;
use crate::trials::Trials;
use crate::{Parameters, SessionOrder};
use std::collections::{BTreeMap, BTreeSet};
use zwidth_results::{Effect, OrderTest, RedrawnDifference};
use zwidth_stats::Unestimable;
use zwidth_stats::null::Sampling;
use zwidth_stats::sharp_null::{self, Randomised, Statistic};
use zwidth_study::order::{Rules, can_draw, draw_modes};
use zwidth_study::{EnvironmentId, ModeId, ParticipantId, SessionId};

/// The number of orders drawn besides the actual one, and their seed.
pub(crate) const SAMPLING: Sampling = Sampling { draws: 9_999, seed: 1 };

/// Why there is no randomisation over orders.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub(crate) enum NoTest {
    /// Imported, or recorded by others.
    #[error("the order of {session} was not drawn by this program")]
    NotDrawn {
        /// Participant and session.
        session: String,
    },
    /// Trials are missing or excluded, or there are others.
    #[error("{session} has {found} trials that count where its order has {planned}")]
    NotWhole {
        /// Participant and session.
        session: String,
        /// Trials that count.
        found: usize,
        /// Trials of the order.
        planned: usize,
    },
    /// Trials with other modes or in another sequence.
    #[error("the trials of {session} came in an order that its design could not have drawn")]
    OtherOrder {
        /// Participant and session.
        session: String,
    },
    /// Orders that could be drawn, and values that have no test.
    #[error(transparent)]
    Unestimable(#[from] Unestimable),
}

/// The tests of one environment.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SharpNull {
    /// Sessions.
    pub(crate) sessions: usize,
    /// Trials that have the metric.
    pub(crate) trials: usize,
    /// Between all modes.
    pub(crate) any_effect: Result<Randomised, NoTest>,
    /// Between the two modes of each of [`Parameters::contrasts`].
    pub(crate) contrasts: Vec<Result<Randomised, NoTest>>,
}

/// The design from which the orders of sessions were drawn.
#[derive(Clone, Copy)]
pub(crate) struct Design<'a> {
    /// The study's environments and modes.
    pub(crate) environments: &'a [EnvironmentId],
    pub(crate) modes: &'a [ModeId],
    /// The orders of the sessions, and how they were drawn.
    pub(crate) orders: &'a [SessionOrder],
}

/// A trial of one session in one environment.
#[derive(Debug, Clone)]
pub(crate) struct Place<V> {
    pub(crate) number: u32,
    /// As [`Design::modes`] has them.
    pub(crate) mode: usize,
    pub(crate) value: Option<V>,
}

/// What the modes of a session's trials in one environment are redrawn by. Sessions of which this
/// is equal get the same modes in every order.
#[derive(Debug, Clone, PartialEq)]
struct Source {
    rules: Rules,
    /// The environment as the rules number it.
    environment: usize,
    /// The modes as the rules number them, by their places among [`Design::modes`].
    modes: Vec<usize>,
    /// Sessions of one number have one seed.
    seed: u64,
    /// The actual modes, place by place in the block.
    actual: Vec<usize>,
}

/// A session whose order can be redrawn in one environment.
pub(crate) struct Redrawn<V> {
    source: Source,
    /// The values, place by place in the block.
    values: Vec<Option<V>>,
}

/// The trials that have a value, of all sessions in one environment, and what redraws their modes together.
pub(crate) struct Joined<'a, V> {
    pub(crate) values: Vec<V>,
    /// The number of the session of each.
    pub(crate) session: Vec<usize>,
    /// The mode that each had.
    pub(crate) actual: Vec<usize>,
    /// The place of each in an order; trials of one place have one mode in every order.
    pub(crate) places: Vec<usize>,
    /// Each with the place of its first trial in an order.
    sources: Vec<(&'a Source, usize)>,
}

impl<'a, V: Clone> Joined<'a, V> {
    pub(crate) fn of(sessions: &'a [Redrawn<V>]) -> Self {
        let mut joined = Self {
            values: vec![],
            session: vec![],
            actual: vec![],
            places: vec![],
            sources: vec![],
        };
        for (number, Redrawn { source, values }) in sessions.iter().enumerate() {
            let mut existing = joined.sources.iter();
            let existing = existing.find(|(other, _)| *other == source).map(|(_, start)| *start);
            let start = existing.unwrap_or_else(|| {
                let last = joined.sources.last();
                let start = last.map_or(0, |(last, start)| start + last.actual.len());
                joined.sources.push((source, start));
                start
            });
            for (place, value) in values.iter().enumerate() {
                let Some(value) = value else { continue };
                joined.values.push(value.clone());
                joined.session.push(number);
                joined.actual.push(source.actual[place]);
                joined.places.push(start + place);
            }
        }
        joined
    }

    /// The mode of each place in the order that the design draws by a seed.
    pub(crate) fn redraw(&self, seed: u64) -> Vec<usize> {
        self.sources.iter().flat_map(|(source, _)| source.redraw(seed)).collect()
    }
}

/// The tests of each environment, in the order of [`Parameters::environments`].
///
/// A trial without the metric is left out of every order alike: under the sharp null it would have
/// had none in any mode.
pub(crate) fn sharp_nulls(
    trials: &Trials,
    parameters: &Parameters,
    sampling: Sampling,
) -> Vec<SharpNull> {
    // By participant and session.
    type OfSessions = BTreeMap<(usize, usize), Vec<Place<f64>>>;
    let mut environments = vec![OfSessions::new(); parameters.environments.len()];
    for trial in &trials.trials {
        let session = (trial.participant, trial.session);
        let places = environments[trial.environment].entry(session).or_default();
        places.push(Place { number: trial.number, mode: trial.mode, value: trial.value });
    }
    let Parameters { environments: ids, modes, orders, .. } = parameters;
    let design = Design { environments: ids, modes, orders };
    let nulls = environments.iter().enumerate().map(|(environment, sessions)| {
        let redrawn = sessions.iter().map(|(&(participant, session), places)| {
            let who = (&trials.participants[participant], &trials.sessions[session]);
            redrawn(environment, who, places, design)
        });
        let redrawn: Result<Vec<Redrawn<f64>>, NoTest> = redrawn.collect();
        // One session that cannot be redrawn voids the environment: all are redrawn together.
        let tests = redrawn.and_then(|sessions| tests(&sessions, parameters, sampling));
        let (any_effect, contrasts) = match tests {
            Ok(tests) => tests,
            Err(why) => (Err(why.clone()), vec![Err(why); parameters.contrasts.len()]),
        };
        let values = sessions.values().flatten().filter(|place| place.value.is_some());
        SharpNull { sessions: sessions.len(), trials: values.count(), any_effect, contrasts }
    });
    nulls.collect()
}

type Tests = (Result<Randomised, NoTest>, Vec<Result<Randomised, NoTest>>);

/// Any effect, and each contrast.
fn tests(
    sessions: &[Redrawn<f64>],
    parameters: &Parameters,
    sampling: Sampling,
) -> Result<Tests, NoTest> {
    let pairs = parameters.contrasts.iter().map(|contrast| {
        // No trial has a mode that the study lacks.
        let [mode, against] = parameters.modes_of(contrast).unwrap_or([usize::MAX; 2]);
        Statistic::Difference(mode, against)
    });
    let statistics: Vec<Statistic> = [Statistic::BetweenModes].into_iter().chain(pairs).collect();
    let joined = Joined::of(sessions);
    let modes = parameters.modes.len();
    let trials = sharp_null::Trials::new(&joined.values, &joined.session, &joined.actual, modes)?;
    let trials = trials.moving_together(&joined.places)?;
    let groups: BTreeSet<usize> = joined.places.iter().copied().collect();
    let tests = trials.each_against_drawn(&statistics, sampling, |seed| {
        let all = joined.redraw(seed);
        groups.iter().filter_map(|group| all.get(*group).copied()).collect()
    });
    let mut tests = tests.into_iter().map(|test| test.map_err(NoTest::from));
    let none = Unestimable::TooFew { units: "trials", found: 0, needed: 1 };
    // The statistic between all modes is the first.
    Ok((tests.next().unwrap_or_else(|| Err(none.into())), tests.collect()))
}

/// A session's trials in one environment, if they are a whole order of its design.
pub(crate) fn redrawn<V: Clone>(
    environment: usize,
    (participant, session): (&ParticipantId, &SessionId),
    places: &[Place<V>],
    design: Design,
) -> Result<Redrawn<V>, NoTest> {
    let name = format!("{participant} {session}");
    let mut orders = design.orders.iter();
    let order = orders
        .find(|o| (&o.participant, &o.session) == (participant, session))
        .and_then(|order| order.drawn.as_ref());
    let Some(order) = order else { return Err(NoTest::NotDrawn { session: name }) };
    let planned = order.rules.trials_per_block();
    if places.len() != planned {
        return Err(NoTest::NotWhole { session: name, found: places.len(), planned });
    }
    let other = NoTest::OtherOrder { session: name };
    let environment = &design.environments[environment];
    let environment = order.environments.iter().position(|e| e == environment);
    let modes = order.modes.iter().map(|mode| design.modes.iter().position(|m| m == mode));
    let modes: Option<Vec<usize>> = modes.collect();
    let Some((environment, modes)) = environment.zip(modes) else { return Err(other) };
    // A repeated trial has the place of the one that it replaces, so numbers may be out of order.
    let placed =
        places.iter().map(|trial| Place { number: order.place(trial.number), ..trial.clone() });
    let mut places: Vec<Place<V>> = placed.collect();
    places.sort_by_key(|place| place.number);
    let numbers: Option<Vec<usize>> =
        places.iter().map(|place| modes.iter().position(|m| *m == place.mode)).collect();
    let Some(numbers) = numbers else { return Err(other) };
    let in_block = places.iter().zip(order.first_of_block(places[0].number)..);
    if !in_block.clone().all(|(place, expected)| place.number == expected)
        || !can_draw(&order.rules, &numbers)
    {
        return Err(other);
    }
    let source = Source {
        rules: order.rules.shared(),
        environment,
        modes,
        seed: seed_number(order.seed, design),
        actual: places.iter().map(|place| place.mode).collect(),
    };
    Ok(Redrawn { source, values: places.into_iter().map(|place| place.value).collect() })
}

/// The place of a seed among all that sessions were drawn with.
fn seed_number(seed: Option<u64>, design: Design) -> u64 {
    let drawn = design.orders.iter().filter_map(|order| order.drawn.as_ref());
    // Its place is enough: seeds are drawn anew, and only which sessions share one matters.
    let seeds: BTreeSet<Option<u64>> = drawn.map(|drawn| drawn.seed).collect();
    seeds.range(..seed).count() as u64
}

impl Source {
    /// The modes of the trials, place by place, in an order that the design draws by a seed. Seeds
    /// that differ, by however little, give orders that have nothing to do with each other.
    fn redraw(&self, seed: u64) -> Vec<usize> {
        let order = draw_modes(&self.rules, seed.wrapping_add(self.seed));
        let block = order.blocks.into_iter().find(|block| block.environment == self.environment);
        let modes = block.map(|block| block.modes).unwrap_or_default();
        modes.into_iter().map(|mode| self.modes[mode]).collect()
    }
}

/// For each environment any effect, then each contrast.
pub(crate) fn rows(
    tests: &[SharpNull],
    measure: &Measure,
    parameters: &Parameters,
) -> Vec<OrderTest> {
    let mut rows = Vec::new();
    for (environment, own) in parameters.environments.iter().zip(tests) {
        if own.trials == 0 {
            continue;
        }
        let contrasts = parameters.contrasts.iter().cloned().map(Effect::Of).zip(&own.contrasts);
        for (effect, test) in [(Effect::Any, &own.any_effect)].into_iter().chain(contrasts) {
            rows.push(OrderTest {
                metric: measure.parameters.metric.clone(),
                environment: environment.clone(),
                effect,
                sessions: own.sessions,
                trials: own.trials,
                p_value: test.as_ref().ok().map(|test| test.p_value),
                smallest_p: test.as_ref().ok().map(|test| test.smallest_p),
                remark: test.as_ref().err().map(|why| why.to_string().into()),
            });
        }
    }
    rows
}

/// Each contrast in the redrawn orders: a hundred differences that are equally probable under the
/// sharp null, from the least on.
pub(crate) fn redrawn_differences(
    tests: &[SharpNull],
    measure: &Measure,
    parameters: &Parameters,
) -> Vec<RedrawnDifference> {
    let mut rows = Vec::new();
    for (environment, own) in parameters.environments.iter().zip(tests) {
        for (contrast, test) in parameters.contrasts.iter().zip(&own.contrasts) {
            let percentiles = test.iter().flat_map(|test| &test.percentiles);
            rows.extend(percentiles.map(|difference| RedrawnDifference {
                metric: measure.parameters.metric.clone(),
                unit: measure.unit.clone(),
                environment: environment.clone(),
                contrast: contrast.clone(),
                difference: *difference,
            }));
        }
    }
    rows
}

#[cfg(test)]
pub(crate) mod tests;
