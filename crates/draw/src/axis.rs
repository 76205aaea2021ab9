//! One axis, planned: its ticks with their labels set, its own label, and the room that all of
//! these take.

use crate::error::Error;
use crate::figure::{Axis, Direction, Ticks};
use crate::font::{self, Fonts, Label};
use crate::scale::{Ends, Scale};
use crate::style::{LABEL_PT, SMALL_PT, TICK_PT};
use crate::ticks;

/// Between a tick and its label, in pt.
pub(crate) const TICK_GAP_PT: f64 = 2.0;
/// Between tick labels and the axis' label, in pt.
pub(crate) const LABEL_GAP_PT: f64 = 2.5;
/// Between a plot area and its heading or the words at a reference line's end, in pt.
pub(crate) const PLOT_GAP_PT: f64 = 2.0;
/// Least room between neighbouring tick labels along a horizontal axis, in pt.
const LABELS_APART_PT: f64 = 7.0;
/// Least distance of ticks along a horizontal axis, in pt.
const TICKS_APART_X_PT: f64 = 20.0;
/// Least distance of ticks along a vertical axis, in pt.
const TICKS_APART_Y_PT: f64 = 16.0;

/// Least length of a decade whose inner ticks are told apart, in pt.
const DECADE_PT: f64 = 30.0;

/// A tick with its label set in lines.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PlannedTick {
    pub(crate) at: f64,
    pub(crate) lines: Vec<Label>,
    /// Between two powers of ten: shorter, without label and grid line.
    pub(crate) minor: bool,
}

/// An axis ready to be drawn.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct AxisPlan {
    pub(crate) ends: Option<Ends>,
    pub(crate) ticks: Vec<PlannedTick>,
    /// Names of categories and numbers that found no room side by side read upwards.
    pub(crate) turned: bool,
    /// Names get no tick mark and no grid line.
    pub(crate) named: bool,
    /// Neither ticks nor an edge of the plot.
    pub(crate) bare: bool,
    pub(crate) label: Vec<Label>,
}

impl AxisPlan {
    /// Room from the plot's edge outwards.
    pub(crate) fn depth_pt(&self, direction: Direction) -> f64 {
        let depths = self.ticks.iter().map(|tick| match (direction, self.turned) {
            (Direction::Horizontal, false) => font::height_pt(&tick.lines),
            _ => font::widest_pt(&tick.lines),
        });
        let ticks = if self.ticks.iter().any(|tick| !tick.lines.is_empty()) {
            TICK_PT + TICK_GAP_PT + depths.fold(0.0, f64::max)
        } else if self.bare {
            0.0
        } else {
            TICK_PT
        };
        let label =
            if self.label.is_empty() { 0.0 } else { LABEL_GAP_PT + font::height_pt(&self.label) };
        ticks + label
    }

    /// How far the outermost tick labels stick out beyond the axis' ends, before and after.
    pub(crate) fn overhang_pt(&self, direction: Direction, length_pt: f64) -> (f64, f64) {
        let Some(ends) = self.ends else { return (0.0, 0.0) };
        let scale = Scale { ends, page_pt: (0.0, length_pt) };
        let mut overhang: (f64, f64) = (0.0, 0.0);
        for tick in &self.ticks {
            let half = match (direction, self.turned) {
                (Direction::Horizontal, false) => font::widest_pt(&tick.lines) / 2.0,
                _ => font::height_pt(&tick.lines) / 2.0,
            };
            overhang.0 = overhang.0.max(half - scale.pt(tick.at));
            overhang.1 = overhang.1.max(scale.pt(tick.at) + half - length_pt);
        }
        overhang
    }
}

/// Plans an axis of the given length on paper; an axis that is not `numbered` has bare ticks.
pub(crate) fn plan(
    fonts: &Fonts,
    axis: &Axis,
    ends: Option<Ends>,
    direction: Direction,
    length_pt: f64,
    numbered: bool,
) -> Result<AxisPlan, Error> {
    let mut plan = AxisPlan { ends, bare: axis.ticks == Ticks::Bare, ..AxisPlan::default() };
    let mut exponent = 0;
    if let (Some(ends), Ticks::Categories(names)) = (ends, &axis.ticks) {
        plan.named = true;
        (plan.ticks, plan.turned) = categories(fonts, names, ends, direction, length_pt)?;
    } else if let Some(ends) = ends.filter(|_| !plan.bare) {
        let fits = |ticks: &ticks::Ticks| apart(fonts, ticks, ends, direction, length_pt);
        let chosen = ticks::choose(ends.0, ends.1, &axis.ticks, fits);
        exponent = chosen.exponent;
        // Of an axis always two numbers are kept; where they have no room side by side, they turn.
        plan.turned = direction == Direction::Horizontal && !fits(&chosen);
        for tick in &chosen.ticks {
            let lines = vec![fonts.label(&tick.label, SMALL_PT)?];
            plan.ticks.push(PlannedTick { at: tick.at, lines, minor: false });
        }
        if axis.ticks == Ticks::Powers && length_pt / (ends.1 - ends.0) >= DECADE_PT {
            let minor = ticks::between_powers(ends.0, ends.1);
            plan.ticks.extend(minor.map(|at| PlannedTick { at, lines: Vec::new(), minor: true }));
        }
    }
    // Without numbers the ticks stay: the grid lines of stacked panels go through.
    if numbered {
        plan.label = fonts.parted(&label(axis, exponent), LABEL_PT, length_pt)?;
    } else {
        plan.ticks.iter_mut().for_each(|tick| tick.lines.clear());
    }
    Ok(plan)
}

/// Quantity, and in parentheses the power of ten and the unit.
fn label(axis: &Axis, exponent: i32) -> String {
    let power = match exponent {
        0 => String::new(),
        n if n < 0 => format!("10^{{−{}}}", -n),
        n => format!("10^{{{n}}}"),
    };
    // No line break parts the power from its unit.
    let space = if power.is_empty() || axis.unit.is_empty() { "" } else { "\u{a0}" };
    match format!("{power}{space}{}", axis.unit) {
        scale if scale.is_empty() => axis.label.clone(),
        scale => format!("{} ({scale})", axis.label),
    }
}

/// Whether neighbouring ticks and their labels keep their distance.
fn apart(
    fonts: &Fonts,
    ticks: &ticks::Ticks,
    ends: Ends,
    direction: Direction,
    length_pt: f64,
) -> bool {
    ticks.ticks.windows(2).all(|pair| {
        let spacing = (pair[1].at - pair[0].at) / (ends.1 - ends.0) * length_pt;
        match direction {
            Direction::Vertical => spacing >= TICKS_APART_Y_PT,
            Direction::Horizontal => {
                // A label that cannot be set is an error once the ticks are chosen.
                let widths = pair.iter().map(|tick| {
                    fonts.label(&tick.label, SMALL_PT).map_or(0.0, |label| label.width_pt)
                });
                spacing >= TICKS_APART_X_PT.max(widths.sum::<f64>() / 2.0 + LABELS_APART_PT)
            }
        }
    })
}

/// Share of a horizontal axis' slot that names beside each other fill on average.
const SLOT_SHARE: f64 = 0.92;
/// Widths that names beside a vertical axis may take, in pt: the first at which all are lower than
/// their rows.
const NAME_PT: [f64; 4] = [80.0, 120.0, 160.0, 220.0];
/// Share of a figure's width that names beside a vertical axis leave to it at least.
const SHARE_BESIDE_NAMES: f64 = 0.3;

/// Length of a vertical axis, in a figure that is `figure_pt` wide, on which each of the names has room.
pub(crate) fn names_pt(fonts: &Fonts, names: &[String], figure_pt: f64) -> Result<f64, Error> {
    let most_pt = (1.0 - SHARE_BESIDE_NAMES) * figure_pt;
    let width_pt = NAME_PT.iter().rev().find(|pt| **pt <= most_pt).unwrap_or(&NAME_PT[0]);
    let mut highest: f64 = 0.0;
    for name in names {
        highest = highest.max(font::height_pt(&fonts.parted(name, SMALL_PT, *width_pt)?));
    }
    Ok(highest * names.len() as f64)
}

/// Lengths that names which read upwards under a horizontal axis may take, in pt: the first at which
/// the lines of each are in its slot.
const TURNED_PT: [f64; 4] = [60.0, 90.0, 130.0, 200.0];

/// Names in lines, and whether they had to be turned.
fn categories<'f>(
    fonts: &Fonts<'f>,
    names: &[String],
    ends: Ends,
    direction: Direction,
    length_pt: f64,
) -> Result<(Vec<PlannedTick>, bool), Error> {
    let slot_pt = length_pt / (ends.1 - ends.0);
    if direction == Direction::Horizontal {
        let upright = named_ticks(fonts, names, SLOT_SHARE * slot_pt, Fonts::wrap)?;
        let widths: Vec<f64> = upright.iter().map(|tick| font::widest_pt(&tick.lines)).collect();
        // A name may fill its slot where those beside it leave room.
        if widths.iter().all(|width| *width <= slot_pt)
            && widths.windows(2).all(|pair| (pair[0] + pair[1]) / 2.0 <= SLOT_SHARE * slot_pt)
        {
            return Ok((upright, false));
        }
        let mut turned = named_ticks(fonts, names, TURNED_PT[0], Fonts::parted)?;
        // The greatest length is taken even where it is not enough: no name is left out.
        for length_pt in &TURNED_PT[1..] {
            if highest_pt(&turned) > slot_pt {
                turned = named_ticks(fonts, names, *length_pt, Fonts::parted)?;
            }
        }
        return Ok((turned, true));
    }
    // A word is parted only where no width keeps all of them whole.
    let ways: [SetLines<'f>; 2] = [Fonts::block, Fonts::parted];
    for lines in ways {
        for width_pt in NAME_PT {
            match named_ticks(fonts, names, width_pt, lines) {
                Err(Error::TextTooLong { .. }) => {}
                Ok(ticks) if highest_pt(&ticks) > slot_pt => {}
                ticks => return Ok((ticks?, false)),
            }
        }
    }
    let ticks = named_ticks(fonts, names, NAME_PT[NAME_PT.len() - 1], Fonts::parted)?;
    let highest = ticks
        .iter()
        .zip(names)
        .max_by(|(a, _), (b, _)| font::height_pt(&a.lines).total_cmp(&font::height_pt(&b.lines)));
    let text = highest.map(|(_, name)| name.clone()).unwrap_or_default();
    Err(Error::TextTooLong { text, need_pt: highest_pt(&ticks), have_pt: slot_pt })
}

/// How a text becomes lines of a size within a width.
type SetLines<'f> = fn(&Fonts<'f>, &str, f64, f64) -> Result<Vec<Label>, Error>;

/// A tick for each name, set in lines within a width.
fn named_ticks<'f>(
    fonts: &Fonts<'f>,
    names: &[String],
    width_pt: f64,
    set_lines: SetLines<'f>,
) -> Result<Vec<PlannedTick>, Error> {
    let mut ticks = Vec::new();
    for (i, name) in names.iter().enumerate() {
        let lines = set_lines(fonts, name, SMALL_PT, width_pt)?;
        ticks.push(PlannedTick { at: i as f64, lines, minor: false });
    }
    Ok(ticks)
}

fn highest_pt(ticks: &[PlannedTick]) -> f64 {
    ticks.iter().map(|tick| font::height_pt(&tick.lines)).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn horizontal(axis: &Axis, ends: Ends, length_pt: f64) -> AxisPlan {
        plan(Fonts::bundled().unwrap(), axis, Some(ends), Direction::Horizontal, length_pt, true)
            .unwrap()
    }

    fn text(lines: &[Label]) -> String {
        lines.iter().map(Label::text).collect::<Vec<_>>().join("/")
    }

    #[test]
    fn tick_labels_never_come_closer_than_they_may() {
        for length_pt in [30.0, 60.0, 120.0, 300.0] {
            for ends in [(0.0, 4.16), (-12_345.0, 98_765.0), (0.001, 0.0013), (-5.0, 5e6)] {
                let plan = horizontal(&Axis::new("t", "s"), ends, length_pt);
                let scale = Scale { ends, page_pt: (0.0, length_pt) };
                let spans = plan.ticks.iter().map(|tick| {
                    let half = font::widest_pt(&tick.lines) / 2.0;
                    (scale.pt(tick.at) - half, scale.pt(tick.at) + half)
                });
                let spans: Vec<_> = spans.collect();
                let free = spans.windows(2).all(|pair| pair[1].0 - pair[0].1 > 1.0);
                assert!(free || spans.len() == 2, "{ends:?} on {length_pt} pt: {spans:?}");
                assert!(spans.len() >= 2, "{ends:?} on {length_pt} pt");
            }
        }
    }

    #[test]
    fn two_numbers_without_room_side_by_side_read_upwards() {
        let turned = |length_pt| horizontal(&Axis::new("*K*", "N/rad"), (4.095, 4.1), length_pt);
        assert!(turned(24.0).turned && !turned(240.0).turned);
        assert!(turned(24.0).depth_pt(Direction::Horizontal) > 20.0, "they have the room below");
    }

    #[test]
    fn the_power_of_ten_stands_with_the_unit() {
        let plan = horizontal(&Axis::new("*I*", "kg·m²"), (0.0, 4e-4), 120.0);
        assert_eq!(text(&plan.label), "I (10−6\u{a0}kg·m2)");
    }

    #[test]
    fn decades_have_inner_ticks_only_where_they_can_be_told_apart() {
        let powers = Axis { ticks: Ticks::Powers, ..Axis::new("*h*", "s") };
        let minors = |length_pt| {
            horizontal(&powers, (-4.0, -2.0), length_pt).ticks.iter().filter(|t| t.minor).count()
        };
        assert_eq!((minors(100.0), minors(50.0)), (16, 0));
    }

    #[test]
    fn long_names_wrap_and_those_that_cannot_are_turned() {
        let sessions = Axis::categories(["session 9", "session 10"]);
        let wrapped = horizontal(&sessions, (-0.5, 1.5), 60.0);
        assert_eq!((text(&wrapped.ticks[0].lines).as_str(), wrapped.turned), ("session/9", false));
        assert!(horizontal(&sessions, (-0.5, 1.5), 50.0).turned, "no name is set smaller");
        let modes = |names: [&str; 3]| horizontal(&Axis::categories(names), (-0.5, 2.5), 78.0);
        assert!(!modes(["Active", "Passive", "Hybrid"]).turned, "one is wide between two narrow");
        assert!(modes(["Passive", "Passive", "Passive"]).turned);
        let turned =
            horizontal(&Axis::categories(["administration", "configuration"]), (-0.5, 1.5), 40.0);
        assert!(turned.turned);
    }

    #[test]
    fn names_that_are_turned_are_as_long_as_their_slot_needs() {
        let names =
            ["administration: undecided, 12 trials of P01", "configuration: different, all"];
        let plan = horizontal(&Axis::categories(names), (-0.5, 1.5), 44.0);
        assert!(plan.turned);
        let highest = plan.ticks.iter().map(|tick| font::height_pt(&tick.lines));
        assert!(highest.fold(0.0, f64::max) <= 22.0, "{:?}", plan.ticks);
    }

    #[test]
    fn an_axis_without_ends_has_its_label_and_no_ticks() {
        let fonts = Fonts::bundled().unwrap();
        let plan =
            plan(fonts, &Axis::new("*θ*", "°"), None, Direction::Vertical, 60.0, true).unwrap();
        assert!(plan.ticks.is_empty() && !plan.label.is_empty());
    }
}
