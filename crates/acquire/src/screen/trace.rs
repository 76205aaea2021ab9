//! The live traces: angle with the wall, velocity, force, and voltages where they may be seen.

use super::look::{Look, Role};
use super::place::{cut, cut_left, halves, shares};
use crate::{Phase, Point, View};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Color;
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::Widget;
use ratatui::widgets::canvas::{Canvas, Context, Line as Segment};

/// Cells left of a plot: its scale.
pub(super) const GUTTER: u16 = 6;

/// Cells between the two columns of plots.
const COLUMN_GAP: u16 = 2;

/// Room above and below the work space, degrees: the trip outside it is at 2° and must still be
/// seen.
const ANGLE_ROOM_DEG: f64 = 3.0;

/// Where the force's scale begins, N: the motor gives 4.16 N. No scale shrinks while a trial runs,
/// and this one does not grow either.
const FORCE_SCALE_N: f64 = 5.0;

/// Where the velocity's scale begins, degrees/s: there and back through the work space within a
/// trial's four seconds.
const VELOCITY_SCALE_DEG_S: f64 = 100.0;

/// Where the voltages' scale begins, V: the brake's 8 V fit.
const VOLTAGE_SCALE_V: f64 = 10.0;

/// Force below which the scale also shows the negative side, N: a load cell's noise stays above it.
const NEGATIVE_FORCE_N: f64 = -0.5;

/// One quantity over time.
struct Curve {
    points: Vec<(f64, f64)>,
    colour: Color,
    /// What draws it in ASCII.
    letter: char,
    /// Drawn with gaps, to be told from its neighbour without colour.
    dashed: bool,
}

/// A plot: title, what stands beside it, scale, curves.
#[derive(Default)]
struct Plot {
    title: &'static str,
    value: String,
    /// The ends of the scale, which it names beside 0.
    low: f64,
    high: f64,
    /// What can still be seen beyond either end.
    room: f64,
    /// A level to be seen: the wall.
    level: Option<f64>,
    curves: Vec<Curve>,
}

/// Draws the traces of a view. Angle and velocity stand on the left, forces and voltages on the
/// right; a blinded screen has no voltages, and its angle gets their room.
pub(super) fn draw(view: &View, look: Look, area: Rect, buffer: &mut Buffer) {
    let window_s = window_s(view);
    for (column, plots) in halves(area, COLUMN_GAP).into_iter().zip(columns_of(view, look)) {
        let (above, axis) = cut(column, column.height.saturating_sub(1));
        for (plot, share) in plots.iter().zip(shares(above, plots.len() as u16)) {
            plot.draw(window_s, look, share, buffer);
        }
        draw_axis(view, window_s, look, axis, buffer);
    }
}

fn columns_of(view: &View, look: Look) -> [Vec<Plot>; 2] {
    let angle = angle(view, look);
    let velocity = velocity(view, look);
    let force = force(view);
    if view.blinded {
        [vec![angle], vec![force, velocity]]
    } else {
        [vec![angle, velocity], vec![force, voltages(view, look)]]
    }
}

/// The time a trace spans: the trial's limit while it runs, else what it took; whole seconds.
fn window_s(view: &View) -> f64 {
    let limit_s = match view.phase {
        Phase::Trial { limit_s, .. } => limit_s,
        _ => 0.0,
    };
    let last_s = view.trace.back().map_or(0.0, |point| point.t_s);
    limit_s.max(last_s).max(1.0).ceil()
}

fn angle(view: &View, look: Look) -> Plot {
    let low = view.theta_range_rad.0.to_degrees();
    let high = view.theta_range_rad.1.to_degrees();
    let wall_deg = view.wall_rad.map(f64::to_degrees);
    let wall = wall_deg.map_or(String::new(), |wall| format!(" wall {wall:.1} ╌"));
    Plot {
        title: if look.ascii { "angle (deg)" } else { "angle θ (°)" },
        value: latest(view, |p| Some(p.theta_rad.to_degrees()), 1) + &wall,
        low,
        high,
        room: ANGLE_ROOM_DEG,
        level: wall_deg,
        curves: vec![curve(view, |p| Some(p.theta_rad.to_degrees()), Color::Cyan, '*')],
    }
}

/// In light blue: the plain blue of most palettes is hard to read on black.
fn velocity(view: &View, look: Look) -> Plot {
    let curve = curve(view, |p| Some(p.theta_dot_rad_s.to_degrees()), Color::LightBlue, '*');
    let scale = scale(std::slice::from_ref(&curve), VELOCITY_SCALE_DEG_S);
    Plot {
        title: if look.ascii { "velocity (deg/s)" } else { "velocity θ̇ (°/s)" },
        value: latest(view, |p| Some(p.theta_dot_rad_s.to_degrees()), 0),
        low: -scale,
        high: scale,
        curves: vec![curve],
        ..Plot::default()
    }
}

/// While a trial runs, the scale is that of the trials before: one that jumps is mistaken for a
/// force that does. What lies beyond it stays at its edge until the trial is over. Before the first
/// trial both directions have room.
pub(super) fn force_ends(view: &View) -> (f64, f64) {
    let runs = matches!(view.phase, Phase::Trial { .. });
    let forces = view.trace.iter().map(|point| point.force_ex_n);
    let now = forces.filter(|n| n.is_finite() && !runs);
    let ends = now.fold(view.force_before_n, |ends, n| {
        let [low, high] = ends.unwrap_or([n, n]);
        Some([low.min(n), high.max(n)])
    });
    let [least, most] = ends.unwrap_or([-FORCE_SCALE_N, FORCE_SCALE_N]);
    let high = doubled(FORCE_SCALE_N, most.abs().max(least.abs()));
    (if least < NEGATIVE_FORCE_N { -high } else { 0.0 }, high)
}

/// The user's force on that scale.
fn force(view: &View) -> Plot {
    let mut curve = curve(view, |p| Some(p.force_ex_n), Color::Green, '*');
    let (low, high) = force_ends(view);
    curve.points.iter_mut().for_each(|(_, n)| *n = n.clamp(low, high));
    Plot {
        title: "user force (N)",
        value: latest(view, |p| Some(p.force_ex_n), 2),
        low,
        high,
        curves: vec![curve],
        ..Plot::default()
    }
}

/// The brake's voltage has no sign; the motor's is negative where it pushes the lever back.
fn voltages(view: &View, look: Look) -> Plot {
    let motor = curve(view, motor_v, Color::Magenta, 'm');
    let brake = Curve { dashed: true, ..curve(view, brake_v, Color::Yellow, 'b') };
    let curves = vec![motor, brake];
    let scale = scale(&curves, VOLTAGE_SCALE_V);
    let is_signed = curves.iter().flat_map(|curve| &curve.points).any(|(_, y)| *y < 0.0);
    let [motor, brake] = if look.ascii { ["m", "b"] } else { ["─", "╌"] };
    let now_motor = latest(view, motor_v, 1);
    let now_brake = latest(view, brake_v, 1);
    Plot {
        title: "voltage (V)",
        value: format!("motor {now_motor}{motor} brake {now_brake}{brake}"),
        low: if is_signed { -scale } else { 0.0 },
        high: scale,
        curves,
        ..Plot::default()
    }
}

fn motor_v(point: &Point) -> Option<f64> {
    point.voltages.map(|voltages| voltages.motor_v)
}

fn brake_v(point: &Point) -> Option<f64> {
    point.voltages.map(|voltages| voltages.brake_v)
}

fn curve(view: &View, value: impl Fn(&Point) -> Option<f64>, colour: Color, letter: char) -> Curve {
    let points = view.trace.iter().filter_map(|point| Some((point.t_s, value(point)?)));
    let points = points.filter(|(_, y)| y.is_finite()).collect();
    Curve { points, colour, letter, dashed: false }
}

/// The newest value of a trace in words, while the trial runs: afterwards it would be taken for the
/// device's state.
fn latest(view: &View, value: impl Fn(&Point) -> Option<f64>, digits: usize) -> String {
    let running = matches!(view.phase, Phase::Trial { .. });
    let newest = view.trace.back().filter(|_| running).and_then(value);
    newest.map_or(String::new(), |y| unsigned_zero(format!("{y:.digits$} ")))
}

/// A zero without its sign, which would come and go on a lever at rest.
fn unsigned_zero(number: String) -> String {
    match number.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| matches!(c, '0' | '.' | ' ')) => rest.to_owned(),
        _ => number,
    }
}

/// The first scale, doubled until the curves stay within.
fn scale(curves: &[Curve], first: f64) -> f64 {
    let sizes = curves.iter().flat_map(|curve| &curve.points).map(|(_, y)| y.abs());
    doubled(first, sizes.fold(0.0, f64::max))
}

/// The first scale, doubled until it holds the most; the first one for what no doubling holds.
fn doubled(first: f64, most: f64) -> f64 {
    let mut scale = first;
    while most.is_finite() && scale < most {
        scale *= 2.0;
    }
    scale
}

impl Plot {
    fn draw(&self, window_s: f64, look: Look, area: Rect, buffer: &mut Buffer) {
        let (title, plot) = cut(area, 1);
        let words = [
            Span::styled(self.title, look.style(Role::Quiet)),
            Span::raw("  "),
            Span::styled(self.value.trim_start(), look.style(Role::Strong)),
        ];
        Line::from_iter(words).render(title, buffer);
        let (gutter, inside) = cut_left(plot, GUTTER);
        self.draw_scale(look, gutter, buffer);
        let [bottom, top] = self.bounds();
        let canvas = Canvas::default().x_bounds([0.0, window_s]).y_bounds([bottom, top]);
        canvas
            .paint(|context| self.paint(context, window_s, inside.width, look))
            .render(inside, buffer);
    }

    fn bounds(&self) -> [f64; 2] {
        [self.low - self.room, self.high + self.room]
    }

    /// The scale: each label in the row its value falls in.
    fn draw_scale(&self, look: Look, area: Rect, buffer: &mut Buffer) {
        let [bottom, top] = self.bounds();
        let last = area.height.saturating_sub(1);
        for (row, cells) in (0..).zip(area.rows()) {
            // The ends before 0, which gives way where they share its row.
            let value = [self.low, self.high, 0.0].into_iter().find(|value| {
                let from_top = (top - value) / (top - bottom) * f64::from(area.height);
                (from_top as u16).min(last) == row
            });
            let label = value.map_or(String::new(), |value| format!("{value:.0}"));
            let text = format!("{label:>width$}│", width = usize::from(GUTTER) - 1);
            Line::styled(text, look.style(Role::Quiet)).render(cells, buffer);
        }
    }

    fn paint(&self, context: &mut Context<'_>, window_s: f64, cells: u16, look: Look) {
        if let Some(level) = self.level {
            context.marker(marker('-', look));
            for (from, to) in dashes(window_s, cells) {
                context.draw(&Segment::new(from, level, to, level, colour(Color::Yellow, look)));
            }
        }
        for curve in &self.curves {
            context.marker(marker(curve.letter, look));
            for (i, pair) in curve.points.windows(2).enumerate() {
                let gap = curve.dashed && (i / DASH_POINTS) % 2 == 1;
                if let ([(t1, y1), (t2, y2)], false) = (pair, gap) {
                    context.draw(&Segment::new(*t1, *y1, *t2, *y2, colour(curve.colour, look)));
                }
            }
        }
    }
}

pub(super) fn colour(colour: Color, look: Look) -> Color {
    if look.colour { colour } else { Color::Reset }
}

pub(super) fn marker(letter: char, look: Look) -> Marker {
    if look.ascii { Marker::Custom(letter) } else { Marker::Braille }
}

/// Points of a trace in a dash, and in the gap after it.
const DASH_POINTS: usize = 12;

/// A broken line over the whole plot: every other cell. A cell is two dots wide, and the last dot
/// is the plot's end.
fn dashes(window_s: f64, cells: u16) -> impl Iterator<Item = (f64, f64)> {
    let dot_s = window_s / (2.0 * f64::from(cells) - 1.0);
    (0..cells)
        .step_by(2)
        .map(move |i| (2.0 * f64::from(i) * dot_s, (2.0 * f64::from(i) + 1.0) * dot_s))
}

fn draw_axis(view: &View, window_s: f64, look: Look, area: Rect, buffer: &mut Buffer) {
    let (_, area) = cut_left(area, GUTTER);
    let quiet = look.style(Role::Quiet);
    Line::styled("0", quiet).render(area, buffer);
    Line::styled(format!("{window_s:.0} s"), quiet).right_aligned().render(area, buffer);
    if !matches!(view.phase, Phase::Trial { .. }) && !view.trace.is_empty() {
        Line::styled("last trial", quiet).centered().render(area, buffer);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scale_doubles_until_the_curve_stays_within() {
        let of = |most: f64| {
            let points = vec![(0.0, 0.0), (1.0, -most)];
            scale(&[Curve { points, colour: Color::Reset, letter: '*', dashed: false }], 5.0)
        };
        assert_eq!([0.0, 5.0, 5.1, 21.0].map(|most| of(most).to_string()), ["5", "5", "10", "40"]);
    }

    #[test]
    fn the_force_has_one_scale_while_a_trial_runs_and_room_for_what_came_after_it() {
        let point = |force_ex_n: f64| Point { force_ex_n, ..Point::default() };
        let runs = Phase::Trial { t_s: 1.0, limit_s: 4.0 };
        let mut view = View { phase: runs.clone(), ..View::default() };
        let ends = |view: &View| {
            let plot = force(view);
            [plot.low, plot.high].map(|end| end.round() as i64)
        };
        for n in [0.0, 3.0, -1.0, 8.0] {
            view.trace.push_back(point(n));
            assert_eq!(ends(&view), [-5, 5], "{n} N in the first trial");
        }
        let (_, drawn) = force(&view).curves[0].points[3];
        assert!((drawn - 5.0).abs() < 1e-12, "at the edge");
        view.phase = Phase::Ready;
        assert_eq!(ends(&view), [-10, 10]);
        view.begin_trace(Vec::new());
        assert_eq!((view.force_before_n, view.trace.len()), (Some([-1.0, 8.0]), 0));
        view.phase = runs;
        for n in [0.0, 30.0] {
            view.trace.push_back(point(n));
            assert_eq!(ends(&view), [-10, 10], "{n} N in the second trial");
        }
        let mut pushed = View { force_before_n: Some([-0.2, 3.0]), ..view };
        pushed.trace.clear();
        assert_eq!(ends(&pushed), [0, 5]);
    }

    #[test]
    fn no_curve_is_in_the_blue_that_is_hard_to_read_on_black() {
        let view = View::default();
        let look = Look { colour: true, ascii: false };
        let plots = columns_of(&view, look).into_iter().flatten();
        assert!(plots.flat_map(|plot| plot.curves).all(|curve| curve.colour != Color::Blue));
    }

    #[test]
    fn a_zero_has_no_sign() {
        let check =
            |number: &str, expect: &str| assert_eq!(unsigned_zero(number.to_owned()), expect);
        check("-0.0 ", "0.0 ");
        check("-0.1 ", "-0.1 ");
        check("12 ", "12 ");
    }
}
