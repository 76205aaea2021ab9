//! Words at the ends of reference lines, outside of the plot area and clear of each other.

use crate::axis::{LABEL_GAP_PT, PLOT_GAP_PT};
use crate::error::Error;
use crate::figure::{Direction, Layer, Panel};
use crate::font::{self, Fonts, Label};
use crate::scale::Scale;
use crate::sheet::{At, Rect};
use crate::style::SMALL_PT;

/// A label and where its base line starts.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Word {
    pub(crate) label: Label,
    pub(crate) at: At,
}

/// Places the labels of a panel's reference lines: those of horizontal lines right of the plot,
/// those of vertical lines over it, in lines no wider than it is, beside its heading where there is
/// room.
pub(crate) fn plan(
    fonts: &Fonts,
    panel: &Panel,
    x: Option<Scale>,
    y: Option<Scale>,
    title: &[Label],
    plot: &Rect,
) -> Result<Vec<Word>, Error> {
    // The heading's lines from the lowest up, as rows of labels are counted.
    let title_ends = title.iter().rev().map(|line| plot.left + line.width_pt).collect();
    let mut upright = Vec::new();
    for (at, markup) in labels(panel, Direction::Vertical, x) {
        upright.push((at, fonts.wrap(markup, SMALL_PT, plot.width())?));
    }
    let mut beside = Vec::new();
    for (at, markup) in labels(panel, Direction::Horizontal, y) {
        beside.push((at, fonts.label(markup, SMALL_PT)?));
    }
    let mut words = over(upright, title_ends, plot);
    words.extend(stack_beside(beside, plot));
    Ok(words)
}

/// Labels of the lines of one direction with their places on the page, in order. Lines outside of
/// the axis have none.
fn labels(panel: &Panel, direction: Direction, scale: Option<Scale>) -> Vec<(f64, &str)> {
    let Some(scale) = scale else { return Vec::new() };
    let lines = panel.layers.iter().filter_map(|layer| match layer {
        Layer::Reference(line) if line.direction == direction => Some(line),
        _ => None,
    });
    let mut labels = Vec::new();
    for line in lines.filter(|line| (scale.ends.0..=scale.ends.1).contains(&line.at)) {
        if let Some(markup) = &line.label {
            labels.push((scale.pt(line.at), markup.as_str()));
        }
    }
    labels.sort_by(|a, b| a.0.total_cmp(&b.0));
    labels
}

/// Rows over the plot; `row_ends` says how far each row, from the lowest up, is taken already.
fn over(labels: Vec<(f64, Vec<Label>)>, mut row_ends: Vec<f64>, plot: &Rect) -> Vec<Word> {
    let mut words = Vec::new();
    for (at, lines) in labels {
        let width_pt = font::widest_pt(&lines);
        let left = (at - width_pt / 2.0).min(plot.right - width_pt).max(plot.left);
        // The lowest rows that are free where the label begins: labels come from left to right.
        let lowest = (0..row_ends.len())
            .find(|row| {
                row_ends[*row..].iter().take(lines.len()).all(|end| end + LABEL_GAP_PT < left)
            })
            .unwrap_or(row_ends.len());
        row_ends.resize(row_ends.len().max(lowest + lines.len()), 0.0);
        for (i, label) in lines.into_iter().rev().enumerate() {
            let row = lowest + i;
            row_ends[row] = left + width_pt;
            let base = plot.top - PLOT_GAP_PT - label.descent_pt() - row as f64 * label.height_pt();
            words.push(Word { label, at: (left, base) });
        }
    }
    words
}

/// A column right of the plot, each label no higher than the one before it allows.
fn stack_beside(labels: Vec<(f64, Label)>, plot: &Rect) -> Vec<Word> {
    let mut lowest = f64::NEG_INFINITY;
    let mut words = Vec::new();
    for (at, label) in labels {
        let base = (at + label.cap_pt() / 2.0).max(lowest + label.height_pt());
        lowest = base;
        words.push(Word { label, at: (plot.right + PLOT_GAP_PT, base) });
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::Reference;

    const PLOT: Rect = Rect { left: 50.0, top: 50.0, right: 150.0, bottom: 100.0 };

    fn label(markup: &str) -> Label {
        Fonts::bundled().unwrap().label(markup, SMALL_PT).unwrap()
    }

    #[test]
    fn a_word_over_the_plot_stays_between_its_edges() {
        let [start, wall] = ["start", "wall"].map(|markup| vec![label(markup)]);
        let words = over(vec![(50.0, start), (150.0, wall)], Vec::new(), &PLOT);
        assert_eq!(words[0].at.0, PLOT.left);
        assert!(words[1].at.0 + words[1].label.width_pt <= PLOT.right);
        assert_eq!(words[0].at.1, words[1].at.1);
    }

    #[test]
    fn words_that_would_touch_go_to_different_rows() {
        let [wall, stop] = ["wall", "stop"].map(|markup| vec![label(markup)]);
        let words = over(vec![(100.0, wall), (104.0, stop)], Vec::new(), &PLOT);
        assert!(words[1].at.1 < words[0].at.1 - SMALL_PT);
        let beside = stack_beside(vec![(70.0, label("wall")), (71.0, label("stop"))], &PLOT);
        assert!(beside[1].at.1 > beside[0].at.1 + SMALL_PT);
    }

    #[test]
    fn a_label_longer_than_the_plot_is_wide_breaks_at_spaces_over_it() {
        let layers = ["brake: none below 1.01 V of the command", "stop"].map(|label| {
            let line = Reference::new(Direction::Vertical, 1.0, crate::style::reference());
            Layer::Reference(Reference { label: Some(label.to_owned()), ..line })
        });
        let [x, y] = [0, 1].map(|_| crate::figure::Axis::new("", ""));
        let cell = crate::figure::Cell::at(0, 0);
        let panel = Panel::new(cell, x, y, layers.to_vec());
        let x = Scale { ends: (0.0, 2.0), page_pt: (PLOT.left, PLOT.right) };
        let words = plan(Fonts::bundled().unwrap(), &panel, Some(x), None, &[], &PLOT).unwrap();
        let texts: Vec<String> = words.iter().map(|word| word.label.text()).collect();
        assert_eq!(texts, ["the command", "brake: none below 1.01 V of", "stop"]);
        assert!(words.iter().all(|word| word.at.0 + word.label.width_pt <= PLOT.right));
        assert!(words[1].at.1 < words[0].at.1 && words[2].at.1 < words[1].at.1, "{words:?}");
    }
}
