//! The words of a study: ids, modes, environments, conditions, trials, design; `study.toml` read
//! and written; the order of the trials, and its seal. It uses no files and no clock: text in,
//! values out.
//!
//! Angles are radians and everything else is SI in memory; `study.toml` uses degrees and
//! millimetres as people do, and its keys end in their unit.

mod answer;
mod axes;
mod calibration;
mod changes;
mod compare;
mod control;
mod counted;
mod drawn;
mod effects;
mod event;
mod factors;
mod figures;
mod file;
mod form;
mod id;
mod label;
mod law;
mod level_contrast;
mod locate;
mod model;
pub mod order;
mod outside;
mod own_metric;
mod own_stage;
mod people;
mod perception;
mod printable;
mod random;
mod replay;
mod sample;
mod scale;
mod scene;
mod scene_figure;
mod score;
mod seal;
mod session;
mod setup;
mod task;
mod task_order;
mod template;
mod threshold;
mod trial;
mod words;

pub use answer::{AnswerValue, NoAnswer};
pub use axes::Axes;
pub use calibration::{
    Basis, Calibration, CalibrationError, CalibrationFile, CalibrationOrigin, Characteristic,
    ForceInterval,
};
pub use changes::{Affects, StudyChange, study_changes};
pub use compare::{
    Better, Bound, Compare, Contrast, Curve, EffectSize, Families, GroupContrast, GroupsCompared,
    OverTrials, Primary,
};
pub use control::{Control, VelocityFilter};
pub use counted::counted;
pub use effects::{DoseCurve, Effect, WithinLevel};
pub use event::{Event, Given, Moment, SealedTrial};
pub use factors::{DoseScale, Factor, FactorOf, Levels, Term, Trend, Weight, Weighted};
pub use figures::{Alignment, Figures, OwnFigures};
pub use form::{CURRENT_BRAKE, CURRENT_MOTOR, Channel, REFERENCE, Schema, TrialForm};
pub use id::{
    ActuatorId, ChannelId, EnvironmentId, ExperimenterId, FactorId, IdError, LevelId, MetricId,
    ModeId, ParticipantId, PersonColumnId, QuestionId, SceneFigureId, SessionId, StageId, StreamId,
    StudyId,
};
pub use label::{contrast_label, curve_label, in_a_sentence, ratio_label};
pub use law::{ActuatorKind, ModeLaw};
pub use level_contrast::{LevelContrast, OverDose};
pub use locate::{line_of, toml_error};
pub use model::{
    Analysis, Condition, Coordinate, Design, Device, Environment, Masses, Mode, OrderScheme,
    Question, Resistances, Study,
};
pub use outside::{OutsideMetric, is_unit, unit_in_names};
pub use own_metric::{OwnMetric, Statistic, TrialPart};
pub use own_stage::{GivenFigure, GivenMetric, OwnStage, StageFormat, command_line};
pub use people::{Known, People, PeopleForm, Person, PersonColumn, PersonValue};
pub use perception::{Measured, MeasuredJnd, Perception, VibrationCurve, is_felt};
pub use printable::{printable, printable_lines};
pub use replay::ReplayModel;
pub use sample::{Extra, Flags, MOST_CHANNELS, Sample, Voltages};
pub use scale::{AnswerScale, NumberScale};
pub use scene::{ForceLaw, Scene, SceneKind, Spring};
pub use scene_figure::{SceneDrawing, SceneFigure};
pub use score::{Score, ScoreKind};
pub use seal::{Seal, SealError};
pub use session::{AskedPair, Check, OrderRecord, PlannedTrial, SessionRecord};
pub use setup::Setup;
pub use task::{
    Asks, Method, Presented, StaircasePlan, Task, TaskEstimate, TaskFit, TaskLevel, TaskPlace,
    TaskSigmoid, axis,
};
pub use template::{template, template_of_imports};
pub use threshold::TaskQuantity;
pub use trial::{Kind, Source, Status, TrialMeta};

/// The one version of session records that this software writes and reads.
pub const RECORD_VERSION: u32 = 1;

/// One thing wrong in a `study.toml`: where, what, and how to mend it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {}: {}", printable(key), printable(problem))]
pub struct StudyError {
    /// Line in the file, from 1.
    pub line: usize,
    /// The key, as a path: `environments[1].wall_deg`.
    pub key: String,
    /// What is wrong, with the value and the remedy.
    pub problem: String,
}

#[cfg(test)]
mod tests {
    //! What the tests of several files share.

    use crate::{Study, StudyError, template};

    /// The template's text.
    pub(crate) fn text() -> String {
        template(&"demo".parse().unwrap())
    }

    /// The template's study.
    pub(crate) fn demo() -> Study {
        Study::from_toml(&text()).unwrap()
    }

    /// The template's study with a section more, and these lines in it.
    pub(crate) fn with(section: &str, lines: &str) -> Result<Study, Vec<StudyError>> {
        Study::from_toml(&format!("{}\n{section}\n{lines}\n", text()))
    }

    /// The template's study in schema 3, whose spring asks nothing, with a task of these keys.
    pub(crate) fn with_task(keys: &str) -> Result<Study, Vec<StudyError>> {
        let three = text().replacen("schema = 2", "schema = 3", 1);
        let silent = three.replacen("question = \"felt_spring\"\n", "", 1);
        Study::from_toml(&format!("{silent}\n[[tasks]]\n{keys}\n"))
    }

    /// The keys of a task of constant stimuli.
    pub(crate) const CONSTANT: &str = "id = \"stiffer\"\ntext = \"Which one was stiffer?\"\nasks = \"2ifc\"\n\
        environment = \"spring\"\nvaries = \"stiffness_n_per_rad\"\nstandard = 4.0\nmethod = \"constant\"\n\
        levels = [2.8, 3.2, 3.6, 4.0, 4.4, 4.8, 5.2]\ntrials = 20";

    /// The template's study with questions `q1` to `q6`, and their pairs as weights of a score; these keys among the
    /// score's.
    pub(crate) fn with_pairs(keys: &str) -> Study {
        let questions =
            (1..=6).map(|i| format!("[[questions]]\nid = \"q{i}\"\ntext = \"Question {i}\"\n"));
        let questions: String = questions.collect();
        let list = (1..=6).map(|i| format!("\"q{i}\"")).collect::<Vec<_>>().join(", ");
        let score = format!("id = \"load\"\nkind = \"nasa_tlx\"\nquestions = [{list}]\n{keys}");
        with(&questions, &format!("[[scores]]\n{score}")).unwrap()
    }

    #[track_caller]
    pub(crate) fn check_round_trip(study: &Study) {
        assert_eq!(Study::from_toml(&study.to_toml().unwrap()).unwrap(), *study);
    }

    /// A text is refused with one error: for this key, in these words, and not on its first line.
    #[track_caller]
    pub(crate) fn check_refused(read: Result<Study, Vec<StudyError>>, key: &str, words: &str) {
        let errors = read.unwrap_err();
        assert_eq!(errors.len(), 1, "{errors:?}");
        assert_eq!(errors[0].key, key, "{}", errors[0]);
        assert!(errors[0].problem.contains(words) && errors[0].line > 1, "{}", errors[0]);
    }
}
