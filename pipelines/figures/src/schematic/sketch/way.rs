//! A line on paper that a piece lies along: a spring, a damper, an arrow, a wall.

use std::f64::consts::TAU;

/// A place on paper, mm.
pub(crate) type Point = (f64, f64);

/// Pieces of an arc over a whole turn.
const PIECES: f64 = 360.0;
/// No arc has more, however often it goes round.
const MOST_PIECES: f64 = 4.0 * PIECES;

/// Straight pieces from point to point.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Way(Vec<Point>);

impl Way {
    /// Through these points, in this order.
    pub(crate) fn through(points: impl IntoIterator<Item = Point>) -> Self {
        let mut points: Vec<Point> = points.into_iter().collect();
        // A piece without length has no direction.
        points.dedup();
        Self(points)
    }

    /// Along a circle.
    pub(crate) fn arc(centre: Point, radius: f64, from_rad: f64, to_rad: f64) -> Self {
        let pieces =
            ((to_rad - from_rad).abs() / TAU * PIECES).ceil().clamp(1.0, MOST_PIECES) as usize;
        Self::through((0..=pieces).map(|i| {
            polar(centre, radius, from_rad + (to_rad - from_rad) * i as f64 / pieces as f64)
        }))
    }

    /// Its points.
    pub(crate) fn points(&self) -> impl Iterator<Item = Point> {
        self.0.iter().copied()
    }

    /// Its length, mm.
    pub(crate) fn length(&self) -> f64 {
        self.0.windows(2).map(|pair| distance(pair[0], pair[1])).sum()
    }

    /// The point so far along the way and so far to its left, mm; before its beginning and past its
    /// end it goes straight on.
    pub(crate) fn at(&self, along: f64, left: f64) -> Point {
        let mut rest = along;
        for (i, pair) in self.0.windows(2).enumerate() {
            let piece = distance(pair[0], pair[1]);
            // The last piece goes on past its end.
            if rest <= piece || i + 2 == self.0.len() {
                let x = (pair[1].0 - pair[0].0) / piece;
                let y = (pair[1].1 - pair[0].1) / piece;
                return (pair[0].0 + rest * x - left * y, pair[0].1 + rest * y + left * x);
            }
            rest -= piece;
        }
        self.0.first().copied().unwrap_or_default()
    }
}

/// The point at that distance from `centre`, in the direction `theta_rad` from upright.
pub(crate) fn polar(centre: Point, distance: f64, theta_rad: f64) -> Point {
    let sin = libm::sin(theta_rad);
    let cos = libm::cos(theta_rad);
    (centre.0 + distance * sin, centre.1 + distance * cos)
}

fn distance(a: Point, b: Point) -> f64 {
    let dx = b.0 - a.0;
    let dy = b.1 - a.1;
    (dx * dx + dy * dy).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    fn close(a: Point, b: Point) {
        // straight pieces of a degree are half a degree off their arc
        assert!(distance(a, b) < 1e-2, "{a:?} and {b:?}");
    }

    #[test]
    fn a_way_goes_round_its_corners_and_straight_on_past_its_ends() {
        let way = Way::through([(0.0, 0.0), (3.0, 0.0), (3.0, 4.0)]);
        assert!((way.length() - 7.0).abs() < 1e-12);
        close(way.at(1.0, 0.0), (1.0, 0.0));
        close(way.at(5.0, 1.0), (2.0, 2.0));
        close(way.at(-1.0, 0.0), (-1.0, 0.0));
        close(way.at(8.0, 0.0), (3.0, 5.0));
    }

    #[test]
    fn left_of_a_clockwise_arc_is_outside() {
        let arc = Way::arc((1.0, 1.0), 2.0, 0.0, FRAC_PI_2);
        assert!((arc.length() - TAU / 2.0).abs() < 1e-3);
        close(arc.at(arc.length() / 2.0, 0.5), polar((1.0, 1.0), 2.5, FRAC_PI_2 / 2.0));
        close(arc.at(arc.length(), 0.0), (3.0, 1.0));
    }

    #[test]
    fn a_way_of_one_point_stays_there() {
        let way = Way::through([(1.0, 2.0), (1.0, 2.0)]);
        assert!(way.length() < 1e-12);
        close(way.at(3.0, 4.0), (1.0, 2.0));
    }
}
