//! From a study back to the text of its `study.toml`.

use super::environment::EnvironmentTable;
use super::people::PersonColumnTable;
use super::shape::*;
use super::tasks::TaskTable;
use super::units::{MILLI, decimal, degrees};
use crate::model::{Analysis, Coordinate, Study};

impl Study {
    /// The study as `study.toml` text (without comments); [`Study::from_toml`] reads it back.
    #[cfg(test)]
    pub(crate) fn to_toml(&self) -> Result<String, toml::ser::Error> {
        toml::to_string_pretty(&File::from(self))
    }
}

/// The study as the values of its `study.toml`, in the file's units; nothing of a study that cannot
/// be written.
pub(crate) fn value_of(study: &Study) -> toml::Value {
    toml::Value::try_from(File::from(study))
        .unwrap_or_else(|_| toml::Value::Table(toml::Table::new()))
}

impl From<&Study> for File {
    fn from(s: &Study) -> Self {
        Self {
            schema: s.schema.number(),
            study: StudyTable { id: s.id.clone(), title: s.title.clone() },
            design: s.design.clone(),
            coordinate: CoordinateTable {
                kind: match s.coordinate {
                    Coordinate::Rotational => CoordinateKind::Rotational,
                    Coordinate::Linear { .. } => CoordinateKind::Linear,
                },
            },
            device: DeviceTable {
                name: s.device.name.clone(),
                lever_m: s.device.lever_m,
                theta_min_deg: s.device.theta_min_rad.map(degrees),
                theta_max_deg: s.device.theta_max_rad.map(degrees),
                force_rate_hz: s.device.force_rate_hz,
            },
            control: s.control.into(),
            masses: s.masses.map(|m| MassesTable {
                motor_g: decimal(m.motor_kg / MILLI),
                brake_g: decimal(m.brake_kg / MILLI),
            }),
            resistances: s.resistances,
            analysis: analysis_table(&s.analysis, s.coordinate),
            compare: super::compare::table(s),
            perception: super::perception::table(&s.perception),
            replay: ReplayTable { model: s.replay },
            figures: super::figures::table(&s.figures),
            scenes: s.scenes.clone(),
            environments: s
                .environments
                .iter()
                .map(|e| EnvironmentTable::of(e, s.coordinate))
                .collect(),
            modes: s.modes.clone(),
            // Those about pairs follow from the scores, and those of tasks from the tasks.
            questions: s
                .questions
                .iter()
                .filter(|question| !question.is_pair() && !question.is_of_task())
                .map(QuestionTable::of)
                .collect(),
            channels: s.channels.clone(),
            people: s.people.iter().map(PersonColumnTable::of).collect(),
            metrics: s.metrics.clone(),
            stage: s.stages.clone(),
            scores: s.scores.clone(),
            tasks: s.tasks.iter().map(TaskTable::of).collect(),
            axes: s.axes.clone(),
            factors: s.factors.clone(),
        }
    }
}

fn analysis_table(a: &Analysis, coordinate: Coordinate) -> AnalysisTable {
    let mut table = AnalysisTable {
        grid_points: a.grid_points,
        confidence: a.confidence,
        ..AnalysisTable::default()
    };
    match coordinate {
        Coordinate::Rotational => {
            table.onset_deg_s = Some(degrees(a.onset_rad_s));
            table.offset_deg_s = Some(degrees(a.offset_rad_s));
            table.slope_from_deg = Some(degrees(a.slope_from_rad));
        }
        Coordinate::Linear { lever_m } => {
            [table.onset_mm_s, table.offset_mm_s, table.slope_from_mm] =
                [a.onset_rad_s, a.offset_rad_s, a.slope_from_rad]
                    .map(|rad| Some(decimal(rad * lever_m / MILLI)));
        }
    }
    table
}
