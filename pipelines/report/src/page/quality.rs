//! What readers must know about the data before they trust them: what is missing, what is to be
//! read with care, and in which order conditions came.

use super::contents::{Page, TrialOf};
use crate::{Remark, nothing};
use maud::{Markup, html};
use std::collections::BTreeMap;
use zwidth_draw::style::MODE_COLOURS;

/// Orders of more sessions than this would fill pages.
const MOST_SESSIONS: usize = 60;

pub(super) fn body(page: &Page) -> Markup {
    let summary = page.summary;
    html! {
        h3 { "Left out" }
        @if summary.left_out.is_empty() { p { (nothing(summary)) } }
        (remarks(&summary.left_out))
        @if !summary.care.is_empty() { h3 { "Read with care" } }
        (remarks(&summary.care))
        @if !summary.limits.is_empty() {
            h3 { "What these data cannot show" }
            ul { @for limit in &summary.limits { li { (limit) } } }
        }
        (order(page))
    }
}

fn remarks(remarks: &[Remark]) -> Markup {
    html! {
        @if !remarks.is_empty() {
            ul { @for Remark { what, why } in remarks { li { strong { (what) } ": " (why) } } }
        }
    }
}

/// The order of conditions, one row per session.
fn order(page: &Page) -> Markup {
    let recorded = page.contents.filter(|contents| contents.has_recordings());
    let Some(contents) = recorded else { return html! {} };
    let mut sessions: BTreeMap<String, Vec<&TrialOf>> = BTreeMap::new();
    for trial in &contents.trials {
        let who = format!("{} {}", trial.participant, trial.session);
        sessions.entry(who).or_default().push(trial);
    }
    sessions.values_mut().for_each(|trials| trials.sort_by_key(|trial| trial.trial));
    let n = sessions.len();
    let planned = page.planned;
    let environment =
        |trial: &TrialOf| planned.environments.iter().position(|e| e.id == trial.environment);
    let mode = |trial: &TrialOf| planned.modes.iter().position(|m| m.id == trial.mode);
    html! {
        h3 { "Order of conditions" }
        @if n > MOST_SESSIONS {
            p { "The orders of " (n) " sessions are in the table of metrics." }
        } @else {
            div.scroll tabindex="0" role="region" aria-label="Table of the order of conditions" {
                table.order { tbody { @for (who, trials) in &sessions { tr {
                    th scope="row" { (who) }
                    @for trial in trials {
                        @let environment = environment(trial).unwrap_or(0);
                        @let mode = mode(trial).unwrap_or(0);
                        td class={ "mode-" (mode % MODE_COLOURS) } title={
                            "trial " (trial.trial) ": " (trial.environment) " " (trial.mode) " " (trial.repeat)
                        } { (environment + 1) (letter(mode)) }
                    }
                } } } }
            }
            p.caption {
                "Trials that count, in the order of their numbers. For trials recorded with this program \
                 that is the order of recording; for imported ones it is the order of the files, \
                 unless the mapping file numbers them. Cells: "
                @for (place, environment) in planned.environments.iter().enumerate() {
                    (place + 1) " " (environment.label) ", "
                }
                "colour and letter: "
                @for (place, mode) in planned.modes.iter().enumerate() {
                    @if place > 0 { ", " }
                    span class={ "key mode-" (place % MODE_COLOURS) } { (letter(place)) " " (mode.label) }
                }
                "."
            }
        }
    }
}

/// A letter for each mode, so that colour is not all.
fn letter(place: usize) -> char {
    char::from(b'a' + (place % 26) as u8)
}
