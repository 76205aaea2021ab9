//! Figure 24: for a session and each environment with a spring, one trial per mode beside the
//! models, by eye and fitted, driven by its external force. The stage `replay` derives these data.

use crate::figures::drawing::{Drawing, Figured};
use crate::replay::courses;
use crate::shared::conditions::Session;
use crate::shared::handle::Derived;
use serde::Serialize;
use zwidth_figures::{About, REPLAY};
use zwidth_results::CourseSample;
use zwidth_store::StudyData;
use zwidth_study::Environment;

/// What a figure depends on besides the courses.
#[derive(Serialize)]
struct Against {
    about: About,
    environment: Environment,
    who: String,
}

pub(crate) fn of(data: &StudyData, session: &Session) -> Vec<Drawing> {
    let mut drawings = Vec::new();
    for environment in &data.study.environments {
        let Some(courses) = courses::file(data, session, environment) else { continue };
        let subject = session.ids_with(environment);
        let about = About::of(&data.study);
        let environment = environment.clone();
        let against = Against { about, environment, who: session.who() };
        drawings.push(Drawing::new(data, REPLAY, subject, against, courses, draw));
    }
    drawings
}

fn draw(Against { about, environment, who }: &Against, courses: &Derived<CourseSample>) -> Figured {
    let (courses, notes) = courses.read_with_notes()?;
    Ok((zwidth_figures::replay(about, environment, who, &courses, &notes), Vec::new()))
}
