//! What a characterisation and its surroundings tell each other: words alone.

use crate::{CellFault, Judged, LoadCell, SweepFault};
use zwidth_device::{Push, PushRun, Ramp, Ramped, Weighed};
use zwidth_stability::impedance::{Found, Probe};
use zwidth_study::Check;

/// What a person is asked to do.
#[derive(Debug, Clone, PartialEq)]
pub enum Ask {
    /// Nothing touches the load cell.
    Zero,
    /// This mass hangs from it, kg, and pulls towards +θ.
    Mass(f64),
    /// The lever is held against its lower stop.
    Home,
    /// The lever is clamped in its fixture against the load cell.
    Clamp,
    /// The lever is back at its lower stop.
    Back,
    /// The lever is held against its upper stop.
    Up,
    /// The last mass goes on hanging, for so long, s.
    Hang(f64),
    /// A sweep may begin: a motor is watched, a brake is pushed through.
    Sweep {
        /// How it goes.
        ramp: Ramp,
        /// Which one it is, from 1.
        number: u32,
        /// How many there are to be.
        of: u32,
    },
    /// The lever is carried to the middle of its work space and let go of.
    Middle,
    /// Walls are raised until the free lever keeps swinging in them; somebody watches.
    Walls {
        /// Which are searched.
        probe: Probe,
        /// Which search it is, from 1.
        number: usize,
        /// How many there are to be.
        of: usize,
    },
    /// What stopped it is mended.
    GoOn,
}

/// What is told a person.
#[derive(Debug, Clone, PartialEq)]
pub enum Remark {
    /// The load cell is known.
    Cell {
        /// What is known of it.
        cell: LoadCell,
        /// What `newtons_per_count` of rig.toml should be, N, where it is off.
        newtons_per_count: Option<f64>,
    },
    /// The load does not count.
    CellFault(CellFault),
    /// The lever is not at rest yet, or not where it is to be.
    LeverElsewhere,
    /// The winding cools for so long, s.
    Cooling(f64),
    /// A sweep was kept.
    Kept(Judged),
    /// A sweep does not count.
    SweepFault(SweepFault),
    /// A sweep does not agree with those before, and is repeated; its gain and theirs, N/V.
    Odd([f64; 2]),
    /// The repeat agrees with those before: the odd one is left out.
    OddLeftOut,
    /// The repeat agrees with the odd one: the actuator has changed, and both are kept.
    Changed,
    /// A search of a Z-width test has ended.
    Found(Probe, Found),
    /// Nobody watched the motor.
    Unwatched,
    /// The lever came off its clamp.
    Loose,
    /// The motor was held back, because the lever has not moved since it was homed.
    HeldBack,
    /// It was stopped, and why.
    Stopped(String),
}

/// What happens.
#[derive(Debug, Clone, PartialEq)]
pub enum Input {
    /// The person has done what they were asked for.
    Go,
    /// Readings at 0 V.
    Weighed(Vec<Weighed>),
    /// The lever is homed.
    Homed,
    /// A sweep has ended.
    Ramped(Ramped),
    /// A push has ended.
    Pushed(PushRun),
    /// The device check of a lever at rest.
    Rested(Vec<Check>),
    /// The device failed, in words.
    Failed(String),
}

/// A sweep to be kept.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepRun {
    /// What it says.
    pub judged: Judged,
    /// How it went.
    pub ramp: Ramp,
    /// The load cell that it was measured with.
    pub cell: LoadCell,
}

/// What is to be done, in this order.
#[derive(Debug, Clone, PartialEq)]
pub enum Action {
    /// Ask a person; [`Input::Go`] follows.
    Ask(Ask),
    /// Tell a person.
    Tell(Remark),
    /// Read at 0 V for so long, s; [`Input::Weighed`] or [`Input::Failed`] follows.
    Weigh(f64),
    /// Home; [`Input::Homed`] or [`Input::Failed`] follows.
    Home,
    /// Check the device while its lever is at rest; [`Input::Rested`] or [`Input::Failed`] follows.
    Rest,
    /// Drive a sweep; [`Input::Ramped`] follows.
    Ramp(Ramp),
    /// Make a push; [`Input::Pushed`] follows.
    Push(Push),
    /// Keep the loads as a sweep of the load cell: weight and force shown, N.
    KeepLoads(Vec<[f64; 2]>),
    /// Keep a sweep.
    Keep(SweepRun),
    /// Keep a search of a Z-width test.
    KeepSearch(Probe, Found),
    /// All is there.
    Finish,
}

/// A pure state machine: inputs in, actions out.
pub trait Steps {
    /// Begins.
    fn begin(&mut self) -> Vec<Action>;

    /// What follows from an input. One that does not belong to where it is changes nothing.
    fn step(&mut self, input: Input) -> Vec<Action>;
}
