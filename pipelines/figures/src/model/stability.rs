//! Which walls a sampled device can render: each limit is a line of its own.

use crate::words::{lettered, model_mark, plain, solver_colour};
use zwidth_draw::style::{self, Dash, Marker, Stroke};
use zwidth_draw::{
    Axis, Band, Cell, Direction, Figure, Intervals, Layer, Line, Panel, Points, Range, Reference,
    Ticks,
};
use zwidth_results::{LimitKind, LimitName, LimitPoint, Row, WallLimit, WallQuantity};

/// Height of a panel, mm.
const PANEL_MM: f64 = 66.0;

/// An axis of a panel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Side {
    /// Its quantity.
    pub quantity: WallQuantity,
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

/// A panel: two axes, and what is between them besides the limits.
#[derive(Debug, Clone, PartialEq)]
pub struct StabilityPanel {
    /// Along x.
    pub x: Side,
    /// Along y.
    pub y: Side,
    /// Where the wall is stable, exactly.
    pub stable: Vec<StableArea>,
    /// The device's place on x and on y, SI; `None` if it has no such part.
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
struct Limit<'a> {
    first: &'a LimitPoint,
    label: String,
    x: Vec<f64>,
    y: Vec<f64>,
}

/// The limits of some maps, a panel for each pair of axes.
pub fn stability(curves: &[LimitPoint], panels: &[StabilityPanel], notes: &[String]) -> Figure {
    let drawn = panels.iter().enumerate().map(|(i, sides)| panel(curves, i, sides, panels.len()));
    Figure {
        title: Some(plain(LimitPoint::TITLE)),
        description: "Which walls a sampled device bears. Shaded: stable. Diamond or dotted line: the device itself. \
                      Black: exact linear stability of the lifted map; points: the \
                      same found by simulating the loop. Indigo: passivity. Dashed: closed forms of the literature, \
                      which are approximations. Thin: where the step of a solver becomes unstable."
            .to_owned(),
        panels: drawn.collect(),
        footnotes: notes.iter().map(|note| plain(note)).collect(),
        mark: model_mark(),
        ..Figure::default()
    }
}

fn panel(curves: &[LimitPoint], number: usize, sides: &StabilityPanel, count: usize) -> Panel {
    let limits = limits(curves, sides);
    let mut layers = Vec::new();
    for area in &sides.stable {
        let [low, high] = [&area.low, &area.high]
            .map(|edge| edge.iter().map(|value| sides.y.place(*value)).collect());
        layers.push(Layer::Band(Band {
            x: area.x.iter().map(|value| sides.x.place(*value)).collect(),
            low,
            high,
            colour: style::GREY,
            name: Some("stable".to_owned()),
        }));
    }
    layers.extend(limits.iter().map(layer));
    layers.extend(device(sides));
    let x = sides.x.axis();
    let y = sides.y.axis();
    let cell = Cell::at(number / 2, number % 2);
    let title = lettered(number, &format!("{} and {}", sides.x.label, sides.y.label));
    let panel = if limits.is_empty() {
        let note = match sides.stable.is_empty() {
            true => "no limit crosses this range",
            false => "no limit crosses this range: all of it is stable",
        };
        Panel::with_note(cell, x, y, note)
    } else {
        Panel::new(cell, x, y, layers)
    };
    if count > 1 { panel.titled(title).tall(PANEL_MM) } else { panel.tall(PANEL_MM) }
}

/// The device as a diamond; as a line where only its place along x is known.
fn device(sides: &StabilityPanel) -> Option<Layer> {
    let [x, y] = [(&sides.x, sides.device[0]), (&sides.y, sides.device[1])].map(|(side, value)| {
        let [from, to] = side.ends;
        value.filter(|value| (from..=to).contains(value)).map(|value| side.place(value))
    });
    let name = Some("this device".to_owned());
    Some(match (x, y) {
        (Some(x), Some(y)) => {
            let place = Intervals::new(Direction::Vertical, vec![x], [y; 3].map(|y| vec![y]));
            Layer::Intervals(Intervals { marker: Marker::Diamond, name, ..place })
        }
        (Some(at), None) if sides.device[1].is_none() => {
            let pen = style::reference().dashed(Dash::Dotted);
            let line = Reference::new(Direction::Vertical, at, pen);
            Layer::Reference(Reference { name, ..line })
        }
        _ => return None,
    })
}

/// What a limit is called; `None` for one that another draws: the passive walls of Colgate &
/// Schenkel's closed form are those of the maximum over frequency.
fn label(limit: WallLimit) -> Option<&'static str> {
    match limit {
        WallLimit::LiftedMap => Some("stable below (exact)"),
        WallLimit::Passivity => Some("passive below"),
        WallLimit::Measured => Some("the same, the loop simulated"),
        WallLimit::Rk4 => Some("a step of RK4 is stable below"),
        WallLimit::SymplecticEuler => Some("a step of symplectic Euler is stable below"),
        WallLimit::Hulin => Some("Hulin"),
        WallLimit::AbbottOkamura => Some("Abbott–Okamura"),
        WallLimit::Diolaiti => Some("Diolaiti"),
        WallLimit::ColgateSchenkel => None,
    }
}

fn limits<'a>(curves: &'a [LimitPoint], sides: &StabilityPanel) -> Vec<Limit<'a>> {
    let axes = (sides.x.quantity, sides.y.quantity);
    let own = curves.iter().filter(|point| (point.x_quantity, point.y_quantity) == axes);
    let mut limits: Vec<Limit> = Vec::new();
    let mut piece = 0;
    for point in own {
        let label = match &point.limit {
            _ if point.kind == LimitKind::Others => Some(plain(&point.limit.to_string())),
            LimitName::Computed(limit) => label(*limit).map(str::to_owned),
            LimitName::Others(_) => None,
        };
        let Some(label) = label else { continue };
        // The points of one limit come one after the other.
        if limits.last().is_none_or(|last| last.first.limit != point.limit) {
            limits.push(Limit { first: point, label, x: Vec::new(), y: Vec::new() });
            piece = point.piece;
        }
        let Some(limit) = limits.last_mut() else { continue };
        // A limit may come in pieces, which nothing connects.
        if piece != point.piece {
            limit.x.push(f64::NAN);
            limit.y.push(f64::NAN);
            piece = point.piece;
        }
        limit.x.push(sides.x.place(point.x));
        limit.y.push(sides.y.place(point.y));
    }
    limits
}

fn layer(limit: &Limit) -> Layer {
    let x = limit.x.clone();
    let y = limit.y.clone();
    let name = Some(limit.label.clone());
    if limit.first.kind == LimitKind::Measured {
        return Layer::Points(Points { x, y, name, diameter_pt: 4.0, ..Points::default() });
    }
    Layer::Line(Line { x, y, name, stroke: stroke(limit), ..Line::default() })
}

fn stroke(limit: &Limit) -> Stroke {
    match (limit.first.kind, &limit.first.limit) {
        (LimitKind::Exact, _) => style::mean(style::INK),
        (LimitKind::Passivity, _) => style::mean(style::environment_colour(0)),
        (LimitKind::Others, _) => style::mean(style::environment_colour(4)),
        (LimitKind::Method, LimitName::Computed(WallLimit::SymplecticEuler)) => {
            style::single(solver_colour("symplectic_euler")).dashed(Dash::Dotted)
        }
        (LimitKind::Method, _) => style::single(solver_colour("rk4_per_step")),
        (_, name) => {
            let index = match name {
                LimitName::Computed(WallLimit::AbbottOkamura) => 5,
                LimitName::Computed(WallLimit::Diolaiti) => 3,
                _ => 2,
            };
            style::single(style::environment_colour(index)).dashed(Dash::Dashed)
        }
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

/// Boundaries that others measured: on axes of damping and stiffness in their units, and in shares
/// of their own ends, which need no units, beside `linear`, the lifted map's in the same shares.
pub fn boundaries(
    boundaries: &[BoundaryOf],
    linear: Option<&[[f64; 2]]>,
    notes: &[String],
) -> Figure {
    let own = boundaries.iter().enumerate().flat_map(|(i, b)| boundary(i, &b.name, &b.points));
    let x = Axis::new("wall damping *B*", "as measured");
    let y = Axis::new("wall stiffness *K*", "as measured");
    let own = Panel::new(Cell::at(0, 0), x, y, own.collect());
    let map = linear.map(|points| {
        let (x, y) = points.iter().map(|[x, y]| (*x, *y)).unzip();
        let name = Some("this device, exact (lifted map)".to_owned());
        Layer::Line(Line { x, y, name, stroke: style::mean(style::INK), ..Line::default() })
    });
    let shares =
        boundaries.iter().enumerate().filter_map(|(i, b)| Some((i, b, b.shares.as_ref()?)));
    let shares: Vec<Layer> =
        map.into_iter().chain(shares.flat_map(|(i, b, s)| boundary(i, &b.name, s))).collect();
    let x = Axis::new("damping over its largest *B*/*B*_{end}", "");
    let y = Axis::new("stiffness over the undamped *K*/*K*(0)", "");
    let shares = if shares.is_empty() {
        Panel::with_note(Cell::at(0, 1), x, y, "no boundary has both ends")
    } else {
        Panel::new(Cell::at(0, 1), x, y, shares)
    };
    let panels = vec![
        own.titled(lettered(0, "as measured")).tall(PANEL_MM),
        shares.titled(lettered(1, "in shares of their own ends")).tall(PANEL_MM),
    ];
    Figure {
        title: Some("Stiffest walls, measured by others".to_owned()),
        description:
            "The stiffest wall without sustained oscillation against the wall's damping, as others \
                      measured it, and in shares of its own ends beside the exact one of this device."
                .to_owned(),
        panels,
        footnotes: notes.iter().map(|note| plain(note)).collect(),
        ..Figure::default()
    }
}

/// The `i`-th boundary, a line with its points on it.
fn boundary(i: usize, name: &str, points: &[[f64; 2]]) -> [Layer; 2] {
    let (x, y): (Vec<f64>, Vec<f64>) = points.iter().map(|[x, y]| (*x, *y)).unzip();
    let colour = style::environment_colour(i);
    let stroke = style::single(colour);
    let name = Some(plain(name));
    let line = Line { x: x.clone(), y: y.clone(), stroke, name, ..Line::default() };
    let points = Points { x, y, colour, diameter_pt: 4.0, ..Points::default() };
    [Layer::Line(line), Layer::Points(points)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_draw::draw;

    fn side(quantity: WallQuantity, is_logarithmic: bool) -> Side {
        let ends = if is_logarithmic { [10.0, 1e4] } else { [0.0, 4.0] };
        let label = quantity.as_str();
        Side { quantity, label, unit: "N/m", per_si: 1.0, ends, is_logarithmic }
    }

    fn panel_of(x: WallQuantity) -> StabilityPanel {
        let (x, y) = (side(x, false), side(WallQuantity::Stiffness, true));
        StabilityPanel { x, y, stable: Vec::new(), device: [None; 2] }
    }

    fn curves() -> Vec<LimitPoint> {
        let point = |limit, kind, piece, x, y| LimitPoint {
            x_quantity: WallQuantity::Damping,
            y_quantity: WallQuantity::Stiffness,
            limit: LimitName::Computed(limit),
            kind,
            piece,
            x,
            y,
        };
        let exact = |piece, x, y| point(WallLimit::LiftedMap, LimitKind::Exact, piece, x, y);
        vec![
            exact(0, 1.0, 100.0),
            exact(0, 2.0, 200.0),
            exact(1, 3.0, 300.0),
            point(WallLimit::Measured, LimitKind::Measured, 0, 1.5, 150.0),
        ]
    }

    #[test]
    fn every_limit_has_its_name_and_pieces_are_apart() {
        let sides = panel_of(WallQuantity::Damping);
        let figure = stability(&curves(), &[sides], &[]);
        draw(&figure).unwrap();
        let layers = &figure.panels[0].layers;
        let line = figure.panels[0].lines().next();
        assert!(line.is_some_and(|line| line.x.len() == 4 && line.x[2].is_nan()));
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
            ..panel_of(WallQuantity::Damping)
        };
        let layers = |y| stability(&curves(), &[device(y)], &[]).panels[0].layers.clone();
        let known = layers(Some(1000.0));
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert!(matches!(&known[0], Layer::Band(band) if near(band.high[0], 2.0)));
        let is_there = |i: &Intervals| near(i.at[0], 2.0) && near(i.estimate[0], 3.0);
        assert!(matches!(known.last(), Some(Layer::Intervals(i)) if is_there(i)));
        assert!(matches!(layers(None).last(), Some(Layer::Reference(r)) if near(r.at, 2.0)));
        let outside = layers(Some(1e6));
        assert!(!matches!(outside.last(), Some(Layer::Intervals(_) | Layer::Reference(_))));
        draw(&stability(&curves(), &[device(None)], &[])).unwrap();
    }

    #[test]
    fn a_panel_without_limits_says_so() {
        let sides = panel_of(WallQuantity::Delay);
        let figure = stability(&curves(), &[sides], &[]);
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
