//! The right answer, and how well it is proven.

use crate::story::Story;
use zwidth_dynamics::{
    DormandPrince, DynamicsError, Exact, FeltMotion, FeltReference, Grid, ModelScene, Solver,
    System, Tolerances, TrBdf2, Trajectory,
};
use zwidth_results::Proof;
use zwidth_study::Perception;

/// Time between the samples that a yardstick is compared with another solver at, s.
pub const SAMPLE_S: f64 = 0.5e-3;
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

/// The solver that needs neither step nor tolerance.
pub const EXACT: &str = "exact";
/// The solver of a right answer with curved terms.
const ADAPTIVE: &str = "dormand_prince";

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
    /// Its run, a sample every half millisecond.
    pub run: Trajectory,
    /// What happens in it.
    pub story: Story,
    /// ∫ F dt of the device's force, N s.
    pub impulse_ns: f64,
    /// What a person would feel of it.
    pub felt: FeltReference,
}

impl Yardstick {
    /// The right answer of a scene, by the exact solver or, with curved terms, by an adaptive one;
    /// compared with another solver's.
    ///
    /// # Errors
    /// A scene that makes no sense, or that neither can run.
    pub fn of(scene: &ModelScene, perception: &Perception) -> Result<Self, DynamicsError> {
        let mut yardstick = Self::by_one(scene, FINE, perception)?;
        let (against, other): (_, Box<dyn Solver>) = match yardstick.by {
            EXACT => (ADAPTIVE, Box::new(DormandPrince { tolerances: Tolerances::of(FINE) })),
            _ => ("tr_bdf2", Box::new(TrBdf2 { tolerances: Tolerances::of(OTHER) })),
        };
        yardstick.against = against;
        // A second solver that fails leaves the answer unproven, but there.
        if let Ok(second) = other.run(&yardstick.system, &grid(scene)) {
            let pairs = yardstick.run.theta_rad().zip(second.theta_rad());
            let apart_rad = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            yardstick.apart_rad = Some(apart_rad);
            yardstick.apart_s = yardstick.story.apart_s(&Story::of(&yardstick.system, &second));
            yardstick.proof = proof(apart_rad, yardstick.apart_s);
        }
        Ok(yardstick)
    }

    /// The same without a second solver, for many neighbours of a scene that is proven.
    ///
    /// # Errors
    /// As [`Self::of`].
    pub fn alone(scene: &ModelScene, perception: &Perception) -> Result<Self, DynamicsError> {
        Self::by_one(scene, OTHER, perception)
    }

    /// An answer that is not proven yet; with curved terms of this tolerance.
    fn by_one(
        scene: &ModelScene,
        tolerance: f64,
        perception: &Perception,
    ) -> Result<Self, DynamicsError> {
        let system = System::new(scene.clone())?;
        let exact = Exact::default();
        let (by, solver): (_, Box<dyn Solver>) = match exact.prepare(&system, &grid(scene)) {
            Ok(_) => (EXACT, Box::new(exact)),
            Err(_) => (ADAPTIVE, Box::new(DormandPrince { tolerances: Tolerances::of(tolerance) })),
        };
        let run = solver.run(&system, &grid(scene))?;
        let motion = FeltMotion::of(&system, &run);
        let felt = FeltReference::new(&motion, system.scene().plant.lever_m, perception);
        let story = Story::of(&system, &run);
        let impulse_ns = motion.impulse_ns();
        Ok(Self {
            system,
            proof: Proof::Unproven,
            apart_rad: None,
            apart_s: None,
            by,
            against: "",
            solver,
            run,
            story,
            impulse_ns,
            felt,
        })
    }

    /// The right run at these times, s: increasing, from the start of the scene on.
    ///
    /// # Errors
    /// Times that do not increase; a run that fails.
    pub fn at(&self, times_s: Vec<f64>) -> Result<Trajectory, DynamicsError> {
        self.solver.run(&self.system, &Grid::Times(times_s))
    }
}

fn grid(scene: &ModelScene) -> Grid {
    Grid::filling(scene.duration_s, SAMPLE_S)
}
