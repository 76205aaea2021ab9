//! Which walls a sampled device bears: each limit a line, with its name at it.

use crate::words::{model_mark, plain};
use zwidth_draw::style::{self, Colour, Dash, Stroke};
use zwidth_draw::{
    Axis, Cell, Figure, Layer, LegendPlace, Line, Panel, Points, Range, Text, TextPlace, Ticks,
};
use zwidth_tables::{Table, TableError};

/// Height of a panel, mm.
const PANEL_MM: f64 = 66.0;

/// An axis of a panel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Side {
    /// Its quantity as the table of curves has it.
    pub quantity: &'static str,
    /// Its name as markup.
    pub label: &'static str,
    /// Its unit on the axis.
    pub unit: &'static str,
    /// So many of these are one SI unit.
    pub per_si: f64,
    /// Its ends, SI.
    pub ends: [f64; 2],
    /// Whether it is logarithmic.
    pub is_logarithmic: bool,
}

/// A panel: two axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StabilityPanel {
    /// Along x.
    pub x: Side,
    /// Along y.
    pub y: Side,
}

impl Side {
    /// Where a value stands on the axis.
    fn place(&self, value: f64) -> f64 {
        let value = value * self.per_si;
        if self.is_logarithmic { libm::log10(value) } else { value }
    }

    fn axis(&self) -> Axis {
        let [from, to] = self.ends.map(|end| self.place(end));
        let ticks = if self.is_logarithmic { Ticks::Powers } else { Ticks::Numbers };
        Axis { ticks, ..Axis::new(self.label, self.unit) }.ranged(Range::Fixed(from, to))
    }

    /// A place as a share of the axis.
    fn share(&self, place: f64) -> f64 {
        let [from, to] = self.ends.map(|end| self.place(end));
        (place - from) / (to - from)
    }
}

/// One limit of a panel, or several that are one line.
struct Limit {
    kind: String,
    labels: Vec<&'static str>,
    x: Vec<f64>,
    y: Vec<f64>,
}

/// The limits of a table of the stage `stability`, a panel for each pair of its axes.
///
/// # Errors
/// A table that lacks a column.
pub fn stability(
    curves: &Table,
    panels: &[StabilityPanel],
    notes: &[String],
) -> Result<Figure, TableError> {
    let drawn = panels.iter().enumerate().map(|(i, sides)| panel(curves, i, sides, panels.len()));
    Ok(Figure {
        title: Some(plain(curves.title())),
        description: "Which walls a sampled device bears. Black: exact linear stability of the lifted map; points: the \
                      same found by simulating the loop. Blue: passivity. Dashed: closed forms of the literature, \
                      which are approximations. Thin: where the step of a solver becomes unstable."
            .to_owned(),
        panels: drawn.collect::<Result<_, _>>()?,
        legend: LegendPlace::Hidden,
        footnotes: notes.iter().map(|note| plain(note)).collect(),
        mark: model_mark(),
        ..Figure::default()
    })
}

fn panel(
    curves: &Table,
    number: usize,
    sides: &StabilityPanel,
    count: usize,
) -> Result<Panel, TableError> {
    let limits = limits(curves, sides)?;
    let mut layers: Vec<Layer> = limits.iter().map(layer).collect();
    layers.extend(labels(&limits, sides));
    let (x, y) = (sides.x.axis(), sides.y.axis());
    let cell = Cell::at(number / 2, number % 2);
    let letter = char::from(b'a' + (number % 26) as u8);
    let title = format!("**{letter}**  {} and {}", sides.x.label, sides.y.label);
    let panel = if limits.is_empty() {
        Panel::with_note(cell, x, y, "no limit crosses this range")
    } else {
        Panel::new(cell, x, y, layers)
    };
    let panel = if count > 1 { panel.titled(title) } else { panel };
    Ok(Panel { height_mm: Some(PANEL_MM), ..panel })
}

/// What stands at a limit; none for one that another draws: the passive walls of Colgate &
/// Schenkel's closed form are those of the maximum over frequency.
fn label(limit: &str) -> Option<&'static str> {
    match limit {
        "lifted_map" => Some("**stable below** (exact)"),
        "passivity" => Some("**passive below**"),
        "measured" => Some("simulated loop"),
        "rk4_per_step" => Some("RK4's step stable below"),
        "symplectic_euler" => Some("symplectic Euler's"),
        "hulin" => Some("Hulin"),
        "abbott_okamura" => Some("Abbott–Okamura"),
        "diolaiti" => Some("Diolaiti"),
        _ => None,
    }
}

fn limits(curves: &Table, sides: &StabilityPanel) -> Result<Vec<Limit>, TableError> {
    let texts = |name| curves.texts(name);
    let (xs, ys) = (texts("x_quantity")?, texts("y_quantity")?);
    let (words, kinds) = (texts("limit")?, texts("kind")?);
    let pieces = curves.integers("piece")?;
    let (x, y) = (curves.floats("x")?, curves.floats("y")?);
    let mut limits: Vec<(String, Option<i64>, Limit)> = Vec::new();
    for i in 0..curves.height() {
        let is = |text: &Option<String>, word: &str| text.as_deref() == Some(word);
        if !is(&xs[i], sides.x.quantity) || !is(&ys[i], sides.y.quantity) {
            continue;
        }
        let (Some(word), Some(kind), Some(x), Some(y)) = (&words[i], &kinds[i], x[i], y[i]) else {
            continue;
        };
        let Some(label) = label(word) else { continue };
        if limits.last().is_none_or(|last| last.0 != *word) {
            let labels = vec![label];
            let limit = Limit { kind: kind.clone(), labels, x: Vec::new(), y: Vec::new() };
            limits.push((word.clone(), pieces[i], limit));
        }
        let Some((_, piece, limit)) = limits.last_mut() else { continue };
        if *piece != pieces[i] {
            limit.x.push(f64::NAN);
            limit.y.push(f64::NAN);
            *piece = pieces[i];
        }
        limit.x.push(sides.x.place(x));
        limit.y.push(sides.y.place(y));
    }
    Ok(merged(limits.into_iter().map(|(_, _, limit)| limit), sides))
}

/// Limits that are one line are drawn once, with all their names.
fn merged(limits: impl Iterator<Item = Limit>, sides: &StabilityPanel) -> Vec<Limit> {
    let mut kept: Vec<Limit> = Vec::new();
    for limit in limits {
        match kept.iter_mut().find(|other| are_one(other, &limit, sides)) {
            Some(other) => other.labels.extend(limit.labels),
            None => kept.push(limit),
        }
    }
    kept
}

/// Whether two lines are nowhere further apart than the eye sees; points are no line.
fn are_one(a: &Limit, b: &Limit, sides: &StabilityPanel) -> bool {
    /// Distance that nobody sees, as a share of a panel.
    const UNSEEN: f64 = 3e-3;
    let near = |i: usize| {
        let apart = |side: &Side, a: f64, b: f64| (side.share(a) - side.share(b)).abs();
        let far = apart(&sides.x, a.x[i], b.x[i]).max(apart(&sides.y, a.y[i], b.y[i]));
        far < UNSEEN || (a.x[i].is_nan() && b.x[i].is_nan())
    };
    let lines = a.kind != "measured" && b.kind != "measured";
    lines && a.x.len() == b.x.len() && (0..a.x.len()).all(near)
}

fn layer(limit: &Limit) -> Layer {
    let (x, y) = (limit.x.clone(), limit.y.clone());
    if limit.kind == "measured" {
        return Layer::Points(Points { x, y, diameter_pt: 4.0, ..Points::default() });
    }
    Layer::Line(Line { x, y, stroke: stroke(limit), ..Line::default() })
}

fn stroke(limit: &Limit) -> Stroke {
    let book = |index: usize| style::single(style::mode_colour(index)).dashed(Dash::Dashed);
    match (limit.kind.as_str(), limit.labels[0]) {
        ("exact", _) => style::mean(style::INK),
        ("passivity", _) => style::mean(style::mode_colour(0)),
        ("method", "symplectic Euler's") => style::faint(colour_of_methods()),
        ("method", _) => style::single(colour_of_methods()),
        (_, "Abbott–Okamura") => book(2),
        (_, "Diolaiti") => book(3),
        _ => book(1),
    }
}

fn colour_of_methods() -> Colour {
    style::mode_colour(4)
}

/// The names, each over the point of its line that is furthest from other lines and names.
fn labels(limits: &[Limit], sides: &StabilityPanel) -> Vec<Layer> {
    let share = |limit: &Limit, i: usize| [sides.x.share(limit.x[i]), sides.y.share(limit.y[i])];
    let mut taken: Vec<[f64; 2]> = Vec::new();
    let mut layers = Vec::new();
    for (number, limit) in limits.iter().enumerate() {
        let others = limits.iter().enumerate().filter(|(other, _)| *other != number);
        let around: Vec<[f64; 2]> = others
            .flat_map(|(_, other)| (0..other.x.len()).map(move |i| share(other, i)))
            .filter(|at| at.iter().all(|x| x.is_finite()))
            .collect();
        let best = (0..limit.x.len())
            .map(|i| (i, share(limit, i)))
            .filter(|(_, at)| (0.24..=0.76).contains(&at[0]) && (0.02..=0.92).contains(&at[1]))
            .map(|(i, at)| (i, room(at, &around).min(room_of_words(at, &taken))))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((i, _)) = best else { continue };
        taken.push(share(limit, i));
        layers.push(Layer::Text(Text {
            lines: words(&limit.labels),
            place: TextPlace::Over(limit.x[i], limit.y[i]),
        }));
    }
    layers
}

/// The first name, and in a second line the others that are the same.
fn words(labels: &[&'static str]) -> Vec<String> {
    let (first, others) = (labels[0].to_owned(), labels[1..].join(" = "));
    if others.is_empty() { vec![first] } else { vec![first, format!("= {others}")] }
}

/// How far the words over a place are from points: words are wide and stand above.
fn room(at: [f64; 2], points: &[[f64; 2]]) -> f64 {
    /// Half the width of words, and how high their middle stands, as shares of a panel.
    const WORDS: (f64, f64) = (0.2, 0.05);
    let far = |p: &[f64; 2]| {
        let x = ((p[0] - at[0]).abs() - WORDS.0).max(0.0);
        libm::hypot(x, p[1] - at[1] - WORDS.1)
    };
    points.iter().map(far).fold(0.3, f64::min)
}

/// The same from other words, which are wide too.
fn room_of_words(at: [f64; 2], words: &[[f64; 2]]) -> f64 {
    let far = |p: &[f64; 2]| libm::hypot(((p[0] - at[0]).abs() - 0.42).max(0.0), p[1] - at[1]);
    words.iter().map(far).fold(0.3, f64::min)
}

/// A boundary of stiffness over damping: its name, points (B, K).
pub type BoundaryOf = (String, Vec<[f64; 2]>);

/// Boundaries that others measured, on axes of damping and stiffness in the units that they have.
pub fn boundaries(boundaries: &[BoundaryOf], notes: &[String]) -> Figure {
    let line = |(i, (name, points)): (usize, &BoundaryOf)| {
        let (x, y): (Vec<f64>, Vec<f64>) = points.iter().map(|p| (p[0], p[1])).unzip();
        let colour = style::mode_colour(i);
        [
            Layer::Line(Line {
                x: x.clone(),
                y: y.clone(),
                stroke: style::single(colour),
                name: Some(plain(name)),
                ..Line::default()
            }),
            Layer::Points(Points { x, y, colour, diameter_pt: 4.0, ..Points::default() }),
        ]
    };
    let layers = boundaries.iter().enumerate().flat_map(line).collect();
    let (x, y) = (
        Axis::new("wall damping *B*", "as measured"),
        Axis::new("wall stiffness *K*", "as measured"),
    );
    let panel = Panel::new(Cell::at(0, 0), x, y, layers);
    Figure {
        title: Some("Stiffest walls, measured by others".to_owned()),
        description:
            "The stiffest wall without sustained oscillation against the wall's damping, as others \
                      measured it."
                .to_owned(),
        panels: vec![Panel { height_mm: Some(PANEL_MM), ..panel }],
        footnotes: notes.iter().map(|note| plain(note)).collect(),
        ..Figure::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_draw::draw;
    use zwidth_tables::Column;

    fn side(quantity: &'static str, is_logarithmic: bool) -> Side {
        let ends = if is_logarithmic { [10.0, 1e4] } else { [0.0, 4.0] };
        Side { quantity, label: quantity, unit: "N/m", per_si: 1.0, ends, is_logarithmic }
    }

    fn curves() -> Table {
        let text = |name, values: [&str; 4]| {
            Column::text(name, "", values.map(|value| Some(value.to_owned())))
        };
        let columns = vec![
            text("x_quantity", ["damping"; 4]),
            text("y_quantity", ["stiffness"; 4]),
            text("limit", ["lifted_map", "lifted_map", "lifted_map", "measured"]),
            text("kind", ["exact", "exact", "exact", "measured"]),
            Column::integer("piece", "1", "", [0, 0, 1, 0].map(Some)),
            Column::float("x", "SI", "", [1.0, 2.0, 3.0, 1.5].map(Some)),
            Column::float("y", "SI", "", [100.0, 200.0, 300.0, 150.0].map(Some)),
        ];
        Table::new("curves", "Limits", columns).unwrap()
    }

    #[test]
    fn every_limit_has_its_name_at_its_line_and_pieces_are_apart() {
        let sides = StabilityPanel { x: side("damping", false), y: side("stiffness", true) };
        let figure = stability(&curves(), &[sides], &[]).unwrap();
        draw(&figure).unwrap();
        let layers = &figure.panels[0].layers;
        let lines = layers.iter().find_map(|layer| match layer {
            Layer::Line(line) => Some(line.x.clone()),
            _ => None,
        });
        assert!(lines.is_some_and(|x| x.len() == 4 && x[2].is_nan()));
        let words = layers.iter().filter(|layer| matches!(layer, Layer::Text(_))).count();
        assert_eq!(words, 2);
    }

    #[test]
    fn a_panel_without_limits_says_so() {
        let sides = StabilityPanel { x: side("delay", false), y: side("stiffness", true) };
        let figure = stability(&curves(), &[sides], &[]).unwrap();
        assert!(figure.panels[0].note.is_some());
        draw(&figure).unwrap();
    }

    #[test]
    fn boundaries_of_others_are_drawn_as_they_are() {
        let figure = boundaries(&[("on".to_owned(), vec![[0.0, 4.0], [0.1, 0.0]])], &[]);
        assert!(figure.mark.is_none());
        draw(&figure).unwrap();
    }
}
