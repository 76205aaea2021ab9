//! Curved terms as straight lines between a few angles, so that a system with a weight is piecewise
//! affine too.

use std::f64::consts::PI;

use super::region::{Region, Side};
use super::row::Row;
use super::{System, THETA};
use crate::error::{Result, positive};
use crate::scene::ModelScene;
use crate::scene::environment::Zone;

impl System {
    /// The system with the curved parts of its terms replaced by chords, each at most `width_rad`
    /// wide, between the stops (without them from −π to π). A curve of amplitude A and unit
    /// curvature, such as A sin θ, is missed by at most A width²/8. Chords end where zones do, so
    /// that every solver runs it; without curved terms it is the same as [`System::new`].
    ///
    /// # Errors
    /// As [`System::new`]; a width that is not above 0.
    pub fn by_chords(scene: ModelScene, width_rad: f64) -> Result<Self> {
        positive("width_rad", width_rad)?;
        Self::new(scene)?.straightened(width_rad)
    }

    /// The same for a system that is already laid out.
    pub(crate) fn straightened(mut self, width_rad: f64) -> Result<Self> {
        if !self.curved {
            return Ok(self);
        }
        let ends = self.scene.plant.stops_rad.unwrap_or([-PI, PI]);
        self.scene.environment.zones = cut(&self.scene.environment.zones, ends, width_rad);
        let edges: Vec<f64> = self.scene.environment.zones.iter().map(|z| z.from_rad).collect();
        let lows = std::iter::once(ends[0]).chain(edges[1..].iter().copied());
        let highs = edges[1..].iter().copied().chain([ends[1]]);
        self.chords = lows.zip(highs).map(|(low, high)| self.line(low, high)).collect();
        // The chords stand for the curved parts, which nothing may add a second time.
        self.curved = false;
        Ok(self)
    }

    /// The line through the curved force at two angles.
    fn line(&self, low_rad: f64, high_rad: f64) -> Row {
        let [a, b] = [low_rad, high_rad].map(|theta_rad| {
            let terms = self.scene.terms.iter();
            let curves = terms.filter_map(|term| term.curve(&self.scene.plant, theta_rad, 0.0));
            curves.map(|curve| curve.force_n).sum::<f64>()
        });
        let slope = if high_rad > low_rad { (b - a) / (high_rad - low_rad) } else { 0.0 };
        Row::entry(THETA, slope).plus(self.constant(a - slope * low_rad))
    }

    /// The chord that holds on a side of a region; nothing where curves are taken as they are.
    pub(super) fn chord(&self, region: &Region, side: Side) -> Row {
        let zone = if side == Side::Up { region.zone_up } else { region.zone_down };
        self.chords.get(usize::from(zone)).copied().unwrap_or(Row::ZERO)
    }
}

/// Zones cut where chords end, each with the demand of the one it was part of.
fn cut(zones: &[Zone], [low, high]: [f64; 2], width_rad: f64) -> Vec<Zone> {
    /// More chords than any curve of a lever needs.
    const MOST: f64 = 1000.0;
    let pieces = ((high - low) / width_rad).ceil().clamp(1.0, MOST) as usize;
    let inner = (1..pieces).map(|k| low + (high - low) * k as f64 / pieces as f64);
    let own = zones[1..].iter().map(|zone| zone.from_rad);
    let mut edges: Vec<f64> = inner.chain(own).collect();
    edges.sort_by(f64::total_cmp);
    // A zone may begin where a chord does.
    edges.dedup();
    std::iter::once(zones[0])
        .chain(edges.iter().map(|edge| {
            let before = zones[1..].iter().take_while(|zone| *edge >= zone.from_rad).count();
            Zone { from_rad: *edge, demand: zones[before].demand }
        }))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::table3;
    use crate::{DriveMode, Exact, Gravity, Grid, Input, Solver, Tolerances, TrBdf2};

    fn weighed() -> ModelScene {
        let mut scene = table3::scene(DriveMode::Active, Input::sine(1.0));
        scene.terms.set(Gravity { mass_kg: 0.2, radius_m: 0.1 });
        scene
    }

    #[test]
    fn the_exact_solver_runs_a_weight_by_chords_as_an_adaptive_one_runs_the_sine() {
        let grid = Grid::filling(4.0, 0.01);
        let tight = TrBdf2 { tolerances: Tolerances::of(1e-9) };
        let curved = System::new(weighed()).unwrap();
        let truth: Vec<f64> = tight.run(&curved, &grid).unwrap().theta_rad().collect();
        let off = |width_rad: f64| {
            let system = System::by_chords(weighed(), width_rad).unwrap();
            let run = Exact::default().run(&system, &grid).unwrap();
            run.theta_rad().zip(&truth).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        // 0.2 N · (5°)²/8 over 4 N/rad: the bound of what the angle can be off by.
        let width = 5.0_f64.to_radians();
        assert!(off(width) < 0.2 * width * width / 8.0 / 4.0 * 1.1, "{}", off(width));
        assert!(off(width / 4.0) < 0.1 * off(width), "{} {}", off(width / 4.0), off(width));
    }

    #[test]
    fn without_a_curved_term_nothing_is_cut() {
        let scene = table3::scene(DriveMode::Hybrid, Input::sine(2.15));
        assert_eq!(System::by_chords(scene.clone(), 0.1).unwrap(), System::new(scene).unwrap());
    }
}
