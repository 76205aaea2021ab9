//! Which walls a sampled device bears: each limit a line of its own.

use crate::words::{model_mark, plain};
use zwidth_draw::style::{self, Dash, Marker, Stroke};
use zwidth_draw::{
    Axis, Band, Cell, Direction, Figure, Intervals, Layer, Line, Panel, Points, Range, Reference,
    Ticks,
};
use zwidth_dynamics::NAMED_SOLVERS;
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

/// A panel: two axes, and what lies between them besides the limits.
#[derive(Debug, Clone, PartialEq)]
pub struct StabilityPanel {
    /// Along x.
    pub x: Side,
    /// Along y.
    pub y: Side,
    /// Where the wall is stable, exactly.
    pub stable: Vec<StableArea>,
    /// Where the device stands on x and on y, SI; `None` where it has no such part.
    pub device: [Option<f64>; 2],
}

/// An area between two edges over x, SI; NaN where it has a gap.
#[derive(Debug, Clone, PartialEq)]
pub struct StableArea {
    /// Places along x.
    pub x: Vec<f64>,
    /// The lower edge at each.
    pub low: Vec<f64>,
    /// The upper edge at each.
    pub high: Vec<f64>,
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
}

/// One limit of a panel.
struct Limit {
    kind: String,
    label: String,
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
        description: "Which walls a sampled device bears. Shaded: stable. Diamond or dotted line: the device itself. \
                      Black: exact linear stability of the lifted map; points: the \
                      same found by simulating the loop. Indigo: passivity. Dashed: closed forms of the literature, \
                      which are approximations. Thin: where the step of a solver becomes unstable."
            .to_owned(),
        panels: drawn.collect::<Result<_, _>>()?,
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
    let mut layers: Vec<Layer> = sides.stable.iter().map(|area| shade(area, sides)).collect();
    layers.extend(limits.iter().map(layer));
    layers.extend(device(sides));
    let (x, y) = (sides.x.axis(), sides.y.axis());
    let cell = Cell::at(number / 2, number % 2);
    let letter = char::from(b'a' + (number % 26) as u8);
    let title = format!("**{letter}**  {} and {}", sides.x.label, sides.y.label);
    let panel = if limits.is_empty() {
        let note = match sides.stable.is_empty() {
            true => "no limit crosses this range",
            false => "no limit crosses this range: all of it is stable",
        };
        Panel::with_note(cell, x, y, note)
    } else {
        Panel::new(cell, x, y, layers)
    };
    let panel = if count > 1 { panel.titled(title) } else { panel };
    Ok(Panel { height_mm: Some(PANEL_MM), ..panel })
}

fn shade(area: &StableArea, sides: &StabilityPanel) -> Layer {
    let places = |side: &Side, values: &[f64]| values.iter().map(|v| side.place(*v)).collect();
    Layer::Band(Band {
        x: places(&sides.x, &area.x),
        low: places(&sides.y, &area.low),
        high: places(&sides.y, &area.high),
        colour: style::GREY,
        name: Some("stable".to_owned()),
    })
}

/// The device as a diamond; as a line where only its place along x is known.
fn device(sides: &StabilityPanel) -> Option<Layer> {
    let on = |side: &Side, value: Option<f64>| {
        let [from, to] = side.ends;
        value.filter(|value| (from..=to).contains(value)).map(|value| side.place(value))
    };
    let name = Some("this device".to_owned());
    Some(match (on(&sides.x, sides.device[0]), on(&sides.y, sides.device[1])) {
        (Some(x), Some(y)) => Layer::Intervals(Intervals {
            direction: Direction::Vertical,
            at: vec![x],
            estimate: vec![y],
            low: vec![y],
            high: vec![y],
            colour: style::INK,
            marker: Marker::Diamond,
            name,
        }),
        (Some(at), None) if sides.device[1].is_none() => Layer::Reference(Reference {
            direction: Direction::Vertical,
            at,
            label: None,
            stroke: style::reference().dashed(Dash::Dotted),
            name,
        }),
        _ => return None,
    })
}

const SYMPLECTIC_EULER: &str = "a step of symplectic Euler is stable below";
const ABBOTT_OKAMURA: &str = "Abbott–Okamura";
const DIOLAITI: &str = "Diolaiti";

/// What a limit is called; `None` for one that another draws: the passive walls of Colgate &
/// Schenkel's closed form are those of the maximum over frequency.
fn label(limit: &str) -> Option<&'static str> {
    match limit {
        "lifted_map" => Some("stable below (exact)"),
        "passivity" => Some("passive below"),
        "measured" => Some("the same, the loop simulated"),
        "rk4_per_step" => Some("a step of RK4 is stable below"),
        "symplectic_euler" => Some(SYMPLECTIC_EULER),
        "hulin" => Some("Hulin"),
        "abbott_okamura" => Some(ABBOTT_OKAMURA),
        "diolaiti" => Some(DIOLAITI),
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
        let of_others = (kind == "others").then(|| plain(word));
        let Some(label) = of_others.or_else(|| label(word).map(str::to_owned)) else { continue };
        if limits.last().is_none_or(|last| last.0 != *word) {
            let limit = Limit { kind: kind.clone(), label, x: Vec::new(), y: Vec::new() };
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
    Ok(limits.into_iter().map(|(_, _, limit)| limit).collect())
}

fn layer(limit: &Limit) -> Layer {
    let (x, y, name) = (limit.x.clone(), limit.y.clone(), Some(limit.label.clone()));
    if limit.kind == "measured" {
        return Layer::Points(Points { x, y, name, diameter_pt: 4.0, ..Points::default() });
    }
    Layer::Line(Line { x, y, name, stroke: stroke(limit), ..Line::default() })
}

fn stroke(limit: &Limit) -> Stroke {
    let book = |index: usize| style::single(style::environment_colour(index)).dashed(Dash::Dashed);
    let solver = |name: &str| {
        let number = NAMED_SOLVERS.iter().position(|named| named.name == name);
        style::single(style::solver_colour(number.unwrap_or(0)))
    };
    match (limit.kind.as_str(), limit.label.as_str()) {
        ("exact", _) => style::mean(style::INK),
        ("passivity", _) => style::mean(style::environment_colour(0)),
        ("others", _) => style::mean(style::environment_colour(4)),
        ("method", SYMPLECTIC_EULER) => solver("symplectic_euler").dashed(Dash::Dotted),
        ("method", _) => solver("rk4_per_step"),
        (_, ABBOTT_OKAMURA) => book(5),
        (_, DIOLAITI) => book(3),
        _ => book(2),
    }
}

/// A boundary of stiffness over damping that others measured.
#[derive(Debug, Clone, PartialEq)]
pub struct BoundaryOf {
    /// Its name.
    pub name: String,
    /// (B, K) in the units that it has.
    pub points: Vec<[f64; 2]>,
    /// The same in shares of the largest B and of K(0), where both were measured.
    pub shares: Option<Vec<[f64; 2]>>,
}

/// Boundaries that others measured: on axes of damping and stiffness in the units that they have,
/// and in shares of their own ends, which need none, beside `linear`, the lifted map's in the same
/// shares.
pub fn boundaries(
    boundaries: &[BoundaryOf],
    linear: Option<&[[f64; 2]]>,
    notes: &[String],
) -> Figure {
    let curve = |i: usize, name: &str, points: &[[f64; 2]]| {
        let (x, y): (Vec<f64>, Vec<f64>) = points.iter().map(|p| (p[0], p[1])).unzip();
        let colour = style::environment_colour(i);
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
    let own = boundaries.iter().enumerate().flat_map(|(i, b)| curve(i, &b.name, &b.points));
    let (x, y) = (
        Axis::new("wall damping *B*", "as measured"),
        Axis::new("wall stiffness *K*", "as measured"),
    );
    let own = Panel::new(Cell::at(0, 0), x, y, own.collect());
    let map = linear.map(|points| {
        let (x, y) = points.iter().map(|p| (p[0], p[1])).unzip();
        let name = Some("this device, exact (lifted map)".to_owned());
        Layer::Line(Line { x, y, name, stroke: style::mean(style::INK), ..Line::default() })
    });
    let shares =
        boundaries.iter().enumerate().filter_map(|(i, b)| Some((i, b, b.shares.as_ref()?)));
    let shares: Vec<Layer> =
        map.into_iter().chain(shares.flat_map(|(i, b, s)| curve(i, &b.name, s))).collect();
    let (x, y) = (
        Axis::new("damping over its largest *B*/*B*_{end}", ""),
        Axis::new("stiffness over the undamped *K*/*K*(0)", ""),
    );
    let shares = if shares.is_empty() {
        Panel::with_note(Cell::at(0, 1), x, y, "no boundary has both ends")
    } else {
        Panel::new(Cell::at(0, 1), x, y, shares)
    };
    let panels =
        [own.titled("**a**  as measured"), shares.titled("**b**  in shares of their own ends")];
    Figure {
        title: Some("Stiffest walls, measured by others".to_owned()),
        description:
            "The stiffest wall without sustained oscillation against the wall's damping, as others \
                      measured it, and in shares of its own ends beside the exact one of this device."
                .to_owned(),
        panels: panels
            .into_iter()
            .map(|panel| Panel { height_mm: Some(PANEL_MM), ..panel })
            .collect(),
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

    fn panel_of(x: &'static str) -> StabilityPanel {
        let (x, y) = (side(x, false), side("stiffness", true));
        StabilityPanel { x, y, stable: Vec::new(), device: [None; 2] }
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
    fn every_limit_has_its_name_and_pieces_are_apart() {
        let sides = panel_of("damping");
        let figure = stability(&curves(), &[sides], &[]).unwrap();
        draw(&figure).unwrap();
        let layers = &figure.panels[0].layers;
        let lines = layers.iter().find_map(|layer| match layer {
            Layer::Line(line) => Some(line.x.clone()),
            _ => None,
        });
        assert!(lines.is_some_and(|x| x.len() == 4 && x[2].is_nan()));
        let name = |layer: &Layer| match layer {
            Layer::Line(line) => line.name.clone(),
            Layer::Points(points) => points.name.clone(),
            _ => None,
        };
        let names: Vec<String> = layers.iter().filter_map(name).collect();
        assert_eq!(names, ["stable below (exact)", "the same, the loop simulated"]);
    }

    #[test]
    fn the_stable_side_is_shaded_and_the_device_stands_where_it_is() {
        let stable =
            StableArea { x: vec![1.0, 2.0], low: vec![10.0; 2], high: vec![100.0, f64::NAN] };
        let device = |y| StabilityPanel {
            stable: vec![stable.clone()],
            device: [Some(2.0), y],
            ..panel_of("damping")
        };
        let layers = |y| stability(&curves(), &[device(y)], &[]).unwrap().panels[0].layers.clone();
        let known = layers(Some(1000.0));
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert!(matches!(&known[0], Layer::Band(band) if near(band.high[0], 2.0)));
        let is_there = |i: &Intervals| near(i.at[0], 2.0) && near(i.estimate[0], 3.0);
        assert!(matches!(known.last(), Some(Layer::Intervals(i)) if is_there(i)));
        assert!(matches!(layers(None).last(), Some(Layer::Reference(r)) if near(r.at, 2.0)));
        let outside = layers(Some(1e6));
        assert!(!matches!(outside.last(), Some(Layer::Intervals(_) | Layer::Reference(_))));
        draw(&stability(&curves(), &[device(None)], &[]).unwrap()).unwrap();
    }

    #[test]
    fn a_panel_without_limits_says_so() {
        let sides = panel_of("delay");
        let figure = stability(&curves(), &[sides], &[]).unwrap();
        assert!(figure.panels[0].note.is_some());
        draw(&figure).unwrap();
    }

    #[test]
    fn boundaries_of_others_are_drawn_as_they_are() {
        let measured = BoundaryOf {
            name: "on".to_owned(),
            points: vec![[0.0, 4.0], [0.1, 0.0]],
            shares: Some(vec![[0.0, 1.0], [1.0, 0.0]]),
        };
        let figure =
            boundaries(std::slice::from_ref(&measured), Some(&[[0.0, 1.0], [1.0, 0.0]]), &[]);
        assert!(figure.mark.is_none());
        assert_eq!(figure.panels.iter().map(|p| p.layers.len()).collect::<Vec<_>>(), [2, 3]);
        draw(&figure).unwrap();
        let half = BoundaryOf { shares: None, ..measured };
        let figure = boundaries(&[half], None, &[]);
        assert!(figure.panels[1].note.is_some());
        draw(&figure).unwrap();
    }
}
