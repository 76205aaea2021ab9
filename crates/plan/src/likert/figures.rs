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

/// What a page depends on besides the answers.
#[derive(Serialize)]
struct Page {
    about: About,
    page: LikertPage,
    sources: Vec<Source>,
}

pub(crate) fn all(data: &StudyData) -> Vec<Drawing> {
    let Some((tally, answers)) = tally(data).zip(answers(data)) else { return Vec::new() };
    let rated = list_rated(data);
    let overview = (LIKERT, zwidth_figures::likert_overview(&rated));
    let items = (LIKERT_ITEMS, zwidth_figures::likert_items(&rated));
    let mut drawings = Vec::new();
    for (kind, pages) in [overview, items] {
        for (number, page) in number_pages(pages.len()).into_iter().zip(pages) {
            let shown = data.answers.iter().filter(|answer| {
                let question = data.study.question(&answer.question);
                question.is_some_and(|q| page.shows(&answer.condition.environment, q))
            });
            let n = shown.count();
            let sources = data.sessions.iter().map(|s| s.record.source).collect();
            let page = Page { about: About::of(&data.study), page, sources };
            drawings.push(Drawing::new(data, kind, number, page, answers.clone(), draw).of(n));
        }
    }
    let pages = zwidth_figures::ratings_pages(&rated);
    for (number, page) in number_pages(pages.len()).into_iter().zip(pages) {
        let tables = (tally.clone(), answers.clone());
        let shown =
            data.answers.iter().filter(|a| page.shows(&a.condition.environment, &a.question));
        let n = shown.count();
        let sources = data.sessions.iter().map(|s| s.record.source).collect();
        let rated = Rated { about: About::of(&data.study), page, sources };
        drawings.push(Drawing::new(data, RATINGS, number, rated, tables, draw_rated).of(n));
    }
    drawings
}

/// The numbers of pages, from 1 on; a single page has no number.
pub(crate) fn number_pages(pages: usize) -> Vec<Option<String>> {
    (1..=pages).map(|number| (pages > 1).then(|| number.to_string())).collect()
}

/// What a page of answers on scales of many points depends on besides the tables.
#[derive(Serialize)]
struct Rated {
    about: About,
    page: RatingsPage,
    sources: Vec<Source>,
}

fn draw_rated(
    Rated { about, page, sources }: &Rated,
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

fn draw(page: &Page, answers: &Derived<GivenAnswer>) -> Figured {
    let Page { about, page, sources } = page;
    Ok((zwidth_figures::likert(about, page, &read_counting(answers)?, sources), Vec::new()))
}
