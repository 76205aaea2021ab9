//! A study as a value: what was planned, in SI units.

use crate::{
    ActuatorKind, AnswerScale, Axes, Channel, Compare, Control, EnvironmentId, Factor, Figures,
    Levels, ModeId, ModeLaw, OutsideMetric, OwnMetric, OwnStage, Perception, PersonColumn,
    QuestionId, ReplayModel, Scene, SceneFigure, Schema, Score, StageId, StudyId, Task, TaskLevel,
};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A whole `study.toml`, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Study {
    /// The study's id: the folder's name under `raw/`.
    pub id: StudyId,
    /// A title for pages and figures.
    pub title: String,
    /// Trials and their order.
    pub design: Design,
    /// What figures and tables call the coordinate.
    pub coordinate: Coordinate,
    /// The device.
    pub device: Device,
    /// Numbers of the control loop.
    pub control: Control,
    /// Actuator masses, for the weight calculation.
    pub masses: Option<Masses>,
    /// Resistances of the actuators' windings, for the electrical energy of a trial.
    pub resistances: Resistances,
    /// What is rendered, in the order of the file.
    pub environments: Vec<Environment>,
    /// How it is rendered, in the order of the file (figures give each its colour by this order).
    pub modes: Vec<Mode>,
    /// What is asked.
    pub questions: Vec<Question>,
    /// Numbers the analysis needs.
    pub analysis: Analysis,
    /// What is compared.
    pub compare: Compare,
    /// What a person can feel.
    pub perception: Perception,
    /// Which model recorded trials are replayed with.
    pub replay: ReplayModel,
    /// What figures show.
    pub figures: Figures,
    /// Figures of scenes of the model, in the order of the file.
    pub scenes: Vec<SceneFigure>,
    /// Version of the trial files' form.
    pub schema: Schema,
    /// The study's own quantities per sample, in the order of the file.
    pub channels: Vec<Channel>,
    /// The columns of the participants' file, in the order of the file.
    pub people: Vec<PersonColumn>,
    /// The study's own metrics, in the order of the file.
    pub metrics: Vec<OwnMetric>,
    /// The study's own stages, in the order of the file.
    pub stages: Vec<OwnStage>,
    /// Scores of several answers, in the order of the file.
    pub scores: Vec<Score>,
    /// What can be felt, measured by answers.
    pub tasks: Vec<Task>,
    /// The axes of space, where positions and forces are recorded in three.
    pub axes: Option<Axes>,
    /// What modes and environments have in common, in the order of the file.
    pub factors: Vec<Factor>,
    /// Metrics that other programs computed, of which tables beside the recordings hold the values. No `study.toml` has
    /// them: they come with the study's data.
    pub from_tables: Vec<OutsideMetric>,
    /// Metrics that the study's own stages give, each with the stage's id; they follow from `stages`.
    pub from_stages: Vec<(StageId, OutsideMetric)>,
}

impl Study {
    /// Every metric whose values come from outside of zwidth. A table of a metric that a stage gives has no
    /// effect: of two sources of one column nobody could say which it is.
    pub fn outside(&self) -> impl Iterator<Item = &OutsideMetric> {
        let of_stages = self.from_stages.iter().map(|(_, metric)| metric);
        let is_alone = |own: &&OutsideMetric| {
            self.from_stages.iter().all(|(_, metric)| metric.column != own.column)
        };
        of_stages.chain(self.from_tables.iter().filter(is_alone))
    }

    /// The metrics that a stage of the study's own gives, in its order.
    pub fn of_stage<'a>(&'a self, id: &'a StageId) -> impl Iterator<Item = &'a OutsideMetric> {
        self.from_stages.iter().filter(move |(stage, _)| stage == id).map(|(_, metric)| metric)
    }

    /// The metric from outside whose column has that name.
    pub fn outside_metric(&self, column: &str) -> Option<&OutsideMetric> {
        self.outside().find(|own| own.column.as_str() == column)
    }

    /// The environment of that id.
    pub fn environment(&self, id: &EnvironmentId) -> Option<&Environment> {
        self.environments.iter().find(|e| e.id == *id)
    }

    /// The mode of that id.
    pub fn mode(&self, id: &ModeId) -> Option<&Mode> {
        self.modes.iter().find(|m| m.id == *id)
    }

    /// The question of that id.
    pub fn question(&self, id: &QuestionId) -> Option<&Question> {
        self.questions.iter().find(|q| q.id == *id)
    }

    /// The task of that id.
    pub fn task(&self, id: &QuestionId) -> Option<&Task> {
        self.tasks.iter().find(|task| task.id == *id)
    }

    /// The tasks in which an environment varies, in the order of the file.
    pub fn tasks_in<'s>(&'s self, id: &'s EnvironmentId) -> impl Iterator<Item = &'s Task> {
        self.tasks.iter().filter(move |task| task.environment == *id)
    }

    /// The unit of a task's levels, as [`Task::unit`] has it.
    pub fn task_unit(&self, task: &Task) -> String {
        task.unit().to_owned()
    }

    /// The environment of a task at a level; `None` if there is none that has the number. Where nothing is rendered, a level
    /// changes nothing.
    pub fn environment_at(&self, task: &Task, level: TaskLevel) -> Option<Environment> {
        let environment = self.environment(&task.environment)?;
        match environment.scene {
            Scene::None => Some(environment.clone()),
            _ => environment.varied(&task.varies, level.value(), self.coordinate),
        }
    }

    /// The scores whose questions are all asked after trials of an environment, and whose pairs are
    /// asked once in a session after the last of those trials.
    pub fn weighed_in<'s>(
        &'s self,
        environment: &'s Environment,
    ) -> impl Iterator<Item = &'s Score> {
        self.scores.iter().filter(|score| {
            let mut questions = score.questions.iter();
            score.pairs.is_some()
                && questions.all(|id| environment.questions().any(|asked| asked == id))
        })
    }

    /// Every condition of the study, environments first, in the order of the file.
    pub fn conditions(&self) -> Vec<Condition> {
        let pairs = self.environments.iter().flat_map(|e| self.modes.iter().map(move |m| (e, m)));
        pairs.map(|(e, m)| Condition { environment: e.id.clone(), mode: m.id.clone() }).collect()
    }
}

/// Trials and their order: `[design]` of `study.toml`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
// Where a value is no such table, serde says what it expected by the name of the type; this one is
// called as the tables of `file/shape.rs` are, so that all are told in the same words.
#[serde(deny_unknown_fields, expecting = "struct DesignTable")]
pub struct Design {
    /// Repeats of each condition in a session.
    pub repeats: u32,
    /// Familiarisation trials before a session.
    #[serde(default)]
    pub familiarisation: u32,
    /// Longest a trial may take, s.
    pub trial_limit_s: f64,
    /// Shortest pause between trials, s.
    #[serde(default)]
    pub pause_s: f64,
    /// How many times a trial that did not meet the protocol is done again, after all others; 0 for never.
    #[serde(default)]
    pub redo_unmet: u32,
    /// How the order of the modes is drawn.
    #[serde(default)]
    pub order: OrderScheme,
    /// Whether the modes are sealed until the session is unsealed ([`crate::Seal`]).
    #[serde(default)]
    pub blinded: bool,
}

/// How the order of the modes within a block is drawn ([`crate::order`]).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OrderScheme {
    /// Rows of Williams squares, one a repeat.
    #[default]
    Williams,
    /// At random, with no mode more than twice in a row.
    Constrained,
}

/// What figures and tables call the coordinate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Coordinate {
    /// A lever: θ in degrees, stiffness in N/rad.
    Rotational,
    /// A slide: x = L θ in millimetres, stiffness in N/mm.
    Linear {
        /// The length L that turns θ into x, m.
        lever_m: f64,
    },
}

/// The device, as far as the analysis needs it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Device {
    /// What it is called.
    pub name: String,
    /// Lever length L from the axis to the finger, m. Without it torque stays torque.
    pub lever_m: Option<f64>,
    /// Work space, lower end, rad.
    pub theta_min_rad: Option<f64>,
    /// Work space, upper end, rad.
    pub theta_max_rad: Option<f64>,
    /// Rate at which the force sensor gives new values, Hz.
    pub force_rate_hz: Option<f64>,
}

/// Actuator masses (thesis, appendix A).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Masses {
    /// The motor's mass, kg.
    pub motor_kg: f64,
    /// The brake's mass, kg.
    pub brake_kg: f64,
}

/// Resistances of the actuators' windings; `None` if they are not known.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
// What was expected is told in the same words as for [`Design`].
#[serde(deny_unknown_fields, expecting = "struct ResistancesTable")]
pub struct Resistances {
    /// The motor's, Ω.
    pub motor_ohm: Option<f64>,
    /// The brake's, Ω.
    pub brake_ohm: Option<f64>,
}

/// One environment of the study.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Environment {
    /// Its id.
    pub id: EnvironmentId,
    /// What figures call it.
    pub label: String,
    /// What is rendered.
    pub scene: Scene,
    /// By how much it is rendered late, s; 0 is at once. A loop renders the nearest whole number of its ticks
    /// ([`Environment::delivered_delay_s`]).
    #[serde(skip_serializing_if = "is_at_once")]
    pub delay_s: f64,
    /// The first question after each of its trials.
    pub question: Option<QuestionId>,
    /// The questions after it, in this order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub further: Vec<QuestionId>,
    /// Its level of each factor of environments.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub factors: Levels,
}

fn is_at_once(delay_s: &f64) -> bool {
    *delay_s == 0.0
}

impl Environment {
    /// The longest delay that can be asked for, s: a movement takes about as long.
    pub const LONGEST_DELAY_S: f64 = 1.0;

    /// The delay in ticks of a loop of that rate, Hz: the nearest whole number.
    pub fn delay_ticks(&self, rate_hz: f64) -> usize {
        // A delay or a rate that is no number above 0 is none.
        (self.delay_s * rate_hz).round() as usize
    }

    /// The delay that a loop of that rate, Hz, renders, s: a whole number of its ticks.
    pub fn delivered_delay_s(&self, rate_hz: f64) -> f64 {
        match self.delay_ticks(rate_hz) {
            0 => 0.0,
            ticks => ticks as f64 / rate_hz,
        }
    }

    /// The questions after each of its trials, in order.
    pub fn questions(&self) -> impl Iterator<Item = &QuestionId> {
        self.question.iter().chain(&self.further)
    }
}

/// One mode of the study: an entry of `[[modes]]` in `study.toml`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
// What was expected is told in the same words as for [`Design`].
#[serde(deny_unknown_fields, expecting = "struct ModeTable")]
pub struct Mode {
    /// Its id.
    pub id: ModeId,
    /// What figures call it.
    pub label: String,
    /// Highest motor voltage used, V.
    pub motor_max_v: Option<f64>,
    /// Highest brake voltage used, V.
    pub brake_max_v: Option<f64>,
    /// Which of them is in charge when, where the study names it ([`Mode::law`]).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub law: Option<ModeLaw>,
    /// Its level of each factor of modes.
    #[serde(
        default,
        skip_serializing_if = "BTreeMap::is_empty",
        deserialize_with = "crate::factors::levels"
    )]
    pub factors: Levels,
}

impl Mode {
    /// Whether an actuator has a voltage in this mode.
    pub fn has(&self, drive: ActuatorKind) -> bool {
        let max_v = match drive {
            ActuatorKind::Motor => self.motor_max_v,
            ActuatorKind::Brake => self.brake_max_v,
        };
        max_v.is_some_and(|v| v > 0.0)
    }

    /// Its law: the one named, else the first that uses the actuators that have a voltage, and no
    /// other; `None` if there is no such law.
    pub fn law(&self) -> Option<ModeLaw> {
        self.law.or_else(|| {
            ModeLaw::ALL.into_iter().find(|law| {
                ActuatorKind::ALL.iter().all(|drive| law.uses(*drive) == self.has(*drive))
            })
        })
    }
}

/// One question, answered on a scale.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Question {
    /// Its id.
    pub id: QuestionId,
    /// Its wording.
    pub text: String,
    /// The group with which it is tallied, if it belongs to one.
    pub group: Option<String>,
    /// What may be answered.
    pub scale: AnswerScale,
    /// Whether agreement is unfavourable: the tally then reverses the answer
    /// ([`AnswerScale::score`]).
    pub reversed: bool,
    /// What a pair calls it, where that is not its wording.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// Whether its answers are weights of a score: they say how much others count, and not what was
    /// felt.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub is_weight: bool,
}

impl Question {
    /// Whether its answers rate what was felt: they have an order, and are tallied and compared.
    /// Those to the question which mode it was do not, nor do the weights of a score and the answers
    /// to tasks.
    pub fn is_rating(&self) -> bool {
        !self.scale.is_nominal() && !self.is_weight
    }

    /// Whether it asks which mode it was.
    pub fn asks_mode(&self) -> bool {
        matches!(self.scale, AnswerScale::Modes(_))
    }

    /// Whether it asks for one of two questions of a score: the program adds those itself
    /// ([`Score::pairs`]).
    pub fn is_pair(&self) -> bool {
        matches!(self.scale, AnswerScale::Pair(_))
    }

    /// Whether it is the question of a task: the program adds it itself, and asks it after each presentation of the task.
    pub fn is_of_task(&self) -> bool {
        matches!(self.scale, AnswerScale::Task(_))
    }
}

/// Environment × mode.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct Condition {
    /// What is rendered.
    pub environment: EnvironmentId,
    /// How it is rendered.
    pub mode: ModeId,
}

/// Numbers the analysis needs; each has a default.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Analysis {
    /// Movement begins where |θ̇| first exceeds this, rad/s.
    pub onset_rad_s: f64,
    /// Movement ends where |θ̇| last falls below this, rad/s (smaller than the onset: hysteresis).
    pub offset_rad_s: f64,
    /// A spring's slope is fitted on samples at least this far past its rest, rad.
    pub slope_from_rad: f64,
    /// Points of a common grid over time or angle.
    pub grid_points: usize,
    /// Level of every interval, as a fraction.
    pub confidence: f64,
}

impl Default for Analysis {
    fn default() -> Self {
        Self {
            onset_rad_s: 10_f64.to_radians(),
            offset_rad_s: 5_f64.to_radians(),
            slope_from_rad: 0.0,
            grid_points: 401,
            confidence: 0.95,
        }
    }
}
