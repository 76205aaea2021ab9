//! What a study compares: contrasts of modes, metrics, what difference would matter.

use crate::words::words;
use crate::{FactorId, IdError, LevelId, MetricId, ModeId, PersonColumnId, Term, Trend, Weighted};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

/// `[compare]` of a study, with its defaults put in: what is compared, set before the data.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Compare {
    /// Pairs of modes; by default the last mode against each other one.
    pub contrasts: Vec<Contrast>,
    /// The metrics and curves whose claims count, at least one; the claims of every other are exploratory.
    pub primary: Primary,
    /// Whether study.toml names it. No number depends on it.
    #[serde(skip)]
    pub is_primary_named: bool,
    /// The other metrics; `None` for those of the stage.
    pub metrics: Option<Vec<MetricId>>,
    /// What difference is too small to matter, by metric.
    pub bounds: BTreeMap<MetricId, Bound>,
    /// Which way is better, by metric, where the study says other than is usual for the metric.
    pub better: BTreeMap<MetricId, Better>,
    /// A claim counts where its adjusted p value is below this.
    pub alpha: f64,
    /// Level of the intervals, as a fraction; by default that of the analysis.
    pub level: f64,
    /// Which contrasts of a metric are claimed together.
    pub families: Families,
    /// Sizes of differences without unit that are given, each once.
    pub effect_sizes: Vec<EffectSize>,
    /// Curves that are compared as a whole, each once.
    #[serde(skip)]
    pub curves: Vec<Curve>,
    /// Nodes of each of their branches.
    #[serde(skip)]
    pub curve_nodes: usize,
    /// The groups of people that are compared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub groups: Option<GroupsCompared>,
    /// Numbers of people with which differences between modes may change.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub covariates: Vec<PersonColumnId>,
    /// What everybody's means are adjusted over, by a line of their own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub over: Option<OverTrials>,
    /// Factors and interactions whose effects are compared.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<Term>,
    /// How doses are compared, where not by a line.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub trend: BTreeMap<FactorId, Trend>,
    /// Contrasts between any conditions.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub weighted: Vec<Weighted>,
}

/// The difference of two modes: `mode` − `against`.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct Contrast {
    /// The mode that is compared.
    pub mode: ModeId,
    /// The mode that it is compared with.
    pub against: ModeId,
}

impl Contrast {
    /// Between the two modes of a contrast, in a text. No id has a space.
    pub const MINUS: &str = " − ";
    /// The same where their difference is read as a ratio.
    pub const OVER: &str = " / ";
}

impl fmt::Display for Contrast {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}{}", self.mode, Self::MINUS, self.against)
    }
}

impl FromStr for Contrast {
    type Err = IdError;

    fn from_str(text: &str) -> Result<Self, IdError> {
        // Without the sign the second text is empty, which is no id: that is the error.
        let (mode, against) = text.split_once(Self::MINUS).unwrap_or((text, ""));
        Ok(Self { mode: mode.parse()?, against: against.parse()? })
    }
}

/// `[compare]` of a study whose people are of several groups.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct GroupsCompared {
    /// The column of people whose levels are the groups.
    pub column: PersonColumnId,
    /// The groups, in the order of `study.toml`.
    pub levels: Vec<LevelId>,
    /// Whether chance chose everybody's group.
    pub assigned: bool,
    /// Pairs of groups; by default each later group against the first one.
    pub contrasts: Vec<GroupContrast>,
}

/// The difference of two groups of people: `group` − `against`.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct GroupContrast {
    /// The group that is compared.
    pub group: LevelId,
    /// The group that it is compared with.
    pub against: LevelId,
}

impl fmt::Display for GroupContrast {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}{}", self.group, Contrast::MINUS, self.against)
    }
}

impl FromStr for GroupContrast {
    type Err = IdError;

    fn from_str(text: &str) -> Result<Self, IdError> {
        // Without the sign the second text is empty, which is no id: that is the error.
        let (group, against) = text.split_once(Contrast::MINUS).unwrap_or((text, ""));
        Ok(Self { group: group.parse()?, against: against.parse()? })
    }
}

/// Differences within ± this are too small to matter.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Bound {
    /// A number in the metric's unit, which its name ends in.
    Absolute(f64),
    /// A share of the commanded value: the Weber fraction of the just noticeable difference.
    Weber(f64),
}

words! {
    /// Which values of a metric are better.
    Better {
        /// Those nearer to zero, such as those of an error.
        Lower = "lower",
        /// The higher ones.
        Higher = "higher",
        /// Neither: a difference is only a difference.
        Neither = "neither",
    }

    /// A size of a difference between two modes without unit.
    EffectSize {
        /// In standard deviations of people within a mode, without bias where people are few.
        GAv = "g_av",
        /// In those of people's differences, without bias.
        GZ = "g_z",
        /// As `g_av`, as the sample has it.
        DAv = "d_av",
        /// As `g_z`, as the sample has it.
        DZ = "d_z",
    }

    /// What of trials everybody's line is over, besides the modes.
    OverTrials {
        /// The number of the trial in its session.
        Trial = "trial",
        /// The repeat of its condition.
        Repeat = "repeat",
    }

    /// A course of repeats' means that is compared as a whole.
    Curve {
        /// The user's force over the angle, there and back.
        ForceOverAngle = "force_over_angle",
        /// The user's force over the time since movement onset.
        ForceOverTime = "force_over_time",
        /// The angle over the time since movement onset.
        ThetaOverTime = "theta_over_time",
        /// The angular velocity over the angle, there and back.
        VelocityOverAngle = "velocity_over_angle",
    }
}

impl Curve {
    /// The unit of its values.
    pub const fn unit(self) -> &'static str {
        match self {
            Self::ForceOverAngle | Self::ForceOverTime => "N",
            Self::ThetaOverTime => "rad",
            Self::VelocityOverAngle => "rad/s",
        }
    }

    /// Whether it is over the angle; else over the time.
    pub const fn is_over_angle(self) -> bool {
        matches!(self, Self::ForceOverAngle | Self::VelocityOverAngle)
    }
}

/// The metrics and whole curves whose claims count, in the order of study.toml, which names one without a list.
/// No metric has the name of a curve.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub enum Primary {
    /// One, as in most studies.
    One(MetricId),
    /// Several.
    Several(Vec<MetricId>),
}

impl Primary {
    /// What study.toml names, curves among metrics.
    pub fn names(&self) -> &[MetricId] {
        match self {
            Self::One(name) => std::slice::from_ref(name),
            Self::Several(names) => names,
        }
    }

    /// The metrics.
    pub fn metrics(&self) -> impl Iterator<Item = &MetricId> {
        self.names().iter().filter(|name| Curve::from_word(name.as_str()).is_none())
    }

    /// The whole curves.
    pub fn curves(&self) -> impl Iterator<Item = Curve> {
        self.names().iter().filter_map(|name| Curve::from_word(name.as_str()))
    }

    /// Whether there is more than one.
    pub fn are_several(&self) -> bool {
        self.names().len() > 1
    }

    /// Whether the metric or curve of that name is one of them.
    pub fn has(&self, name: &str) -> bool {
        self.names().iter().any(|own| own.as_str() == name)
    }
}

/// Which contrasts are one family, adjusted together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Families {
    /// Those of one metric, over all environments.
    #[default]
    Metric,
    /// Those of one metric in one environment.
    Environment,
    /// Those of all primary metrics and curves over all environments; every other metric or curve is a family of its own.
    Study,
}

impl Compare {
    /// Effect sizes if a study does not choose any.
    pub const EFFECT_SIZES: [EffectSize; 1] = [EffectSize::GAv];

    /// Curves if a study does not choose any.
    pub const CURVES: [Curve; 1] = [Curve::ForceOverAngle];

    /// Nodes of a branch of a curve if a study does not choose any number.
    pub const CURVE_NODES: usize = 101;

    /// The level of significance if a study does not give one.
    pub const ALPHA: f64 = 0.05;
}
