//! A boundary of stiffness and damping that someone measured: its extent, and its overlap with
//! others.

use crate::error::StabilityError;
use zwidth_dynamics::SampledWall;

/// The stiffest wall without sustained oscillation for each damping, in the units it was measured
/// in, damping rising.
#[derive(Debug, Clone, PartialEq)]
pub struct Boundary {
    /// (B, K), B rising.
    pub points: Vec<[f64; 2]>,
    /// Whether they are N s/m and N/m at the lever's end; else their units are unknown.
    pub is_si: bool,
}

/// Heads of the columns of stiffness and damping, and what they are of: as measured, at the lever's
/// end, about its axis.
const HEADS: [[&str; 2]; 3] =
    [["K", "B"], ["K_n_per_m", "B_ns_per_m"], ["K_nm_per_rad", "B_nms_per_rad"]];

/// The summary of a boundary.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// K at B = 0; `None` if it was not measured.
    pub undamped: Option<f64>,
    /// The largest K.
    pub largest: f64,
    /// Its B.
    pub largest_at: f64,
    /// The range of B, from and to.
    pub damping: [f64; 2],
    /// ∫ K dB over it, by trapezia.
    pub area: f64,
}

impl Extent {
    /// The area over that of the rectangle K(0) × the largest B: a number without a unit. None
    /// where the wall without damping was not measured.
    pub fn fullness(&self) -> Option<f64> {
        let rectangle = self.undamped? * (self.damping[1] - self.damping[0]);
        (rectangle > 0.0).then(|| self.area / rectangle)
    }
}

impl Boundary {
    /// Sorts and checks points (B, K) of unknown units.
    ///
    /// # Errors
    /// A number that is negative or not finite; fewer than two; one damping twice.
    pub fn new(mut points: Vec<[f64; 2]>) -> Result<Self, StabilityError> {
        for (i, [b, k]) in points.iter().enumerate() {
            if !(*b >= 0.0 && *k >= 0.0 && b.is_finite() && k.is_finite()) {
                // Lines of a file count from 1, and the first is its head.
                return Err(wrong(i + 2, &format!("K = {k}, B = {b}")));
            }
        }
        if points.len() < 2 {
            return Err(wrong(points.len() + 1, "fewer than two points"));
        }
        for (i, [b, _]) in points.iter().enumerate() {
            if points[..i]
                .iter()
                .any(|[before, _]| before.partial_cmp(b).is_some_and(std::cmp::Ordering::is_eq))
            {
                return Err(wrong(i + 2, &format!("B = {b} stands there twice")));
            }
        }
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        Ok(Self { points, is_si: false })
    }

    /// Reads a CSV with the columns K and B, in any order, whose units are not known; or
    /// `K_n_per_m` and `B_ns_per_m`, or `K_nm_per_rad` and `B_nms_per_rad`, which a lever of length
    /// L feels as K/L² and B/L² at its end.
    ///
    /// # Errors
    /// A column that is missing, or as [`Boundary::new`].
    pub fn from_csv(text: &str, lever_m: f64) -> Result<Self, StabilityError> {
        // Spreadsheets put a byte order mark before the first column's name.
        let text = text.trim_start_matches('\u{feff}');
        let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
        let head = lines.next().map_or("", |(_, line)| line);
        let columns = HEADS
            .map(|names| names.map(|name| head.split(',').position(|head| head.trim() == name)));
        let Some((form, [k, b])) = columns.into_iter().enumerate().find_map(|(form, columns)| {
            let [k, b] = columns;
            Some((form, [k?, b?]))
        }) else {
            return Err(wrong(1, &format!("{head:?}")));
        };
        let per_m = if form == 2 { 1.0 / (lever_m * lever_m) } else { 1.0 };
        let points = lines.map(|(i, line)| {
            let [b, k] = [b, k].map(|at| line.split(',').nth(at)?.trim().parse::<f64>().ok());
            b.zip(k).map(|(b, k)| [b, k]).ok_or_else(|| wrong(i + 1, &format!("{line:?}")))
        });
        let points: Vec<[f64; 2]> = points.collect::<Result<_, _>>()?;
        let read = Self::new(points.iter().map(|p| p.map(|value| per_m * value)).collect())?;
        Ok(Self { is_si: form > 0, ..read })
    }

    /// The limit of a wall by the lifted map, from no damping to that at which no wall is stable;
    /// `None` for a device that can render any wall.
    ///
    /// # Errors
    /// A wall that makes no sense.
    pub fn of_lifted_map(wall: &SampledWall) -> Result<Option<Self>, StabilityError> {
        /// Points, and halvings of the interval in which the last one lies.
        const POINTS: usize = 40;
        const HALVINGS: u32 = 40;
        /// A wall of this share of the undamped one counts as no wall.
        const NONE: f64 = 1e-3;
        let stiffest = |b: f64| SampledWall { wall_damping_ns_per_m: b, ..*wall }.stiffest_stable();
        let Some(undamped) = stiffest(0.0)?.filter(|k| *k > 0.0) else { return Ok(None) };
        // What a period's damping of the mass would take away.
        let mut high = wall.mass_kg / wall.period_s;
        let mut low = 0.0;
        while stiffest(high)?.is_none_or(|k| k > NONE * undamped) {
            (low, high) = (high, 2.0 * high);
            if !high.is_finite() {
                return Ok(None);
            }
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if stiffest(middle)?.is_none_or(|k| k > NONE * undamped) {
                low = middle;
            } else {
                high = middle;
            }
        }
        let mut points = Vec::new();
        for i in 0..POINTS {
            let b = low * i as f64 / POINTS as f64;
            points.extend(stiffest(b)?.map(|k| [b, k]));
        }
        points.push([high, 0.0]);
        Ok(Some(Self { is_si: true, ..Self::new(points)? }))
    }

    /// The same in shares of the wall without damping and of the largest damping, which need no
    /// units: none where either was not measured, or is 0.
    pub fn shares(&self) -> Option<Vec<[f64; 2]>> {
        let undamped = self.extent().undamped?;
        let [_, most] = self.extent().damping;
        (undamped > 0.0 && most > 0.0)
            .then(|| self.points.iter().map(|p| [p[0] / most, p[1] / undamped]).collect())
    }

    /// Its extent.
    pub fn extent(&self) -> Extent {
        let points = &self.points;
        let best = points.iter().fold([0.0, 0.0], |best, p| if p[1] > best[1] { *p } else { best });
        let pairs = points.windows(2);
        let parts = pairs.map(|pair| 0.5 * (pair[1][0] - pair[0][0]) * (pair[0][1] + pair[1][1]));
        let first = points.first();
        let last = points.last();
        Extent {
            undamped: first.filter(|p| p[0] <= 0.0).map(|p| p[1]),
            largest: best[1],
            largest_at: best[0],
            damping: [first.map_or(0.0, |p| p[0]), last.map_or(0.0, |p| p[0])],
            area: parts.sum(),
        }
    }
}

/// What stands in a line of a boundary's file, from 1, that cannot be read.
fn wrong(line: usize, what: &str) -> StabilityError {
    StabilityError::Refused(format!(
        "line {line} of the boundary: {what}; give the columns K and B (or K_n_per_m and B_ns_per_m) with a number in each, not below 0"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_has_half_its_rectangle() {
        let boundary = Boundary::from_csv("K,B\n4.0,0.0\n2.0,0.5\n0.0,1.0\n", 1.0).unwrap();
        let extent = boundary.extent();
        assert!((extent.area - 2.0).abs() < 1e-15);
        assert_eq!(extent.undamped, Some(4.0));
        assert!(extent.largest_at.abs() < 1e-300);
        assert_eq!(extent.fullness(), Some(0.5));
        assert_eq!(boundary.shares().unwrap(), [[0.0, 1.0], [0.5, 0.5], [1.0, 0.0]]);
        assert!(!boundary.is_si);
    }

    #[test]
    fn units_that_the_head_states_are_those_of_the_levers_end() {
        let of =
            |head: &str| Boundary::from_csv(&format!("{head}\n4.0,0.0\n0.0,1.0\n"), 0.5).unwrap();
        assert_eq!(of("K_n_per_m,B_ns_per_m").points, [[0.0, 4.0], [1.0, 0.0]]);
        let about = of("K_nm_per_rad,B_nms_per_rad");
        assert_eq!((about.is_si, about.points), (true, vec![[0.0, 16.0], [4.0, 0.0]]));
        assert_eq!(Boundary::new(vec![[0.5, 1.0], [1.0, 0.0]]).unwrap().shares(), None);
    }

    /// The undamped end is the lifted map's own limit; the other one is checked by simulating the
    /// loop.
    #[test]
    fn the_lifted_maps_boundary_runs_from_its_stiffest_wall_to_the_damper_that_flips() {
        let wall = SampledWall::bare(0.0972, 2.6, 8.3e-3);
        let boundary = Boundary::of_lifted_map(&wall).unwrap().unwrap();
        let extent = boundary.extent();
        assert!((extent.undamped.unwrap() - 650.6).abs() < 0.1, "{extent:?}");
        let end = extent.damping[1];
        let grows = |b: f64| {
            let wall = SampledWall { wall_damping_ns_per_m: b, ..wall };
            wall.with_stiffness(1.0).simulated_growth(6000).unwrap()
        };
        assert!(grows(0.98 * end) < 1.0 && grows(1.02 * end) > 1.0, "{end}");
        assert!(boundary.shares().unwrap().iter().all(|p| (0.0..=1.0).contains(&p[0])));
        let free = SampledWall::bare(0.0972, 0.0, 8.3e-3);
        assert_eq!(Boundary::of_lifted_map(&free).unwrap(), None, "no wall is stable");
    }

    #[test]
    fn what_is_no_number_is_named_with_its_line() {
        let error = Boundary::from_csv("K,B\n4.0,0.0\nx,0.5\n", 1.0).unwrap_err().to_string();
        assert!(error.starts_with("line 3"), "{error}");
        assert!(
            Boundary::from_csv("B\n1\n", 1.0).unwrap_err().to_string().contains("columns K and B")
        );
        assert!(
            Boundary::from_csv("K,B\n1,0\n2,0\n", 1.0).unwrap_err().to_string().contains("twice")
        );
        assert!(Boundary::from_csv("K,B\n1,NaN\n2,1\n", 1.0).is_err());
    }
}
