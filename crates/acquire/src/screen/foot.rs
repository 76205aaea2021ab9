//! The foot of the screen: what is typed or asked, how the loop keeps time, and the keys, the stop
//! key first.

use super::keys::{Ask, Entry, commands, stop_key};
use super::look::{Look, Role};
use super::text;
use crate::{Timing, View};
use ratatui::text::{Line, Span};

/// Rate below this part of the nominal one is marked.
const SLOW: f64 = 0.98;

/// How the control loop keeps time, in at most `limit` cells: briefer where the whole does not fit.
pub(super) fn timing(timing: &Timing, look: Look, limit: usize) -> Line<'static> {
    if timing.measured_hz == 0.0 {
        return Line::styled(format!("{:.0} Hz nominal", timing.rate_hz), look.style(Role::Quiet));
    }
    let whole = timing_line(timing, look, false);
    if whole.width() <= limit { whole } else { timing_line(timing, look, true) }
}

fn timing_line(timing: &Timing, look: Look, brief: bool) -> Line<'static> {
    let [p50, p99, max] = [timing.jitter_p50_s, timing.jitter_p99_s, timing.jitter_max_s]
        .map(|s| format!("{:.0}", s * 1e6));
    let rate = format!("{:.0}", timing.measured_hz);
    let (rate, jitter) = match (brief, timing.jitter_max_s > 0.0) {
        (true, true) => (format!("{rate} Hz"), format!("p99 {p99} max {max}")),
        (false, true) => (
            format!("{rate} of {:.0} Hz", timing.rate_hz),
            format!("p50 {p50} p99 {p99} max {max}"),
        ),
        // It is known when a trial has ended.
        (_, false) => (format!("{rate} of {:.0} Hz", timing.rate_hz), "–".to_owned()),
    };
    let quiet = look.style(Role::Quiet);
    Line::from(vec![
        alarm(timing.measured_hz < SLOW * timing.rate_hz, rate, look),
        Span::styled("  jitter µs ", quiet),
        Span::raw(jitter),
        Span::styled("  missed ", quiet),
        alarm(timing.missed > 0, timing.missed.to_string(), look),
        Span::styled("  dropouts ", quiet),
        alarm(timing.dropouts > 0, timing.dropouts.to_string(), look),
    ])
}

/// A number, marked where it is bad.
fn alarm(is_bad: bool, number: String, look: Look) -> Span<'static> {
    match is_bad {
        true => Span::styled(number + " !", look.style(Role::Warn)),
        false => Span::raw(number),
    }
}

/// The keys that do something now.
pub(super) fn keys(view: &View, entry: Option<&Entry>, look: Look) -> Line<'static> {
    let mut spans =
        vec![Span::styled(format!(" {} STOP ", stop_key(entry)), look.style(Role::Stop))];
    let commands = match entry {
        None => commands(&view.phase),
        Some(Entry::Note(..)) => vec![("Enter".into(), "keep the note"), ("Esc".into(), "drop it")],
        Some(Entry::Exclude(..)) => vec![("Enter".into(), "exclude"), ("Esc".into(), "do not")],
        Some(Entry::Which(_)) => vec![("Enter".into(), "that trial"), ("Esc".into(), "none")],
        Some(Entry::Trial(_)) => {
            let keys = [
                ("n", "note"),
                ("x", "exclude"),
                ("r", "repeat"),
                ("a", "ask again"),
                ("Esc", "none"),
            ];
            keys.map(|(key, does)| (key.into(), does)).to_vec()
        }
        Some(Entry::Answer(_)) => vec![("Enter".into(), "answer"), ("Esc".into(), "take it back")],
        Some(Entry::Sure(_)) => vec![("y".into(), "yes"), ("any other key".into(), "no")],
    };
    for (key, meaning) in commands {
        spans.push(Span::styled(format!("   {key}"), look.style(Role::Accent)));
        spans.push(Span::raw(format!(" {meaning}")));
    }
    Line::from(spans)
}

/// What is typed or asked, in lines of at most `width` cells; the last ones, if there are more than
/// three.
pub(super) fn entry(entry: &Entry, look: Look, width: usize) -> Vec<Line<'static>> {
    /// Lines of a remark that stay in sight.
    const LINES: usize = 3;
    let lines = text::pieces(&words(entry), width.max(1));
    let hidden = lines.len().saturating_sub(LINES);
    lines
        .into_iter()
        .skip(hidden)
        .map(|line| Line::styled(line, look.style(Role::Strong)))
        .collect()
}

fn words(entry: &Entry) -> String {
    match entry {
        Entry::Note(None, text) => format!("Note: {text}_"),
        Entry::Note(Some(trial), text) => format!("Note on trial {trial}: {text}_"),
        Entry::Which(text) => format!("Number of the trial: {text}_"),
        Entry::Trial(trial) => format!("Trial {trial}: what of it?"),
        Entry::Answer(text) => format!("Answer: {text}_"),
        Entry::Exclude(None, text) => format!("The last trial does not count, because: {text}_"),
        Entry::Exclude(Some(trial), text) => {
            format!("Trial {trial} does not count, because: {text}_")
        }
        Entry::Sure(Ask::Repeat(None)) => {
            "Do the last trial again? It stays, marked as superseded.".into()
        }
        Entry::Sure(Ask::Repeat(Some(trial))) => {
            format!("Do trial {trial} again? It stays, marked as superseded.")
        }
        Entry::Sure(Ask::Skip) => "Leave the question without an answer?".into(),
        Entry::Sure(Ask::Quit) => {
            "End the session here? It goes on from here the next time.".into()
        }
    }
}
