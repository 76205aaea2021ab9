//! Randomisation over orders: had the trials come in another order that the design could have
//! drawn, would the modes have differed as much?
//!
//! The hypothesis is the sharp null: *no trial of anyone* depended on mode, carry-over included. It
//! is not that of an average effect. Orders are redrawn for all participants and sessions together,
//! by the rules and with the probabilities that drew theirs ([`zwidth_study::order`]).

use crate::cells::{KEYS, whole};
use crate::measure::Measure;
use crate::{CompareError, Parameters, columns};
use std::collections::{BTreeMap, BTreeSet};
use zwidth_stats::Unestimable;
use zwidth_stats::null::Sampling;
use zwidth_stats::sharp_null::{Randomised, Statistic, Trials};
use zwidth_study::order::{Rules, can_draw, draw_modes};
use zwidth_tables::{Column, Table};

/// How many orders are drawn besides the actual one.
pub(crate) const SAMPLING: Sampling = Sampling { draws: 9_999, seed: 1 };

/// What the test between all modes is sensitive to.
const ANY_EFFECT: &str = "any effect";

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

/// The trials of one session in one environment: the mode and the value of each by its place in
/// the session's order. Modes as [`Parameters::modes`] has them.
type Places = Vec<(u32, usize, Option<f64>)>;

/// What the modes of a session's trials in one environment are redrawn by. Sessions of which this
/// is equal get the same modes in every order.
#[derive(Debug, Clone, PartialEq)]
struct Source {
    rules: Rules,
    /// The environment as the rules number it.
    environment: usize,
    /// The modes as the rules number them, by their places among [`Parameters::modes`].
    modes: Vec<usize>,
    /// Sessions of one number have one seed.
    seed: u64,
    /// The actual modes, place by place in the block.
    actual: Vec<usize>,
}

/// A session whose order can be redrawn in one environment.
struct Redrawn {
    source: Source,
    /// The values, place by place in the block.
    values: Vec<Option<f64>>,
}

/// The tests of each environment, in the order of [`Parameters::environments`].
///
/// A trial without the metric is left out of every order alike: under the sharp null it would have
/// had none in any mode.
pub(crate) fn sharp_nulls(
    metrics: &Table,
    measure: &Measure,
    parameters: &Parameters,
    sampling: Sampling,
) -> Result<Vec<SharpNull>, CompareError> {
    let by_session = by_session(metrics, measure, parameters)?;
    Ok((0..parameters.environments.len())
        .map(|environment| {
            let here = by_session.iter().filter(|((of, _), _)| *of == environment);
            let sessions: Vec<(&[String; 2], &Places)> =
                here.map(|((_, session), places)| (session, places)).collect();
            sharp_null(environment, &sessions, parameters, sampling)
        })
        .collect())
}

fn by_session(
    metrics: &Table,
    measure: &Measure,
    parameters: &Parameters,
) -> Result<BTreeMap<(usize, [String; 2]), Places>, CompareError> {
    let [participants, sessions, environments, modes] = KEYS.map(|key| metrics.texts(key));
    let (participants, sessions) = (participants?, sessions?);
    let (environments, modes) = (environments?, modes?);
    let (trials, values) = (metrics.integers("trial")?, metrics.floats(&measure.name)?);
    let mut found: BTreeMap<_, Places> = BTreeMap::new();
    for row in 0..metrics.height() {
        let text = |column: &[Option<String>]| column[row].clone().unwrap_or_default();
        let (environment, mode) = (text(&environments), text(&modes));
        let Some([environment, mode]) = parameters.condition(&environment, &mode) else { continue };
        let trial = trials[row].and_then(|trial| u32::try_from(trial).ok()).unwrap_or(0);
        let session = [text(&participants), text(&sessions)];
        found.entry((environment, session)).or_default().push((trial, mode, values[row]));
    }
    Ok(found)
}

fn sharp_null(
    environment: usize,
    sessions: &[(&[String; 2], &Places)],
    parameters: &Parameters,
    sampling: Sampling,
) -> SharpNull {
    let redrawn: Result<Vec<Redrawn>, NoTest> = sessions
        .iter()
        .map(|(session, places)| redrawn(environment, session, places, parameters))
        .collect();
    let found = redrawn.and_then(|sessions| tests(&sessions, parameters, sampling));
    let values = sessions.iter().flat_map(|(_, places)| places.iter().map(|(_, _, value)| value));
    let each = parameters.contrasts.len();
    let (any_effect, contrasts) = match found {
        Ok(found) => found,
        Err(why) => (Err(why.clone()), vec![Err(why); each]),
    };
    SharpNull { sessions: sessions.len(), trials: values.flatten().count(), any_effect, contrasts }
}

type Tests = (Result<Randomised, NoTest>, Vec<Result<Randomised, NoTest>>);

/// Any effect, and each contrast.
fn tests(
    sessions: &[Redrawn],
    parameters: &Parameters,
    sampling: Sampling,
) -> Result<Tests, NoTest> {
    let pairs = parameters.contrasts.iter().map(|contrast| {
        // No trial has a mode that the study lacks.
        let [mode, against] = parameters.modes_of(contrast).unwrap_or([usize::MAX; 2]);
        Statistic::Difference(mode, against)
    });
    let statistics: Vec<Statistic> = [Statistic::BetweenModes].into_iter().chain(pairs).collect();
    // Each with the place of its first trial among those of all.
    let mut sources: Vec<(&Source, usize)> = Vec::new();
    let (mut values, mut block, mut actual, mut group) = (vec![], vec![], vec![], vec![]);
    for (number, Redrawn { source, values: of_session }) in sessions.iter().enumerate() {
        let known = sources.iter().find(|(known, _)| *known == source).map(|(_, start)| *start);
        let start = known.unwrap_or_else(|| {
            let start = sources.last().map_or(0, |(last, start)| start + last.actual.len());
            sources.push((source, start));
            start
        });
        for (place, value) in of_session.iter().enumerate() {
            let Some(value) = value else { continue };
            values.push(*value);
            block.push(number);
            actual.push(source.actual[place]);
            group.push(start + place);
        }
    }
    let trials = Trials::new(&values, &block, &actual, parameters.modes.len())?;
    let trials = trials.moving_together(&group)?;
    let groups: BTreeSet<usize> = group.into_iter().collect();
    let found = trials.each_against_drawn(&statistics, sampling, |seed| {
        let all: Vec<usize> = sources.iter().flat_map(|(source, _)| source.redraw(seed)).collect();
        groups.iter().filter_map(|group| all.get(*group).copied()).collect()
    });
    let mut found = found.into_iter().map(|test| test.map_err(NoTest::from));
    let none = Unestimable::TooFew { units: "trials", found: 0, needed: 1 };
    Ok((found.next().unwrap_or_else(|| Err(none.into())), found.collect()))
}

/// A session's trials in one environment, if they are a whole order of its design.
fn redrawn(
    environment: usize,
    [participant, session]: &[String; 2],
    places: &Places,
    parameters: &Parameters,
) -> Result<Redrawn, NoTest> {
    let name = || format!("{participant} {session}");
    let mut orders = parameters.orders.iter();
    let order = orders
        .find(|o| (o.participant.as_str(), o.session.as_str()) == (participant, session))
        .and_then(|order| order.drawn.as_ref());
    let order = order.ok_or_else(|| NoTest::NotDrawn { session: name() })?;
    let planned = order.rules.trials_per_block();
    if places.len() != planned {
        return Err(NoTest::NotWhole { session: name(), found: places.len(), planned });
    }
    let environment = &parameters.environments[environment];
    let environment = order.environments.iter().position(|e| e == environment);
    let modes = order.modes.iter().map(|mode| parameters.modes.iter().position(|m| m == mode));
    let modes: Option<Vec<usize>> = modes.collect();
    let other = || NoTest::OtherOrder { session: name() };
    let (environment, modes) = environment.zip(modes).ok_or_else(other)?;
    let mut places: Places =
        places.iter().map(|(trial, mode, value)| (order.place(*trial), *mode, *value)).collect();
    places.sort_by_key(|(place, ..)| *place);
    let numbers: Option<Vec<usize>> =
        places.iter().map(|(_, mode, _)| modes.iter().position(|m| m == mode)).collect();
    let numbers = numbers.ok_or_else(other)?;
    let in_block = places.iter().zip(order.first_of_block(places[0].0)..);
    if !in_block.clone().all(|((place, ..), expected)| *place == expected)
        || !can_draw(&order.rules, &numbers)
    {
        return Err(other());
    }
    let source = Source {
        rules: order.rules.shared(),
        environment,
        modes,
        seed: seed_number(order.seed, parameters),
        actual: places.iter().map(|(_, mode, _)| *mode).collect(),
    };
    Ok(Redrawn { source, values: places.into_iter().map(|(.., value)| value).collect() })
}

/// The place of a seed among all that sessions were drawn with.
fn seed_number(seed: Option<u64>, parameters: &Parameters) -> u64 {
    let drawn = parameters.orders.iter().filter_map(|order| order.drawn.as_ref());
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

/// The tests as a table: for each environment any effect, then each contrast.
pub(crate) fn table(
    tests: &[SharpNull],
    measure: &Measure,
    parameters: &Parameters,
) -> Result<Table, CompareError> {
    let mut names = vec![ANY_EFFECT.to_owned()];
    names.extend(parameters.contrasts.iter().map(columns::name));
    let all: Vec<(usize, &str, &Result<Randomised, NoTest>)> = tests
        .iter()
        .enumerate()
        .filter(|(_, of)| of.trials > 0)
        .flat_map(|(environment, of)| {
            let found = [&of.any_effect].into_iter().chain(&of.contrasts);
            names.iter().zip(found).map(move |(name, test)| (environment, name.as_str(), test))
        })
        .collect();
    let number = |name, description, of: fn(&Randomised) -> f64| {
        let values = all.iter().map(|(_, _, test)| test.as_ref().ok().map(of));
        Column::float(name, "1", description, values)
    };
    let count = |name, description, of: fn(&SharpNull) -> usize| {
        let values = all.iter().map(|(environment, ..)| whole(of(&tests[*environment])));
        Column::integer(name, "1", description, values)
    };
    let columns = vec![
        columns::environments(parameters, all.iter().map(|(environment, ..)| *environment)),
        Column::text(
            "effect",
            "the effect to which the test is sensitive",
            all.iter().map(|(_, name, _)| Some(*name)),
        ),
        count("sessions", "sessions whose orders are redrawn", |of| of.sessions),
        count("trials", "trials that have the metric", |of| of.trials),
        number("p_value", "p value of the sharp null, not adjusted", |test| test.p_value),
        number("smallest_p", "the smallest that the design's orders reach", |test| test.smallest_p),
        Column::text(
            "remark",
            "why there is no test",
            all.iter().map(|(_, _, test)| test.as_ref().err().map(ToString::to_string)),
        ),
    ];
    let title = format!("Randomised orders: {}", measure.description);
    let table = Table::new(&format!("orders_{}", measure.name), &title, columns)?;
    Ok(table.with_note(format!(
        "The sharp null: no trial of anyone depended on mode, carry-over included. Not a test of an \
         average effect. {} orders redrawn by the design's rules, for all participants together.",
        SAMPLING.draws
    )))
}

/// Each contrast in the redrawn orders: a hundred differences that are equally probable under the
/// sharp null, from the least on.
pub(crate) fn redrawn_table(
    tests: &[SharpNull],
    measure: &Measure,
    parameters: &Parameters,
) -> Result<Table, CompareError> {
    let mut rows: Vec<(usize, String, f64)> = Vec::new();
    for (environment, tests) in tests.iter().enumerate() {
        for (contrast, test) in parameters.contrasts.iter().zip(&tests.contrasts) {
            let Ok(test) = test else { continue };
            let name = columns::name(contrast);
            rows.extend(test.percentiles.iter().map(|one| (environment, name.clone(), *one)));
        }
    }
    let columns = vec![
        columns::environments(parameters, rows.iter().map(|(environment, ..)| *environment)),
        Column::text(
            "contrast",
            "the modes compared: the one minus the other",
            rows.iter().map(|(_, name, _)| Some(name.as_str())),
        ),
        measure.column(
            "difference",
            "difference of the modes' means in redrawn orders: each row is a hundredth of them",
            rows.iter().map(|(.., difference)| Some(*difference)),
        ),
    ];
    let title = format!("Differences in redrawn orders: {}", measure.description);
    Ok(Table::new(&format!("redrawn_{}", measure.name), &title, columns)?)
}

#[cfg(test)]
mod tests;
