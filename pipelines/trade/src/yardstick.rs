//! The right answer, and how well it is proven.

use crate::TradeError;
use crate::story::Story;
use zwidth_dynamics::{
    DormandPrince, Exact, FeltMotion, FeltReference, Grid, ModelScene, Solver, System, Tolerances,
    TrBdf2, Trajectory,
};
use zwidth_results::Proof;
use zwidth_study::Perception;

/// Time between the samples that a yardstick is compared with another solver at, s.
pub(crate) const SAMPLE_S: f64 = 0.5e-3;
/// Two solvers agree if no angle, rad, and no event, s, is further apart.
const AGREE_RAD: f64 = 1e-9;
const AGREE_S: f64 = 1e-9;
/// Where a guard is grazed times are known to the root of that.
const GRAZING_S: f64 = 3.2e-5;
/// Tolerance of the solver that must agree with the exact one; with curved terms, where there is no
/// exact one, of the better of two.
const FINE: f64 = 1e-12;
/// Tolerance of the other one of those two.
const OTHER: f64 = 1e-10;

/// How far an answer is proven by another solver's, from how far the two are apart.
fn proof(theta_rad: f64, events_s: Option<f64>) -> Proof {
    match events_s {
        _ if theta_rad > AGREE_RAD || theta_rad.is_nan() => Proof::Unproven,
        Some(apart_s) if apart_s <= AGREE_S => Proof::Proven,
        Some(apart_s) if apart_s <= GRAZING_S => Proof::Grazing,
        _ => Proof::Unproven,
    }
}

/// The right answer of a scene.
pub struct Yardstick {
    /// The scene, checked.
    pub system: System,
    /// How far it is proven.
    pub proof: Proof,
    /// The largest difference of the two solvers' angles, rad; `None` where one of them cannot run.
    pub apart_rad: Option<f64>,
    /// That of their events' times, s; `None` where their events differ.
    pub apart_s: Option<f64>,
    /// By which solver.
    pub by: &'static str,
    /// With which it was compared.
    pub against: &'static str,
    solver: Box<dyn Solver>,
    pub(crate) run: Trajectory,
    pub(crate) story: Story,
    pub(crate) impulse_ns: f64,
    pub(crate) felt: FeltReference,
}

impl Yardstick {
    /// The right answer of a scene, by the exact solver or, with curved terms, by an adaptive one.
    ///
    /// # Errors
    /// A scene that makes no sense, or that neither can run.
    pub fn of(scene: &ModelScene, perception: &Perception) -> Result<Self, TradeError> {
        let system = System::new(scene.clone())?;
        let exact = Exact::default();
        let is_curved = exact.prepare(&system, &grid(scene)).is_err();
        if is_curved {
            let fine = DormandPrince { tolerances: Tolerances::of(FINE) };
            let other = TrBdf2 { tolerances: Tolerances::of(OTHER) };
            return Self::compared(
                system,
                Box::new(fine),
                &other,
                "dormand_prince",
                "tr_bdf2",
                perception,
            );
        }
        let other = DormandPrince { tolerances: Tolerances::of(FINE) };
        Self::compared(system, Box::new(exact), &other, "exact", "dormand_prince", perception)
    }

    /// The same without a second solver, for many neighbours of a scene that is proven.
    pub(crate) fn alone(scene: &ModelScene, perception: &Perception) -> Result<Self, TradeError> {
        let system = System::new(scene.clone())?;
        let exact = Exact::default();
        if exact.prepare(&system, &grid(scene)).is_ok() {
            let run = exact.run(&system, &grid(scene))?;
            return Ok(Self::new(system, Box::new(exact), run, ["exact", ""], perception));
        }
        let fine = DormandPrince { tolerances: Tolerances::of(OTHER) };
        let run = fine.run(&system, &grid(scene))?;
        Ok(Self::new(system, Box::new(fine), run, ["dormand_prince", ""], perception))
    }

    /// By one solver, and compared with another.
    fn compared(
        system: System,
        solver: Box<dyn Solver>,
        other: &dyn Solver,
        by: &'static str,
        against: &'static str,
        perception: &Perception,
    ) -> Result<Self, TradeError> {
        let run = solver.run(&system, &grid(system.scene()))?;
        let mut yardstick = Self::new(system, solver, run, [by, against], perception);
        // A second solver that fails leaves the answer unproven, but there.
        if let Ok(second) = other.run(&yardstick.system, &grid(yardstick.system.scene())) {
            let pairs = yardstick.run.theta_rad().zip(second.theta_rad());
            let apart_rad = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            yardstick.apart_rad = Some(apart_rad);
            yardstick.apart_s = yardstick.story.apart_s(&Story::of(&yardstick.system, &second));
            yardstick.proof = proof(apart_rad, yardstick.apart_s);
        }
        Ok(yardstick)
    }

    /// An answer that is not proven yet.
    fn new(
        system: System,
        solver: Box<dyn Solver>,
        run: Trajectory,
        [by, against]: [&'static str; 2],
        perception: &Perception,
    ) -> Self {
        let motion = FeltMotion::of(&system, &run);
        let felt = FeltReference::new(&motion, system.scene().plant.lever_m, perception);
        let story = Story::of(&system, &run);
        let impulse_ns = motion.impulse_ns();
        Self {
            system,
            proof: Proof::Unproven,
            apart_rad: None,
            apart_s: None,
            by,
            against,
            solver,
            run,
            story,
            impulse_ns,
            felt,
        }
    }

    /// The right run at these times, s.
    pub(crate) fn at(&self, times_s: Vec<f64>) -> Result<Trajectory, TradeError> {
        Ok(self.solver.run(&self.system, &Grid::Times(times_s))?)
    }
}

fn grid(scene: &ModelScene) -> Grid {
    Grid::filling(scene.duration_s, SAMPLE_S)
}
