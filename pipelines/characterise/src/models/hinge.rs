//! A line above a free break, constant below it: a dead zone.

use crate::shape::{Point, Points, Quantity, Shape};
use zwidth_results::CurveSymbol;

/// Two sums of squares closer than this share of the total are the same but for rounding; then the
/// lower break is taken.
const SAME: f64 = 1e-12;

/// y = a for x ≤ x0, y = a + b (x − x0) above.
#[derive(Debug, Clone, Copy)]
pub struct Hinge;

impl Shape for Hinge {
    fn formula(&self) -> &'static str {
        "y = a + b max(x - x0, 0)"
    }

    fn parameters(&self) -> &'static [(CurveSymbol, Quantity)] {
        &[
            (CurveSymbol::A, Quantity::Response),
            (CurveSymbol::B, Quantity::Slope),
            (CurveSymbol::X0, Quantity::Break),
        ]
    }

    /// The global minimum, without a starting value (Hudson 1966, J. Amer. Statist. Assoc.
    /// 61:1097): between two neighbouring commands the points split in a fixed way, so the best
    /// break there is where the mean of the lower ones meets the line through the upper ones,
    /// or else one of the two commands. Running sums make each case O(1). The constant part has
    /// two commands or none.
    fn fit(&self, points: &Points, _near: Option<&[f64]>) -> Option<Vec<f64>> {
        let (lowest, highest) = points.break_range()?;
        if !points.can_determine(self.complexity()) {
            return None;
        }
        let scale = Scale::of(points);
        let best = best(points.at, &scale, highest)?;
        Some(vec![scale.response(best.a), best.b / scale.span, scale.command(best.x0).max(lowest)])
    }

    fn predict(&self, parameters: &[f64], command: f64) -> f64 {
        parameters[0] + parameters[1] * (command - parameters[2]).max(0.0)
    }
}

/// The hinge through points of rising (or equal) commands with the smallest sum of squares, its
/// break at `highest` at most. In scaled units.
pub(super) fn best(at: &[Point], scale: &Scale, highest: f64) -> Option<Fit> {
    let cuts = cuts(at, scale, highest);
    // Each cut has all points, below or above it.
    let total = cuts.first()?.all();
    let neighbours = cuts.windows(2).filter_map(|pair| pair[0].break_between(pair[1].level));
    let mut best: Option<Fit> = None;
    for fit in cuts.iter().filter_map(Cut::break_here).chain(neighbours) {
        if best.as_ref().is_none_or(|b| fit.rss < b.rss - SAME * total.yy) {
            best = Some(fit);
        }
    }
    best
}

/// Commands from 0 to 1 and responses about their mean: running sums of squares keep their digits.
pub(super) struct Scale {
    origin: f64,
    pub(super) span: f64,
    mean: f64,
}

impl Scale {
    pub(super) fn of(points: &Points) -> Self {
        let (weight, sum) = points
            .at
            .iter()
            .fold((0.0, 0.0), |(sw, sy), p| (sw + p.weight, sy + p.weight * p.response));
        let origin = points.levels[0];
        Self { origin, span: points.levels[points.levels.len() - 1] - origin, mean: sum / weight }
    }

    pub(super) fn command(&self, x: f64) -> f64 {
        self.origin + self.span * x
    }

    pub(super) fn response(&self, y: f64) -> f64 {
        self.mean + y
    }
}

/// Weighted sums over some points.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    w: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
    yy: f64,
}

impl Sums {
    /// These and a number times others: 1 takes the others in, −1 out.
    fn plus_times(self, factor: f64, o: Self) -> Self {
        Self {
            w: self.w + factor * o.w,
            x: self.x + factor * o.x,
            y: self.y + factor * o.y,
            xx: self.xx + factor * o.xx,
            xy: self.xy + factor * o.xy,
            yy: self.yy + factor * o.yy,
        }
    }
}

/// The points split at one command: those at or below it, and those above.
#[derive(Debug, Clone, Copy)]
struct Cut {
    level: f64,
    /// Different commands at or below the level.
    commands_below: usize,
    below: Sums,
    above: Sums,
}

/// A hinge in scaled units, with its sum of squares.
pub(super) struct Fit {
    pub(super) a: f64,
    pub(super) b: f64,
    pub(super) x0: f64,
    pub(super) rss: f64,
}

/// One cut at each command up to `highest`, rising.
fn cuts(at: &[Point], scale: &Scale, highest: f64) -> Vec<Cut> {
    let mut cuts = Vec::with_capacity(at.len());
    let mut below = Sums::default();
    for (commands, same) in at.chunk_by(|p, q| p.command >= q.command).enumerate() {
        let x = (same[0].command - scale.origin) / scale.span;
        let here = same.iter().fold(Sums::default(), |sums, p| {
            let y = p.response - scale.mean;
            let w = p.weight;
            let at = Sums { w, x: w * x, y: w * y, xx: w * x * x, xy: w * x * y, yy: w * y * y };
            sums.plus_times(1.0, at)
        });
        below = below.plus_times(1.0, here);
        if same[0].command <= highest {
            let above = Sums::default();
            cuts.push(Cut { level: x, commands_below: commands + 1, below, above });
        }
    }
    // Now `below` has all points.
    cuts.iter_mut().for_each(|cut| cut.above = below.plus_times(-1.0, cut.below));
    cuts
}

impl Cut {
    fn all(&self) -> Sums {
        self.below.plus_times(1.0, self.above)
    }

    /// The best fit with its break at this level: a regression on h = max(x − level, 0).
    fn break_here(&self) -> Option<Fit> {
        let all = self.all();
        let up = self.above;
        let v = self.level;
        let h = up.x - v * up.w;
        let hh = up.xx - 2.0 * v * up.x + v * v * up.w - h * h / all.w;
        let hy = up.xy - v * up.y - h * all.y / all.w;
        let b = hy / hh;
        (hh > 0.0).then(|| Fit {
            a: (all.y - b * h) / all.w,
            b,
            x0: v,
            rss: all.yy - all.y * all.y / all.w - b * hy,
        })
    }

    /// The best fit with its break strictly between this level and the `next`, if there is one. A
    /// constant part that rests on one command is none: that would be a line with an odd first
    /// point.
    fn break_between(&self, next: f64) -> Option<Fit> {
        let low = self.below;
        let up = self.above;
        let xx = up.xx - up.x * up.x / up.w;
        let xy = up.xy - up.x * up.y / up.w;
        let a = low.y / low.w;
        let b = xy / xx;
        let x0 = (a - (up.y - b * up.x) / up.w) / b;
        let rss = low.yy - low.y * a + up.yy - up.y * up.y / up.w - b * xy;
        (self.commands_below > 1 && xx > 0.0 && x0 > self.level && x0 < next).then_some(Fit {
            a,
            b,
            x0,
            rss,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::check;

    #[test]
    fn a_hinge_is_recovered_on_and_between_commands() {
        for break_at in [2.0, 3.517, 9.0] {
            check::recovers(&Hinge, &[0.3, 1.7, break_at]);
            check::recovers(&Hinge, &[-40.0, -0.2, break_at]);
        }
    }

    #[test]
    fn a_line_is_a_hinge_that_breaks_at_its_first_command() {
        let x = check::ramp();
        let y: Vec<f64> = x.iter().map(|x| 2.0 - 0.5 * x).collect();
        let found = check::fit(&Hinge, &x, &y).unwrap();
        assert_eq!(found[2..], [0.0]);
        assert!((found[0] - 2.0).abs() < 1e-9 && (found[1] + 0.5).abs() < 1e-9);
    }

    /// Compared with every break of a fine grid, each with its own regression.
    #[test]
    fn no_other_break_fits_a_scattered_curve_better() {
        let x = check::ramp();
        let y: Vec<f64> = x
            .iter()
            .enumerate()
            .map(|(i, x)| x * x / 10.0 + f64::from(i as u32 * 7 % 13) / 5.0)
            .collect();
        let found = check::rss(&Hinge, &check::fit(&Hinge, &x, &y).unwrap(), &x, &y);
        for step in 0..990 {
            let x0 = f64::from(step) * 0.01;
            let points = x.iter().zip(&y).map(|(x, y)| ((x - x0).max(0.0), *y, 1.0));
            let (a, b) = crate::shape::weighted_line(points).unwrap();
            let other = check::rss(&Hinge, &[a, b, x0], &x, &y);
            assert!(found <= other * (1.0 + 1e-9), "a break at {x0} is better");
        }
    }

    #[test]
    fn three_commands_leave_no_room_for_a_break() {
        assert_eq!(check::fit(&Hinge, &[0.0, 1.0, 2.0], &[0.0, 0.0, 1.0]), None);
    }
}
