//! What a run returns: states at the grid's times, their regions, the events between them, and the
//! work done.

use crate::energy::EnergyBalance;
use crate::system::region::Region;
use crate::system::transition::EventKind;
use crate::system::{Layout, OMEGA, System, THETA};

/// Forces on the lever's end by part, N; above 0 pushes to +θ, into the object.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Forces {
    /// The user's force F_ex.
    pub external_n: f64,
    /// The part of it that arrives at the lever: through the finger, or all of it without one.
    pub tip_n: f64,
    /// The share of the finger's tissue, K_F x2 + B_F ẋ2.
    pub tissue_n: f64,
    /// The motor.
    pub motor_n: f64,
    /// The brake.
    pub brake_n: f64,
    /// Dry and viscous friction.
    pub friction_n: f64,
    /// The scene's terms together; [`System::term_forces_n`] has them one by one.
    pub terms_n: f64,
    /// A mechanical stop.
    pub stop_n: f64,
}

impl Forces {
    /// What the device does to the lever's end: all but the user's share, N.
    pub fn device_n(&self) -> f64 {
        self.motor_n + self.brake_n + self.friction_n + self.terms_n + self.stop_n
    }
}

/// Something that happened between samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// When, s.
    pub t_s: f64,
    /// What.
    pub kind: EventKind,
    /// θ there, rad.
    pub theta_rad: f64,
    /// The region that holds from then on.
    pub region: Region,
}

/// Work counts, to compare methods by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct WorkCounts {
    /// Steps taken, or exact pieces.
    pub steps: u64,
    /// Steps rejected by an error estimate.
    pub rejected: u64,
    /// Evaluations of the right-hand side, or products with a flow matrix.
    pub evaluations: u64,
    /// Matrix exponentials or factorisations.
    pub factorisations: u64,
}

impl WorkCounts {
    /// One number by which to compare costs, in evaluations: a factorisation or an exponential of
    /// an n × n matrix counts as n products of it with a state. It does not depend on the machine,
    /// and is not a time.
    pub fn in_evaluations(&self, layout: &Layout) -> u64 {
        self.evaluations + self.factorisations * layout.n as u64
    }
}

/// A run. States are augmented (see [`Layout`]), one row of `layout.n` numbers per sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    /// The place of each quantity in a state.
    pub layout: Layout,
    /// Sample times, s.
    pub t_s: Vec<f64>,
    /// States, row after row.
    pub states: Vec<f64>,
    /// Index into `regions` for each sample.
    pub region: Vec<u16>,
    /// The regions that were met.
    pub regions: Vec<Region>,
    /// The events, in order of time; empty for methods that do not look for them.
    pub events: Vec<Event>,
    /// Work counts.
    pub work: WorkCounts,
    /// Where the energy went, if the method was asked to integrate it.
    pub energy: Option<EnergyBalance>,
}

impl Trajectory {
    pub(crate) fn new(layout: Layout, samples: usize) -> Self {
        Self {
            layout,
            t_s: Vec::with_capacity(samples),
            states: Vec::with_capacity(samples * layout.n),
            region: Vec::with_capacity(samples),
            regions: Vec::new(),
            events: Vec::new(),
            work: WorkCounts::default(),
            energy: None,
        }
    }

    /// Empties it, keeping its memory, for a run of so many samples.
    pub(crate) fn clear(&mut self, layout: Layout, samples: usize) {
        self.layout = layout;
        self.t_s.clear();
        self.states.clear();
        self.region.clear();
        self.regions.clear();
        self.events.clear();
        self.t_s.reserve(samples);
        self.states.reserve(samples * layout.n);
        self.region.reserve(samples);
    }

    /// The motion of another program as a run of this system: θ (rad) and θ̇ (rad/s) at the times of
    /// `self`, the system's own run, from which all other entries of the state are taken. A lever
    /// that moves at `rest_rad_s` or less stands still, as far as forces are concerned. Of the
    /// program's events nothing is known.
    ///
    /// One angle and one velocity per sample of `self`; the shorter of all three counts.
    pub fn with_motion(
        &self,
        system: &System,
        theta_rad: &[f64],
        theta_dot_rad_s: &[f64],
        rest_rad_s: f64,
    ) -> Self {
        let n = self.len().min(theta_rad.len()).min(theta_dot_rad_s.len());
        let mut run = Self::new(self.layout, n);
        for i in 0..n {
            let from = run.states.len();
            run.states.extend_from_slice(self.state(i));
            let z = &mut run.states[from..];
            z[THETA] = theta_rad[i];
            z[OMEGA] =
                if theta_dot_rad_s[i].abs() <= rest_rad_s { 0.0 } else { theta_dot_rad_s[i] };
            let region = system.sampled_region(z);
            // Only the region is that of a lever at rest: the velocity stays as it was given.
            z[OMEGA] = theta_dot_rad_s[i];
            let region = run.region_number(&region);
            run.region.push(region);
            run.t_s.push(self.t_s[i]);
        }
        run
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.t_s.len()
    }

    /// True without samples.
    pub fn is_empty(&self) -> bool {
        self.t_s.is_empty()
    }

    /// The augmented state of sample `i`.
    pub fn state(&self, i: usize) -> &[f64] {
        &self.states[i * self.layout.n..(i + 1) * self.layout.n]
    }

    /// θ of every sample, rad.
    pub fn theta_rad(&self) -> impl Iterator<Item = f64> {
        self.states.chunks_exact(self.layout.n).map(|z| z[THETA])
    }

    /// θ̇ of every sample, rad/s.
    pub fn theta_dot_rad_s(&self) -> impl Iterator<Item = f64> {
        self.states.chunks_exact(self.layout.n).map(|z| z[OMEGA])
    }

    /// Tissue compression x2 of every sample, m; empty without a finger.
    pub fn finger_m(&self) -> impl Iterator<Item = f64> {
        let at = self.layout.finger;
        self.states.chunks_exact(self.layout.n).filter_map(move |z| at.map(|i| z[i]))
    }

    /// The forces by part at sample `i`, by the system that was run.
    pub fn forces(&self, system: &System, i: usize) -> Forces {
        system.forces(&self.regions[usize::from(self.region[i])], self.state(i))
    }

    /// Sign changes of θ̇ between samples, zeros skipped.
    pub fn reversals(&self) -> usize {
        let mut last = 0.0;
        let mut count = 0;
        for omega in self.theta_dot_rad_s().filter(|omega| *omega != 0.0) {
            count += usize::from(last * omega < 0.0);
            last = omega.signum();
        }
        count
    }

    /// Changes of the lever's motion (forward, backward, rest) along the events; saturation is
    /// none.
    pub fn motion_changes(&self) -> usize {
        let motions: Vec<_> = self.events.iter().map(|event| event.region.motion).collect();
        motions.windows(2).filter(|pair| pair[0] != pair[1]).count()
    }

    /// Number of a region, which is added if new.
    pub(crate) fn region_number(&mut self, region: &Region) -> u16 {
        let number = self.regions.iter().position(|existing| existing.resembles(region));
        number.unwrap_or_else(|| {
            self.regions.push(*region);
            self.regions.len() - 1
        }) as u16
    }

    /// Adds one or several samples of a region.
    #[inline(always)]
    pub(crate) fn push<const N: usize, const K: usize>(
        &mut self,
        t_s: &[f64; K],
        states: &[[f64; N]; K],
        region: u16,
    ) {
        self.t_s.extend_from_slice(t_s);
        // States of full length lie side by side and are copied as one block.
        if N == self.layout.n {
            self.states.extend_from_slice(states.as_flattened());
        } else {
            states.iter().for_each(|z| self.states.extend_from_slice(&z[..self.layout.n]));
        }
        self.region.extend_from_slice(&[region; K]);
    }
}
