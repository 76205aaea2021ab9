//! Samples gathered by step of the command: the sums that a fit needs, a hundred times shorter.

use crate::shape::{Point, Points};
use core::ops::Range;
use zwidth_numerics::branch::Branch;

/// More different commands than this are gathered in as many steps of equal width.
///
/// Over a step of width h a curve f departs from its value at the mean command by f'' h²/24 on
/// average: for a parabola over the whole span, 1/(12 · 256²) ≈ 10⁻⁶ of its rise.
pub(crate) const MOST_STEPS: usize = 256;

/// The step of each sample, and the steps.
pub(crate) struct Steps {
    /// Step of each sample, from 0.
    steps: Vec<usize>,
    /// Mean command of each step, rising: the command itself where a step is one command.
    pub(crate) levels: Vec<f64>,
    /// Whether each step is one command. A sum of squares then depends on the samples through the
    /// means alone: the fit is that to the samples.
    exact: bool,
}

/// Sums over the samples of one cell: one group of samples, one branch, one step.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Cell {
    samples: usize,
    weight: f64,
    command: f64,
    response: f64,
}

/// The samples as a model sees them: by branch, and both together.
pub(crate) struct Gathered<'a> {
    points: [Vec<Point>; 2],
    both: Vec<Point>,
    samples: [usize; 2],
    levels: &'a [f64],
}

impl Steps {
    pub(crate) fn new(command: &[f64]) -> Self {
        let mut levels = command.to_vec();
        levels.sort_by(f64::total_cmp);
        // By ≤, because −0 sorts before 0 and is the same command.
        levels.dedup_by(|a, b| *a <= *b);
        if levels.len() <= MOST_STEPS {
            let steps = command.iter().map(|x| levels.partition_point(|level| level < x)).collect();
            return Self { steps, levels, exact: true };
        }
        // Steps of equal width, those without a sample left out.
        let low = levels[0];
        let high = levels[levels.len() - 1];
        let mut steps = Vec::with_capacity(command.len());
        let mut sums = vec![(0.0, 0.0); MOST_STEPS];
        for &x in command {
            let step = ((x - low) / (high - low) * MOST_STEPS as f64) as usize;
            let step = step.min(MOST_STEPS - 1);
            steps.push(step);
            let (n, sum) = &mut sums[step];
            (*n, *sum) = (*n + 1.0, *sum + x);
        }
        let used: Vec<usize> = (0..MOST_STEPS).filter(|&s| sums[s].0 > 0.0).collect();
        for step in &mut steps {
            *step = used.partition_point(|s| s < step);
        }
        let levels = used.iter().map(|&s| sums[s].1 / sums[s].0).collect();
        Self { steps, levels, exact: false }
    }

    /// The cells of the samples in `range`: those on the way up by step, then those on the way
    /// down.
    pub(crate) fn cells(
        &self,
        range: Range<usize>,
        command: &[f64],
        response: &[f64],
        branch: &[Branch],
    ) -> Vec<Cell> {
        let mut cells = vec![Cell::default(); 2 * self.levels.len()];
        for i in range {
            let cell = &mut cells[branch[i] as usize * self.levels.len() + self.steps[i]];
            cell.samples += 1;
            cell.weight += 1.0;
            cell.command += command[i];
            cell.response += response[i];
        }
        cells
    }

    /// Groups of cells, each counted as often as its number says.
    pub(crate) fn gather<'a>(
        &self,
        groups: impl Iterator<Item = (&'a [Cell], u32)>,
    ) -> Gathered<'_> {
        let mut total = vec![Cell::default(); 2 * self.levels.len()];
        // One drawn 0 times would still add its samples.
        for (cells, times) in groups.filter(|(_, times)| *times > 0) {
            for (sum, cell) in total.iter_mut().zip(cells) {
                sum.add(cell, f64::from(times));
            }
        }
        let (up, down) = total.split_at(self.levels.len());
        let mut both = up.to_vec();
        both.iter_mut().zip(down).for_each(|(sum, cell)| sum.add(cell, 1.0));
        Gathered {
            points: [self.points(up), self.points(down)],
            both: self.points(&both),
            samples: [up, down].map(|cells| cells.iter().map(|cell| cell.samples).sum()),
            levels: &self.levels,
        }
    }

    fn points(&self, cells: &[Cell]) -> Vec<Point> {
        let used = cells.iter().zip(&self.levels).filter(|(cell, _)| cell.weight > 0.0);
        used.map(|(cell, &level)| Point {
            command: if self.exact { level } else { cell.command / cell.weight },
            response: cell.response / cell.weight,
            weight: cell.weight,
        })
        .collect()
    }
}

impl Cell {
    fn add(&mut self, other: &Self, times: f64) {
        // A sample drawn twice weighs twice, but adds no degree of freedom.
        self.samples += other.samples;
        self.weight += times * other.weight;
        self.command += times * other.command;
        self.response += times * other.response;
    }
}

impl Gathered<'_> {
    /// The points of one branch, or of both together.
    pub(crate) fn of(&self, branch: Option<Branch>) -> Points<'_> {
        let (at, samples) = match branch {
            Some(branch) => (&self.points[branch as usize], self.samples[branch as usize]),
            None => (&self.both, self.samples[0] + self.samples[1]),
        };
        Points { at, samples, levels: self.levels }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::Model;
    use crate::samples::{Samples, Sweep};
    use zwidth_numerics::lsq;
    use zwidth_results::CurveModel;

    #[test]
    fn a_step_is_one_command_and_its_points_are_means_by_branch() {
        let sweep = Sweep {
            command: &[0.0, 1.0, 2.0, 1.0, 0.0, 0.0],
            response: &[1.0, 2.0, 4.0, 6.0, 3.0, 5.0],
        };
        let samples = Samples::new(&[sweep]).unwrap();
        let gathered = samples.gathered();
        let points = |branch| -> Vec<_> {
            gathered.of(branch).at.iter().map(|p| (p.command, p.response, p.weight)).collect()
        };
        assert_eq!(points(Some(Branch::Up)), [(0.0, 1.0, 1.0), (1.0, 2.0, 1.0), (2.0, 4.0, 1.0)]);
        assert_eq!(points(Some(Branch::Down)), [(0.0, 4.0, 2.0), (1.0, 6.0, 1.0)]);
        assert_eq!(points(None), [(0.0, 3.0, 3.0), (1.0, 4.0, 2.0), (2.0, 4.0, 1.0)]);
        assert_eq!((gathered.of(None).samples, gathered.of(Some(Branch::Down)).samples), (6, 3));
    }

    #[test]
    fn a_group_that_counts_twice_weighs_twice_and_one_that_does_not_count_is_gone() {
        let x = [0.0, 1.0, 2.0];
        let sweeps = [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0], [9.0, 9.0, 9.0]];
        let sweeps: Vec<_> = sweeps.iter().map(|y| Sweep { command: &x, response: y }).collect();
        let samples = Samples::new(&sweeps).unwrap();
        let cells: Vec<_> = samples.sweeps.iter().map(|s| samples.cells(s.clone())).collect();
        let gathered = samples.steps.gather(cells.iter().map(Vec::as_slice).zip([1, 2, 0]));
        let all = gathered.of(None);
        assert_eq!(all.at[0], Point { command: 0.0, response: 2.0, weight: 3.0 });
        assert_eq!(all.samples, 6);
    }

    /// How far the line through the steps is from the line through the samples, as a share of its
    /// standard error.
    fn departure(commands: u32) -> f64 {
        let x: Vec<f64> =
            (0..20_000).map(|i| f64::from(i % commands) * 16.0 / f64::from(commands)).collect();
        let y: Vec<f64> = (0..20_000u32)
            .map(|i| 0.26 * x[i as usize] + f64::from(i * 7919 % 1009) / 1009.0)
            .collect();
        let samples = Samples::new(&[Sweep { command: &x, response: &y }]).unwrap();
        let found = Model::of(CurveModel::Line).fit(&samples.gathered(), None).unwrap();
        let exact = lsq::fit(&[&vec![1.0; x.len()], &x], &y).unwrap();
        (found[1] - exact.coefficients[1]).abs() / exact.std_errors()[1]
    }

    #[test]
    fn the_fit_is_that_to_the_samples_and_nearly_so_where_steps_are_wide() {
        assert!(departure(MOST_STEPS as u32) < 1e-9);
        let wide = departure(3001);
        assert!(wide > 1e-9 && wide < 0.02, "{wide}");
    }
}
