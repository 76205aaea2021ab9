//! How a screen looks: with or without colour, with or without anything beyond ASCII.

use ratatui::buffer::Buffer;
use ratatui::style::{Color, Modifier, Style};

/// How a screen looks. Nothing is shown by colour alone, so all four combinations show the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Look {
    /// Whether colours are used.
    pub colour: bool,
    /// Whether only ASCII characters are written.
    pub ascii: bool,
}

impl Look {
    /// What the environment asks for: no colour with `NO_COLOR` or on a terminal that has none;
    /// ASCII if `ascii`, on a terminal known to have no more, or in a locale that is not UTF-8.
    pub fn from_env(ascii: bool) -> Self {
        Self::of(ascii, |name| std::env::var(name).ok().filter(|value| !value.is_empty()))
    }

    fn of(ascii: bool, var: impl Fn(&str) -> Option<String>) -> Self {
        let term = var("TERM").unwrap_or_default();
        let locale = ["LC_ALL", "LC_CTYPE", "LANG"].into_iter().find_map(&var);
        let plain_term = ["vt", "linux", "dumb"].iter().any(|start| term.starts_with(start));
        let plain_locale = locale.is_some_and(|locale| {
            let locale = locale.to_ascii_lowercase();
            !locale.contains("utf-8") && !locale.contains("utf8")
        });
        Self {
            colour: var("NO_COLOR").is_none() && !term.starts_with("vt") && term != "dumb",
            ascii: ascii || plain_term || plain_locale,
        }
    }

    /// The style of a role.
    pub(crate) fn style(self, role: Role) -> Style {
        let (colour, modifier) = match role {
            Role::Plain => (Color::Reset, Modifier::empty()),
            Role::Strong => (Color::Reset, Modifier::BOLD),
            // Not grey: some palettes have their background there.
            Role::Quiet => (Color::Reset, Modifier::DIM),
            Role::Accent => (Color::Cyan, Modifier::BOLD),
            Role::Good => (Color::Green, Modifier::empty()),
            Role::Warn => (Color::Yellow, Modifier::BOLD),
            Role::Stop => (Color::Red, Modifier::BOLD.union(Modifier::REVERSED)),
        };
        let style = Style::new().add_modifier(modifier);
        if self.colour { style.fg(colour) } else { style }
    }
}

/// What a piece of the screen is, for its style.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    /// Running text.
    Plain,
    /// A number or a word to be seen first.
    Strong,
    /// Labels and axes.
    Quiet,
    /// The phase, and the keys.
    Accent,
    /// A check that passed.
    Good,
    /// What wants attention.
    Warn,
    /// The stop key, and what stopped a trial.
    Stop,
}

/// Writes every cell of a buffer in ASCII: lines and bars by their nearest likeness, what has none
/// as `?`.
pub(crate) fn to_ascii(buffer: &mut Buffer) {
    for cell in buffer.content.iter_mut().filter(|cell| !cell.symbol().is_ascii()) {
        let likeness = likeness(cell.symbol());
        cell.set_symbol(likeness);
    }
}

fn likeness(symbol: &str) -> &'static str {
    match symbol.chars().next().unwrap_or(' ') {
        '█' | '▓' => "#",
        '░' | '·' | '…' | '•' => ".",
        '─' | '━' | '╌' | '–' | '—' | '−' => "-",
        '│' | '┃' => "|",
        '┌' | '┐' | '└' | '┘' => "+",
        '✓' => "+",
        '✗' => "x",
        'µ' | 'μ' => "u",
        'θ' => "q",
        '×' => "x",
        '‘' | '’' => "'",
        '“' | '”' => "\"",
        _ => "?",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ratatui::layout::Rect;

    fn look(vars: &[(&str, &str)]) -> Look {
        Look::of(false, |name| vars.iter().find(|(n, _)| *n == name).map(|(_, v)| (*v).to_owned()))
    }

    #[test]
    fn a_modern_terminal_has_colour_and_more_than_ascii() {
        let full = Look { colour: true, ascii: false };
        assert_eq!(look(&[("TERM", "xterm-256color"), ("LANG", "en_GB.UTF-8")]), full);
        assert_eq!(look(&[("TERM", "xterm-256color")]), full);
    }

    #[test]
    fn no_color_old_terminals_and_other_locales_are_heeded() {
        assert!(!look(&[("NO_COLOR", "1"), ("TERM", "xterm")]).colour);
        assert_eq!(
            look(&[("TERM", "vt100"), ("LANG", "C.UTF-8")]),
            Look { colour: false, ascii: true }
        );
        assert!(look(&[("TERM", "xterm"), ("LC_ALL", "C"), ("LANG", "C.UTF-8")]).ascii);
        assert!(Look::of(true, |_| None).ascii);
    }

    #[test]
    fn an_ascii_buffer_holds_nothing_else() {
        let mut buffer = Buffer::empty(Rect::new(0, 0, 8, 1));
        buffer.set_string(0, 0, "│█ é✓ µs", Style::new());
        to_ascii(&mut buffer);
        let text: String = buffer.content.iter().map(|cell| cell.symbol()).collect();
        assert_eq!(text, "|# ?+ us");
    }
}
