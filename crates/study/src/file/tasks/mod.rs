//! `[[tasks]]` of a `study.toml`: the keys of each method, and the way back.

#[cfg(test)]
mod tests;

use super::check::{Check, MOST_TRIALS};
use crate::model::{Coordinate, Device, Environment};
use crate::scene::SceneNumber;
use crate::task::MOST_AXIS;
use crate::{
    AnswerScale, Asks, EnvironmentId, Method, MetricId, Question, QuestionId, Scene, StaircasePlan,
    Task, TaskEstimate, TaskFit, TaskLevel, TaskSigmoid, axis,
};
use serde::{Deserialize, Serialize};

/// The ratio of steps down and up of one up, and 1 to 4 down, with which a staircase settles near 77.85, 80.35, 83.15 and
/// 85.84 % (García-Pérez 1998, Vision Research 38:1861, table 1).
const DOWN_OVER_UP: [f64; 4] = [0.2845, 0.5488, 0.7393, 0.8415];
/// The most answers in a row that a rule asks for.
const MOST_IN_A_ROW: u8 = 4;
/// Reversals of a staircase, and those of which the mean is taken, if a study names none.
const REVERSALS: u32 = 12;
const OF_LAST: u32 = 8;
/// A staircase ends after so many presentations for each of its reversals: one of two down has some four.
const TRIALS_PER_REVERSAL: u32 = 10;
/// No staircase turns more often.
const MOST_REVERSALS: u32 = 1000;
/// No more staircases take turns.
const MOST_TRACKS: usize = 16;
/// No person sets a level more often: settings have numbers below 256.
const MOST_SETTINGS: u32 = 100;
/// The fewest levels through which a curve can be fitted.
const LEAST_LEVELS: usize = 3;
/// No method has more levels.
const MOST_LEVELS: usize = 1000;
/// Levels times curves of QUEST+, up to which a step takes less than a millisecond.
const MOST_SHARES: usize = 500_000;
/// No share of presentations at the standard is larger.
const MOST_CATCH: f64 = 0.5;
/// No study has more tasks.
const MOST_TASKS: usize = 32;

#[derive(Serialize, Deserialize, Clone, Copy, PartialEq)]
#[serde(rename_all = "snake_case")]
enum MethodKind {
    Constant,
    Staircase,
    /// A staircase of one up and one down that settles at a share.
    Weighted,
    QuestPlus,
    Adjustment,
}

impl MethodKind {
    fn as_str(self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::Staircase => "staircase",
            Self::Weighted => "weighted",
            Self::QuestPlus => "quest_plus",
            Self::Adjustment => "adjustment",
        }
    }
}

/// What the steps of a staircase are: numbers in the unit of the level, or factors.
#[derive(Serialize, Deserialize, Clone, Copy, PartialEq)]
#[serde(rename_all = "snake_case")]
enum StepScale {
    Unit,
    Factor,
}

#[derive(Serialize, Deserialize, Clone, PartialEq)]
#[serde(untagged, expecting = "start is a level, or a list of levels such as [2.0, 6.0]")]
enum Start {
    One(f64),
    Several(Vec<f64>),
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TaskTable {
    id: QuestionId,
    text: String,
    asks: Asks,
    pub(super) environment: EnvironmentId,
    varies: String,
    standard: Option<f64>,
    method: MethodKind,
    levels: Option<Vec<f64>>,
    trials: Option<u32>,
    rule: Option<String>,
    target: Option<f64>,
    start: Option<Start>,
    up: Option<f64>,
    down: Option<f64>,
    scale: Option<StepScale>,
    lowest: Option<f64>,
    highest: Option<f64>,
    reversals: Option<u32>,
    of_last: Option<u32>,
    interleaved: Option<usize>,
    most_trials: Option<u32>,
    pse: Option<[f64; 3]>,
    sigma: Option<[f64; 3]>,
    #[serde(rename = "lapse")]
    lapses: Option<[f64; 3]>,
    starts: Option<[f64; 2]>,
    step: Option<f64>,
    settings: Option<u32>,
    catch: Option<f64>,
    feedback: Option<bool>,
    fit: Option<FitTable>,
    estimate: Option<TaskEstimate>,
}

#[derive(Serialize, Deserialize, Clone, Copy)]
#[serde(deny_unknown_fields)]
struct FitTable {
    sigmoid: Option<TaskSigmoid>,
    lapse: Option<[f64; 2]>,
}

/// What else of the study a task's check looks at.
pub(super) struct Around<'s> {
    pub(super) environments: &'s [Environment],
    pub(super) coordinate: Coordinate,
    pub(super) device: &'s Device,
    pub(super) force_limit_n: f64,
    /// How many modes there are.
    pub(super) modes: usize,
}

/// Where a level is checked: the number that varies, if it is one that is rendered.
#[derive(Clone, Copy)]
struct Varies<'s> {
    number: Option<SceneNumber>,
    around: &'s Around<'s>,
    sigmoid: TaskSigmoid,
}

impl TaskTable {
    /// The keys that only some methods have, whether they are there, and the methods that have them.
    fn keys_of_methods(&self) -> [(&'static str, bool, &'static [MethodKind]); 20] {
        use MethodKind::{Adjustment, Constant, QuestPlus, Staircase, Weighted};
        [
            ("levels", self.levels.is_some(), &[Constant, QuestPlus]),
            ("trials", self.trials.is_some(), &[Constant, QuestPlus]),
            ("rule", self.rule.is_some(), &[Staircase]),
            ("target", self.target.is_some(), &[Weighted]),
            ("start", self.start.is_some(), &[Staircase, Weighted]),
            ("up", self.up.is_some(), &[Staircase, Weighted]),
            ("down", self.down.is_some(), &[Staircase]),
            ("scale", self.scale.is_some(), &[Staircase, Weighted]),
            ("lowest", self.lowest.is_some(), &[Staircase, Weighted, Adjustment]),
            ("highest", self.highest.is_some(), &[Staircase, Weighted, Adjustment]),
            ("reversals", self.reversals.is_some(), &[Staircase, Weighted]),
            ("of_last", self.of_last.is_some(), &[Staircase, Weighted]),
            ("interleaved", self.interleaved.is_some(), &[Staircase, Weighted]),
            ("most_trials", self.most_trials.is_some(), &[Staircase, Weighted, Adjustment]),
            ("pse", self.pse.is_some(), &[QuestPlus]),
            ("sigma", self.sigma.is_some(), &[QuestPlus]),
            ("lapse", self.lapses.is_some(), &[QuestPlus]),
            ("starts", self.starts.is_some(), &[Adjustment]),
            ("step", self.step.is_some(), &[Adjustment]),
            ("settings", self.settings.is_some(), &[Adjustment]),
        ]
    }
}

impl Check<'_> {
    /// The tasks, and their questions among the others.
    pub(super) fn tasks(
        &mut self,
        tables: &[TaskTable],
        around: &Around<'_>,
        questions: &mut Vec<Question>,
    ) -> Vec<Task> {
        self.unique("tasks", tables.iter().map(|table| table.id.as_str()));
        if tables.len() > MOST_TASKS {
            let n = tables.len();
            let problem = format!("the list has {n} entries; at most {MOST_TASKS} are allowed");
            self.error("tasks", problem);
        }
        let mut tasks = Vec::new();
        for (i, table) in tables.iter().enumerate() {
            let at = format!("tasks[{i}]");
            // Ids differ by more than case everywhere.
            let same = |own: &&Question| {
                !own.is_of_task() && own.id.as_str().eq_ignore_ascii_case(table.id.as_str())
            };
            if let Some(own) = questions.iter().find(same) {
                let problem = format!(
                    "a question of the study has the id '{}', and a task is a question, too; choose another id",
                    own.id
                );
                self.error(&format!("{at}.id"), problem);
            }
            let Some(task) = self.task(&at, table, around) else { continue };
            self.compared_as(&format!("{at}.id"), &task, &tasks);
            questions.push(Question {
                id: task.id.clone(),
                text: task.text.clone(),
                group: None,
                scale: AnswerScale::Task(task.asks),
                reversed: false,
                label: None,
                is_weight: false,
            });
            tasks.push(task);
        }
        let trials = tasks.iter().map(|task| {
            let presentations = task.presentations().saturating_add(task.catches());
            presentations
                .saturating_mul(around.modes as u64)
                .saturating_mul(task.asks.intervals().into())
        });
        let trials = trials.fold(0_u64, u64::saturating_add);
        if trials > MOST_TRIALS.into() {
            let problem = format!(
                "the tasks have {trials} trials in a session; at most {MOST_TRIALS} are allowed: fewer of each"
            );
            self.error("tasks", problem);
        }
        tasks
    }

    /// What a task measures is compared as metrics, whose names have its id in lower case, with `_` for `-`.
    fn compared_as(&mut self, key: &str, task: &Task, before: &[Task]) {
        for quantity in task.quantities() {
            let metric = match task.metric(quantity) {
                Ok(metric) => metric,
                Err(why) => return self.error(key, format!("{why}; choose a shorter id")),
            };
            // Of ids that differ by case alone is told that they stand twice.
            let is_same = |own: &&Task| {
                own.metric(quantity).is_ok_and(|id| id == metric)
                    && !own.id.as_str().eq_ignore_ascii_case(task.id.as_str())
            };
            if let Some(own) = before.iter().find(is_same) {
                let problem = format!(
                    "'{}' is compared as {metric}, too; choose an id that differs by more than '-' and '_'",
                    own.id
                );
                return self.error(key, problem);
            }
        }
    }

    /// A task; `None` where its method cannot be told.
    fn task(&mut self, at: &str, table: &TaskTable, around: &Around<'_>) -> Option<Task> {
        let key = |name: &str| format!("{at}.{name}");
        self.line(&key("text"), &table.text);
        if table.text.trim().is_empty() {
            self.error(&key("text"), "is empty; write what is asked after each presentation");
        }
        let fit = self.fit(at, table);
        let number = self.varies(at, table, around)?;
        let varies = Varies { number, around, sigmoid: fit.sigmoid };
        let standard = self.standard(&key("standard"), table, varies);
        for (name, is_present, methods) in table.keys_of_methods() {
            if is_present && !methods.contains(&table.method) {
                let problem = format!(
                    "is not used with method = \"{}\"; leave it out",
                    table.method.as_str()
                );
                self.error(&key(name), problem);
            }
        }
        if (table.asks == Asks::Set) != (table.method == MethodKind::Adjustment) {
            let problem = "asks = \"set\" and method = \"adjustment\" belong together: the person sets the level; \
                           write both or neither";
            self.error(&key("method"), problem);
            return None;
        }
        let method = match table.method {
            MethodKind::Constant => self.constant(at, table, varies),
            MethodKind::Staircase | MethodKind::Weighted => {
                Method::Staircase(self.staircase(at, table, varies))
            }
            MethodKind::QuestPlus => self.quest_plus(at, table, varies),
            MethodKind::Adjustment => self.adjustment(at, table, varies),
        };
        let catch = self.catch(&key("catch"), table);
        self.beside_the_standard(at, table, standard, &method, catch);
        Some(Task {
            id: table.id.clone(),
            text: table.text.clone(),
            asks: table.asks,
            environment: table.environment.clone(),
            varies: table.varies.clone(),
            standard,
            method,
            catch,
            feedback: table.feedback.unwrap_or_default(),
            fit,
            estimate: table.estimate.unwrap_or(TaskEstimate::Likelihood),
        })
    }

    /// The function to fit; settings are not fitted.
    fn fit(&mut self, at: &str, table: &TaskTable) -> TaskFit {
        let usual = TaskFit::default();
        if table.asks == Asks::Set {
            for (name, is_present) in [
                ("fit", table.fit.is_some()),
                ("estimate", table.estimate.is_some()),
                ("feedback", table.feedback.is_some()),
                ("catch", table.catch.is_some()),
            ] {
                if is_present {
                    let problem = "is not used with asks = \"set\", where no answer is right or wrong and \
                                   nothing is fitted; leave it out";
                    self.error(&format!("{at}.{name}"), problem);
                }
            }
            return usual;
        }
        let Some(fit) = table.fit else { return usual };
        let lapse = fit.lapse.unwrap_or(usual.lapse);
        let [least, most] = lapse;
        if !(0.0 <= least && least <= most && most < 0.5) {
            let problem = format!(
                "[{least}, {most}] must be the least and the most share of lapses, from 0 to below 0.5, such as [0.0, 0.06]"
            );
            self.error(&format!("{at}.fit.lapse"), problem);
        }
        TaskFit { sigmoid: fit.sigmoid.unwrap_or(usual.sigmoid), lapse }
    }

    /// The number that varies, where it is rendered; `None` where there is none of that key.
    fn varies(
        &mut self,
        at: &str,
        table: &TaskTable,
        around: &Around<'_>,
    ) -> Option<Option<SceneNumber>> {
        let key = format!("{at}.environment");
        let id = &table.environment;
        let Some(environment) = around.environments.iter().find(|own| own.id == *id) else {
            self.error(&key, format!("'{id}' is not the id of any [[environments]]"));
            return None;
        };
        if let Some(question) = environment.questions().next() {
            let problem = format!(
                "'{id}' asks '{question}' after each of its trials, which are those of the task: take the question out of that \
                 environment, or name another one"
            );
            self.error(&key, problem);
        }
        let key = format!("{at}.varies");
        let varies = &table.varies;
        if environment.scene == Scene::None {
            // Nothing is rendered by a device: what others varied has the name that they give it.
            let is_name = MetricId::new(varies).is_ok() && varies.contains('_');
            if !is_name {
                let problem = format!(
                    "'{varies}' must be in lower case and end in its unit, such as contrast_db: '{id}' renders nothing, so the \
                     name alone says what the levels are"
                );
                self.error(&key, problem);
            }
            return is_name.then_some(None);
        }
        let number = environment.number_of(varies, around.coordinate);
        if number.is_none() {
            let keys: Vec<&str> =
                environment.keys(around.coordinate).into_iter().map(|(key, _)| key).collect();
            let there = match keys.is_empty() {
                true => "it has no number that can vary".to_owned(),
                false => format!("there are {}", keys.join(", ")),
            };
            self.error(&key, format!("'{id}' has no number '{varies}': {there}"));
        }
        number.map(Some)
    }

    /// What levels are compared with; only where a level is set there need be none.
    fn standard(&mut self, key: &str, table: &TaskTable, varies: Varies<'_>) -> Option<TaskLevel> {
        if table.standard.is_none() && table.asks != Asks::Set {
            let problem = match table.asks {
                Asks::YesNo | Asks::OneOfTwo => {
                    "is missing: the level of what is nothing, mostly standard = 0.0"
                }
                _ => "is missing: the level that the others are compared with",
            };
            self.error(key, problem);
        }
        self.level(key, table.standard?, varies)
    }

    /// A level that is a whole number of millionths, and that the environment can have.
    fn level(&mut self, key: &str, value: f64, varies: Varies<'_>) -> Option<TaskLevel> {
        let Some(level) = TaskLevel::nearest(value) else {
            self.error(key, format!("{value} must be a finite number, at most 1e9"));
            return None;
        };
        // What has at most six decimals is read as the very number that the level is.
        if (level.value() - value).abs() > 0.0 {
            let problem = format!(
                "{value} must have at most six decimals, so that equal levels are equal: write {}",
                level.value()
            );
            self.error(key, problem);
            return None;
        }
        let Some(number) = varies.number else { return Some(level) };
        let before = self.errors.len();
        let si = self.typed(key, number, value, varies.around.coordinate);
        if self.errors.len() > before {
            return None;
        }
        let Around { device, force_limit_n, coordinate, .. } = *varies.around;
        // What a conversion of units may add.
        const ROUNDING_RAD: f64 = 1e-12;
        if let (SceneNumber::Wall, Some(least), Some(most)) =
            (number, device.theta_min_rad, device.theta_max_rad)
            && !(least - ROUNDING_RAD..=most + ROUNDING_RAD).contains(&si)
        {
            let [least, most] = [least, most].map(|end| number.typed(end, coordinate));
            let problem =
                format!("{value} lies outside of the device's work space, from {least} to {most}");
            self.error(key, problem);
            return None;
        }
        if number == SceneNumber::Force && si.abs() > force_limit_n {
            let problem =
                format!("{value} is more than control.force_limit_n, which is {force_limit_n}");
            self.error(key, problem);
            return None;
        }
        Some(level)
    }

    /// A level of a method: Weibull's function has none at 0 or below.
    fn shown_level(&mut self, key: &str, value: f64, varies: Varies<'_>) -> Option<TaskLevel> {
        let level = self.level(key, value, varies)?;
        if varies.sigmoid == TaskSigmoid::Weibull && level.value() <= 0.0 {
            let problem = format!(
                "{value} must lie above 0 for sigmoid = \"weibull\"; choose \"norm\" or \"logistic\", or leave it out"
            );
            self.error(key, problem);
            return None;
        }
        Some(level)
    }

    /// Rising levels.
    fn rising_levels(&mut self, at: &str, table: &TaskTable, varies: Varies<'_>) -> Vec<TaskLevel> {
        let key = format!("{at}.levels");
        let Some(values) = &table.levels else {
            self.error(&key, "is missing: the levels, rising, such as [2.0, 3.0, 4.0, 5.0, 6.0]");
            return Vec::new();
        };
        let n = values.len();
        if n < LEAST_LEVELS {
            let problem = format!("has {n} levels; a curve needs at least {LEAST_LEVELS}");
            self.error(&key, problem);
        }
        if n > MOST_LEVELS {
            self.error(&key, format!("has {n} levels; at most {MOST_LEVELS} are allowed"));
            return Vec::new();
        }
        let mut levels: Vec<TaskLevel> = Vec::new();
        for (i, value) in values.iter().enumerate() {
            let key = format!("{key}[{i}]");
            let Some(level) = self.shown_level(&key, *value, varies) else { continue };
            match levels.last() {
                Some(last) if *last == level => {
                    self.error(&key, format!("{value} stands twice; leave one out"));
                }
                Some(last) if *last > level => {
                    let problem = format!(
                        "{value} comes after {}; levels must rise: sort the list",
                        last.value()
                    );
                    self.error(&key, problem);
                }
                _ => levels.push(level),
            }
        }
        levels
    }

    /// A whole number from 1 on; `missing` stands in for an absent key, without it the key is required.
    fn counted_key(
        &mut self,
        key: &str,
        value: Option<u32>,
        missing: Option<u32>,
        most: u32,
    ) -> u32 {
        let Some(value) = value.or(missing) else {
            self.error(key, "is missing; this method needs it");
            return 1;
        };
        if !(1..=most).contains(&value) {
            self.error(key, format!("{value} must be a whole number from 1 to {most}"));
            return 1;
        }
        value
    }

    fn constant(&mut self, at: &str, table: &TaskTable, varies: Varies<'_>) -> Method {
        let trials = self.counted_key(&format!("{at}.trials"), table.trials, None, MOST_TRIALS);
        Method::Constant { levels: self.rising_levels(at, table, varies), trials }
    }

    /// The lowest and the highest level.
    fn bounds(&mut self, at: &str, table: &TaskTable, varies: Varies<'_>) -> [TaskLevel; 2] {
        let ends = [("lowest", table.lowest), ("highest", table.highest)];
        let [lowest, highest] = ends.map(|(name, value)| {
            let key = format!("{at}.{name}");
            if value.is_none() {
                self.error(&key, "is missing: no level may lie beyond it");
            }
            self.shown_level(&key, value?, varies)
        });
        // With a problem noted no study comes out: any level will do.
        let [Some(lowest), Some(highest)] = [lowest, highest] else { return [TaskLevel::ZERO; 2] };
        if lowest >= highest {
            let problem =
                format!("{} must lie above lowest, which is {}", highest.value(), lowest.value());
            self.error(&format!("{at}.highest"), problem);
        }
        [lowest, highest]
    }

    /// A level where something begins, which must lie within the bounds.
    fn start(
        &mut self,
        key: &str,
        value: f64,
        [lowest, highest]: [TaskLevel; 2],
        varies: Varies<'_>,
    ) -> Option<TaskLevel> {
        let level = self.shown_level(key, value, varies)?;
        // Bounds that are none were told already.
        if lowest < highest && !(lowest..=highest).contains(&level) {
            let problem = format!(
                "{value} must lie between lowest and highest, from {} to {}",
                lowest.value(),
                highest.value()
            );
            self.error(key, problem);
        }
        Some(level)
    }

    fn staircase(&mut self, at: &str, table: &TaskTable, varies: Varies<'_>) -> StaircasePlan {
        let key = |name: &str| format!("{at}.{name}");
        let bounds = self.bounds(at, table, varies);
        let starts = self.starts(at, table, bounds, varies);
        let is_factor = table.scale == Some(StepScale::Factor);
        if is_factor && bounds[0] < bounds[1] && bounds[0].value() <= 0.0 {
            let problem = format!(
                "{} must lie above 0 for scale = \"factor\"; choose \"unit\", or a higher one",
                bounds[0].value()
            );
            self.error(&key("lowest"), problem);
        }
        let [up_after, down_after] = self.rule(at, table);
        let up = match table.up {
            Some(up) => self.step(&key("up"), up, is_factor),
            None => {
                let what = match is_factor {
                    true => "is missing: the factor of a step up, such as 1.25",
                    false => "is missing: the step up, in the unit of the levels",
                };
                self.error(&key("up"), what);
                1.0
            }
        };
        let ratio = match (table.method, table.target) {
            (MethodKind::Weighted, target) => self.ratio(at, table.asks, target),
            (_, _) if up_after == 1 => DOWN_OVER_UP[usize::from(down_after) - 1],
            (_, _) => 1.0,
        };
        let down = match table.down {
            Some(down) => self.step(&key("down"), down, is_factor),
            None => {
                if up_after > 1 {
                    let problem = format!(
                        "is missing: with {up_after} answers before a step up no ratio of steps is known that the rule settles \
                         well with; name the step down"
                    );
                    self.error(&key("down"), problem);
                }
                // The same on every machine: levels follow from it.
                if is_factor { libm::pow(up, ratio) } else { up * ratio }
            }
        };
        let reversals =
            self.counted_key(&key("reversals"), table.reversals, Some(REVERSALS), MOST_REVERSALS);
        let of_last = Some(OF_LAST.min(reversals));
        let of_last = self.counted_key(&key("of_last"), table.of_last, of_last, reversals);
        let most_trials = self.counted_key(
            &key("most_trials"),
            table.most_trials,
            Some(TRIALS_PER_REVERSAL * reversals),
            MOST_TRIALS,
        );
        if most_trials < reversals {
            let problem = format!(
                "{most_trials} trials cannot turn {reversals} times; allow more, mostly {TRIALS_PER_REVERSAL} for each reversal"
            );
            self.error(&key("most_trials"), problem);
        }
        StaircasePlan {
            up_after,
            down_after,
            starts,
            up,
            down,
            is_factor,
            bounds,
            reversals,
            of_last,
            most_trials,
        }
    }

    /// The first level of each of the staircases that take turns.
    fn starts(
        &mut self,
        at: &str,
        table: &TaskTable,
        bounds: [TaskLevel; 2],
        varies: Varies<'_>,
    ) -> Vec<TaskLevel> {
        let key = format!("{at}.start");
        let together = format!("{at}.interleaved");
        if let Some(n) = table.interleaved
            && !(1..=MOST_TRACKS).contains(&n)
        {
            self.error(&together, format!("{n} must be a whole number from 1 to {MOST_TRACKS}"));
            return Vec::new();
        }
        let values = match &table.start {
            None => {
                self.error(&key, "is missing: the first level, easy to feel");
                return Vec::new();
            }
            Some(Start::One(value)) => {
                let start = self.start(&key, *value, bounds, varies);
                let n = table.interleaved.unwrap_or(1);
                return start.map_or(Vec::new(), |start| vec![start; n]);
            }
            Some(Start::Several(values)) => values,
        };
        let n = values.len();
        if !(1..=MOST_TRACKS).contains(&n) {
            self.error(&key, format!("the list has {n} levels; give 1 to {MOST_TRACKS}"));
            return Vec::new();
        }
        if let Some(other) = table.interleaved.filter(|other| *other != n) {
            let problem = format!(
                "{other} staircases take turns and start has {n} levels; give one for each"
            );
            self.error(&together, problem);
        }
        let starts = values.iter().enumerate();
        starts
            .filter_map(|(i, value)| self.start(&format!("{key}[{i}]"), *value, bounds, varies))
            .collect()
    }

    /// After how many answers in a row there is a step up, and one down.
    fn rule(&mut self, at: &str, table: &TaskTable) -> [u8; 2] {
        if table.method == MethodKind::Weighted {
            return [1, 1];
        }
        let key = format!("{at}.rule");
        let Some(rule) = &table.rule else {
            self.error(&key, "is missing: such as \"1up2down\"");
            return [1, 1];
        };
        let counts = rule.strip_suffix("down").and_then(|rest| rest.split_once("up"));
        let count = |text: &str| {
            text.parse::<u8>().ok().filter(|count| (1..=MOST_IN_A_ROW).contains(count))
        };
        match counts.and_then(|(up, down)| Some([count(up)?, count(down)?])) {
            Some(counts) => counts,
            None => {
                let problem = format!(
                    "'{rule}' must say after how many wrong answers in a row the level goes up, and after how many right ones \
                     down, each from 1 to {MOST_IN_A_ROW}, such as \"1up2down\""
                );
                self.error(&key, problem);
                [1, 1]
            }
        }
    }

    /// A step that changes a level.
    fn step(&mut self, key: &str, step: f64, is_factor: bool) -> f64 {
        /// No step is smaller than a level's last digit, nor larger than any level.
        const LEAST: f64 = 1e-6;
        const MOST: f64 = 1e9;
        let is_good = match is_factor {
            true => step > 1.0 && step <= MOST,
            false => (LEAST..=MOST).contains(&step),
        };
        if !is_good {
            let problem = match is_factor {
                true => format!("{step} must be a factor above 1, such as 1.25"),
                false => {
                    format!("{step} must be a step in the unit of the levels, from {LEAST:e} on")
                }
            };
            self.error(key, problem);
        }
        step
    }

    /// The ratio of steps down and up that makes a share the target: (1 − p)/p (Kaernbach 1991, Perception & Psychophysics
    /// 49:227).
    fn ratio(&mut self, at: &str, asks: Asks, target: Option<f64>) -> f64 {
        let key = format!("{at}.target");
        let Some(target) = target else {
            self.error(&key, "is missing: the share of right answers to settle at, such as 0.75");
            return 1.0;
        };
        let chance = if asks == Asks::OneOfTwo { 0.5 } else { 0.0 };
        // So close to its ends nothing settles.
        if !(0.01..=0.99).contains(&target) || target <= chance {
            let problem = match asks {
                Asks::OneOfTwo => {
                    format!(
                        "{target} must be a share above 0.5, up to 0.99: half of two are right by chance"
                    )
                }
                _ => format!("{target} must be a share from 0.01 to 0.99, such as 0.75"),
            };
            self.error(&key, problem);
            return 1.0;
        }
        (1.0 - target) / target
    }

    fn quest_plus(&mut self, at: &str, table: &TaskTable, varies: Varies<'_>) -> Method {
        if table.asks == Asks::YesNo {
            let problem = "\"quest_plus\" cannot learn how often somebody says yes to nothing; choose \"constant\" with \
                           trials at nothing, or asks = \"2afc\"";
            self.error(&format!("{at}.method"), problem);
        }
        let trials = self.counted_key(&format!("{at}.trials"), table.trials, None, MOST_TRIALS);
        let levels = self.rising_levels(at, table, varies);
        let axes = [("pse", table.pse), ("sigma", table.sigma), ("lapse", table.lapses)];
        let mut cells: usize = 1;
        let [pse, sigma, lapse] = axes.map(|(name, range)| {
            let key = format!("{at}.{name}");
            let Some(range) = range else {
                self.error(&key, "is missing: from, to and step, such as [2.0, 6.0, 0.1]");
                return [0.0, 0.0, 1.0];
            };
            let [from, to, step] = range;
            let is_range = range.iter().all(|number| number.abs() <= 1e9) && from <= to && step > 0.0;
            let lies = match name {
                "lapse" => Some((0.0..0.5).contains(&from) && to < 0.5).filter(|is_in| !is_in).map(|_| {
                    "shares of lapses lie from 0 to below 0.5"
                }),
                "sigma" => (from <= 0.0).then_some("spreads lie above 0"),
                _ => (varies.sigmoid == TaskSigmoid::Weibull && from <= 0.0)
                    .then_some("thresholds of sigmoid = \"weibull\" lie above 0"),
            };
            match lies {
                _ if !is_range => {
                    let problem = format!(
                        "[{from}, {to}, {step}] must be from, to and a step above 0, with from no higher than to"
                    );
                    self.error(&key, problem);
                }
                Some(why) => self.error(&key, format!("[{from}, {to}, {step}]: {why}")),
                None => {
                    // An axis that was cut short is too long in any case.
                    let n = Some(axis(range).len()).filter(|n| *n < MOST_AXIS);
                    cells = cells.saturating_mul(n.unwrap_or(usize::MAX));
                }
            }
            range
        });
        if cells.saturating_mul(levels.len()) > MOST_SHARES {
            let problem = format!(
                "{} levels times all combinations of pse, sigma and lapse are more than {MOST_SHARES}; take longer steps of \
                 these",
                levels.len()
            );
            self.error(&format!("{at}.levels"), problem);
        }
        Method::QuestPlus { levels, trials, pse, sigma, lapse }
    }

    fn adjustment(&mut self, at: &str, table: &TaskTable, varies: Varies<'_>) -> Method {
        let key = |name: &str| format!("{at}.{name}");
        let bounds = self.bounds(at, table, varies);
        let settings = self.counted_key(&key("settings"), table.settings, None, MOST_SETTINGS);
        if settings == 1 && table.settings == Some(1) {
            self.error(&key("settings"), "1 setting has no spread; ask for at least 2");
        }
        let step = match table.step.and_then(TaskLevel::nearest) {
            Some(step)
                if step > TaskLevel::ZERO
                    && table.step.is_some_and(|typed| (step.value() - typed).abs() <= 0.0) =>
            {
                step
            }
            _ => {
                let problem = "must be the step from a level to the next, above 0 with at most six decimals, such as 0.2";
                self.error(&key("step"), problem);
                TaskLevel::ZERO
            }
        };
        let starts = match table.starts {
            None => {
                self.error(
                    &key("starts"),
                    "is missing: a level well below and one well above, such as [2.0, 6.0]",
                );
                [None; 2]
            }
            Some(values) => {
                let [low, high] = values;
                if low >= high {
                    let problem = format!("[{low}, {high}] must be a lower and a higher level");
                    self.error(&key("starts"), problem);
                }
                [(0, low), (1, high)].map(|(i, value)| {
                    self.start(&key(&format!("starts[{i}]")), value, bounds, varies)
                })
            }
        };
        // There and back: whoever has not found it by then does not find it.
        let there = (bounds[1].value() - bounds[0].value()) / step.value();
        let there =
            if there.is_finite() { there.ceil().clamp(1.0, MOST_TRIALS.into()) } else { 1.0 };
        let usual = (2 * there as u32).clamp(2, MOST_TRIALS);
        let most_trials =
            self.counted_key(&key("most_trials"), table.most_trials, Some(usual), MOST_TRIALS);
        let [low, high] = starts.map(Option::unwrap_or_default);
        Method::Adjustment { starts: [low, high], step, bounds, settings, most_trials }
    }

    /// The share of presentations at the standard.
    fn catch(&mut self, key: &str, table: &TaskTable) -> f64 {
        let catch = table.catch.unwrap_or_default();
        if !(0.0..=MOST_CATCH).contains(&catch) {
            let problem = format!("{catch} must be a share from 0 to {MOST_CATCH}, such as 0.1");
            self.error(key, problem);
            return 0.0;
        }
        if catch > 0.0 && table.asks == Asks::OneOfTwo {
            let problem = "is not used with asks = \"2afc\": where both intervals are the standard, neither is right; leave it out";
            self.error(key, problem);
            return 0.0;
        }
        catch + 0.0 // without a sign
    }

    /// Where "nothing" is meant: whether there are trials at it, or must be none.
    fn beside_the_standard(
        &mut self,
        at: &str,
        table: &TaskTable,
        standard: Option<TaskLevel>,
        method: &Method,
        catch: f64,
    ) {
        let Some(standard) = standard else { return };
        let (lowest, key) = match method {
            Method::Constant { levels, .. } | Method::QuestPlus { levels, .. } => {
                (levels.first().copied(), "levels[0]")
            }
            Method::Staircase(plan) => (Some(plan.bounds[0]), "lowest"),
            Method::Adjustment { .. } => return,
        };
        let Some(lowest) = lowest else { return };
        let value = standard.value();
        match table.asks {
            Asks::OneOfTwo if lowest <= standard => {
                let problem = format!(
                    "{} must lie above the standard, {value}, which is in the other interval: else neither is right",
                    lowest.value()
                );
                self.error(&format!("{at}.{key}"), problem);
            }
            Asks::YesNo if lowest < standard => {
                let problem = format!(
                    "{} must not lie below the standard, {value}, which is nothing",
                    lowest.value()
                );
                self.error(&format!("{at}.{key}"), problem);
            }
            Asks::YesNo => {
                let has =
                    matches!(method, Method::Constant { levels, .. } if levels.contains(&standard));
                if !has && catch <= 0.0 && !matches!(method, Method::QuestPlus { .. }) {
                    let problem = format!(
                        "needs trials at nothing, to know how often somebody says yes to it: add catch = 0.2, or the level {value}"
                    );
                    self.error(&format!("{at}.asks"), problem);
                }
            }
            _ => {}
        }
    }
}

impl TaskTable {
    /// The table of a task.
    pub(super) fn of(task: &Task) -> Self {
        let list = |levels: &[TaskLevel]| levels.iter().map(|level| level.value()).collect();
        let usual = TaskFit::default();
        let fit = FitTable { sigmoid: Some(task.fit.sigmoid), lapse: Some(task.fit.lapse) };
        let mut table = Self {
            id: task.id.clone(),
            text: task.text.clone(),
            asks: task.asks,
            environment: task.environment.clone(),
            varies: task.varies.clone(),
            standard: task.standard.map(TaskLevel::value),
            method: MethodKind::Constant,
            levels: None,
            trials: None,
            rule: None,
            target: None,
            start: None,
            up: None,
            down: None,
            scale: None,
            lowest: None,
            highest: None,
            reversals: None,
            of_last: None,
            interleaved: None,
            most_trials: None,
            pse: None,
            sigma: None,
            lapses: None,
            starts: None,
            step: None,
            settings: None,
            catch: (task.catch > 0.0).then_some(task.catch),
            feedback: task.feedback.then_some(true),
            fit: (task.fit != usual).then_some(fit),
            estimate: (task.estimate != TaskEstimate::Likelihood).then_some(task.estimate),
        };
        match &task.method {
            Method::Constant { levels, trials } => {
                table.levels = Some(list(levels));
                table.trials = Some(*trials);
            }
            Method::Staircase(plan) => {
                table.method = MethodKind::Staircase;
                table.rule = Some(format!("{}up{}down", plan.up_after, plan.down_after));
                table.start = Some(Start::Several(list(&plan.starts)));
                table.up = Some(plan.up);
                table.down = Some(plan.down);
                table.scale =
                    Some(if plan.is_factor { StepScale::Factor } else { StepScale::Unit });
                table.set_bounds(plan.bounds);
                table.reversals = Some(plan.reversals);
                table.of_last = Some(plan.of_last);
                table.most_trials = Some(plan.most_trials);
            }
            Method::QuestPlus { levels, trials, pse, sigma, lapse } => {
                table.method = MethodKind::QuestPlus;
                table.levels = Some(list(levels));
                table.trials = Some(*trials);
                table.pse = Some(*pse);
                table.sigma = Some(*sigma);
                table.lapses = Some(*lapse);
            }
            Method::Adjustment { starts, step, bounds, settings, most_trials } => {
                table.method = MethodKind::Adjustment;
                table.starts = Some(starts.map(TaskLevel::value));
                table.step = Some(step.value());
                table.set_bounds(*bounds);
                table.settings = Some(*settings);
                table.most_trials = Some(*most_trials);
            }
        }
        table
    }

    fn set_bounds(&mut self, [lowest, highest]: [TaskLevel; 2]) {
        self.lowest = Some(lowest.value());
        self.highest = Some(highest.value());
    }
}
