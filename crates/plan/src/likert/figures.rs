//! The figures of the stage `likert`, with as many panels per figure as fit on a page.

use crate::figures::drawing::{Drawing, Figured};
use crate::likert::{answers, ratings, read_counting, tally};
use crate::shared::handle::Derived;
use serde::Serialize;
use std::collections::BTreeSet;
use zwidth_figures::{About, FigureKind, LIKERT, LIKERT_ITEMS, LikertPage, RATINGS, RatingsPage};
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
    let asked = list_asked(data);
    let overview = (LIKERT, zwidth_figures::likert_overview(&asked));
    let items = (LIKERT_ITEMS, zwidth_figures::likert_items(&asked));
    let mut drawings = Vec::new();
    for (kind, pages) in [overview, items] {
        for (number, page) in number_pages(pages.len()).into_iter().zip(pages) {
            drawings.push(draw_page(data, kind, number, page, answers.clone()));
        }
    }
    let pages = zwidth_figures::ratings_pages(&asked);
    for (number, page) in number_pages(pages.len()).into_iter().zip(pages) {
        let tables = (tally.clone(), answers.clone());
        drawings.push(draw_ratings(data, number, page, tables));
    }
    drawings
}

/// The numbers of pages, from 1 on; a single page has no number.
pub(crate) fn number_pages(pages: usize) -> Vec<Option<String>> {
    (1..=pages).map(|number| (pages > 1).then(|| number.to_string())).collect()
}

fn draw_page(
    data: &StudyData,
    kind: FigureKind,
    number: Option<String>,
    page: LikertPage,
    given: Derived<GivenAnswer>,
) -> Drawing {
    let of_page = |answer: &&zwidth_store::Answer| {
        let question = data.study.question(&answer.question);
        question.is_some_and(|q| page.shows(&answer.condition.environment, q))
    };
    let answers = data.answers.iter().filter(of_page).count();
    let sources = data.sessions.iter().map(|s| s.record.source).collect();
    let page = Page { about: About::of(&data.study), page, sources };
    Drawing::new(data, kind, number, page, given, draw).of(answers)
}

/// What a page of answers on scales of many points depends on besides the tables.
#[derive(Serialize)]
struct Rated {
    about: About,
    page: RatingsPage,
    sources: Vec<Source>,
}

fn draw_ratings(
    data: &StudyData,
    number: Option<String>,
    page: RatingsPage,
    tables: (Derived<AnswerTally>, Derived<GivenAnswer>),
) -> Drawing {
    let answers =
        data.answers.iter().filter(|a| page.shows(&a.condition.environment, &a.question)).count();
    let sources = data.sessions.iter().map(|s| s.record.source).collect();
    let rated = Rated { about: About::of(&data.study), page, sources };
    Drawing::new(data, RATINGS, number, rated, tables, draw_rated).of(answers)
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
pub(crate) fn list_asked(data: &StudyData) -> Vec<(&Environment, Vec<&Question>)> {
    let given: BTreeSet<_> =
        ratings(data).map(|a| (&a.condition.environment, &a.question)).collect();
    let mut asked = Vec::new();
    for environment in &data.study.environments {
        let mut questions: Vec<&Question> = data.study.questions.iter().collect();
        questions.retain(|question| given.contains(&(&environment.id, &question.id)));
        if !questions.is_empty() {
            asked.push((environment, questions));
        }
    }
    asked
}

fn draw(page: &Page, answers: &Derived<GivenAnswer>) -> Figured {
    let Page { about, page, sources } = page;
    Ok((zwidth_figures::likert(about, page, &read_counting(answers)?, sources), Vec::new()))
}
