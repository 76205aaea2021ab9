//! The parts of the page, in their order.

use super::contents::Page;
use super::quality;
use crate::people::{participants, sources};
use crate::{Asked, Made, NO_MEAN, Summary, groups, on_demand, what_it_is};
use maud::{Markup, html};
use std::collections::{BTreeMap, BTreeSet};

/// More figures than this stand in groups that are closed at first.
const MOST_OPEN: usize = 60;

/// A part of the page.
pub(super) struct Part {
    /// Its anchor.
    pub(super) id: &'static str,
    pub(super) title: &'static str,
    pub(super) body: Markup,
}

/// The parts that have something in them.
pub(super) fn all(page: &Page) -> Vec<Part> {
    let Page { summary, .. } = page;
    let asked = page.planned.questions.iter().any(zwidth_study::Question::is_rating);
    let trials = page.contents.is_some();
    let recorded = has_recordings(page);
    let turned = page.contents.is_some_and(|contents| contents.turned.is_some());
    let part = |id, title, is_there: bool, body: fn(&Page) -> Markup| {
        is_there.then(|| Part { id, title, body: body(page) })
    };
    // Where nobody has two modes there is nothing to draw.
    let differs = page.contents.is_none_or(|contents| contents.verdicts_in_words().is_some());
    let is_told = |question| about(summary, question).next().is_some();
    let said = trials && asked || is_told(Asked::Answers);
    let parts = [
        part("verdicts", VERDICTS, differs && verdicts_of(summary).is_some(), verdicts),
        part("matrix", "How large is it?", !summary.matrix.rows.is_empty(), matrix),
        part("dots", "Does everybody show it?", trials, |_| drawn_by_script("dot-plot")),
        part("practice", "Does it change with practice?", is_told(Asked::Practice), practice),
        part("answers", "What did people say?", said, answers),
        part("findings", "What else the trials show", is_told(Asked::Else), |page| {
            sentences(page.summary, Asked::Else)
        }),
        part("trials", "Every trial", recorded, trial_browser),
        part("model", "The model, turned by hand", turned, model),
        part("statements", "The thesis’ statements", !summary.statements.is_empty(), statements),
        part("quality", "Quality of the data", true, quality::body),
        part("plan", crate::PLAN, !summary.plan.is_empty(), |page| {
            html! { ul { @for sentence in &page.summary.plan { li { (sentence) } } } }
        }),
        part("runs", crate::RUNS, !summary.runs.is_empty(), runs),
        part("figures", "Figures", !summary.figures.is_empty(), figures),
        part("own-figures", crate::OWN_FIGURES, !summary.own_figures.is_empty(), own_figures),
        part("tables", "Tables", !summary.tables.is_empty(), tables),
        part("provenance", "Where this comes from", true, provenance),
    ];
    parts.into_iter().flatten().collect()
}

/// Whether there are trials to look at.
fn has_recordings(page: &Page) -> bool {
    page.contents.is_some_and(super::Contents::has_recordings)
}

pub(super) fn header(page: &Page) -> Markup {
    let summary = page.summary;
    let origins = sources(&summary.sources);
    let mark = origins.as_ref().and_then(|origins| origins.mark);
    let origins = origins.map(|origins| origins.text).filter(|text| !text.is_empty());
    html! {
        header #top {
            a.skip href="#main" { "Skip to the results" }
            // Stays in sight where data are simulated.
            @if let Some(mark) = mark { p.synthetic role="note" { strong { "SYNTHETIC" } " " (mark) } }
            h1 { (summary.title) }
            @if !summary.title.contains(page.study) { p.study { (page.study) } }
            @for answer in leading(summary) { p.answer { (answer.caption) } }
            p.facts {
                (what_it_is(summary))
                @for more in [origins, participants(summary.participants)].into_iter().flatten() { " " (more) }
            }
        }
    }
}

/// What the page begins with: an answer for each primary metric, or what else the trials show.
fn leading(summary: &Summary) -> Vec<&Made> {
    let answers: Vec<&Made> = summary.shown.iter().filter(|made| made.is_answer).collect();
    let else_shown = summary.shown.iter().find(|made| made.question != Asked::Practice);
    if answers.is_empty() { else_shown.into_iter().collect() } else { answers }
}

/// What the first part is called.
const VERDICTS: &str = "Does it differ, and can it be felt?";

/// The figure of every difference between modes, where it was made.
fn verdicts_of(summary: &Summary) -> Option<&Made> {
    summary.figures.iter().find(|made| made.path == crate::VERDICTS_FIGURE)
}

fn verdicts(page: &Page) -> Markup {
    html! {
        @if let Some(told) = page.contents.and_then(super::Contents::verdicts_in_words) { p.lead { (told) } }
        div #verdict-matrix {}
        @if page.contents.is_some_and(super::Contents::has_claims) { div #claims {} }
        @if let Some(made) = verdicts_of(page.summary) { (picture(made)) }
    }
}

fn matrix(page: &Page) -> Markup {
    let matrix = &page.summary.matrix;
    let recorded = has_recordings(page);
    html! {
        div.scroll tabindex="0" role="region" aria-label="Table of the modes compared" {
            table.matrix {
                thead {
                    tr {
                        th scope="col" { "metric" }
                        th scope="col" { "environment" }
                        @for (_, label) in &matrix.modes { th scope="col" { (label) } }
                    }
                }
                tbody {
                    @for rows in matrix.rows.chunk_by(|a, b| a.metric == b.metric) {
                        @for (place, row) in rows.iter().enumerate() {
                        tr {
                            @if place == 0 { th scope="rowgroup" rowspan=(rows.len()) { (row.metric) } }
                            th scope="row" { (row.label) }
                            @for ((mode, label), cell) in matrix.modes.iter().zip(&row.cells) {
                                td.number data-label=(label) {
                                    @match cell {
                                        // A cell leads to its trials where there is a browser of them.
                                        Some(cell) if recorded => {
                                            a href="#trials" data-environment=(row.environment) data-mode=(mode) { (cell) }
                                        }
                                        Some(cell) => (cell),
                                        None => (NO_MEAN),
                                    }
                                }
                            }
                        }
                        }
                    }
                }
            }
        }
        @if about(page.summary, Asked::Difference).count() > 1 { details {
            summary { "Each difference in words " span.count { (about(page.summary, Asked::Difference).count()) } }
            (sentences(page.summary, Asked::Difference))
        } }
        p.caption { (matrix.caption) @if recorded { " Each number opens its trials." } }
    }
}

/// A sentence and a link to where it is seen, within the page where that is a figure of it.
fn sentence(text: &str, path: &str) -> Markup {
    let (words, target) = match path.starts_with("figures/") {
        true => ("figure", format!("#{}", anchor(path))),
        false => ("table", table_file(path)),
    };
    html! { (text) " (" a href=(target) { (words) } ")" }
}

/// The sentences that answer a question.
fn about(summary: &Summary, question: Asked) -> impl Iterator<Item = &Made> {
    summary.shown.iter().filter(move |made| made.question == question)
}

fn sentences(summary: &Summary, question: Asked) -> Markup {
    html! {
        ul.told { @for made in about(summary, question) { li { (sentence(&made.caption.to_string(), &made.path)) } } }
    }
}

/// The first figure of each of these kinds, where there is one.
fn pictures(summary: &Summary, stems: [&str; 2]) -> Markup {
    let figures = &summary.figures;
    html! {
        @for stem in stems {
            @if let Some(made) = figures.iter().find(|made| made.name().starts_with(stem)) { (picture(made)) }
        }
    }
}

fn practice(page: &Page) -> Markup {
    html! {
        (sentences(page.summary, Asked::Practice))
        (pictures(page.summary, ["learning.", "sessions."]))
    }
}

/// A figure of the gallery, shown here too.
fn picture(made: &Made) -> Markup {
    html! {
        figure {
            (drawing(made))
            figcaption { (made.caption) ". " a href={ "#" (anchor(&made.path)) } { "All its forms" } }
        }
    }
}

/// A figure's drawing, which leads to the one for print.
fn drawing(made: &Made) -> Markup {
    html! {
        a href=(with_extension(&made.path, "pdf")) {
            img src=(with_extension(&made.path, "svg")) alt=(made.caption) loading="lazy";
        }
    }
}

fn runs(page: &Page) -> Markup {
    html! {
        p { "Of the model, not of what was recorded." }
        ul { @for made in &page.summary.runs { li { (sentence(&made.caption.to_string(), &made.path)) } } }
    }
}

fn statements(page: &Page) -> Markup {
    html! {
        p { (page.summary.statements) }
        @if !page.summary.judged.is_empty() {
            details {
                summary { "All that were judged " span.count { (page.summary.judged.len()) } }
                ul.statements {
                    @for told in &page.summary.judged {
                        li {
                            span.verdict data-verdict=(told.verdict) { (told.verdict) } " "
                            strong { (told.statement) } " " span.source { "(" (told.source) ")" }
                            br;
                            (sentence(&told.evidence, &told.path))
                        }
                    }
                }
            }
        }
    }
}

/// A place in which the page's script draws.
fn drawn_by_script(id: &str) -> Markup {
    html! {
        div id=(id) {
            noscript {
                p { "This part needs JavaScript. Figures and tables below show the same data." }
            }
        }
    }
}

fn trial_browser(_: &Page) -> Markup {
    html! {
        p { "Every sample as it was recorded. Drag over time to mark a span; the same span is marked on the loop." }
        (drawn_by_script("browser"))
    }
}

fn model(_: &Page) -> Markup {
    html! {
        p { "A typical trial of each mode (the one of median error by eye) and the model that was given the force of its user. Turn the plant's mass, damping and friction, and see the angle's error." }
        (drawn_by_script("model-plot"))
    }
}

fn answers(page: &Page) -> Markup {
    html! {
        (sentences(page.summary, Asked::Answers))
        (pictures(page.summary, ["likert", "ratings"]))
        @if page.contents.is_some() {
            h3 { "Answers beside a metric" }
            (drawn_by_script("answer-plot"))
        }
    }
}

fn figures(page: &Page) -> Markup {
    let trials = page.contents.iter().flat_map(|contents| &contents.trials);
    let codes: BTreeSet<&str> = trials.map(|trial| trial.participant.as_str()).collect();
    let mut of_all: Vec<&Made> = Vec::new();
    let mut people: BTreeMap<&str, Vec<&Made>> = BTreeMap::new();
    for made in &page.summary.figures {
        // One session's figure has its person in its name: `modes.P01.S01.spring`.
        match made.name().split('.').nth(1).filter(|code| codes.contains(code)) {
            Some(person) => people.entry(person).or_default().push(made),
            None => of_all.push(made),
        }
    }
    html! {
        @if let Some(told) = on_demand(page.summary.undrawn) { p.caption { (told.replace('`', "")) } }
        (grouped(&of_all))
        @if !people.is_empty() { h3 { "Person by person" } }
        @for (person, own) in people {
            details {
                summary { (person) " " span.count { (own.len()) } }
                (grouped(&own))
            }
        }
    }
}

/// Figures that zwidth did not draw: as images alone, because an SVG within the page could bring a
/// script along.
fn own_figures(page: &Page) -> Markup {
    html! {
        @for figure in &page.summary.own_figures {
            figure {
                @if !figure.path.ends_with(".pdf") {
                    a href=(figure.path) { img src=(figure.path) alt=(figure.caption) loading="lazy"; }
                }
                figcaption {
                    (figure.in_words()) " "
                    a href=(figure.path) { "The file" } " "
                    a href={ (figure.path) ".json" } { "Where it comes from" }
                }
            }
        }
    }
}

fn grouped(all: &[&Made]) -> Markup {
    let open = all.len() <= MOST_OPEN;
    html! {
        @for (kind, group) in groups(all.iter().copied(), |made| &made.kind) {
            details open[open] {
                summary { (kind) " " span.count { (group.len()) } }
                @for made in group {
                    figure id=(anchor(&made.path)) {
                        (drawing(made))
                        figcaption {
                            (made.caption) ". "
                            @for kind in ["svg", "pdf", "png", "parquet"] {
                                a href=(with_extension(&made.path, kind)) { (kind.to_uppercase()) } " "
                            }
                        }
                    }
                }
            }
        }
    }
}

fn tables(page: &Page) -> Markup {
    html! {
        details {
        summary { "All tables " span.count { (page.summary.tables.len()) } }
        ul.tables {
            @for made in &page.summary.tables {
                li {
                    a href=(table_file(&made.path)) { (made.caption) } " "
                    span.forms {
                        @for kind in forms(&made.path) {
                            a href=(with_extension(&made.path, kind)) aria-label={ (made.caption) " as " (kind) } { (kind) } " "
                        }
                    }
                }
            }
        }
        }
    }
}

fn provenance(page: &Page) -> Markup {
    let simulated = sources(&page.summary.sources).and_then(|told| told.mark);
    html! {
        p {
            "Made by " code { "zwidth " (page.version) } " from " code { "raw/" (page.study) } " alone. "
            code { "zwidth verify " (page.study) } " checks the recordings, "
            code { "zwidth trace reports/" (page.study) "/index.html" } " names every file and parameter behind this page."
        }
        @if let Some(origin) = page.origin { p { "Origin: " code.origin { (origin) } } }
        h3 { "Cite this" }
        p #cite {
            (page.summary.title) " (study " (page.study) "). " (what_it_is(page.summary)) " "
            @if let Some(mark) = simulated { (mark) " " }
            "Analysed with zwidth " (page.version) "."
            @if let Some(origin) = page.origin { " Origin " (origin) "." }
        }
        button.copy type="button" data-copy="cite" { "Copy" }
    }
}

/// Whether a table is there for programs alone: of a large study, one that nobody would read.
fn is_for_programs(table: &str) -> bool {
    table.ends_with(".csv")
}

/// The file of a table that a browser shows best.
fn table_file(table: &str) -> String {
    if is_for_programs(table) { table.to_owned() } else { with_extension(table, "html") }
}

/// The forms of a table to be taken along.
fn forms(table: &str) -> &'static [&'static str] {
    if is_for_programs(table) {
        &["csv", "parquet"]
    } else {
        &["csv", "tex", "typ", "md", "parquet"]
    }
}

/// The same file in another form.
fn with_extension(path: &str, extension: &str) -> String {
    let stem = path.rsplit_once('.').map_or(path, |(stem, _)| stem);
    format!("{stem}.{extension}")
}

/// The anchor of a figure in the page.
fn anchor(path: &str) -> String {
    let name = path.rsplit_once('/').map_or(path, |(_, name)| name);
    let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
    format!("figure-{stem}")
}
