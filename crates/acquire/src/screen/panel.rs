//! What the session needs of the people before it, phase by phase, in words.

use super::look::{Look, Role};
use super::text::{fit, width, wrap};
use crate::{Cell, CheckLine, Phase, TaskNow, View};
use ratatui::text::{Line, Span};
use zwidth_study::{AnswerScale, Kind};

/// A device check of so many lines leaves room for messages in the smallest window, of 24 rows.
const LEAVES_ROOM: usize = 12;

/// The name of a phase, as it heads the screen.
pub(super) fn name(phase: &Phase) -> &'static str {
    match phase {
        Phase::Check | Phase::Step { .. } => "DEVICE CHECK",
        Phase::AtStop | Phase::Homing => "HOMING",
        Phase::Ready => "READY",
        Phase::Trial { .. } => "TRIAL",
        Phase::Question { .. } => "QUESTION",
        Phase::Pause { .. } => "PAUSE",
        Phase::Stopped { .. } => "STOPPED",
        Phase::Done => "DONE",
        Phase::Left => "CLOSED",
    }
}

/// The trial at hand or the next one, in words: number, kind, environment, and mode where it may be
/// seen.
pub(super) fn trial(view: &View) -> Option<String> {
    let current = view.trial.as_ref()?;
    let mut words = vec![match current.repeats {
        // A repeat has a number of its own; its place in the order is told by the progress.
        Some(_) => format!("trial {}", current.trial),
        None => format!("trial {} of {}", current.place, view.total),
    }];
    if current.kind == Kind::Familiarisation {
        words.push("familiarisation".into());
    }
    words.push(current.environment.clone());
    words.extend(current.mode.clone().filter(|_| !view.blinded));
    words.extend(current.repeats.map(|trial| format!("repeats trial {trial}")));
    words.extend(view.task.as_ref().map(TaskNow::in_words));
    Some(words.join(" · "))
}

/// Time left, s, and the whole of it.
pub(super) fn countdown(phase: &Phase) -> Option<(f64, f64)> {
    match *phase {
        Phase::Trial { t_s, limit_s } => Some(((limit_s - t_s).max(0.0), limit_s)),
        Phase::Pause { left_s, pause_s } => Some((left_s, pause_s)),
        _ => None,
    }
}

/// What is to be read in a phase, in lines of at most `limit` cells; where there is little room, a
/// question with the ends of its scale alone.
pub(super) fn lines(view: &View, look: Look, limit: usize, is_low: bool) -> Vec<Line<'static>> {
    let plain = |text: &str| styled(text, Role::Plain, look, limit);
    match &view.phase {
        Phase::Check => match (&view.step, view.checks.is_empty()) {
            (Some(step), _) => plain(step),
            (None, true) => plain("The device is being checked."),
            (None, false) => checks(&view.checks, look, limit),
        },
        Phase::Step { what, .. } => {
            [plain(what), after_gap(checks(&view.checks, look, limit))].concat()
        }
        Phase::AtStop => [plain(AT_STOP), after_gap(checks(&view.checks, look, limit))].concat(),
        Phase::Homing => [plain(HOMING), after_gap(checks(&view.checks, look, limit))].concat(),
        // Before the first trial there is no trace to look at, but a device.
        Phase::Ready if view.trace.is_empty() && !view.checks.is_empty() => {
            let all = view.messages.is_empty() || view.checks.len() <= LEAVES_ROOM;
            let list = if all { checks } else { bad_checks };
            [plain(READY), after_gap(list(&view.checks, look, limit))].concat()
        }
        Phase::Ready => [plain(READY), cells(view, limit)].concat(),
        Phase::Trial { .. } => {
            plain("The trial runs until its time is up. Space stops it at once, at 0 V.")
        }
        Phase::Question { text, scale } => question(text, scale, look, limit, is_low),
        Phase::Pause { .. } => {
            let rest = if view.held { HELD } else { "Rest. Both actuators are off." };
            [plain(rest), next(view, limit), cells(view, limit)].concat()
        }
        Phase::Stopped { why } => {
            let why = styled(why, Role::Warn, look, limit);
            [why, plain(STOPPED), next(view, limit)].concat()
        }
        Phase::Done => {
            let done = plain("Every trial is done and stored; q ends the session.");
            [done, cells(view, limit)].concat()
        }
        Phase::Left => plain("The session is closed."),
    }
}

const HELD: &str = "The pause is held; both actuators are off. p or Enter ends it.";

const READY: &str = "Finger on the lever. Enter starts the trial.";

const AT_STOP: &str = "Hold the lever still against its lower stop. Enter says that it is there; \
    both actuators are off.";

const HOMING: &str = "The lever must rest against its lower stop; both actuators are off. \
    Without this the angle is unknown, and nothing is switched on.";

const STOPPED: &str = "Both actuators are at 0 V. Enter goes on with the check or the homing that is due; a trial \
    that was cut is done again.";

/// The next trial, if there is one.
fn next(view: &View, limit: usize) -> Vec<Line<'static>> {
    let words = trial(view).map(|trial| fit(&format!("Next: {trial}"), limit));
    words.into_iter().map(Line::raw).collect()
}

/// What is done of each condition: a line an environment where there are few, else what is done of
/// each environment in one.
fn cells(view: &View, limit: usize) -> Vec<Line<'static>> {
    const LINES: usize = 2;
    let mut environments: Vec<(&str, Vec<&Cell>)> = Vec::new();
    for cell in &view.cells {
        // Cells of one environment stand side by side.
        match environments.last_mut().filter(|(name, _)| *name == cell.environment) {
            Some((_, cells)) => cells.push(cell),
            None => environments.push((&cell.environment, vec![cell])),
        }
    }
    let mut lines = Vec::new();
    let mut totals = Vec::new();
    for (name, cells) in environments {
        let done: usize = cells.iter().map(|cell| cell.done).sum();
        let all: usize = cells.iter().map(|cell| cell.of).sum();
        let total = format!("{name} {done} of {all}");
        let modes: Option<Vec<String>> = cells
            .iter()
            .map(|cell| {
                let mode = cell.mode.as_ref().filter(|_| !view.blinded)?;
                Some(format!("{mode} {} of {}", cell.done, cell.of))
            })
            .collect();
        lines.push(match modes {
            Some(modes) => format!("{name}: {}", modes.join(", ")),
            None => total.clone(),
        });
        totals.push(total);
    }
    if lines.len() <= LINES && lines.iter().all(|line| width(line) <= limit) {
        return lines.into_iter().map(Line::raw).collect();
    }
    vec![Line::raw(fit(&totals.join(" · "), limit))]
}

fn after_gap(lines: Vec<Line<'static>>) -> Vec<Line<'static>> {
    [vec![Line::default()], lines].concat()
}

fn styled(text: &str, role: Role, look: Look, limit: usize) -> Vec<Line<'static>> {
    wrap(text, limit).into_iter().map(|line| Line::styled(line, look.style(role))).collect()
}

/// The question and its scale: in one row where it fits, else one row an answer; of a long scale
/// the ends and what has a word, and where there is little room the ends alone.
fn question(
    text: &str,
    scale: &AnswerScale,
    look: Look,
    limit: usize,
    is_low: bool,
) -> Vec<Line<'static>> {
    let mut lines = styled(text, Role::Strong, look, limit);
    lines.extend((!is_low).then(Line::default));
    let shown = scale.answers().into_iter().filter(|answer| {
        let is_end = [scale.lowest(), scale.highest()].contains(answer);
        is_end
            || scale.is_nominal()
            || (!is_low && (scale.is_short() || scale.word(*answer).is_some()))
    });
    let answers: Vec<[Span<'static>; 2]> = shown
        .map(|answer| {
            let word = scale.word(answer).map(|word| format!(" {word}")).unwrap_or_default();
            [Span::styled(answer.to_string(), look.style(Role::Accent)), Span::raw(word)]
        })
        .collect();
    if !scale.is_short() {
        let what = format!("A number from {}, then Enter.", scale.range());
        lines.extend(styled(&what, Role::Plain, look, limit));
    }
    let row: usize = answers.iter().flatten().map(Span::width).sum();
    let gaps = answers.len().saturating_sub(1).max(1);
    if row + 2 * gaps > limit {
        lines.extend(answers.into_iter().map(Line::from_iter));
        return lines;
    }
    let gap = " ".repeat((limit - row) / gaps).chars().take(5).collect::<String>();
    let spaced = answers.into_iter().enumerate().flat_map(|(i, answer)| {
        let space = if i == 0 { String::new() } else { gap.clone() };
        std::iter::once(Span::raw(space)).chain(answer)
    });
    lines.push(Line::from_iter(spaced));
    lines
}

/// The device check as a list; in words whether a line passed, not by colour alone.
fn checks(checks: &[CheckLine], look: Look, limit: usize) -> Vec<Line<'static>> {
    let widest = checks.iter().map(|check| width(&check.name)).max().unwrap_or(0);
    let lines = checks.iter().map(|check| {
        // As wide as each other, so that the names stand below each other.
        let (verdict, role) =
            if check.ok { ("ok    ", Role::Good) } else { ("FAILED", Role::Warn) };
        let pad = " ".repeat(widest - width(&check.name));
        let text = format!("  {}{pad}  {}", check.name, check.value);
        Line::from(vec![
            Span::styled(verdict, look.style(role)),
            Span::raw(fit(&text, limit.saturating_sub(verdict.len()))),
        ])
    });
    lines.collect()
}

/// The lines that are not good enough, and how many are.
fn bad_checks(all: &[CheckLine], look: Look, limit: usize) -> Vec<Line<'static>> {
    let bad: Vec<CheckLine> = all.iter().filter(|check| !check.ok).cloned().collect();
    let good = format!("{} of {} device checks are ok", all.len() - bad.len(), all.len());
    [vec![Line::raw(fit(&good, limit))], checks(&bad, look, limit)].concat()
}
