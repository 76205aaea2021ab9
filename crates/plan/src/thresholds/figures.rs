//! The figures of the stage `thresholds`: everybody's answers with their curves, their staircases, and thresholds by mode.

use crate::figures::drawing::{Drawing, Figured};
use crate::shared::handle::Derived;
use crate::thresholds::{OfPeople, answered, of_study, over_people};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use zwidth_figures::{About, OfPerson, PSYCHOMETRIC, STAIRCASES, THRESHOLDS};
use zwidth_results::{PeopleThreshold, PsychometricFit};
use zwidth_store::StudyData;
use zwidth_study::{Method, ParticipantId, SessionId, Source, Task};

/// What a figure of a task depends on besides tables.
#[derive(Serialize)]
struct OfTask {
    about: About,
    task: Task,
    sources: BTreeSet<Source>,
}

/// What a figure of a person's answers depends on besides tables.
#[derive(Serialize)]
struct OfSession {
    #[serde(flatten)]
    of_task: OfTask,
    participant: ParticipantId,
    session: SessionId,
}

impl OfSession {
    fn is_own(&self, participant: &ParticipantId, session: &SessionId) -> bool {
        (&self.participant, &self.session) == (participant, session)
    }

    /// The fits of this person, session and task.
    fn fits(&self, tables: &OfPeople) -> Result<Vec<PsychometricFit>, zwidth_tables::TableError> {
        let mut fits = tables.fits.read()?;
        fits.retain(|fit| {
            self.is_own(&fit.participant, &fit.session) && fit.task == self.of_task.task.id
        });
        Ok(fits)
    }
}

/// Every figure of the tasks of a study; of the sessions whose figures a run makes, or of all.
pub(crate) fn all(data: &StudyData, of_session: impl Fn(&[String; 2]) -> bool) -> Vec<Drawing> {
    let Some(tables) = of_study(data) else { return Vec::new() };
    let answers = answered(data);
    let mut drawings = Vec::new();
    for task in &data.study.tasks {
        let own = || answers.iter().filter(|answer| answer.task == task.id);
        let sources = own().map(|answer| answer.source).collect();
        let of_task =
            |sources| OfTask { about: About::of(&data.study), task: task.clone(), sources };
        if let Some(over) = over_people(data).filter(|_| own().next().is_some()) {
            let inputs = (tables.fits.clone(), over);
            let subject = [task.id.to_string()];
            let drawing =
                Drawing::new(data, THRESHOLDS, subject, of_task(sources), inputs, draw_people);
            drawings.push(drawing.of(own().count()));
        }
        let mut sessions: BTreeMap<_, (usize, BTreeSet<Source>)> = BTreeMap::new();
        for answer in own() {
            let (n, sources) = sessions.entry((&answer.participant, &answer.session)).or_default();
            *n += 1;
            sources.insert(answer.source);
        }
        for ((participant, session), (n, sources)) in sessions {
            let ids = [participant.to_string(), session.to_string()];
            if !of_session(&ids) {
                continue;
            }
            let subject = || [ids[0].clone(), ids[1].clone(), task.id.to_string()];
            let parameters = || OfSession {
                of_task: of_task(sources.clone()),
                participant: participant.clone(),
                session: session.clone(),
            };
            if !matches!(task.method, Method::Staircase(_) | Method::Adjustment { .. }) {
                let (own, tables) = (parameters(), tables.clone());
                let drawing = Drawing::new(data, PSYCHOMETRIC, subject(), own, tables, draw_curves);
                drawings.push(drawing.of(n));
            }
            if !matches!(task.method, Method::Constant { .. }) {
                let (own, tables) = (parameters(), tables.clone());
                let drawing =
                    Drawing::new(data, STAIRCASES, subject(), own, tables, draw_staircases);
                drawings.push(drawing.of(n));
            }
        }
    }
    drawings
}

fn draw_curves(own: &OfSession, tables: &OfPeople) -> Figured {
    let OfTask { about, task, sources } = &own.of_task;
    let fits = own.fits(tables)?;
    let mut by_level = tables.by_level.read()?;
    by_level.retain(|row| own.is_own(&row.participant, &row.session) && row.task == task.id);
    let mut curves = tables.curves.read()?;
    curves.retain(|row| own.is_own(&row.participant, &row.session) && row.task == task.id);
    let who = format!("{} {}", own.participant, own.session);
    let sources: Vec<Source> = sources.iter().copied().collect();
    let of = OfPerson { task, who: &who, sources: &sources, fits: &fits };
    Ok((zwidth_figures::psychometric(about, of, &by_level, &curves), Vec::new()))
}

fn draw_staircases(own: &OfSession, tables: &OfPeople) -> Figured {
    let OfTask { about, task, sources } = &own.of_task;
    let fits = own.fits(tables)?;
    let mut presentations = tables.presentations.read()?;
    presentations.retain(|row| own.is_own(&row.participant, &row.session) && row.task == task.id);
    let who = format!("{} {}", own.participant, own.session);
    let sources: Vec<Source> = sources.iter().copied().collect();
    let of = OfPerson { task, who: &who, sources: &sources, fits: &fits };
    Ok((zwidth_figures::staircases(about, of, &presentations), Vec::new()))
}

fn draw_people(
    OfTask { about, task, sources }: &OfTask,
    (fits, over): &(Derived<PsychometricFit>, Derived<PeopleThreshold>),
) -> Figured {
    let mut fits = fits.read()?;
    fits.retain(|fit| fit.task == task.id);
    let mut over = over.read()?;
    over.retain(|row| row.task == task.id);
    let sources: Vec<Source> = sources.iter().copied().collect();
    Ok((zwidth_figures::thresholds(about, task, &sources, &fits, &over), Vec::new()))
}
