//! The setting of a run: a solver and its step or tolerance.

use serde::Serialize;
use zwidth_dynamics::{NAMED_SOLVERS, NamedSolver, Solver};
use zwidth_judge::EXACT;

/// Those that are given a tolerance.
const ADAPTIVE: [&str; 2] = ["dormand_prince", "tr_bdf2"];
/// For solvers that are given a step, which do not look at it.
const UNUSED_TOLERANCE: f64 = 1e-9;

/// What a solver is given.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Fineness {
    /// Nothing: events and samples come as they are.
    None,
    /// A step, s.
    StepS(f64),
    /// A relative error per step.
    Tolerance(f64),
}

/// A solver with its step or tolerance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Setting {
    /// The solver's name.
    pub solver: &'static str,
    /// What it is given.
    pub fineness: Fineness,
}

impl Setting {
    /// The solver, ready to run.
    pub fn solver(&self) -> Box<dyn Solver> {
        let tolerance = match self.fineness {
            Fineness::Tolerance(tolerance) => tolerance,
            _ => UNUSED_TOLERANCE,
        };
        (named(self.solver).make)(tolerance)
    }

    /// Its step or tolerance: smaller is finer. 0 if it has no number.
    pub fn size(&self) -> f64 {
        match self.fineness {
            Fineness::None => 0.0,
            Fineness::StepS(size) | Fineness::Tolerance(size) => size,
        }
    }

    /// Its step, s, if it has one.
    pub fn step_s(&self) -> Option<f64> {
        if let Fineness::StepS(step_s) = self.fineness { Some(step_s) } else { None }
    }

    /// Its tolerance, if it is given one.
    pub fn tolerance(&self) -> Option<f64> {
        if let Fineness::Tolerance(tolerance) = self.fineness { Some(tolerance) } else { None }
    }

    /// In words, for people: `RK4, switched per step, 8.3 ms`.
    pub fn words(&self) -> String {
        let label = named(self.solver).label;
        match self.fineness {
            Fineness::None => label.to_owned(),
            Fineness::StepS(step_s) => format!("{label}, {}", step_words(step_s)),
            Fineness::Tolerance(tolerance) => format!("{label}, tolerance {tolerance:e}"),
        }
    }
}

/// A step in milliseconds, without more digits than it has.
pub(crate) fn step_words(step_s: f64) -> String {
    let ms = (step_s * 1e3 * 1e6).round() / 1e6;
    format!("{ms} ms")
}

fn named(name: &str) -> NamedSolver {
    let [exact, ..] = NAMED_SOLVERS;
    // Names of settings are those of this list: another one does not occur.
    NAMED_SOLVERS.into_iter().find(|solver| solver.name == name).unwrap_or(exact)
}

/// The steps and tolerances that are tried.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Fan {
    /// Steps, s, each twice the one before, so that the runs with half and a quarter of a step are
    /// there for the judgement.
    pub doubled_s: Vec<f64>,
    /// Further steps, s.
    pub further_s: Vec<f64>,
    /// Tolerances.
    pub tolerances: Vec<f64>,
}

impl Fan {
    /// 1 µs to 100 ms, and the scene's own step; tolerances from 10⁻³ to 10⁻¹¹.
    pub fn full(scene_step_s: f64) -> Self {
        let doubled_s: Vec<f64> = (0..17).map(|k| 1e-6 * f64::from(1_u32 << k)).collect();
        let tolerances = (3..=11).map(|k| libm::pow(10.0, -f64::from(k))).collect();
        Self { doubled_s, further_s: vec![scene_step_s, 0.1], tolerances }
    }

    /// 0.5 ms to 33 ms, the scene's own step, and three tolerances: for every run of a study.
    pub fn reduced(scene_step_s: f64) -> Self {
        let doubled_s: Vec<f64> = (9..16).map(|k| 1e-6 * f64::from(1_u32 << k)).collect();
        Self { doubled_s, further_s: vec![scene_step_s], tolerances: vec![1e-3, 1e-5, 1e-7] }
    }

    /// The solvers, each with its settings from the finest to the coarsest.
    pub fn settings(&self) -> Vec<Vec<Setting>> {
        NAMED_SOLVERS.into_iter().map(|solver| self.settings_of(solver.name)).collect()
    }

    fn settings_of(&self, solver: &'static str) -> Vec<Setting> {
        if solver == EXACT {
            return vec![Setting { solver, fineness: Fineness::None }];
        }
        let list: Vec<Fineness> = if ADAPTIVE.contains(&solver) {
            self.tolerances.iter().map(|t| Fineness::Tolerance(*t)).collect()
        } else {
            self.doubled_s.iter().chain(&self.further_s).map(|h| Fineness::StepS(*h)).collect()
        };
        let settings = list.into_iter().map(|fineness| Setting { solver, fineness });
        let mut settings: Vec<Setting> = settings.collect();
        settings.sort_by(|a, b| a.size().total_cmp(&b.size()));
        // The scene's own step may be one of the doubled ones.
        settings.dedup_by(|a, b| a.size().to_bits() == b.size().to_bits());
        settings
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_fan_goes_from_a_microsecond_to_a_hundred_milliseconds_and_has_the_scene_s_own_step() {
        let settings = Fan::full(8.3e-3).settings();
        assert_eq!(settings.len(), NAMED_SOLVERS.len());
        let rk4 = settings.iter().find(|list| list[0].solver == "rk4_per_step").unwrap();
        assert!(rk4.windows(2).all(|pair| pair[0].size() < pair[1].size()));
        assert!(
            (rk4[0].size() - 1e-6).abs() < 1e-18 && (rk4[rk4.len() - 1].size() - 0.1).abs() < 1e-12
        );
        assert!(rk4.iter().any(|setting| (setting.size() - 8.3e-3).abs() < 1e-15));
    }

    #[test]
    fn a_setting_says_what_it_is() {
        let of = |solver, fineness| Setting { solver, fineness }.words();
        assert_eq!(of("rk4_per_step", Fineness::StepS(8.3e-3)), "RK4, switched per step, 8.3 ms");
        assert_eq!(of("tr_bdf2", Fineness::Tolerance(1e-6)), "TR-BDF2, tolerance 1e-6");
        assert_eq!(of("exact", Fineness::None), "exact");
    }
}
