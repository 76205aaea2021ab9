//! What the stages find, as types: one struct for each derived table.
//!
//! A field is a column: its name, which ends in its unit, its unit and its meaning are declared
//! once, beside it (`rows!`). A stage returns rows, a figure or a sentence is made of rows, and a
//! file has their columns ([`Row::columns`], [`Row::read`]). A value from a small set is an enum,
//! and a name is an id: no code reads a word to learn its meaning.
//!
//! | rows | key | made by | read by |
//! |---|---|---|---|
//! | [`TrialKey`], the first columns of `metrics` | participant, session, trial | `metrics` | `compare`, report, page |
//! | [`ConditionTrials`], the first columns of `conditions` | participant, session, environment, mode | `metrics` | printed tables |
//! | [`TrialEvent`] | participant, session, trial, place | `metrics` | page |
//! | [`TrialRemark`] | file, place | `metrics` | summary, page, `trials` |
//! | [`OutsideValue`] | participant, session, trial | `zwidth metric` and `stage`, a table for each metric | `metrics` |
//! | [`CountedTrial`] | participant, session, trial | `trials` | other programs |
//! | [`AveragePoint`], read as [`AveragedTime`] too, with columns for each signal | participant, session, environment, mode, time | `average` | figures, page |
//! | [`LoopPoint`], read as [`LoopAngle`] too, with columns for each load | participant, session, environment, mode, branch, angle | `average` | `average`, figures |
//! | [`ParticipantsLoopPoint`], read as [`LoopAngle`], with columns for each load | branch, angle | `average` | figures |
//! | [`Compared`] | metric | `compare` | figures, page, summary, printed tables |
//! | [`Cell`] | metric, participant, session, environment, mode | `compare` | figures |
//! | [`Mean`] | metric, environment, mode | `compare` | figures, page, summary |
//! | [`ModeDifference`] | metric, environment, contrast | `compare` | figures, page, summary, `power` |
//! | [`PrintedDifference`] | metric, environment, contrast | `compare` | printed tables |
//! | [`Omnibus`] | metric, environment | `compare` | printed tables |
//! | [`Model`] | metric, environment, contrast | `compare` | `power` |
//! | [`ProgramDifference`] | metric, environment, contrast, program | `zwidth compare --peers` | printed tables |
//! | [`PersonDifference`] | metric, environment, contrast, participant | `compare` | figures |
//! | [`CovariateSlope`] | metric, environment, contrast, covariate | `compare` | printed tables |
//! | [`TrialSlope`] | metric, environment | `compare` | printed tables |
//! | [`GroupMember`] | participant | `compare` | figures, page |
//! | [`PersonValue`] | metric, environment, effect, participant | `compare` | page |
//! | [`GroupMean`] | metric, environment, mode, group | `compare` | figures, printed tables |
//! | [`GroupModeDifference`] | metric, environment, contrast, group | `compare` | printed tables |
//! | [`GroupDifference`] | metric, environment, effect, groups | `compare` | figures, page, summary |
//! | [`PersonCount`] | column, level | `compare` | printed tables |
//! | [`GroupModel`] | metric, environment, effect, groups | `compare` | printed tables |
//! | [`GroupModelTest`] | metric, environment | `compare` | printed tables |
//! | [`AnyGroup`] | metric, environment, effect | `compare` | printed tables |
//! | [`EffectDifference`] | metric, environment, effect, levels | `compare` | figures, summary |
//! | [`FactorTest`] | metric, environment, effect | `compare` | summary, printed tables |
//! | [`DoseModel`] | metric, environment, effect | `compare` | printed tables |
//! | [`DosePoint`] | metric, environment, effect, level, group, dose | `compare` | figures, printed tables |
//! | [`CurveNode`] | curve, environment, effect, groups, branch, angle or time | `compare` | figures |
//! | [`CurveDifference`] | curve, environment, effect, groups | `compare` | figures, summary, printed tables |
//! | [`CurveRun`] | curve, environment, effect, branch, angle or time | `compare` | figures, summary, printed tables |
//! | [`SessionChange`] | metric, environment, mode, sessions | `compare` | figures, summary |
//! | [`Learning`] | metric, environment, mode | `compare` | printed tables |
//! | [`RepeatMean`] | metric, environment, mode, repeat | `compare` | figures |
//! | [`OrderTest`] | metric, environment, effect | `compare` | printed tables |
//! | [`RedrawnDifference`] | metric, environment, contrast, place | `compare` | figures |
//! | [`AnswerDifference`] | question, environment, contrast | `compare` | figures, printed tables |
//! | [`PersonSuperiority`] | question, environment, contrast, participant | `compare` | figures |
//! | [`TrialScore`] | score, participant, session, trial | `likert` | `compare`, printed tables |
//! | [`Reliability`] | score, environment, mode, session | `likert` | printed tables |
//! | [`Relation`] | metric, environment, question or score | `compare` | printed tables |
//! | [`MetricNote`] | metric, table, place | `compare` | figures, summary, printed tables |
//! | [`LadderModel`] | scene, terms | `ladder` | figures, the choice's own fit |
//! | [`TermEffect`] | scene, quantity, term | `ladder` | figures |
//! | [`TermPair`] | scene, quantity, two terms | `ladder` | nothing but the file |
//! | [`HeldOutModel`] | condition, model | `ladder` | `ladder`, `replay` |
//! | [`LadderChoice`] | condition | `ladder` | summary, printed tables |
//! | [`TradeSetting`] | scene, model, solver, step or tolerance | `trade` | figures, printed tables |
//! | [`TradeChoice`] | scene, model | `trade` | figures, summary, printed tables |
//! | [`TradeMetric`] | scene, solver, step or tolerance, metric | `zwidth trade` | nothing but the file |
//! | [`JudgedTrajectory`] | scene, trajectory | `zwidth judge`, `zwidth trade` | figures |
//! | [`TrajectoryFault`] | scene, trajectory, fault, event | `zwidth judge`, `zwidth trade` | nothing but the file |
//! | [`SolverCreep`] | scene, solver, step or tolerance | `zwidth trade` | nothing but the file |
//! | [`RunTime`] | solver, step or tolerance | `zwidth trade` | nothing but the file |
//! | [`MetricShift`] | condition, what is less, metric | `trade`, `zwidth trade` | figures |
//! | [`SetupSummary`] | setup | `zwidth trade` | `zwidth trade` |
//! | [`WallCell`] | place on a map | `zwidth stability` | nothing but the file |
//! | [`LimitPoint`] | map, limit, piece, place | `zwidth stability` | figures |
//! | [`StiffestWall`] | limit | `zwidth stability` | `zwidth stability` |
//! | [`BoundaryExtent`] | boundary | `zwidth stability` | nothing but the file |
//! | [`WallBound`] | mode, push, damping | `zwidth characterise` | figures |
//! | [`ZWidth`] | mode, push | `zwidth characterise` | nothing but the file |
//! | [`ImpedancePoint`] | environment, mode, frequency | `zwidth characterise` | figures |
//! | [`FittedModel`] | model, a table for each actuator | `characterise` | figures, calibration, printed tables |
//! | [`FittedParameter`] | model, branch, parameter | `characterise` | figures, calibration, printed tables |
//! | [`CurvePoint`] | branch, command | `characterise` | figures, calibration |
//! | [`PlantEstimate`] | parameter | `identify` | replay, metrics, page, printed tables |
//! | [`PlantCovariance`] | parameter, other | `identify` | metrics, printed tables |
//! | [`PlantProfile`] | parameter, value | `identify` | printed tables |
//! | [`ThresholdBracket`] | threshold | `identify` | printed tables |
//! | [`HeldOutError`] | environment, mode | `identify` | printed tables |
//! | [`PlantTrialError`] | participant, session, trial | `identify` | printed tables |
//! | [`FreePlane`] | participant, session, trial | `freemotion` | figures, printed tables |
//! | [`FreePlant`] | participant, session, trial | `freemotion` | printed tables |
//! | [`GivenAnswer`] | participant, session, trial, question | `likert` | `compare`, figures, page, statements, printed tables |
//! | [`AnswerTally`] | environment, mode, question or group | `likert` | figures, summary, statements, printed tables |
//! | [`BlindingIndex`] | participant, mode | `likert` | printed tables |
//! | [`Presentation`] | participant, session, trial | `thresholds` | figures, printed tables |
//! | [`LevelTally`] | participant, session, task, mode, level | `thresholds` | figures, printed tables |
//! | [`FittedShare`] | participant, session, task, mode, level | `thresholds` | figures |
//! | [`PsychometricFit`] | participant, session, task, mode | `thresholds` | `compare`, figures, summary, printed tables |
//! | [`PeopleThreshold`] | task, quantity, mode or contrast | `thresholds` | summary, printed tables |
//! | [`ReplayedTrial`], read as [`ReplayedPeak`] too | participant, session, trial, model, causality | `replay` | courses, agreement, statements, printed tables |
//! | [`ReplayAgreement`] | causality, mode, model, quantity | `replay` | printed tables |
//! | [`CourseSample`] | mode, series, place | `replay` | figures, page |
//! | [`PlantRun`] | mode, plant, place | `replay` | page |
//! | [`ModelSample`], with a column for each term | place | `simulate`, `zwidth simulate` | figures |
//! | [`ModelEvent`] | time | `zwidth simulate` | nothing but the file |
//! | [`BowTieSample`] | place | `simulate`, `zwidth simulate` | figures |
//! | [`ChatteringRun`] | solver, step | `zwidth simulate` | figures |
//! | [`TrialOscillation`] | participant, session, trial | `zwidth stability` | nothing but the file |
//! | [`FigurePoint`] | panel, layer, place | `figures` | nothing but the file |
//! | [`JudgedStatement`] | statement | `report` | summary, page, printed tables |
//! | [`ProOrCon`] | actuation, claim | `report` | printed tables |
//! | [`ModeForces`] | mode | `report` | printed tables |
//! | [`Component`] | component | `report` | printed tables |
//! | [`Fact`], of device, model and weight | quantity | `report` | printed tables |

mod answers;
mod average;
mod characteristic;
mod claims;
mod column;
mod comparison;
mod curves;
mod effects;
mod figure;
mod free_motion;
mod groups;
mod identification;
mod judged;
mod ladder;
mod model_run;
mod note;
mod psychometric;
mod replay;
mod row;
mod sentence;
mod stability;
mod trade;
mod trial;
mod value;

pub use answers::*;
pub use average::*;
pub use characteristic::*;
pub use claims::*;
pub use column::{Column, Field, Scalar, Type, UNIT_OF_ROW, Values};
pub use comparison::*;
pub use curves::*;
pub use effects::{DoseModel, DosePoint, EffectDifference, EffectLevels, FactorEffect, FactorTest};
pub use figure::*;
pub use free_motion::*;
pub use groups::*;
pub use identification::*;
pub use judged::*;
pub use ladder::*;
pub use model_run::*;
pub use note::NoteKind;
pub use psychometric::*;
pub use replay::*;
pub use row::{ReadError, Row};
pub use sentence::Sentence;
pub use stability::*;
pub use trade::*;
pub use trial::*;
pub use value::{NoSuchText, Value};
