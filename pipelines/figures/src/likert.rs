//! Figure 30: answers as diverging bars, their counts in the boxes.

use crate::words::{mark, plain};
use zwidth_draw::{Axis, Cell, Figure, Layer, Likert, LikertScale, Panel, Ticks};
use zwidth_study::{Likert as Scale, Source};

/// One panel: a heading, and for each row a label and the counts of the answers 1…5.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LikertPanel {
    /// Heading: the environment, or the question.
    pub title: String,
    /// Label and counts of each row.
    pub rows: Vec<(String, [u32; 5])>,
}

/// Height a row of bars takes, mm.
const ROW_MM: f64 = 7.5;
/// Panels side by side in a two-column figure.
const COLUMNS: usize = 2;

/// Diverging bars, `COLUMNS` panels side by side. `footnotes` says what was reversed.
pub fn likert(
    title: &str,
    panels: &[LikertPanel],
    footnotes: &[String],
    sources: &[Source],
) -> Figure {
    let columns = COLUMNS.min(panels.len().max(1));
    let totals = panels.iter().flat_map(|p| &p.rows).map(|(_, counts)| counts.iter().sum::<u32>());
    let (least, most) = totals.fold((u32::MAX, 0), |(a, b), n| (a.min(n), b.max(n)));
    let scale = if least == most { LikertScale::Counts } else { LikertScale::Percent };
    let drawn =
        panels.iter().enumerate().map(|(i, p)| panel(p, Cell::at(i / columns, i % columns), scale));
    Figure {
        title: Some(plain(title)),
        description: format!(
            "{title}: number of answers from strongly disagree to strongly agree, a row of boxes each; the neutral \
             answers straddle zero."
        ),
        width_mm: if columns == 1 { 120.0 } else { zwidth_draw::TWO_COLUMNS_MM },
        panels: drawn.collect(),
        footnotes: footnotes.iter().map(|n| plain(n)).collect(),
        mark: mark(sources.iter().copied()),
        ..Figure::default()
    }
}

fn panel(p: &LikertPanel, cell: Cell, scale: LikertScale) -> Panel {
    let (label, unit) = match scale {
        LikertScale::Counts => ("answers, against ← → in favour", ""),
        LikertScale::Percent => ("answers, against ← → in favour", "%"),
    };
    let x = Axis { ticks: Ticks::Magnitudes, ..Axis::new(label, unit) }.linked("answers");
    let y = Axis::categories(p.rows.iter().map(|(label, _)| plain(label)));
    let bars = Likert {
        answers: Scale::WORDS.iter().map(|w| (*w).to_owned()).collect(),
        rows: p.rows.iter().map(|(_, counts)| counts.to_vec()).collect(),
        scale,
    };
    let panel = Panel::new(cell, x, y, vec![Layer::Likert(bars)]).titled(plain(&p.title));
    Panel { height_mm: Some(ROW_MM * p.rows.len() as f64), ..panel }
}
