//! The whole screen: it turns a view into a frame.

use super::foot;
use super::keys::Entry;
use super::look::{Look, Role, to_ascii};
use super::text::{bar, fit, width, wrap};
use super::{felt, panel, place, trace};
use crate::course::in_words;
use crate::{Course, Phase, View};
use ratatui::Frame;
use ratatui::buffer::Buffer;
use ratatui::layout::{Margin, Rect};
use ratatui::text::{Line, Span};
use ratatui::widgets::Widget;

/// Rows below which traces say nothing: two plots of a title and three rows, and the axis.
const TRACE_ROWS: u16 = 9;

/// Rows kept for what is to be read and for messages, so that the traces stay where they are from
/// phase to phase: a question of two lines, an empty one, its scale, an empty one, and a message.
const TALK_ROWS: u16 = 6;

/// Draws a view, and what is typed, into a frame.
///
/// From the top: who and what; progress; the phase with its trial and time left; the traces; what
/// is to be read or answered, and messages; how the loop keeps time; the keys. In a window that is
/// too small the traces go first, then the messages; the last row, with the stop key, stays.
pub(super) fn render(view: &View, entry: Option<&Entry>, look: Look, frame: &mut Frame<'_>) {
    let area = frame.area();
    let buffer = frame.buffer_mut();
    let entry = entry.filter(|_| !matches!(view.phase, Phase::Trial { .. }));
    let inner = area.inner(Margin::new(1, 0));
    let limit = usize::from(inner.width);
    let mut talk = panel::lines(view, look, limit, false);
    // Beside the phase and the keys.
    if cells(talk.len() + 2) > inner.height {
        talk = panel::lines(view, look, limit, true);
    }
    talk.extend(entry.map_or(Vec::new(), |entry| foot::entry(entry, look, limit)));
    let rows = Rows::of(inner, view, cells(talk.len()));
    title(view, look, rows.title, buffer);
    progress(view, look, rows.progress, buffer);
    headline(view, look, rows.headline, buffer);
    verdict(view, look, rows.verdict, buffer);
    let [traces, felt] = felt::split(rows.traces);
    trace::draw(view, look, traces, buffer);
    if !felt.is_empty() {
        felt::draw(view, look, felt, buffer);
    }
    let (_, free) = place::cut(rows.talk, cells(talk.len() + 1));
    stack(talk.into_iter(), rows.talk, buffer);
    messages(view, free, buffer);
    foot::timing(&view.timing, look, limit).render(rows.timing, buffer);
    foot::keys(view, entry, look).render(rows.keys, buffer);
    if look.ascii {
        to_ascii(buffer);
    }
}

/// Whether there is something to draw, or will be in a moment.
fn has_traces(view: &View) -> bool {
    match view.phase {
        Phase::Check | Phase::Step { .. } | Phase::AtStop | Phase::Homing | Phase::Left => false,
        Phase::Trial { .. } => true,
        _ => !view.trace.is_empty(),
    }
}

/// A number of cells as ratatui counts them.
fn cells(n: usize) -> u16 {
    u16::try_from(n).unwrap_or(u16::MAX)
}

/// Where each part of the screen stands; a part without room has an empty area.
struct Rows {
    title: Rect,
    progress: Rect,
    headline: Rect,
    /// Empty but for a verdict.
    verdict: Rect,
    traces: Rect,
    talk: Rect,
    timing: Rect,
    keys: Rect,
}

impl Rows {
    /// The most needed parts take their rows first: the stop key, the phase, what is to be
    /// answered.
    fn of(area: Rect, view: &View, talk: u16) -> Self {
        let left = &mut { area.height };
        let told = u16::from(view.verdict.is_some());
        let [keys, headline, talk, told] = [1, 1, talk, told].map(|rows| take(left, rows));
        let [title, timing, progress, gap] = [1, 1, 1, 1 - told].map(|rows| take(left, rows));
        let talk = talk + take(left, TALK_ROWS.max(talk + 1) - talk);
        // In a high window messages get some of the room, without traces all of it.
        let more = if has_traces(view) { *left / 8 } else { *left };
        let talk = if *left - more >= TRACE_ROWS {
            talk + take(left, more)
        } else {
            talk + take(left, *left)
        };
        let heights = [title, progress, headline, told + gap, *left, talk, timing, keys];
        let [title, progress, headline, verdict, traces, talk, timing, keys] =
            place::rows(area, heights);
        Self { title, progress, headline, verdict, traces, talk, timing, keys }
    }
}

/// Takes rows from what is left, as far as there are any.
fn take(left: &mut u16, wanted: u16) -> u16 {
    let rows = wanted.min(*left);
    *left -= rows;
    rows
}

/// A row with something at its left and at its right end; the left gives way.
fn ends(left: &str, role: Role, right: Line<'_>, look: Look, area: Rect, buffer: &mut Buffer) {
    let room = usize::from(area.width).saturating_sub(right.width() + 2);
    Line::styled(fit(left, room), look.style(role)).render(area, buffer);
    right.right_aligned().render(area, buffer);
}

fn title(view: &View, look: Look, area: Rect, buffer: &mut Buffer) {
    let mut marks = vec![Span::raw(fit(&view.device, usize::from(area.width) / 3))];
    if view.simulated {
        marks.push(Span::styled("  SIMULATED", look.style(Role::Warn)));
    }
    if view.blinded {
        marks.push(Span::styled("  BLINDED", look.style(Role::Strong)));
    }
    let who = [view.study.as_str(), &view.participant, &view.session].join(" · ");
    ends(&who, Role::Strong, Line::from(marks), look, area, buffer);
}

fn progress(view: &View, look: Look, area: Rect, buffer: &mut Buffer) {
    let Course { elapsed_s, left_s } = view.course;
    let time = match (elapsed_s > 0.0, left_s) {
        (true, Some(left_s)) => {
            format!(" · {}, about {} to go", in_words(elapsed_s), in_words(left_s))
        }
        (true, None) => format!(" · {}", in_words(elapsed_s)),
        (false, Some(left_s)) => format!(" · about {} to go", in_words(left_s)),
        (false, None) => String::new(),
    };
    let done = format!("{} of {} done", view.done, view.total);
    let whole = format!("{done}{time}");
    let done = if width(&whole) <= usize::from(area.width) { whole } else { done };
    let cells = usize::from(area.width).saturating_sub(width(&done) + 2);
    let bar = bar(view.done as f64 / view.total as f64, cells);
    ends(&bar, Role::Quiet, Line::raw(done), look, area, buffer);
}

/// The phase, its trial, and the time left: in seconds, and as a bar that empties in what room
/// there is.
fn headline(view: &View, look: Look, area: Rect, buffer: &mut Buffer) {
    /// Cells of the bar, at most, and at least: a shorter one says nothing.
    const BAR: (usize, usize) = (20, 4);
    let role = if matches!(view.phase, Phase::Stopped { .. }) { Role::Warn } else { Role::Accent };
    let name = panel::name(&view.phase);
    let is_trial =
        matches!(view.phase, Phase::Ready | Phase::Trial { .. } | Phase::Question { .. });
    let trial = panel::trial(view).filter(|_| is_trial).unwrap_or_default();
    let left = panel::countdown(&view.phase).map_or(String::new(), |(left_s, whole_s)| {
        let seconds = format!(" {left_s:>4.1} s left");
        let taken = width(name) + 3 + width(&trial) + 2 + width(&seconds);
        let room = usize::from(area.width).saturating_sub(taken).min(BAR.0);
        bar(left_s / whole_s, if room < BAR.1 { 0 } else { room }) + &seconds
    });
    Line::styled(name, look.style(role)).render(area, buffer);
    let (_, rest) = place::cut_left(area, cells(width(name) + 3));
    ends(&trial, Role::Strong, Line::styled(left, look.style(Role::Strong)), look, rest, buffer);
}

/// Whether the trial that is shown met the protocol.
fn verdict(view: &View, look: Look, area: Rect, buffer: &mut Buffer) {
    let Some(verdict) = &view.verdict else { return };
    let role = if verdict.unmet.is_none() { Role::Good } else { Role::Warn };
    let (room, whole) = (usize::from(area.width), verdict.in_words());
    // In a small window what was not met is worth more than of which trial.
    let short = verdict.unmet.as_ref().map(|what| format!("not met: {what}"));
    let words = short.filter(|_| width(&whole) > room).unwrap_or(whole);
    Line::styled(fit(&words, room), look.style(role)).render(area, buffer);
}

fn stack<'a>(lines: impl Iterator<Item = Line<'a>>, area: Rect, buffer: &mut Buffer) {
    for (row, line) in area.rows().zip(lines) {
        line.render(row, buffer);
    }
}

/// The newest messages that fit whole, the newest at the foot; of one that does not fit alone, its
/// beginning.
fn messages(view: &View, area: Rect, buffer: &mut Buffer) {
    let room = usize::from(area.height);
    let mut shown: Vec<String> = Vec::new();
    for message in view.messages.iter().rev() {
        let lines =
            wrap(message, usize::from(area.width).saturating_sub(2)).into_iter().enumerate();
        let lines: Vec<String> = lines
            .map(|(i, line)| if i == 0 { format!("> {line}") } else { format!("  {line}") })
            .collect();
        if shown.is_empty() {
            shown = lines.into_iter().take(room).collect();
        } else if shown.len() + lines.len() <= room {
            shown.splice(0..0, lines);
        } else {
            break;
        }
    }
    let (_, foot) = place::cut(area, area.height - cells(shown.len()));
    stack(shown.into_iter().map(Line::raw), foot, buffer);
}
