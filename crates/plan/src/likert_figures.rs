//! The figures of the stage `likert`, as many panels to a figure as fit on a page.

use crate::drawing::{Drawing, write_figure};
use crate::likert::tally;
use serde::Serialize;
use std::path::PathBuf;
use zwidth_figures::{About, FigureKind, LIKERT, LIKERT_ITEMS, LikertPage};
use zwidth_runner::{JobError, Made, Making};
use zwidth_store::{Answer, StudyData};
use zwidth_study::{Environment, Question, Source};
use zwidth_tables::Table;

/// What a page depends on besides the tally.
#[derive(Serialize)]
struct Page {
    about: About,
    page: LikertPage,
    sources: Vec<Source>,
}

pub(crate) fn all(data: &StudyData) -> Vec<Drawing> {
    let Some(tally) = tally(data) else { return Vec::new() };
    let (answers, asked) = (data.answers(), list_asked(data));
    let overview = zwidth_figures::likert_overview(&asked);
    let items = zwidth_figures::likert_items(&asked);
    let pages = |kind: FigureKind, pages: Vec<LikertPage>| -> Vec<Drawing> {
        let number = |i: usize| (pages.len() > 1).then(|| (i + 1).to_string());
        let one = |(i, page): (usize, &LikertPage)| {
            let sources = data.sessions.iter().map(|s| s.record.source).collect();
            let page = Page { about: About::of(&data.study), page: page.clone(), sources };
            let is_shown = |answer: &&Answer| {
                let question = data.study.question(&answer.question);
                question.is_some_and(|q| page.page.shows(&answer.condition.environment, q))
            };
            let n = answers.iter().filter(is_shown).count();
            Drawing::new(data, kind, number(i), page, tally.clone(), draw).of(n)
        };
        pages.iter().enumerate().map(one).collect()
    };
    let mut drawings = pages(LIKERT, overview);
    drawings.extend(pages(LIKERT_ITEMS, items));
    drawings
}

/// The questions answered in each environment, in the study's order.
pub(crate) fn list_asked(data: &StudyData) -> Vec<(&Environment, Vec<&Question>)> {
    let answers = data.answers();
    let given = |e: &Environment, q: &Question| {
        answers.iter().any(|a| a.condition.environment == e.id && a.question == q.id)
    };
    let questions = |e: &Environment| -> Vec<&Question> {
        data.study.questions.iter().filter(|q| given(e, q)).collect()
    };
    let asked = data.study.environments.iter().map(|e| (e, questions(e)));
    asked.filter(|(_, questions)| !questions.is_empty()).collect()
}

fn draw(page: &Page, tally: &PathBuf, making: &Making) -> Result<Made, JobError> {
    let tally = Table::from_parquet(tally)?;
    let Page { about, page, sources } = page;
    write_figure(zwidth_figures::likert(about, page, &tally, sources)?, Vec::new(), making)
}
