//! A box with words in it, to and from which arrows lead.

use super::pieces::{line, tint, within};
use super::way::Point;
use zwidth_draw::Layer;
use zwidth_draw::style::{self, Colour, Stroke};

/// A box with words in it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Block {
    /// Its middle.
    pub(crate) at: Point,
    /// Width and height, mm.
    pub(crate) size: (f64, f64),
    /// Lines of markup.
    pub(crate) lines: Vec<String>,
    /// Of its edge and, light, of its ground.
    pub(crate) colour: Colour,
}

impl Block {
    /// A box of soft black.
    pub(crate) fn new<S: Into<String>>(
        at: Point,
        size: (f64, f64),
        lines: impl IntoIterator<Item = S>,
    ) -> Self {
        let lines = lines.into_iter().map(Into::into).collect();
        Self { at, size, lines, colour: style::GREY }
    }

    /// The same in another colour.
    pub(crate) fn coloured(self, colour: Colour) -> Self {
        Self { colour, ..self }
    }

    /// The middle of its left edge.
    pub(crate) fn left(&self) -> Point {
        (self.at.0 - self.size.0 / 2.0, self.at.1)
    }

    /// The middle of its right edge.
    pub(crate) fn right(&self) -> Point {
        (self.at.0 + self.size.0 / 2.0, self.at.1)
    }

    /// The middle of its upper edge.
    pub(crate) fn top(&self) -> Point {
        (self.at.0, self.at.1 + self.size.1 / 2.0)
    }

    /// The middle of its lower edge.
    pub(crate) fn bottom(&self) -> Point {
        (self.at.0, self.at.1 - self.size.1 / 2.0)
    }

    /// Ground, edge and words.
    pub(crate) fn layers(&self) -> Vec<Layer> {
        let low = (self.left().0, self.bottom().1);
        let high = (self.right().0, self.top().1);
        let edge = Stroke { width_pt: 0.9, ..style::mean(self.colour) };
        let corners = [low, (high.0, low.1), high, (low.0, high.1), low];
        vec![
            tint(low, high, self.colour),
            line(corners, edge),
            within(self.lines.clone(), low, high),
        ]
    }
}
