//! The shared legend: every named layer once.

use crate::error::Error;
use crate::figure::{Direction, Figure, Intervals, Layer, LegendPlace, Points};
use crate::font::{Fonts, Label};
use crate::sheet::{At, Rect, Sheet};
use crate::style::{self, Colour, INK, Marker, SMALL_PT, Stroke};

/// Width of a sample of a line or band, in pt.
const SAMPLE_PT: f64 = 15.0;
/// Between a sample and its name, in pt.
const NAME_GAP_PT: f64 = 4.0;
/// Between entries, in pt.
const ENTRY_GAP_PT: f64 = 12.0;
/// Height of a row of entries, in pt.
pub(crate) const ROW_PT: f64 = 10.5;
/// Side of a box sample, in pt.
const BOX_PT: f64 = 7.0;
/// How far a whisker sample is longer than a box at either end, in pt.
const WHISKER_OUT_PT: f64 = 1.0;

/// What a layer looks like in small.
#[derive(Debug, Clone, PartialEq)]
enum Sample {
    Line(Stroke),
    Band(Colour),
    Disc { colour: Colour, diameter_pt: f64, opacity: f64 },
    Whisker { colour: Colour, marker: Marker, direction: Direction },
    Box(Colour),
}

impl Sample {
    fn width_pt(&self) -> f64 {
        match self {
            Sample::Line(_) | Sample::Band(_) => SAMPLE_PT,
            Sample::Whisker { direction: Direction::Horizontal, .. } => {
                BOX_PT + 2.0 * WHISKER_OUT_PT
            }
            _ => BOX_PT,
        }
    }
}

/// A name with its samples, one over the other.
type Entry = (String, Vec<Sample>);

/// An entry with its place along its row.
#[derive(Debug, Clone, PartialEq)]
struct Placed {
    samples: Vec<Sample>,
    sample_pt: f64,
    label: Label,
    x_pt: f64,
}

impl Placed {
    fn end_pt(&self) -> f64 {
        self.x_pt + self.sample_pt + NAME_GAP_PT + self.label.width_pt
    }
}

/// A legend set in rows.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Legend {
    rows: Vec<Vec<Placed>>,
}

impl Legend {
    pub(crate) fn height_pt(&self) -> f64 {
        ROW_PT * self.rows.len() as f64
    }

    pub(crate) fn width_pt(&self) -> f64 {
        let ends =
            self.rows.iter().flatten().map(|e| e.x_pt + SAMPLE_PT + NAME_GAP_PT + e.label.width_pt);
        ends.fold(0.0, f64::max)
    }
}

/// Sets the figure's legend in rows of at most `width_pt`.
pub(crate) fn plan(figure: &Figure, fonts: &Fonts, width_pt: f64) -> Result<Legend, Error> {
    let mut rows: Vec<Vec<Placed>> = Vec::new();
    let mut x_pt = 0.0;
    let shown = figure.legend != LegendPlace::Hidden;
    for (name, samples) in entries(figure).into_iter().filter(|_| shown) {
        let sample_pt = samples.iter().map(Sample::width_pt).fold(0.0, f64::max);
        let label = fonts.label(&name, SMALL_PT)?;
        let mut placed = Placed { samples, sample_pt, label, x_pt };
        if rows.is_empty() || placed.end_pt() > width_pt {
            placed.x_pt = 0.0;
            rows.push(Vec::new());
        }
        // Too wide even alone in its row.
        let need_pt = placed.end_pt();
        if need_pt > width_pt {
            return Err(Error::TextTooLong { text: name, need_pt, have_pt: width_pt });
        }
        x_pt = need_pt + ENTRY_GAP_PT;
        if let Some(row) = rows.last_mut() {
            row.push(placed);
        }
    }
    Ok(Legend { rows })
}

/// Names in order of appearance; layers of one name share an entry, equal samples are shown once.
fn entries(figure: &Figure) -> Vec<Entry> {
    let mut entries: Vec<Entry> = Vec::new();
    // What a note stands in the place of is not drawn, and not named.
    let shown = figure.panels.iter().filter(|panel| panel.note.is_none());
    for (name, sample) in shown.flat_map(|panel| &panel.layers).flat_map(samples) {
        match entries.iter_mut().find(|entry| entry.0 == name) {
            Some((_, samples)) if !samples.contains(&sample) => samples.push(sample),
            Some(_) => {}
            None => entries.push((name, vec![sample])),
        }
    }
    entries
}

fn samples(layer: &Layer) -> Vec<(String, Sample)> {
    let (name, sample) = match layer {
        Layer::Line(l) => (&l.name, Sample::Line(l.stroke)),
        Layer::Band(b) => (&b.name, Sample::Band(b.colour)),
        &Layer::Points(Points { colour, diameter_pt, opacity, ref name, .. }) => {
            (name, Sample::Disc { colour, diameter_pt, opacity })
        }
        Layer::Reference(r) => (&r.name, Sample::Line(r.stroke)),
        &Layer::Intervals(Intervals { colour, marker, direction, ref name, .. }) => {
            (name, Sample::Whisker { colour, marker, direction })
        }
        Layer::Text(_) => return Vec::new(),
        Layer::Likert(likert) => {
            let count = likert.answers.len();
            let answers = likert.answers.iter().enumerate();
            return answers
                .map(|(i, a)| (a.clone(), Sample::Box(style::likert_colour(i, count))))
                .collect();
        }
    };
    name.iter().map(|name| (name.clone(), sample.clone())).collect()
}

/// Draws the legend with its top left corner at `at`.
pub(crate) fn draw(sheet: &mut Sheet, legend: &Legend, (left, top): At) {
    for (i, row) in legend.rows.iter().enumerate() {
        let middle = top + ROW_PT * (i as f64 + 0.5);
        for entry in row {
            let x = left + entry.x_pt;
            for sample in &entry.samples {
                draw_sample(sheet, sample, (x + entry.sample_pt / 2.0, middle));
            }
            let base = middle + entry.label.cap_pt() / 2.0;
            sheet.text(&entry.label, (x + entry.sample_pt + NAME_GAP_PT, base), INK, false);
        }
    }
}

fn draw_sample(sheet: &mut Sheet, sample: &Sample, (centre, middle): At) {
    let half_line = SAMPLE_PT / 2.0;
    let patch = |half_width: f64| Rect {
        left: centre - half_width,
        right: centre + half_width,
        top: middle - BOX_PT / 2.0,
        bottom: middle + BOX_PT / 2.0,
    };
    match sample {
        Sample::Line(stroke) => {
            sheet.stroke(&[(centre - half_line, middle), (centre + half_line, middle)], stroke)
        }
        Sample::Band(colour) => sheet.rect(&patch(half_line), *colour, style::BAND_OPACITY),
        Sample::Disc { colour, diameter_pt, opacity } => {
            // Faint points lie in heaps in the plot; a sample lies alone and must be seen.
            sheet.disc((centre, middle), *diameter_pt, *colour, opacity.max(0.6));
        }
        Sample::Whisker { colour, marker, direction } => {
            let half = BOX_PT / 2.0 + WHISKER_OUT_PT;
            let ends = [-half, half].map(|off| {
                let (dx, dy) = direction.x_and_y(off, 0.0);
                (centre + dx, middle + dy)
            });
            sheet.stroke(&ends, &Stroke { width_pt: style::WHISKER_PT, ..style::mean(*colour) });
            draw_marker(sheet, *marker, (centre, middle), *colour);
        }
        Sample::Box(colour) => sheet.rect(&patch(BOX_PT / 2.0), *colour, 1.0),
    }
}

/// A marker of the one size that estimates have.
pub(crate) fn draw_marker(sheet: &mut Sheet, marker: Marker, (x, y): At, colour: Colour) {
    let r = style::MARKER_PT / 2.0;
    match marker {
        Marker::Disc => sheet.disc((x, y), style::MARKER_PT, colour, 1.0),
        Marker::Square => {
            let r = 0.88 * r; // of the disc's area
            let corners = [(x - r, y - r), (x + r, y - r), (x + r, y + r), (x - r, y + r)];
            sheet.fill(&corners, colour, 1.0);
        }
        Marker::Diamond => {
            let r = 1.25 * r; // of the disc's area
            sheet.fill(&[(x, y - r), (x + r, y), (x, y + r), (x - r, y)], colour, 1.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::{Axis, Band, Cell, Line, Panel};

    fn figure(names: &[&str]) -> Figure {
        let layers = names.iter().flat_map(|name| {
            let name = Some((*name).to_owned());
            let band = Layer::Band(Band { name: name.clone(), ..Band::default() });
            [band, Layer::Line(Line { name, ..Line::default() })]
        });
        let [x, y] = [0, 1].map(|_| Axis::new("", ""));
        let panel = Panel::new(Cell::at(0, 0), x, y, layers.collect());
        Figure { panels: vec![panel.clone(), panel], ..Figure::default() }
    }

    #[test]
    fn a_name_appears_once_with_all_its_samples() {
        let entries = entries(&figure(&["active", "passive"]));
        let names: Vec<&str> = entries.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["active", "passive"]);
        assert!(entries.iter().all(|(_, samples)| samples.len() == 2));
    }

    #[test]
    fn rows_are_no_wider_than_they_may() {
        let fonts = Fonts::bundled().unwrap();
        let figure = figure(&["active", "passive", "hybrid", "commanded force"]);
        let legend = plan(&figure, fonts, 120.0).unwrap();
        assert!(legend.rows.len() > 1);
        for entry in legend.rows.iter().flatten() {
            assert!(entry.end_pt() <= 120.0);
        }
    }
}
