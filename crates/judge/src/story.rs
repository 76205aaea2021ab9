//! What happens in a run, and when: how the lever moves, and when it passes an edge of the
//! environment. Runs that look for events supply it themselves; for other runs it is read from the
//! samples.

use zwidth_dynamics::{EventKind, Motion, System, Trajectory};

/// Something that happens in a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum What {
    /// From then on the lever moves so.
    Moves(Motion),
    /// It passes the edge of this zone.
    Passes(usize),
}

/// What happened, in order of time, s.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Story(Vec<(f64, What)>);

impl Story {
    /// Of a run, by its events or else by its samples.
    pub fn of(system: &System, run: &Trajectory) -> Self {
        let mut moves = if run.events.is_empty() { sampled(run) } else { events(run) };
        // Saturation and zones change the region, not the way of moving. The first is the start's.
        moves.dedup_by_key(|(_, motion)| *motion);
        let moves = moves.into_iter().skip(1).map(|(t, motion)| (t, What::Moves(motion)));
        let mut all: Vec<_> = moves.chain(passes(system, run)).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self(all)
    }

    /// The largest difference of the times, s, if the same happens in the same order.
    pub fn apart_s(&self, other: &Self) -> Option<f64> {
        let same =
            self.0.len() == other.0.len() && self.0.iter().zip(&other.0).all(|(a, b)| a.1 == b.1);
        let apart = self.0.iter().zip(&other.0).map(|(a, b)| (a.0 - b.0).abs());
        same.then(|| apart.fold(0.0, f64::max))
    }

    /// How often the lever changes its way of moving.
    pub fn motion_changes(&self) -> usize {
        self.0.iter().filter(|(_, what)| matches!(what, What::Moves(_))).count()
    }
}

fn events(run: &Trajectory) -> Vec<(f64, Motion)> {
    run.events.iter().map(|event| (event.t_s, event.region.motion)).collect()
}

/// Way of moving at the samples; the change from forward to backward lies where the straight line
/// through the velocities passes zero.
fn sampled(run: &Trajectory) -> Vec<(f64, Motion)> {
    let omega: Vec<f64> = run.theta_dot_rad_s().collect();
    let moves = (0..run.len()).map(|i| {
        let between = i > 0 && omega[i - 1] * omega[i] < 0.0;
        let share = if between { omega[i] / (omega[i] - omega[i - 1]) } else { 0.0 };
        let t_s = run.t_s[i] - share * (run.t_s[i] - run.t_s[i.saturating_sub(1)]);
        (t_s, run.regions[usize::from(run.region[i])].motion)
    });
    moves.collect()
}

/// When each edge of the environment is passed.
fn passes(system: &System, run: &Trajectory) -> Vec<(f64, What)> {
    let edges = system.scene().environment.zones.iter().map(|zone| zone.from_rad).enumerate();
    let edges: Vec<(usize, f64)> = edges.skip(1).collect();
    if !run.events.is_empty() {
        let zones = run.events.iter().filter(|event| event.kind == EventKind::Zone);
        let passes = zones.map(|event| {
            // An event does not name its edge, but stands on it.
            let theta = event.theta_rad;
            let nearest =
                edges.iter().min_by(|a, b| (theta - a.1).abs().total_cmp(&(theta - b.1).abs()));
            (event.t_s, What::Passes(nearest.map_or(0, |edge| edge.0)))
        });
        return passes.collect();
    }
    let theta: Vec<f64> = run.theta_rad().collect();
    let mut passes = Vec::new();
    for (i, pair) in theta.windows(2).enumerate() {
        for (number, edge) in &edges {
            if (pair[0] < *edge) != (pair[1] < *edge) {
                let share = (edge - pair[0]) / (pair[1] - pair[0]);
                let t = run.t_s[i] + share * (run.t_s[i + 1] - run.t_s[i]);
                passes.push((t, What::Passes(*number)));
            }
        }
    }
    passes
}
