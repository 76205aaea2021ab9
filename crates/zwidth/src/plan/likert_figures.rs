//! The figures of the stage `likert`: a panel an environment, or a panel a group of questions, as
//! many to a figure as fit on a page.

use super::figures::{Described, figure_job};
use super::likert::tally_of;
use std::collections::BTreeSet;
use zwidth_figures::LikertPanel;
use zwidth_runner::Job;
use zwidth_store::StudyData;
use zwidth_study::{Environment, Question, Study};
use zwidth_tables::{Table, TableError};

/// Panels that fit on a page: two columns of six.
const A_PAGE: usize = 12;

/// A panel to be: its heading, and which rows of the tally it shows.
#[derive(Debug, Clone)]
struct Wanted<'a> {
    title: String,
    environment: &'a Environment,
    what: What<'a>,
}

#[derive(Debug, Clone)]
enum What<'a> {
    Question(&'a Question),
    Group(&'a str),
}

pub(super) fn jobs(data: &StudyData) -> Vec<Job<'_>> {
    let asked = asked(data);
    let overview: Vec<Wanted> =
        asked.iter().flat_map(|(e, questions)| overview(e, questions)).collect();
    let several = asked.iter().filter(|(_, questions)| questions.len() > 1);
    let items: Vec<Wanted> =
        several.flat_map(|(e, questions)| questions.iter().map(|q| item(e, q))).collect();
    let mut jobs = pages(data, "likert", &overview);
    jobs.extend(pages(data, "likert_items", &items));
    jobs
}

/// The questions answered in each environment, in the study's order.
fn asked(data: &StudyData) -> Vec<(&Environment, Vec<&Question>)> {
    let given: BTreeSet<_> =
        data.answers().into_iter().map(|a| (a.condition.environment, a.question)).collect();
    let study = &data.study;
    let of = |e: &Environment| {
        study
            .questions
            .iter()
            .filter(|q| given.contains(&(e.id.clone(), q.id.clone())))
            .collect::<Vec<_>>()
    };
    study
        .environments
        .iter()
        .map(|e| (e, of(e)))
        .filter(|(_, questions)| !questions.is_empty())
        .collect()
}

/// One panel an environment with one question; else one a group, and one a question without a
/// group.
fn overview<'a>(environment: &'a Environment, questions: &[&'a Question]) -> Vec<Wanted<'a>> {
    if let [only] = questions {
        let what = What::Question(only);
        return vec![Wanted { title: environment.label.clone(), environment, what }];
    }
    let mut seen = BTreeSet::new();
    let mut wanted = Vec::new();
    for question in questions {
        match question.group.as_deref() {
            None => wanted.push(item(environment, question)),
            Some(group) if seen.insert(group) => {
                wanted.push(Wanted {
                    title: group.to_owned(),
                    environment,
                    what: What::Group(group),
                });
            }
            Some(_) => {}
        }
    }
    wanted
}

fn item<'a>(environment: &'a Environment, question: &'a Question) -> Wanted<'a> {
    Wanted { title: question.text.clone(), environment, what: What::Question(question) }
}

fn pages<'a>(data: &'a StudyData, name: &str, wanted: &[Wanted<'a>]) -> Vec<Job<'a>> {
    let pages: Vec<_> = wanted.chunks(A_PAGE).collect();
    let name =
        |i: usize| if pages.len() == 1 { name.to_owned() } else { format!("{name}.{}", i + 1) };
    pages.iter().enumerate().map(|(i, page)| job(data, &name(i), page.to_vec())).collect()
}

fn job<'a>(data: &'a StudyData, name: &str, wanted: Vec<Wanted<'a>>) -> Job<'a> {
    let input = tally_of(&data.layout);
    let sources: Vec<_> = data.sessions.iter().map(|s| s.record.source).collect();
    let parameters = format!("{:?}", (&data.study.title, &data.study.modes, &wanted, &sources));
    figure_job(data, name, vec![input.clone()], parameters, move || -> Described {
        let tally = Table::from_parquet(&input)?;
        let panels =
            wanted.iter().map(|w| panel(&data.study, &tally, w)).collect::<Result<Vec<_>, _>>()?;
        let footnotes = footnotes(&wanted);
        Ok((zwidth_figures::likert(&data.study.title, &panels, &footnotes, &sources), Vec::new()))
    })
}

/// A row a mode, in the study's order.
fn panel(study: &Study, tally: &Table, wanted: &Wanted) -> Result<LikertPanel, TableError> {
    let texts = |column| tally.texts(column);
    let (environments, modes) = (texts("environment")?, texts("mode")?);
    let (questions, groups) = (texts("question")?, texts("group")?);
    let counts =
        (1..=5).map(|k| tally.integers(&format!("count_{k}"))).collect::<Result<Vec<_>, _>>()?;
    let is_wanted = |row: usize| match &wanted.what {
        What::Question(q) => questions[row].as_deref() == Some(q.id.as_str()),
        What::Group(g) => questions[row].is_none() && groups[row].as_deref() == Some(*g),
    };
    let row = |mode: &zwidth_study::Mode| {
        let found = (0..tally.height()).find(|row| {
            environments[*row].as_deref() == Some(wanted.environment.id.as_str())
                && modes[*row].as_deref() == Some(mode.id.as_str())
                && is_wanted(*row)
        })?;
        let count = |k: usize| counts[k][found].and_then(|n| u32::try_from(n).ok()).unwrap_or(0);
        Some((mode.label.clone(), std::array::from_fn(count)))
    };
    Ok(LikertPanel {
        title: wanted.title.clone(),
        rows: study.modes.iter().filter_map(row).collect(),
    })
}

/// The wording where a panel is named after its environment, and what was reversed.
fn footnotes(wanted: &[Wanted]) -> Vec<String> {
    let mut notes = Vec::new();
    let mut reversed = false;
    for w in wanted {
        match &w.what {
            What::Question(q) => {
                reversed |= q.reversed;
                if w.title != q.text {
                    notes.push(format!("{}: “{}”", w.title, q.text));
                }
            }
            What::Group(_) => reversed = true,
        }
    }
    if reversed {
        notes.push(
            "Answers to reversed questions are turned round (6 − a), so that right is favourable."
                .to_owned(),
        );
    }
    notes
}
