//! The shape of `study.toml`: what serde reads and writes, in the units people type. TOML has
//! nothing for `None`: such a key is not written.

use super::environment::EnvironmentTable;
use super::people::PersonColumnTable;
use super::perception::PerceptionTable;
use super::tasks::TaskTable;
use crate::model::{Analysis, Design, Mode, Resistances};
use crate::{
    AnswerScale, Axes, Better, LevelId, MetricId, ModeId, PersonColumnId, QuestionId, Score,
    StudyId,
};
use crate::{
    Channel, Control, Curve, EffectSize, Factor, FactorId, Families, OwnMetric, OwnStage, Primary,
    ReplayModel, SceneFigure, Term, Trend, VelocityFilter,
};
use serde::de::{self, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::collections::BTreeMap;
use std::fmt;

fn is_default<T: Default + PartialEq>(table: &T) -> bool {
    *table == T::default()
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    pub(super) schema: u32,
    pub(super) study: StudyTable,
    pub(super) design: Design,
    #[serde(default)]
    pub(super) coordinate: CoordinateTable,
    pub(super) device: DeviceTable,
    #[serde(default)]
    pub(super) control: ControlTable,
    pub(super) masses: Option<MassesTable>,
    #[serde(default, skip_serializing_if = "is_default")]
    pub(super) resistances: Resistances,
    #[serde(default)]
    pub(super) analysis: AnalysisTable,
    #[serde(default, skip_serializing_if = "is_default")]
    pub(super) compare: CompareTable,
    #[serde(default, skip_serializing_if = "is_default")]
    pub(super) perception: PerceptionTable,
    #[serde(default, skip_serializing_if = "is_default")]
    pub(super) replay: ReplayTable,
    /// Tables within tables, read by hand (`figures.rs`): a key's name is the beginning of a
    /// figure's id.
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    pub(super) figures: toml::Table,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) scenes: Vec<SceneFigure>,
    pub(super) environments: Vec<EnvironmentTable>,
    pub(super) modes: Vec<Mode>,
    #[serde(default)]
    pub(super) questions: Vec<QuestionTable>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) channels: Vec<Channel>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) people: Vec<PersonColumnTable>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) metrics: Vec<OwnMetric>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) stage: Vec<OwnStage>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) scores: Vec<Score>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) tasks: Vec<TaskTable>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) axes: Option<Axes>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) factors: Vec<Factor>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StudyTable {
    pub(super) id: StudyId,
    pub(super) title: String,
}

#[derive(Serialize, Deserialize, Default, Clone, Copy, PartialEq)]
#[serde(rename_all = "snake_case")]
pub(super) enum CoordinateKind {
    #[default]
    Rotational,
    Linear,
}

#[derive(Serialize, Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct CoordinateTable {
    pub(super) kind: CoordinateKind,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DeviceTable {
    pub(super) name: String,
    pub(super) lever_m: Option<f64>,
    pub(super) theta_min_deg: Option<f64>,
    pub(super) theta_max_deg: Option<f64>,
    pub(super) force_rate_hz: Option<f64>,
}

/// The words of [`VelocityFilter`], without its numbers.
#[derive(Serialize, Deserialize, Clone, Copy, PartialEq)]
#[serde(rename_all = "snake_case")]
pub(super) enum VelocityKind {
    Difference,
    SecondOrder,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct ControlTable {
    pub(super) rate_hz: f64,
    pub(super) let_go_n: f64,
    pub(super) force_limit_n: f64,
    pub(super) velocity: VelocityKind,
    pub(super) velocity_cutoff_hz: Option<f64>,
}

impl From<Control> for ControlTable {
    fn from(c: Control) -> Self {
        let (velocity, velocity_cutoff_hz) = match c.velocity {
            VelocityFilter::Difference => (VelocityKind::Difference, None),
            VelocityFilter::SecondOrder { cutoff_hz } => {
                (VelocityKind::SecondOrder, Some(cutoff_hz))
            }
        };
        let Control { rate_hz, let_go_n, force_limit_n, .. } = c;
        Self { rate_hz, let_go_n, force_limit_n, velocity, velocity_cutoff_hz }
    }
}

impl Default for ControlTable {
    fn default() -> Self {
        // Absent here, so that it is an error where it is given and has no meaning.
        let mut table = Self::from(Control::default());
        table.velocity_cutoff_hz = None;
        table
    }
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MassesTable {
    pub(super) motor_g: f64,
    pub(super) brake_g: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct AnalysisTable {
    pub(super) onset_deg_s: Option<f64>,
    pub(super) offset_deg_s: Option<f64>,
    pub(super) slope_from_deg: Option<f64>,
    pub(super) onset_mm_s: Option<f64>,
    pub(super) offset_mm_s: Option<f64>,
    pub(super) slope_from_mm: Option<f64>,
    pub(super) grid_points: usize,
    pub(super) confidence: f64,
}

impl Default for AnalysisTable {
    fn default() -> Self {
        let Analysis { grid_points, confidence, .. } = Analysis::default();
        Self {
            onset_deg_s: None,
            offset_deg_s: None,
            slope_from_deg: None,
            onset_mm_s: None,
            offset_mm_s: None,
            slope_from_mm: None,
            grid_points,
            confidence,
        }
    }
}

#[derive(Serialize, Deserialize, Default, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub(super) struct ReplayTable {
    pub(super) model: ReplayModel,
}

#[derive(Serialize, Deserialize, Default, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub(super) struct CompareTable {
    pub(super) contrasts: Option<Vec<[ModeId; 2]>>,
    #[serde(deserialize_with = "one_or_several")]
    pub(super) primary: Option<Primary>,
    pub(super) metrics: Option<Vec<MetricId>>,
    pub(super) alpha: Option<f64>,
    pub(super) level: Option<f64>,
    pub(super) families: Option<Families>,
    pub(super) effect_sizes: Option<Vec<EffectSize>>,
    pub(super) curves: Option<Vec<Curve>>,
    pub(super) curve_nodes: Option<usize>,
    pub(super) bounds: BTreeMap<MetricId, BoundTable>,
    pub(super) better: BTreeMap<MetricId, Better>,
    pub(super) groups: Option<PersonColumnId>,
    pub(super) group_contrasts: Option<Vec<[LevelId; 2]>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) covariates: Vec<String>,
    pub(super) effects: Option<Vec<Term>>,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub(super) trend: BTreeMap<FactorId, Trend>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) weighted: Vec<WeightedTable>,
}

#[derive(Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub(super) struct WeightedTable {
    pub(super) id: FactorId,
    /// By `environment/mode`.
    pub(super) weights: BTreeMap<String, f64>,
}

/// A metric or curve, or a list of such. By hand, because an untagged enum does not say what is wrong with an id.
fn one_or_several<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Primary>, D::Error> {
    struct OneOrSeveral;

    impl<'de> Visitor<'de> for OneOrSeveral {
        type Value = Primary;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a metric or a curve, or a list of such")
        }

        fn visit_str<E: de::Error>(self, text: &str) -> Result<Primary, E> {
            text.parse().map(Primary::One).map_err(E::custom)
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Primary, A::Error> {
            let mut metrics = Vec::new();
            while let Some(metric) = list.next_element()? {
                metrics.push(metric);
            }
            Ok(Primary::Several(metrics))
        }
    }

    deserializer.deserialize_any(OneOrSeveral).map(Some)
}

#[derive(Serialize, Deserialize, Clone, Copy, PartialEq)]
#[serde(
    untagged,
    deny_unknown_fields,
    expecting = "a bound is a number in the metric's unit, or { weber = 0.1 }"
)]
pub(super) enum BoundTable {
    Absolute(f64),
    Weber { weber: f64 },
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct QuestionTable {
    pub(super) id: QuestionId,
    pub(super) text: String,
    pub(super) label: Option<String>,
    pub(super) group: Option<String>,
    pub(super) scale: Option<AnswerScale>,
    #[serde(default)]
    pub(super) reversed: bool,
    pub(super) points: Option<i64>,
    pub(super) from: Option<i64>,
    pub(super) step: Option<i64>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) labels: Vec<String>,
    pub(super) asks: Option<Asks>,
}

/// What a question asks for besides a rating.
#[derive(Clone, Copy, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Asks {
    /// Which mode it was.
    Mode,
}
