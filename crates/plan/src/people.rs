//! Stage `compare`, of people themselves: how many there are of each level, and how their numbers are spread.

use crate::compare::{STAGE, took_part};
use crate::shared::handle::{Derived, write_named};
use crate::shared::making::derived;
use crate::tables::printed::Printed;
use serde::Serialize;
use zwidth_numerics::moments::Moments;
use zwidth_results::PersonCount;
use zwidth_runner::{Inputs as _, Job, JobError, Made, Making};
use zwidth_store::StudyData;
use zwidth_study::{Known, LevelId, ParticipantId, PersonColumnId};
use zwidth_tables::Table;

/// Of fewer people nothing is said: who knows one of them could learn the rest.
const LEAST_TOLD: usize = 3;

/// What is known of those who took part, without whom it is known of.
#[derive(Debug, Serialize)]
struct Counting {
    columns: Vec<Counted>,
    participants: usize,
    simulated: bool,
}

/// What is known in a column.
#[derive(Debug, Serialize)]
enum Counted {
    /// How many are of each level.
    Levels(PersonColumnId, Vec<(LevelId, usize)>),
    /// The numbers of those whose is known, from the smallest on, and their unit.
    Numbers(PersonColumnId, Vec<f64>, String),
}

/// The table, if the study names a column of people, and somebody took part.
pub(crate) fn of_study(data: &StudyData) -> Option<Derived<PersonCount>> {
    let is_any = !data.study.people.is_empty() && !took_part(data).is_empty();
    is_any.then(|| Derived::within(&derived(&data.layout, "compare")))
}

/// The table as people read it.
pub(crate) fn tables(data: &StudyData) -> Vec<Printed> {
    of_study(data).iter().map(|table| Printed::without_empty_columns(table.path())).collect()
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let Some(result) = of_study(data) else { return Vec::new() };
    let people = took_part(data);
    let columns = data.study.people.iter().map(|column| match &column.known {
        Known::Level { levels, .. } => {
            let of = |level: &LevelId| {
                let is_of =
                    |who: &&&ParticipantId| data.people.level(who, &column.id) == Some(level);
                (level.clone(), people.iter().filter(is_of).count())
            };
            Counted::Levels(column.id.clone(), levels.iter().map(of).collect())
        }
        Known::Number { unit } => {
            let numbers = people.iter().filter_map(|who| data.people.number(who, &column.id));
            let mut numbers: Vec<f64> = numbers.collect();
            numbers.sort_by(f64::total_cmp);
            Counted::Numbers(column.id.clone(), numbers, unit.clone())
        }
    });
    let trials = data.counting().any(|trial| trial.meta.source.is_simulated());
    let parameters = Counting {
        columns: columns.collect(),
        participants: people.len(),
        simulated: trials || data.sessions.iter().any(|log| log.record.source.is_simulated()),
    };
    vec![Job::new(STAGE, "compare people", parameters, (), result.files(), make)]
}

fn make(parameters: &Counting, _: &(), making: &Making) -> Result<Made, JobError> {
    let mut rows = Vec::new();
    for column in &parameters.columns {
        match column {
            Counted::Levels(id, levels) => rows.extend(levels.iter().map(|(level, n)| {
                let is_told = *n == 0 || *n >= LEAST_TOLD;
                PersonCount {
                    column: id.clone(),
                    level: Some(level.clone()),
                    unit: None,
                    n: is_told.then_some(*n),
                    mean: None,
                    sd: None,
                    remark: too_few(is_told),
                }
            })),
            Counted::Numbers(id, numbers, unit) => {
                let is_told = numbers.len() >= LEAST_TOLD;
                let moments = is_told.then(|| Moments::of(numbers));
                rows.push(PersonCount {
                    column: id.clone(),
                    level: None,
                    unit: Some(unit.clone()),
                    n: (is_told || numbers.is_empty()).then_some(numbers.len()),
                    mean: moments.as_ref().map(|moments| moments.mean),
                    sd: moments.and_then(|moments| moments.sd()),
                    remark: too_few(is_told || numbers.is_empty()),
                });
            }
        }
    }
    let of_all = format!(
        "Of {} who took part; n: of whom it is known.",
        zwidth_study::counted(parameters.participants, "participants")
    );
    write_named(vec![Table::of_rows(&rows)?.with_note(of_all)], making, parameters.simulated)
}

/// What stands in place of a number of people that is not told.
fn too_few(is_told: bool) -> Option<zwidth_results::Sentence> {
    (!is_told).then(|| format!("fewer than {LEAST_TOLD}: not told").into())
}
