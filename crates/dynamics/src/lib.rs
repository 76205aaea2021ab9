//! The device's hybrid dynamics: scenes as values, models, actuators, and solvers behind one trait.
//!
//! A [`ModelScene`] says what is simulated. [`System::new`] checks it and turns it into regions, in
//! each of which the motion is smooth, and rules for passing from one to the next. A [`Solver`]
//! moves a system along a [`Grid`] of times and returns a [`Trajectory`]. Solvers know no scenes,
//! and scenes know no solvers. Equation numbers in parentheses are the thesis'. Nothing here reads
//! a file or the clock.
//!
//! ```
//! use zwidth_dynamics::{Exact, Grid, Input, DriveMode, Solver, System, table3};
//!
//! let system = System::new(table3::scene(DriveMode::Hybrid, Input::sine(2.15)))?;
//! let run = Exact::default().run(&system, &Grid::of(&system))?;
//! let highest_rad = run.theta_rad().fold(f64::MIN, f64::max);
//! assert!((highest_rad.to_degrees() - 14.40784).abs() < 1e-5);
//! assert_eq!(run.motion_changes(), 3); // forward, stick, backward, forward
//! # Ok::<(), zwidth_dynamics::DynamicsError>(())
//! ```

mod affine;
mod displacement;
mod driven;
mod energy;
mod error;
mod scene;
mod solve;
mod sweep;
mod system;
mod trajectory;
mod verdict;
mod wall;

pub use driven::{Aim, Command, Driven, DrivenParameters, DrivenState, Hand, Tissue};
pub use energy::EnergyBalance;
pub use error::DynamicsError;
pub use scene::actuators::{Brake, BrakeLaw, DriveMode, Motor};
pub use scene::environment::{Demand, Environment, Zone};
pub use scene::finger::{Finger, FingerLaw};
pub use scene::friction::Friction;
pub use scene::input::{Input, Series};
pub use scene::parameter::Parameter;
pub use scene::plant::{Plant, Start};
pub use scene::terms::gravity::Gravity;
pub use scene::terms::pull::Pull;
pub use scene::terms::{Affine, Curve, Term, Terms};
pub use scene::{ModelScene, table3, terms};
pub use solve::adaptive::Tolerances;
pub use solve::dormand_prince::DormandPrince;
pub use solve::exact::held::{HeldCommand, HeldRun, HeldScene};
pub use solve::exact::{Exact, Prepared};
pub use solve::moreau_jean::MoreauJean;
pub use solve::named::{NAMED_SOLVERS, NamedSolver, solver_label};
pub use solve::rk4::Rk4;
pub use solve::symplectic_euler::SymplecticEuler;
pub use solve::tr_bdf2::TrBdf2;
pub use solve::{Grid, Solver, Switching};
pub use sweep::sweep;
pub use system::Layout;
pub use system::linear::LinearPart;
pub use system::region::{Contact, Motion, Region, Side};
pub use system::transition::EventKind;
pub use system::{RestRule, System};
pub use trajectory::{Event, Forces, Trajectory, WorkCounts};
pub use verdict::{
    Controller, ExistingSwings, FEWEST_SWINGS, Felt, FeltDifference, FeltMotion, FeltReference,
    HeldForces, Judgement, Model, Motions, Reference, RunVerdict, SampledLoop, Swings,
    TickController, TickedLoop, VibrationThreshold, felt, judge, own_swings,
};
pub use wall::{DryLimits, Pushed, PushedWall, RidingFinger, SampledWall, Textbook};
