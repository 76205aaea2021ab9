//! What a statement says about numbers, as data.

use crate::evidence::{Derived, Place, Stop, Verdict};
use crate::thesis::estimate::Spread;
use zwidth_results::JudgedStatement;
use zwidth_study::{ActuatorKind, Environment, Mode, ModeLaw};

/// Modes are found by their law, environments by what they are.
pub(crate) type Case = (ModeLaw, Place);

/// Which table a number is in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum From {
    /// One row per trial.
    Metrics,
    /// The replays driven by the recorded force.
    Replays,
}

/// A number of each trial.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Quantity {
    pub(crate) words: &'static str,
    pub(crate) from: From,
    pub(crate) column: &'static str,
    /// The column that is taken off it.
    pub(crate) less: Option<&'static str>,
    /// Of the column, in SI.
    pub(crate) unit: &'static str,
}

impl Quantity {
    pub(crate) fn columns(&self) -> impl Iterator<Item = &'static str> + use<> {
        [self.column].into_iter().chain(self.less)
    }
}

/// A range of values between two ends, in SI, and why it is that.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Range {
    pub(crate) low: f64,
    pub(crate) high: f64,
    pub(crate) why: &'static str,
}

/// A range, before it is known which environment it is of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Bound {
    Given(f64, f64, &'static str),
    /// The commanded stiffness, as far as its compliance cannot be told from another.
    Compliance,
    /// More than the just noticeable share of the force that the spring has where the wall begins.
    ForceAtWall,
}

/// What must hold of the trials or answers of one condition.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Test {
    /// The mean lies in the range.
    Mean(Quantity, Bound),
    /// The mean of the statement's own case less that of another one lies in the range.
    Difference(Quantity, Case, Bound),
    /// Every trial has this word in this column.
    Every(&'static str, &'static str, &'static str),
    /// No trial has a value.
    Never(Quantity),
    /// Some trial has more than this.
    Some(Quantity, f64),
    /// Answers are higher than in another mode.
    Superior(ModeLaw),
    /// The median answer is above the middle of its scale, or not.
    Median { favourable: bool },
}

/// What a statement rests on.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Rule {
    /// What was recorded in one condition.
    In(Case, Test),
    /// Other statements, all of which hold.
    All(&'static [&'static str]),
    /// What the calibration or the masses tell.
    Forces(fn(&Derived) -> Result<JudgedStatement, Stop>),
    /// Nothing that is recorded tells.
    Untold(&'static str),
}

impl Rule {
    /// The quantity that it needs of trials, if it needs one.
    pub(crate) fn quantity(&self) -> Option<Quantity> {
        match self {
            Self::In(
                _,
                Test::Mean(quantity, _)
                | Test::Difference(quantity, ..)
                | Test::Never(quantity)
                | Test::Some(quantity, _),
            ) => Some(*quantity),
            _ => None,
        }
    }
}

/// A statement of the thesis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Statement {
    /// Its word, by which others refer to it.
    pub(crate) key: &'static str,
    /// Where the thesis has it.
    pub(crate) source: &'static str,
    pub(crate) text: &'static str,
    pub(crate) rule: Rule,
    /// Whether its number speaks of the thesis' own spring and voltages alone.
    pub(crate) printed: bool,
}

/// The smallest change of a compliance that a finger can tell, with force and work to go by: 8 %
/// (Tan, Pang & Durlach 1992, ASME DSC 42:13).
const COMPLIANCE_JND: f64 = 0.08;
/// The smallest change of a force that a finger can tell, between 2.5 and 10 N: 7 % (Pang, Tan &
/// Durlach 1991, Percept. Psychophys. 49:531).
pub(crate) const FORCE_JND: f64 = 0.07;

/// The thesis' spring, N/rad, and its rest, rad (§5.2.2).
const THESIS_SPRING: (f64, f64) = (4.0, -core::f64::consts::FRAC_PI_4);
/// Numbers of a study.toml are the thesis' up to this share: degrees become radians.
const SAME: f64 = 1e-6;

impl Bound {
    /// The range in this environment; `None` where it has no spring or wall to set it.
    pub(crate) fn range(self, environment: &Environment) -> Option<Range> {
        let scene = &environment.scene;
        match self {
            Self::Given(low, high, why) => Some(Range { low, high, why }),
            Self::Compliance => {
                let commanded = scene.spring()?.stiffness_n_per_rad;
                // c times the compliance is the stiffness over c, so that the larger c comes first.
                let [low, high] =
                    [1.0 + COMPLIANCE_JND, 1.0 - COMPLIANCE_JND].map(|c| commanded / c);
                let why = "compliance within 8 % of that asked for, the just noticeable \
                           difference (Tan 1992)";
                Some(Range { low, high, why })
            }
            Self::ForceAtWall => {
                let spring = scene.spring()?;
                let force_n =
                    spring.stiffness_n_per_rad * (scene.wall_rad()? - spring.rest_rad).abs();
                let why = "7 % of the spring's force at the wall, the just noticeable difference \
                           (Pang 1991)";
                Some(Range { low: FORCE_JND * force_n, high: f64::INFINITY, why })
            }
        }
    }
}

impl Range {
    /// Supported where the whole interval lies in the range, contradicted where none of it does,
    /// else undecided. Values without scatter are judged as they stand; without an interval for
    /// want of values nothing is decided.
    pub(crate) fn judge(&self, value: f64, spread: &Spread) -> Verdict {
        match spread {
            Spread::Interval([low, high]) if self.holds(*low) && self.holds(*high) => {
                Verdict::Supported
            }
            Spread::Interval([low, high]) if *high <= self.low || self.high <= *low => {
                Verdict::Contradicted
            }
            Spread::Equal => Verdict::of(self.holds(value)),
            Spread::Interval(_) | Spread::Unknown(_) => Verdict::Undecided,
        }
    }

    /// Whether a value lies in the range, whose ends do not.
    fn holds(&self, value: f64) -> bool {
        self.low < value && value < self.high
    }
}

/// Whether spring and voltages are those of the thesis, for which its numbers hold (16 V for the
/// motor alone, 8 V for the brake, 8 V each in the hybrid mode; §5.2.2).
pub(crate) fn is_as_in_the_thesis(environment: &Environment, mode: &Mode) -> bool {
    let Some(law) = mode.law() else { return false };
    let motor_v = if law == ModeLaw::Active { 16.0 } else { 8.0 };
    let spring = environment.scene.spring().is_some_and(|spring| {
        is_same(spring.stiffness_n_per_rad, THESIS_SPRING.0)
            && is_same(spring.rest_rad, THESIS_SPRING.1)
    });
    let voltages = [
        (ActuatorKind::Motor, mode.motor_max_v, motor_v),
        (ActuatorKind::Brake, mode.brake_max_v, 8.0),
    ];
    spring
        && voltages.into_iter().all(|(drive, max_v, thesis_v)| {
            !law.uses(drive) || max_v.is_some_and(|max_v| is_same(max_v, thesis_v))
        })
}

fn is_same(value: f64, thesis: f64) -> bool {
    (value - thesis).abs() <= SAME * thesis.abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_decides_only_where_it_lies_inside_or_outside() {
        let range = Range { low: 1.0, high: 2.0, why: "" };
        let of = |low, high| range.judge((low + high) / 2.0, &Spread::Interval([low, high]));
        assert_eq!(of(1.1, 1.9), Verdict::Supported);
        assert_eq!(of(2.1, 3.0), Verdict::Contradicted);
        assert_eq!(of(0.0, 0.9), Verdict::Contradicted);
        assert_eq!((of(1.5, 2.5), of(0.0, 9.0)), (Verdict::Undecided, Verdict::Undecided));
        assert_eq!(range.judge(1.5, &Spread::Equal), Verdict::Supported);
        assert_eq!(range.judge(1.0, &Spread::Equal), Verdict::Contradicted);
        assert_eq!(range.judge(1.5, &Spread::Unknown(String::new())), Verdict::Undecided);
    }

    #[test]
    fn bounds_are_those_of_the_environment() {
        let study = zwidth_testing::study();
        let range = |bound: Bound, i: usize| bound.range(&study.environments[i]);
        let stiffness = range(Bound::Compliance, 0).unwrap();
        assert!((1.0 / stiffness.low - 0.27).abs() < 1e-12, "{stiffness:?}");
        assert!((1.0 / stiffness.high - 0.23).abs() < 1e-12, "{stiffness:?}");
        let force = range(Bound::ForceAtWall, 1).unwrap();
        assert!((force.low - 0.07 * 4.0 * 71.6_f64.to_radians()).abs() < 1e-12, "{force:?}");
        assert_eq!(range(Bound::ForceAtWall, 0), None);
    }

    #[test]
    fn printed_numbers_belong_to_the_thesis_own_spring_and_voltages() {
        let study = zwidth_testing::study();
        let spring = &study.environments[0];
        assert!(study.modes.iter().all(|mode| is_as_in_the_thesis(spring, mode)));
        let weak = Mode { motor_max_v: Some(12.0), ..study.modes[0].clone() };
        assert!(!is_as_in_the_thesis(spring, &weak));
    }
}
