//! The parameters of a comparison, besides the table of metrics.

use crate::{Preregistered, SessionOrder};
use serde::Serialize;
use std::collections::BTreeMap;
use zwidth_results::Role;
use zwidth_study::{
    Better, Contrast, DoseCurve, Effect, EffectSize, EnvironmentId, Families, GroupsCompared,
    MetricId, ModeId, OverTrials, ParticipantId, Perception, PersonColumnId,
};

/// The parameters of a comparison.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parameters {
    /// The metrics, the primary ones first where trials have them.
    pub metrics: Vec<MetricParameters>,
    /// The environments, in the study's order.
    pub environments: Vec<EnvironmentId>,
    /// The modes, in the study's order.
    pub modes: Vec<ModeId>,
    /// The contrasts.
    pub contrasts: Vec<Contrast>,
    /// Which of them are adjusted together.
    pub families: Families,
    /// How many claims on whole curves are of one family with those of primary metrics, at most.
    pub curve_claims: usize,
    /// A claim needs an adjusted p value below this.
    pub alpha: f64,
    /// Level of every interval, as a fraction.
    pub level: f64,
    /// Sizes without unit that differences have.
    pub effect_sizes: Vec<EffectSize>,
    /// The groups of people that are compared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub groups: Option<Groups>,
    /// Numbers of people with which differences may change.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub covariates: Vec<Covariate>,
    /// What everybody's means are adjusted over, by a line of their own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub over: Option<OverTrials>,
    /// Effects of factors, and weighted contrasts.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<Effect>,
    /// Curves over those of the factors that are doses.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub dose_curves: Vec<DoseCurve>,
    /// The orders of the sessions, and how they were drawn.
    pub orders: Vec<SessionOrder>,
}

/// Groups of people.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Groups {
    /// What the study says of them.
    pub compared: GroupsCompared,
    /// The place of everybody's group among the levels, where it is known.
    pub levels_of: BTreeMap<ParticipantId, usize>,
    /// The block of the drawing in which chance gave everybody their group; empty unless it gave everybody's.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub blocks: BTreeMap<ParticipantId, u32>,
}

/// A number of people.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Covariate {
    /// Its column.
    pub column: PersonColumnId,
    /// Its unit.
    pub unit: String,
    /// Everybody's, where it is known.
    pub numbers: BTreeMap<ParticipantId, f64>,
}

/// The parameters of the comparison of one metric.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MetricParameters {
    /// Its column in the table of metrics.
    pub metric: MetricId,
    /// Whether it is a primary metric of the study. The claims of every other one are exploratory.
    pub primary: bool,
    /// Where another program computed it and it was chosen after the data: that, in words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chosen_after: Option<String>,
    /// Which values of it are better.
    pub better: Better,
    /// What the study's plan says about this analysis, if there is a plan.
    pub preregistered: Option<Preregistered>,
    /// For each environment the size up to which differences are equivalent, in the metric's SI
    /// unit, where the study says so.
    pub bounds: Vec<Option<f64>>,
    /// The just noticeable difference of the metric; `None` if nobody feels it.
    pub noticed: Option<Noticed>,
}

/// From which difference on a metric is noticed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Noticed {
    /// Just noticeable differences of the study.
    pub perception: Perception,
    /// Length of the lever, m; 0 without one.
    pub lever_m: f64,
    /// Whether positions are those of a slide: the just noticeable movement is known for joints,
    /// not for slides.
    pub is_slide: bool,
    /// For each environment, the value of the metric that it commands, if any.
    pub commanded: Vec<Option<f64>>,
}

impl MetricParameters {
    /// What a study says of it.
    pub(crate) fn role(&self) -> Role {
        match (self.primary, &self.chosen_after) {
            (true, _) => Role::Primary,
            (false, None) => Role::Exploratory,
            (false, Some(_)) => Role::ChosenAfter,
        }
    }

    /// The size up to which differences in an environment are equivalent; over several environments (none) where each
    /// has the same.
    pub(crate) fn bound(&self, environment: Option<usize>) -> Option<f64> {
        match environment {
            Some(place) => self.bounds[place],
            None => self.bounds[0].filter(|_| self.bounds.iter().all(|own| *own == self.bounds[0])),
        }
    }
}

impl Noticed {
    /// The just noticeable difference from a mode of that `mean`, in the metric's unit: where a
    /// value is commanded, from that. Over several environments (none) it is known where none commands a value.
    pub(crate) fn jnd(&self, environment: Option<usize>, mean: f64, unit: &str) -> Option<f64> {
        let from = match environment {
            Some(place) => self.commanded[place].unwrap_or(mean),
            None if self.commanded.iter().all(Option::is_none) => mean,
            None => return None,
        };
        let jnd = self.perception.bound(from, unit, self.lever_m);
        let jnd = jnd.filter(|_| !(self.is_slide && matches!(unit, "rad" | "m")));
        // Differences are divided by it, and a share of 0 is 0.
        jnd.filter(|jnd| *jnd > 0.0 && jnd.is_finite())
    }
}

impl Parameters {
    /// Whether claims rest on several metrics.
    pub(crate) fn has_several_primary(&self) -> bool {
        self.metrics.iter().filter(|metric| metric.primary).count() > 1
    }

    /// The places of an environment and a mode, where the study has them.
    pub(crate) fn condition(
        &self,
        environment: &EnvironmentId,
        mode: &ModeId,
    ) -> Option<[usize; 2]> {
        let environment = self.environments.iter().position(|e| e == environment)?;
        Some([environment, self.modes.iter().position(|m| m == mode)?])
    }

    /// The places of the two modes of a contrast.
    pub(crate) fn modes_of(&self, contrast: &Contrast) -> Option<[usize; 2]> {
        let mode = self.modes.iter().position(|m| *m == contrast.mode)?;
        Some([mode, self.modes.iter().position(|m| *m == contrast.against)?])
    }
}
