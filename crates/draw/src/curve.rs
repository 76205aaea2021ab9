//! Curves prepared for paper: broken at gaps, cut at the plot's edge, thinned to what print can
//! show.

/// A point of a curve.
pub(crate) type Point = (f64, f64);

/// The part of the plane that a plot shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Window {
    pub(crate) x: (f64, f64),
    pub(crate) y: (f64, f64),
}

impl Window {
    /// The point moved inside, if rounding put it out: of values near the end of f64 little is
    /// left, not even a number.
    fn hold(&self, (x, y): Point) -> Option<Point> {
        let held = (x.max(self.x.0).min(self.x.1), y.max(self.y.0).min(self.y.1));
        (x.is_finite() && y.is_finite()).then_some(held)
    }

    pub(crate) fn holds(&self, (x, y): Point) -> bool {
        (self.x.0..=self.x.1).contains(&x) && (self.y.0..=self.y.1).contains(&y)
    }
}

/// Stretches of finite points, in order. Neighbouring stretches of a different `kind` share the
/// point between them, so that a curve stays connected where it changes from solid to dotted. A
/// piece between two points is of the `true` kind if both its ends are.
pub(crate) fn stretches(points: &[Point], kind: impl Fn(usize) -> bool) -> Vec<(bool, Vec<Point>)> {
    let mut stretches: Vec<(bool, Vec<Point>)> = Vec::new();
    let mut connected = false;
    for (i, &point) in points.iter().enumerate() {
        let finite = point.0.is_finite() && point.1.is_finite();
        if finite && connected {
            let piece = kind(i - 1) && kind(i);
            match stretches.last_mut() {
                // A lone point has no piece yet: the first piece says of which kind it is.
                Some((last, stretch)) if *last == piece || stretch.len() == 1 => {
                    *last = piece;
                    stretch.push(point);
                }
                _ => stretches.push((piece, vec![points[i - 1], point])),
            }
        } else if finite {
            stretches.push((kind(i), vec![point]));
        }
        connected = finite;
    }
    stretches
}

/// The parts of an open curve inside the window, cut exactly at its edge (Liang & Barsky 1984).
pub(crate) fn cut_line(points: &[Point], window: &Window) -> Vec<Vec<Point>> {
    let mut parts: Vec<Vec<Point>> = Vec::new();
    for pair in points.windows(2) {
        let Some((from, to)) = cut_piece(pair[0], pair[1], window) else { continue };
        match parts.last_mut() {
            // A point that was not cut is the same to the bit in the piece before it.
            Some(part) if part.last() == Some(&from) => part.push(to),
            _ => parts.push(vec![from, to]),
        }
    }
    parts
}

fn cut_piece(a: Point, b: Point, window: &Window) -> Option<(Point, Point)> {
    let dx = b.0 - a.0;
    let dy = b.1 - a.1;
    let mut enter = 0.0_f64;
    let mut leave = 1.0_f64;
    let edges = [
        (-dx, a.0 - window.x.0),
        (dx, window.x.1 - a.0),
        (-dy, a.1 - window.y.0),
        (dy, window.y.1 - a.1),
    ];
    for (outward, room) in edges {
        if outward < 0.0 {
            enter = enter.max(room / outward);
        } else if outward > 0.0 {
            leave = leave.min(room / outward);
        // The piece runs along this edge, and all of it lies outside.
        } else if room < 0.0 {
            return None;
        }
    }
    if enter > leave {
        return None;
    }
    let from = if enter > 0.0 { (a.0 + enter * dx, a.1 + enter * dy) } else { a };
    let to = if leave < 1.0 { (a.0 + leave * dx, a.1 + leave * dy) } else { b };
    window.hold(from).zip(window.hold(to))
}

/// The part of a filled polygon inside the window (Sutherland & Hodgman 1974).
pub(crate) fn cut_area(polygon: &[Point], window: &Window) -> Vec<Point> {
    let left = cut_below(polygon, window.x.0);
    let sides = cut_above(&left, window.x.1);
    // The same two cuts once more, with x and y changed over.
    let turned: Vec<Point> = sides.into_iter().map(|(x, y)| (y, x)).collect();
    let low = cut_below(&turned, window.y.0);
    let inside = cut_above(&low, window.y.1).into_iter();
    inside.filter_map(|(y, x)| window.hold((x, y))).collect()
}

/// Keeps what lies at `x >= limit`.
fn cut_below(polygon: &[Point], limit: f64) -> Vec<Point> {
    let next = polygon.iter().cycle().skip(1);
    let mut kept = Vec::with_capacity(polygon.len() + 2);
    for (&a, &b) in polygon.iter().zip(next) {
        if a.0 >= limit {
            kept.push(a);
        }
        if (a.0 >= limit) != (b.0 >= limit) {
            kept.push((limit, a.1 + (limit - a.0) / (b.0 - a.0) * (b.1 - a.1)));
        }
    }
    kept
}

/// Keeps what lies at `x <= limit`.
fn cut_above(polygon: &[Point], limit: f64) -> Vec<Point> {
    let mirrored: Vec<Point> = polygon.iter().map(|&(x, y)| (-x, y)).collect();
    cut_below(&mirrored, -limit).into_iter().map(|(x, y)| (-x, y)).collect()
}

/// Width of the columns that a curve is thinned in, in pt: 200 to the inch, less than any line is
/// wide.
pub(crate) const COLUMN_PT: f64 = 0.36;
/// How far the thinned curve may lie off the given one, in pt: a tenth of the thinnest line.
const TOLERANCE_PT: f64 = 0.04;

/// Indices of the points that print needs, from points on the page in pt.
///
/// Two passes. Of every run of points within one column of [`COLUMN_PT`] the first, lowest, highest
/// and last stay (the M4 of Jugel et al. 2014, doi:10.14778/2732951.2732953): no spike is lost, and
/// noise costs at most four points a column. Of those, points closer than 0.04 pt to the line
/// through their neighbours go (Douglas & Peucker 1973): smooth curves need a hundred points or
/// two, not thousands.
pub(crate) fn thin(points: &[Point]) -> Vec<usize> {
    straighten(points, &extremes(points))
}

fn extremes(points: &[Point]) -> Vec<usize> {
    let columns: Vec<f64> = points.iter().map(|point| (point.0 / COLUMN_PT).floor()).collect();
    let mut kept = Vec::new();
    let mut start = 0;
    while start < points.len() {
        let run =
            (start..points.len()).take_while(|&i| columns[i].total_cmp(&columns[start]).is_eq());
        let end = run.last().unwrap_or(start);
        let lowest = (start..=end).min_by(|&i, &j| points[i].1.total_cmp(&points[j].1));
        let highest = (start..=end).max_by(|&i, &j| points[i].1.total_cmp(&points[j].1));
        let (lowest, highest) = (lowest.unwrap_or(start), highest.unwrap_or(end));
        // In the order of the curve, whichever of the two comes first.
        kept.extend([start, lowest.min(highest), lowest.max(highest), end]);
        start = end + 1;
    }
    kept.dedup();
    kept
}

fn straighten(points: &[Point], chosen: &[usize]) -> Vec<usize> {
    if chosen.len() < 3 {
        return chosen.to_vec();
    }
    let mut keep = vec![false; chosen.len()];
    // A list, not recursion, which could go as deep as the curve has points.
    let mut open = vec![(0, chosen.len() - 1)];
    while let Some((first, last)) = open.pop() {
        (keep[first], keep[last]) = (true, true);
        let off =
            |i: usize| distance(points[chosen[i]], points[chosen[first]], points[chosen[last]]);
        let farthest = (first + 1..last).max_by(|&i, &j| off(i).total_cmp(&off(j)));
        if let Some(middle) = farthest.filter(|&i| off(i) > TOLERANCE_PT) {
            open.extend([(first, middle), (middle, last)]);
        }
    }
    chosen.iter().zip(keep).filter_map(|(&i, keep)| keep.then_some(i)).collect()
}

/// Distance of `p` from the straight piece `a`–`b`.
fn distance(p: Point, a: Point, b: Point) -> f64 {
    let dx = b.0 - a.0;
    let dy = b.1 - a.1;
    let length2 = dx * dx + dy * dy;
    // Of a closed curve both ends are one spot, from which the distance is taken.
    let along = if length2 > 0.0 { ((p.0 - a.0) * dx + (p.1 - a.1) * dy) / length2 } else { 0.0 };
    let along = along.clamp(0.0, 1.0);
    let ex = p.0 - a.0 - along * dx;
    let ey = p.1 - a.1 - along * dy;
    (ex * ex + ey * ey).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Window = Window { x: (0.0, 1.0), y: (0.0, 1.0) };

    #[test]
    fn a_nan_breaks_the_curve_and_nothing_bridges_it() {
        let points = [(0.0, 0.0), (1.0, 1.0), (2.0, f64::NAN), (3.0, 3.0), (4.0, 4.0)];
        let found = stretches(&points, |_| false);
        assert_eq!(
            found,
            [(false, vec![points[0], points[1]]), (false, vec![points[3], points[4]])]
        );
    }

    #[test]
    fn the_dotted_part_begins_and_ends_where_the_solid_one_does() {
        let points: Vec<Point> = (0..6).map(|i| (f64::from(i), 0.0)).collect();
        let mask = [false, false, true, true, true, false];
        let found = stretches(&points, |i| mask[i]);
        let expect = [
            (false, points[0..=2].to_vec()), // up to the first point past the wall
            (true, points[2..=4].to_vec()),
            (false, points[4..=5].to_vec()),
        ];
        assert_eq!(found, expect);
    }

    #[test]
    fn lines_are_cut_where_they_cross_the_edge_and_keep_their_slope() {
        let parts = cut_line(&[(-1.0, -1.0), (0.5, 0.5), (0.5, 3.0), (0.75, 0.5)], &UNIT);
        assert_eq!(parts.len(), 2);
        assert_eq!(parts[0], [(0.0, 0.0), (0.5, 0.5), (0.5, 1.0)]);
        assert_eq!(parts[1], [(0.7, 1.0), (0.75, 0.5)]);
        assert!(cut_line(&[(2.0, 0.0), (2.0, 1.0)], &UNIT).is_empty());
        for part in cut_line(&[(-1e300, 0.5), (1e299, 0.5), (1e308, -1e308)], &UNIT) {
            assert!(part.iter().all(|&p| UNIT.holds(p)), "{part:?}");
        }
    }

    #[test]
    fn an_area_is_cut_to_the_window() {
        let cut = cut_area(&[(-1.0, 0.25), (2.0, 0.25), (2.0, 5.0), (-1.0, 5.0)], &UNIT);
        assert_eq!(cut.len(), 4);
        assert!(cut.iter().all(|&p| UNIT.holds(p)));
        assert!(cut.contains(&(0.0, 0.25)) && cut.contains(&(1.0, 1.0)));
    }

    #[test]
    fn a_smooth_curve_of_5000_points_needs_few_and_stays_within_the_tolerance() {
        let curve: Vec<Point> =
            (0..5000).map(|i| f64::from(i) / 20.0).map(|x| (x, 40.0 * (x / 40.0).sin())).collect();
        let kept = thin(&curve);
        assert!(kept.len() < 300, "{}", kept.len());
        let thinned: Vec<Point> = kept.iter().map(|&i| curve[i]).collect();
        for &p in &curve {
            let off = thinned
                .windows(2)
                .map(|pair| distance(p, pair[0], pair[1]))
                .fold(f64::MAX, f64::min);
            assert!(off < 0.05, "{p:?} is {off} pt off");
        }
    }

    #[test]
    fn noise_costs_at_most_four_points_a_column_and_no_spike_is_lost() {
        let mut state = 1_u32;
        let mut noise = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24)
        };
        let mut curve: Vec<Point> =
            (0..100_000).map(|i| (f64::from(i) / 1000.0, noise())).collect();
        curve[54_321].1 = 50.0;
        let kept = thin(&curve);
        assert!(kept.len() <= (4.0 * 100.0 / COLUMN_PT) as usize + 4, "{}", kept.len());
        assert!(kept.contains(&54_321));
    }
}
