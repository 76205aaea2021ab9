//! Checks a figure's data and finds the ends of its axes.

use std::collections::BTreeMap;

use crate::error::Error;
use crate::figure::{Figure, Layer, Likert, Panel, Range, TextPlace, Ticks};
use crate::likert;

/// Ends of an axis: low, high.
pub(crate) type Ends = (f64, f64);

/// Share of the data's extent that `Range::Auto` leaves free on either side.
const ROOM: f64 = 0.04;
/// An extent narrower than this share of its place is drawn as if it were this wide: rounding is
/// not data.
const NARROWEST: f64 = 1e-12;
/// Values below this are nothing on any axis; ticks would leave the range of f64.
const SMALLEST: f64 = 1e-270;
/// Values above this leave no room to compute ticks in.
const LARGEST: f64 = 1e300;
/// The same as a power of ten, for axes of logarithms; e to it is no limit of f64 either.
const LARGEST_POWER: f64 = 300.0;

/// A straight map from an axis to the page.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scale {
    pub(crate) ends: Ends,
    /// Where the ends lie on the page.
    pub(crate) page_pt: (f64, f64),
}

impl Scale {
    pub(crate) fn pt(&self, value: f64) -> f64 {
        let share = (value - self.ends.0) / (self.ends.1 - self.ends.0);
        self.page_pt.0 + share * (self.page_pt.1 - self.page_pt.0)
    }

    /// The value at a place on the page.
    pub(crate) fn value(&self, pt: f64) -> f64 {
        let share = (pt - self.page_pt.0) / (self.page_pt.1 - self.page_pt.0);
        self.ends.0 + share * (self.ends.1 - self.ends.0)
    }
}

/// What is wrong with a panel, after its row and column, which count from 1.
pub(crate) fn wrong(panel: &Panel, what: &str) -> Error {
    let [row, column] = [panel.cell.row, panel.cell.column].map(|first| first.saturating_add(1));
    Error::Panel(format!("panel ({row}, {column}){what}"))
}

/// Refuses arrays of unequal length, infinities, and panels with nothing in them.
pub(crate) fn check(panel: &Panel) -> Result<(), Error> {
    // What stands under a note is not drawn, and may be anything.
    if panel.note.is_some() {
        return Ok(());
    }
    panel.layers.iter().try_for_each(|layer| check_layer(panel, layer))?;
    match panel.layers.iter().any(has_data) {
        true => Ok(()),
        false => Err(wrong(
            panel,
            " has nothing to draw; give it data, or a note that says why there are none",
        )),
    }
}

fn check_layer(panel: &Panel, layer: &Layer) -> Result<(), Error> {
    let arrays = arrays(layer);
    for pair in arrays.windows(2) {
        let [first, second] = [pair[0], pair[1]].map(|(name, values)| (name, values.len()));
        same_length(panel, first, second)?;
    }
    for (what, values) in arrays {
        if let Some(index) = values.iter().position(|v| v.is_infinite()) {
            let value = values[index];
            return Err(wrong(
                panel,
                &format!(
                    ": {what}[{index}] is {value}; a missing value is NaN, anything else must be finite"
                ),
            ));
        }
    }
    match layer {
        Layer::Line(line) if !line.dotted.is_empty() => {
            same_length(panel, ("x", line.x.len()), ("dotted", line.dotted.len()))
        }
        Layer::Reference(reference) => place(panel, "a reference line", &[reference.at]),
        Layer::Text(text) => place(panel, "a text", &coordinates(text.place)),
        Layer::Likert(likert) => check_likert(likert, panel),
        _ => Ok(()),
    }
}

/// The numbers that say where words stand.
fn coordinates(place: TextPlace) -> Vec<f64> {
    match place {
        TextPlace::EmptiestCorner => Vec::new(),
        TextPlace::Over(x, y)
        | TextPlace::Amid(x, y)
        | TextPlace::RightOf(x, y)
        | TextPlace::LeftOf(x, y) => vec![x, y],
        TextPlace::Within(low, high) => vec![low.0, low.1, high.0, high.1],
    }
}

/// The place of a single thing is a number: it cannot be missing.
fn place(panel: &Panel, what: &str, at: &[f64]) -> Result<(), Error> {
    let Some(value) = at.iter().find(|value| !value.is_finite()) else { return Ok(()) };
    let stands =
        format!(": {what} stands at {value}; it needs a finite place, or is to be left out");
    Err(wrong(panel, &stands))
}

/// The name of an array, and its length.
type Named<'a> = (&'a str, usize);

fn same_length(panel: &Panel, first: Named, second: Named) -> Result<(), Error> {
    if first.1 == second.1 { Ok(()) } else { Err(unlike(panel, first, second)) }
}

fn unlike(panel: &Panel, (first, a): Named, (second, b): Named) -> Error {
    let lengths = format!(": {first} has {a} values but {second} has {b}; they go in pairs");
    wrong(panel, &lengths)
}

/// The arrays of a layer that must be equally long, with their names.
fn arrays(layer: &Layer) -> Vec<(&'static str, &[f64])> {
    match layer {
        Layer::Line(l) => vec![("x", &l.x), ("y", &l.y)],
        Layer::Points(p) => vec![("x", &p.x), ("y", &p.y)],
        Layer::Band(b) => vec![("x", &b.x), ("low", &b.low), ("high", &b.high)],
        Layer::Intervals(i) => {
            vec![("at", &i.at), ("estimate", &i.estimate), ("low", &i.low), ("high", &i.high)]
        }
        Layer::Reference(_) | Layer::Text(_) | Layer::Likert(_) => Vec::new(),
    }
}

fn has_data(layer: &Layer) -> bool {
    match layer {
        Layer::Reference(_) | Layer::Text(_) => false,
        Layer::Likert(likert) => likert.rows.iter().flatten().flatten().any(|&count| count > 0),
        _ => match arrays(layer)[..] {
            [(_, a), (_, b), ..] => a.iter().zip(b).any(|(a, b)| a.is_finite() && b.is_finite()),
            _ => false,
        },
    }
}

/// What a layer covers on x and on y.
fn extent(layer: &Layer) -> [Option<Ends>; 2] {
    match layer {
        Layer::Line(l) => [cover([&l.x]), cover([&l.y])],
        Layer::Points(p) => [cover([&p.x]), cover([&p.y])],
        Layer::Band(b) => [cover([&b.x]), cover([&b.low, &b.high])],
        Layer::Intervals(i) => {
            let reach = cover([&i.estimate, &i.low, &i.high]);
            i.direction.x_and_y(reach, cover([&i.at])).into()
        }
        Layer::Reference(r) => r.direction.x_and_y(None, Some((r.at, r.at))).into(),
        Layer::Likert(likert) => {
            let strips = likert.rows.iter().flatten();
            let segments = strips.flat_map(|counts| likert::segments(counts, likert.scale));
            // From zero on, which is always shown.
            let ends = segments.fold((0.0_f64, 0.0_f64), |(a, b), s| (a.min(s.from), b.max(s.to)));
            [(ends.0 < ends.1).then_some(ends), None]
        }
        Layer::Text(_) => [None, None],
    }
}

fn cover<const N: usize>(arrays: [&Vec<f64>; N]) -> Option<Ends> {
    let finite = arrays.into_iter().flatten().copied().filter(|v| v.is_finite());
    finite.fold(None, |ends: Option<Ends>, v| {
        Some(ends.map_or((v, v), |(a, b)| (a.min(v), b.max(v))))
    })
}

fn union(a: Option<Ends>, b: Option<Ends>) -> Option<Ends> {
    match (a, b) {
        (Some(a), Some(b)) => Some((a.0.min(b.0), a.1.max(b.1))),
        (a, b) => a.or(b),
    }
}

/// The ends of every panel's x and y axis; `None` where there is neither data nor a fixed range.
pub(crate) fn ends(figure: &Figure) -> Result<Vec<[Option<Ends>; 2]>, Error> {
    let mut ends = Vec::new();
    for panel in &figure.panels {
        ends.push([panel_ends(panel, 0)?, panel_ends(panel, 1)?]);
    }
    let mut shared: BTreeMap<&str, Option<Ends>> = BTreeMap::new();
    for (panel, own) in figure.panels.iter().zip(&ends) {
        for (axis, &own) in [&panel.x, &panel.y].into_iter().zip(own) {
            if let Some(key) = axis.link.as_deref() {
                let so_far = shared.entry(key).or_default();
                *so_far = union(*so_far, own);
            }
        }
    }
    for (panel, own) in figure.panels.iter().zip(&mut ends) {
        for (axis, own) in [&panel.x, &panel.y].into_iter().zip(own) {
            if let Some(shared) = axis.link.as_deref().and_then(|key| shared.get(key)) {
                *own = *shared;
            }
        }
    }
    Ok(ends)
}

/// The ends of one panel's own x (0) or y (1) axis.
fn panel_ends(panel: &Panel, which: usize) -> Result<Option<Ends>, Error> {
    let axis = [&panel.x, &panel.y][which];
    let covered = match panel.note {
        Some(_) => None,
        None => panel.layers.iter().map(|layer| extent(layer)[which]).fold(None, union),
    };
    let held = match axis.range {
        Range::Holding(low, high) => union(covered, Some((low.min(high), low.max(high)))),
        _ => covered,
    };
    let ends = match (&axis.ticks, axis.range) {
        // Names have their places, whatever range is asked for.
        (Ticks::Categories(names), _) => Some((-0.5, names.len() as f64 - 0.5)),
        (_, Range::Fixed(low, high) | Range::OneScale(low, high)) => Some((low, high)),
        (Ticks::Powers, _) => held.map(|ends| two_powers(widen(ends, ROOM))),
        (_, Range::Tight) => covered.map(|ends| widen(ends, 0.0)),
        (_, Range::Holding(..) | Range::Auto) => held.map(|ends| widen(ends, ROOM)),
    };
    let largest = match axis.ticks {
        Ticks::Powers | Ticks::Logarithms => LARGEST_POWER,
        _ => LARGEST,
    };
    if let Some((low, high)) = ends {
        let size = low.abs().max(high.abs());
        // Said so that an end that is no number is refused too: every comparison with it fails.
        let is_drawable = high - low > NARROWEST * size.max(SMALLEST) && size < largest;
        if !is_drawable {
            return Err(wrong(
                panel,
                &format!(
                    ": an axis cannot run from {low} to {high}; the first must be clearly smaller and both below 1e300"
                ),
            ));
        }
    }
    Ok(ends)
}

/// Logarithms between which fewer than two whole powers lie reach to the ones around them: with one
/// number alone an axis says nothing.
fn two_powers((low, high): Ends) -> Ends {
    match libm::floor(high) > libm::ceil(low) {
        true => (low, high),
        false => (libm::floor(low), libm::ceil(high)),
    }
}

/// Adds room on both sides; a single value gets room to be seen in.
fn widen((low, high): Ends, share: f64) -> Ends {
    let place = low.abs().max(high.abs());
    if high - low <= 2.0 * NARROWEST * place.max(SMALLEST) {
        let room = if place < SMALLEST { 1.0 } else { 0.1 * place };
        return (low - room, high + room);
    }
    let room = share * (high - low);
    (low - room, high + room)
}

/// Every row has one count per answer, and the y axis one name per row.
fn check_likert(likert: &Likert, panel: &Panel) -> Result<(), Error> {
    for strip in likert.rows.iter().flatten() {
        let answers = ("answers", likert.answers.len());
        same_length(panel, answers, ("a row of counts", strip.len()))?;
    }
    let rows = ("rows", likert.rows.len());
    match &panel.y.ticks {
        Ticks::Categories(names) => same_length(panel, ("the y axis' names", names.len()), rows),
        // Refused even for no rows: the bars stand at places that only such an axis has.
        _ => Err(unlike(panel, ("the y axis' names", 0), rows)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::{Axis, Cell, Line};

    fn panel(x: Vec<f64>, y: Vec<f64>) -> Panel {
        let line = Layer::Line(Line { x, y, ..Line::default() });
        Panel::new(Cell::at(0, 0), Axis::new("x", ""), Axis::new("y", ""), vec![line])
    }

    #[test]
    fn unequal_arrays_are_refused_with_both_lengths() {
        let error = check(&panel(vec![0.0, 1.0, 2.0], vec![0.0])).unwrap_err().to_string();
        assert!(error.contains("x has 3") && error.contains("y has 1"), "{error}");
    }

    #[test]
    fn infinities_are_refused_and_gaps_are_not() {
        assert!(check(&panel(vec![0.0, 1.0], vec![f64::NAN, 1.0])).is_ok());
        let error = check(&panel(vec![0.0, 1.0], vec![0.0, f64::INFINITY])).unwrap_err();
        assert!(error.to_string().starts_with("panel (1, 1): y[1] is inf"), "{error}");
    }

    #[test]
    fn a_panel_without_any_value_asks_for_a_note() {
        let error = check(&panel(vec![1.0, f64::NAN], vec![f64::NAN, 1.0])).unwrap_err();
        assert!(error.to_string().contains("has nothing to draw"), "{error}");
        let axis = || Axis::new("x", "");
        assert!(check(&Panel::with_note(Cell::at(0, 0), axis(), axis(), "not recorded")).is_ok());
    }

    #[test]
    fn a_constant_curve_still_gets_an_axis() {
        assert_eq!(widen((0.0, 0.0), ROOM), (-1.0, 1.0));
        assert_eq!(widen((5.0, 5.0), ROOM), (4.5, 5.5));
        assert_eq!(widen((0.0, 10.0), 0.1), (-1.0, 11.0));
    }

    #[test]
    fn an_axis_of_powers_holds_at_least_two() {
        assert_eq!(two_powers((-1.2, 0.3)), (-1.2, 0.3));
        assert_eq!(two_powers((0.2, 0.7)), (0.0, 1.0));
        assert_eq!(two_powers((-0.5, 0.5)), (-1.0, 1.0));
        let mut far = panel(vec![0.0, 1.0], vec![0.0, 400.0]);
        far.y.ticks = Ticks::Powers;
        let error = ends(&Figure { panels: vec![far], ..Figure::default() }).unwrap_err();
        assert!(error.to_string().contains("an axis cannot run"), "10^400 is no number: {error}");
    }

    #[test]
    fn axes_of_numbers_and_of_powers_hold_what_they_are_to_hold() {
        for ticks in [Ticks::Numbers, Ticks::Powers] {
            let mut held = panel(vec![0.0, 1.0], vec![2.0, 3.0]);
            held.y = Axis { ticks, ..Axis::new("y", "").ranged(Range::Holding(-4.0, 6.0)) };
            let ends = ends(&Figure { panels: vec![held], ..Figure::default() }).unwrap();
            assert_eq!(ends[0][1], Some(widen((-4.0, 6.0), ROOM)));
        }
    }

    #[test]
    fn linked_axes_share_one_range_even_x_with_y() {
        let mut a = panel(vec![0.0, 1.0], vec![0.0, 30.0]);
        let mut b = panel(vec![-5.0, 10.0], vec![0.0, 1.0]);
        a.y = Axis::new("θ", "°").ranged(Range::Tight).linked("theta");
        b.x = Axis::new("θ", "°").ranged(Range::Tight).linked("theta");
        let ends = ends(&Figure { panels: vec![a, b], ..Figure::default() }).unwrap();
        assert_eq!(ends[0][1], Some((-5.0, 30.0)));
        assert_eq!(ends[1][0], ends[0][1]);
    }

    #[test]
    fn a_range_that_is_no_range_is_refused() {
        for (low, high) in
            [(1.0, 1.0), (2.0, 1.0), (f64::NAN, 1.0), (0.0, f64::INFINITY), (-1e308, 1e308)]
        {
            let mut bad = panel(vec![0.0, 1.0], vec![0.0, 1.0]);
            bad.x.range = Range::Fixed(low, high);
            let error = ends(&Figure { panels: vec![bad], ..Figure::default() }).unwrap_err();
            assert!(error.to_string().contains("an axis cannot run"), "{error}");
        }
    }
}
