//! The figures of the stage `likert`, with as many panels per figure as fit on a page.

use crate::figures::drawing::{Drawing, Figured};
use crate::likert::{answers, ratings, read_counting, tally};
use crate::shared::handle::Derived;
use serde::Serialize;
use std::collections::BTreeSet;
use zwidth_figures::{About, LIKERT, LIKERT_ITEMS, LikertPage, RATINGS, RatingsPage};
use zwidth_results::{AnswerTally, GivenAnswer};
use zwidth_store::StudyData;
use zwidth_study::{Environment, Question, Source};

/// What a page of answers depends on besides tables.
#[derive(Serialize)]
pub(crate) struct Page<P> {
    pub(crate) about: About,
    pub(crate) page: P,
    pub(crate) sources: Vec<Source>,
}

impl<P> Page<P> {
    fn of(data: &StudyData, page: P) -> Self {
        let sources = data.sessions.iter().map(|s| s.record.source).collect();
        Self { about: About::of(&data.study), page, sources }
    }
}

pub(crate) fn all(data: &StudyData) -> Vec<Drawing> {
    let Some((tally, answers)) = tally(data).zip(answers(data)) else { return Vec::new() };
    let rated = list_rated(data);
    let overview = (LIKERT, zwidth_figures::likert_overview(&rated));
    let items = (LIKERT_ITEMS, zwidth_figures::likert_items(&rated));
    let mut drawings = Vec::new();
    for (kind, pages) in [overview, items] {
        for (number, page) in numbered(pages) {
            let shown = data.answers.iter().filter(|answer| {
                let question = data.study.question(&answer.question);
                question.is_some_and(|q| page.shows(&answer.condition.environment, q))
            });
            let n = shown.count();
            let page = Page::of(data, page);
            drawings.push(Drawing::new(data, kind, number, page, answers.clone(), draw).of(n));
        }
    }
    for (number, page) in numbered(zwidth_figures::ratings_pages(&rated)) {
        let tables = (tally.clone(), answers.clone());
        let shown =
            data.answers.iter().filter(|a| page.shows(&a.condition.environment, &a.question));
        let n = shown.count();
        let page = Page::of(data, page);
        drawings.push(Drawing::new(data, RATINGS, number, page, tables, draw_rated).of(n));
    }
    drawings
}

/// Pages with their numbers, from 1 on; a single page has no number.
pub(crate) fn numbered<P>(pages: Vec<P>) -> impl Iterator<Item = (Option<String>, P)> {
    let several = pages.len() > 1;
    (1..).map(move |number: usize| several.then(|| number.to_string())).zip(pages)
}

fn draw_rated(
    Page { about, page, sources }: &Page<RatingsPage>,
    (tally, answers): &(Derived<AnswerTally>, Derived<GivenAnswer>),
) -> Figured {
    let tally = tally.read()?;
    let answers = read_counting(answers)?;
    Ok((zwidth_figures::ratings(about, page, &tally, &answers, sources), Vec::new()))
}

/// The questions answered with a rating in each environment, in the study's order.
pub(crate) fn list_rated(data: &StudyData) -> Vec<(&Environment, Vec<&Question>)> {
    let answered: BTreeSet<_> =
        ratings(data).map(|a| (&a.condition.environment, &a.question)).collect();
    let mut rated = Vec::new();
    for environment in &data.study.environments {
        let mut questions: Vec<&Question> = data.study.questions.iter().collect();
        questions.retain(|question| answered.contains(&(&environment.id, &question.id)));
        if !questions.is_empty() {
            rated.push((environment, questions));
        }
    }
    rated
}

fn draw(
    Page { about, page, sources }: &Page<LikertPage>,
    answers: &Derived<GivenAnswer>,
) -> Figured {
    Ok((zwidth_figures::likert(about, page, &read_counting(answers)?, sources), Vec::new()))
}
