//! A boundary of stiffness and damping that someone measured: its extent.

use crate::error::StabilityError;

/// The stiffest wall without sustained oscillation for each damping, in the units it was measured
/// in, damping rising.
#[derive(Debug, Clone, PartialEq)]
pub struct Boundary {
    /// (B, K), B rising.
    pub points: Vec<[f64; 2]>,
}

/// What a boundary comes to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// K at B = 0; none where it was not measured.
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

impl Boundary {
    /// Sorts and checks points (B, K).
    ///
    /// # Errors
    /// A number that is negative or none; fewer than two; one damping twice.
    pub fn new(mut points: Vec<[f64; 2]>) -> Result<Self, StabilityError> {
        let wrong = |line: usize, what: String| Err(StabilityError::Boundary { line, what });
        for (i, [b, k]) in points.iter().enumerate() {
            if !(*b >= 0.0 && *k >= 0.0 && b.is_finite() && k.is_finite()) {
                return wrong(i + 2, format!("K = {k}, B = {b}"));
            }
        }
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        if points.len() < 2 {
            return wrong(points.len() + 1, "fewer than two points".to_owned());
        }
        if let Some(i) = points.windows(2).position(|pair| pair[0][0] >= pair[1][0]) {
            return wrong(i + 3, format!("B = {} stands there twice", points[i][0]));
        }
        Ok(Self { points })
    }

    /// Reads a CSV with the columns K and B, in any order.
    ///
    /// # Errors
    /// A column that is missing, or as [`Boundary::new`].
    pub fn from_csv(text: &str) -> Result<Self, StabilityError> {
        let text = text.trim_start_matches('\u{feff}');
        let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
        let head = lines.next().map_or("", |(_, line)| line);
        let column = |name: &str| head.split(',').position(|head| head.trim() == name);
        let (Some(k), Some(b)) = (column("K"), column("B")) else {
            return Err(StabilityError::Boundary { line: 1, what: format!("{head:?}") });
        };
        let read = |(i, line): (usize, &str)| {
            let number = |at: usize| line.split(',').nth(at)?.trim().parse::<f64>().ok();
            number(b)
                .zip(number(k))
                .map(|(b, k)| [b, k])
                .ok_or_else(|| StabilityError::Boundary { line: i + 1, what: format!("{line:?}") })
        };
        Self::new(lines.map(read).collect::<Result<_, _>>()?)
    }

    /// Its extent.
    pub fn extent(&self) -> Extent {
        let points = &self.points;
        let best = points.iter().fold([0.0, 0.0], |best, p| if p[1] > best[1] { *p } else { best });
        let part = |pair: &[[f64; 2]]| 0.5 * (pair[1][0] - pair[0][0]) * (pair[0][1] + pair[1][1]);
        let (first, last) = (points.first(), points.last());
        Extent {
            undamped: first.filter(|p| p[0] <= 0.0).map(|p| p[1]),
            largest: best[1],
            largest_at: best[0],
            damping: [first.map_or(0.0, |p| p[0]), last.map_or(0.0, |p| p[0])],
            area: points.windows(2).map(part).sum(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_has_half_its_rectangle() {
        let boundary = Boundary::from_csv("K,B\n4.0,0.0\n2.0,0.5\n0.0,1.0\n").unwrap();
        let extent = boundary.extent();
        assert!((extent.area - 2.0).abs() < 1e-15);
        assert_eq!(extent.undamped, Some(4.0));
        assert!(extent.largest_at.abs() < 1e-300);
    }

    #[test]
    fn what_is_no_number_is_named_with_its_line() {
        let error = Boundary::from_csv("K,B\n4.0,0.0\nx,0.5\n").unwrap_err().to_string();
        assert!(error.starts_with("line 3"), "{error}");
        assert!(Boundary::from_csv("B\n1\n").unwrap_err().to_string().contains("columns K and B"));
        assert!(Boundary::from_csv("K,B\n1,0\n2,0\n").unwrap_err().to_string().contains("twice"));
        assert!(Boundary::from_csv("K,B\n1,NaN\n2,1\n").is_err());
    }
}
