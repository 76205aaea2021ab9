//! The participant's screen: it turns a sight into a frame.

use super::big::{ROWS, big, big_width};
use super::sight::{Now, OpenQuestion, Sight};
use crate::screen::look::{Look, Role, to_ascii};
use crate::screen::text::{fit, width, wrap};
use ratatui::Frame;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;

/// The most cells of a line: a longer one is hard to read from a distance.
const LONGEST: usize = 64;

/// Draws a sight. `typed` is the number typed so far; `is_answered` says that the open question was
/// answered.
///
/// From the top: how much is done; a word in large letters; what to do, or the question with its
/// answers; how the screen is closed. In a small window the first and the last row go first, then
/// the large letters; what is to be read stays.
pub(super) fn render(
    sight: &Sight,
    typed: &str,
    is_answered: bool,
    look: Look,
    frame: &mut Frame<'_>,
) {
    let area = frame.area();
    let buffer = frame.buffer_mut();
    let room = usize::from(area.width).saturating_sub(2).clamp(1, LONGEST);
    let text = text(sight, typed, is_answered, room, area.height.into());
    let mut top = area.y;
    let mut height = usize::from(area.height);
    if height >= text.len() + 4 {
        let progress = format!("{} of {} trials done", sight.done, sight.total);
        centred(&progress, Role::Quiet, look, Rect { y: top, ..area }, buffer);
        let foot = "Ctrl-C closes this screen";
        centred(foot, Role::Quiet, look, Rect { y: area.bottom() - 1, ..area }, buffer);
        (top, height) = (top + 1, height - 2);
    }
    // Where there is a question to be read there is no room for a word.
    let is_asked = matches!(sight.now, Now::Question(_)) && !is_answered;
    let (word, _) = words(&sight.now);
    let word = if is_asked { String::new() } else { word };
    let is_large = height >= text.len() + ROWS && big_width(&word) <= usize::from(area.width);
    let head = match (is_large, word.is_empty()) {
        (_, true) => Vec::new(),
        (true, _) => {
            let gap = usize::from(height > text.len() + ROWS);
            [big(&word), vec![String::new(); gap]].concat()
        }
        (false, _) if height > text.len() => vec![word],
        (false, _) => Vec::new(),
    };
    let lines = head
        .into_iter()
        .map(|line| (line, Role::Accent))
        .chain(text.into_iter().map(|line| (line, Role::Strong)));
    let lines: Vec<(String, Role)> = lines.collect();
    // The rows of a window are few: the cast cannot lose anything.
    let gap = (height.saturating_sub(lines.len()) / 2) as u16;
    for (row, (line, role)) in (top + gap..area.bottom()).zip(&lines) {
        centred(line, *role, look, Rect { y: row, ..area }, buffer);
    }
    if look.ascii {
        to_ascii(buffer);
    }
}

fn centred(line: &str, role: Role, look: Look, area: Rect, buffer: &mut Buffer) {
    // A window without rows has no place for a line.
    if !buffer.area.contains(area.as_position()) {
        return;
    }
    let line = fit(line, usize::from(area.width));
    // A line fits its row: the cast cannot lose anything.
    let left = area.x + (usize::from(area.width) - width(&line)) as u16 / 2;
    let style: Style = look.style(role);
    buffer.set_string(left, area.y, line, style);
}

/// What is to be read, in lines of at most `limit` cells, and in `height` rows if it can be.
fn text(sight: &Sight, typed: &str, is_answered: bool, limit: usize, height: usize) -> Vec<String> {
    match &sight.now {
        Now::Question(open) if !is_answered => {
            let wide = question(open, typed, limit, true);
            if wide.len() <= height { wide } else { question(open, typed, limit, false) }
        }
        now => {
            let is_trial = matches!(now, Now::Ready | Now::Go);
            let environment = sight.environment.as_deref().filter(|_| is_trial);
            let practice = if sight.practice { " (practice)" } else { "" };
            let interval = sight.interval.map_or(String::new(), |[n, of]| format!(", {n} of {of}"));
            let environment =
                environment.map(|name| wrap(&format!("{name}{practice}{interval}"), limit));
            let (_, instruction) = words(now);
            let instruction = if sight.is_between() { FOLLOWS } else { instruction };
            let told = sight.told().map(|word| vec![word.to_owned()]).unwrap_or_default();
            [told, environment.unwrap_or_default(), wrap(instruction, limit)].concat()
        }
    }
}

/// What to do between the intervals of a presentation.
const FOLLOWS: &str = "The next one follows. Finger on the lever.";

/// The word in large letters, and what to do now; a question was answered.
fn words(now: &Now) -> (String, &'static str) {
    let (word, instruction) = match now {
        Now::Wait => ("WAIT", "Please wait. The device is being prepared."),
        Now::Ready => ("READY", "Finger on the lever. The experimenter starts the trial."),
        Now::Go => ("GO", "Move the lever forward and back, once."),
        Now::Question(_) => ("WAIT", "Thank you. Please wait."),
        Now::Pause { left_s } => {
            return (left_s.to_string(), "seconds of rest. Finger off the lever.");
        }
        Now::Held => ("PAUSE", "Rest until the experimenter goes on. Finger off the lever."),
        Now::Stopped => ("STOP", "Finger off the lever. Please wait for the experimenter."),
        Now::Done | Now::Left => ("DONE", "That was the last trial. Thank you."),
    };
    (word.to_owned(), instruction)
}

/// The question and its answers, one per line; without empty lines if it is not `wide`.
fn question(open: &OpenQuestion, typed: &str, limit: usize, wide: bool) -> Vec<String> {
    let gap = if wide { vec![String::new()] } else { Vec::new() };
    let answers: Vec<String> = open.shown().map(|choice| fit(&choice.words(), limit)).collect();
    let longest = answers.iter().map(|answer| width(answer)).max().unwrap_or(0);
    let how = format!("A number from {}, then Enter: {typed}_", open.range);
    let how = if open.has_keys() { Vec::new() } else { [gap.clone(), wrap(&how, limit)].concat() };
    // All as long as the longest: centred, they begin in the same cell.
    let answers = answers.into_iter().map(|answer| {
        let pad = " ".repeat(longest - width(&answer));
        answer + &pad
    });
    let answers = answers.collect();
    [wrap(&open.text, limit), gap, answers, how].concat()
}

#[cfg(test)]
mod tests {
    use super::super::sight::tests::{phases, telling};
    use super::*;
    use crate::{Phase, View};
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;
    use zwidth_study::{AnswerScale, NumberScale, template};

    const FULL: Look = Look { colour: true, ascii: false };
    const BARE: Look = Look { colour: false, ascii: true };
    const LARGE: (u16, u16) = (80, 24);
    const SMALL: (u16, u16) = (40, 10);

    fn rows(view: &View, typed: &str, look: Look, size: (u16, u16)) -> Vec<String> {
        let mut terminal = Terminal::new(TestBackend::new(size.0, size.1)).unwrap();
        let sight = Sight::of(view, 1);
        terminal.draw(|frame| render(&sight, typed, false, look, frame)).unwrap();
        let buffer = terminal.backend().buffer();
        let cells = buffer.content.chunks(usize::from(size.0));
        cells.map(|row| row.iter().map(|cell| cell.symbol()).collect()).collect()
    }

    fn joined(rows: &[String]) -> String {
        rows.join(" ").split_whitespace().collect::<Vec<_>>().join(" ")
    }

    /// The longest question of the commented `study.toml`.
    fn longest() -> String {
        let text = template(&"demo".parse().unwrap());
        let texts = text.lines().filter_map(|line| line.strip_prefix("text = "));
        texts.max_by_key(|text| text.len()).unwrap().trim_matches('"').to_owned()
    }

    #[test]
    fn every_phase_says_what_to_do_and_nothing_of_the_mode_at_both_sizes() {
        for size in [LARGE, SMALL, (120, 40), (20, 4), (1, 1)] {
            for phase in phases() {
                let sight = Sight::of(&telling(phase.clone()), 1);
                let told = joined(&rows(&telling(phase.clone()), "", FULL, size));
                assert!(!told.contains("SECRET") && !told.contains("8888"), "{told}");
                if size.0 >= SMALL.0 && sight.question().is_none() {
                    let (_, instruction) = words(&sight.now);
                    assert!(told.contains(instruction), "{phase:?} {size:?} {told}");
                }
            }
        }
    }

    #[test]
    fn the_longest_question_is_read_with_all_its_answers_in_the_small_window() {
        let view = telling(Phase::Question { text: longest(), scale: AnswerScale::FivePoint });
        for size in [LARGE, SMALL] {
            let told = joined(&rows(&view, "", FULL, size));
            assert!(told.contains(&longest()), "{told}");
            for answer in ["1 strongly disagree", "3 neutral", "5 strongly agree"] {
                assert!(told.contains(answer), "{size:?} {told}");
            }
        }
    }

    #[test]
    fn a_number_that_is_typed_is_seen() {
        let scale = NumberScale { points: 101, from: 0, step: 1, labels: Vec::new() };
        let scale = AnswerScale::Numbers(scale);
        let view = telling(Phase::Question { text: "How stiff?".into(), scale });
        let told = joined(&rows(&view, "42", FULL, SMALL));
        assert!(
            told.contains("How stiff? 0 100 A number from 0 to 100, then Enter: 42_"),
            "{told}"
        );
    }

    #[test]
    fn what_to_do_is_written_large_where_there_is_room() {
        let large = |phase, size| {
            rows(&telling(phase), "", FULL, size).iter().filter(|row| row.contains('█')).count()
        };
        for size in [LARGE, SMALL] {
            assert_eq!(large(Phase::Ready, size), ROWS, "{size:?}");
            assert_eq!(large(Phase::Pause { left_s: 5.0, pause_s: 5.0 }, size), ROWS, "{size:?}");
        }
        assert_eq!(large(Phase::Ready, (40, 6)), 0);
        let told = joined(&rows(&telling(Phase::Ready), "", FULL, (40, 6)));
        assert!(told.contains("READY"), "{told}");
    }

    #[test]
    fn in_ascii_nothing_else_is_written() {
        for phase in phases() {
            assert!(rows(&telling(phase), "", BARE, LARGE).iter().all(|row| row.is_ascii()));
        }
    }
}
