//! A checked scene as a hybrid system: an augmented state, regions with affine flows, and rules
//! between them.
//!
//! The augmented state is z = (θ, θ̇, [x2, ẋ2], [motor force], [brake level], F_ex, Ḟ_ex, [d, ḋ],
//! 1); entries in brackets exist only in scenes that ask for them. Inputs are part of it, so that a
//! region's flow ż = A z is autonomous and its exponential is exact, for a sine too.

mod chords;
pub(crate) mod command;
pub(crate) mod direct;
pub(crate) mod flow;
pub(crate) mod forces;
pub(crate) mod guards;
pub(crate) mod linear;
pub(crate) mod region;
pub(crate) mod row;
mod terms;
pub(crate) mod transition;

use crate::error::{DynamicsError, Result};
use crate::scene::ModelScene;
use crate::scene::actuators::BrakeLaw;
use crate::scene::input::{Input, Span};
use row::{MOST, Row};

/// Index of θ in the augmented state.
pub(crate) const THETA: usize = 0;
/// Index of θ̇.
pub(crate) const OMEGA: usize = 1;

/// The place of each quantity in the augmented state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    /// Number of entries.
    pub n: usize,
    /// Number of entries before the inputs.
    pub dynamic: usize,
    /// x2; ẋ2 follows it.
    pub finger: Option<usize>,
    /// The lagged motor force.
    pub motor: Option<usize>,
    /// The lagged brake level.
    pub brake: Option<usize>,
    /// F_ex; its rate follows it.
    pub force: usize,
    /// d, the input of a term; its rate follows it.
    pub term: Option<usize>,
    /// The command that a digital controller holds.
    pub held: Option<usize>,
}

impl Layout {
    fn of(scene: &ModelScene, is_held: bool) -> Self {
        let mut n = 2;
        let finger = scene.finger.map(|_| n);
        n += if finger.is_some() { 2 } else { 0 };
        let motor = scene.motor.lag_s.map(|_| n);
        n += usize::from(motor.is_some());
        let brake = scene.brake.lag_on_off_s.map(|_| n);
        n += usize::from(brake.is_some());
        let dynamic = n;
        let force = dynamic;
        n += 2;
        let term = scene.terms.input().map(|_| n);
        n += if term.is_some() { 2 } else { 0 };
        let held = is_held.then_some(n);
        n += if is_held { 2 } else { 1 };
        Self { n, dynamic, finger, motor, brake, force, term, held }
    }

    /// Index of the entry that is always 1.
    pub(crate) fn one(&self) -> usize {
        self.n - 1
    }
}

/// Which command lagging actuators follow while θ̇ = 0. The thesis does not say; without a lag it
/// makes no difference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum RestRule {
    /// That of a lever that holds or releases, as while θ̇ < 0.
    #[default]
    Release,
    /// That of a lever that compresses, as while θ̇ > 0: the brake stays engaged.
    Compress,
}

/// A scene checked and laid out; immutable.
#[derive(Debug, Clone, PartialEq)]
pub struct System {
    pub(crate) scene: ModelScene,
    pub(crate) layout: Layout,
    /// The affine part of each term, in the scene's order.
    terms: Vec<Row>,
    /// Whether any term has a curved part that is taken as it is.
    pub(crate) curved: bool,
    /// The terms' curved parts as straight lines, one for each zone; none where they are taken as
    /// they are.
    chords: Vec<Row>,
    /// Which command holds while θ̇ = 0.
    pub(crate) rest_rule: RestRule,
}

/// Which span of each input holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cursor {
    force: (usize, Span),
    term: Option<(usize, Span)>,
    /// End of the current spans, s.
    pub(crate) end_s: f64,
}

/// The span of an input that holds from `t` on, searched from the one that held before.
fn forward(input: &Input, (mut number, mut span): (usize, Span), t: f64) -> (usize, Span) {
    // A guess close to `t` first: over many short periods span by span would take too long.
    if span.end_s <= t {
        number = input.number_near(t, number);
        span = input.span(number);
    }
    while span.end_s <= t {
        number += 1;
        span = input.span(number);
    }
    (number, span)
}

impl System {
    /// Checks every parameter of a scene and lays out its state.
    ///
    /// # Errors
    /// The first parameter that makes no sense, by name and value, or two parts that do not go
    /// together.
    pub fn new(scene: ModelScene) -> Result<Self> {
        Self::laid_out(scene, false)
    }

    /// The same; `is_held` if a command of a digital controller is part of the state.
    pub(crate) fn laid_out(scene: ModelScene, is_held: bool) -> Result<Self> {
        scene.check()?;
        if scene.brake.law == BrakeLaw::Thesis && scene.brake.lag_on_off_s.is_some() {
            let what = "brake.lag_on_off_s needs the level of a set-valued brake";
            let remedy = "set brake.law to \"coulomb\"";
            return Err(DynamicsError::Combination { what, remedy });
        }
        let layout = Layout::of(&scene, is_held);
        let terms = scene.terms.iter().map(|term| {
            let affine = term.affine(&scene.plant);
            let mut row = Row::ZERO;
            row.0[THETA] = affine.per_rad_n;
            row.0[OMEGA] = affine.per_rad_s_n;
            row.0[layout.one()] = affine.constant_n;
            if let (Some(at), true) = (layout.term, term.input().is_some()) {
                row.0[at] = affine.per_input_n;
            }
            row
        });
        let terms = terms.collect();
        let rest_rule = RestRule::default();
        let mut system =
            Self { scene, layout, terms, curved: false, chords: Vec::new(), rest_rule };
        system.curved = system.nonlinear_term().is_some();
        Ok(system)
    }

    /// The same system with another rule for the command at rest.
    #[must_use]
    pub fn with_rest_rule(self, rest_rule: RestRule) -> Self {
        Self { rest_rule, ..self }
    }

    /// The scene this system was made of.
    pub fn scene(&self) -> &ModelScene {
        &self.scene
    }

    /// The augmented state at t = 0, and the inputs' first spans.
    pub(crate) fn start(&self) -> ([f64; MOST], Cursor) {
        let mut z = [0.0; MOST];
        z[THETA] = self.scene.start.theta_rad;
        z[OMEGA] = self.scene.start.theta_dot_rad_s;
        z[self.layout.one()] = 1.0;
        let term = self.scene.terms.input().map(|input| (0, input.span(0)));
        let force = (0, self.scene.input.span(0));
        let mut cursor = Cursor { force, term, end_s: f64::NEG_INFINITY };
        self.pass(&mut cursor, 0.0, &mut z);
        (z, cursor)
    }

    /// Moves the cursor to the spans that hold from `t` on and writes the inputs at `t` into `z`.
    /// True if an input jumps there.
    #[inline]
    pub(crate) fn pass(&self, cursor: &mut Cursor, t: f64, z: &mut [f64]) -> bool {
        /// Relative size of a step in a signal that counts as a jump.
        const JUMP: f64 = 1e-12;
        let old = self.inputs(z);
        cursor.force = forward(&self.scene.input, cursor.force, t);
        cursor.end_s = cursor.force.1.end_s;
        if let Some(at) = &mut cursor.term
            && let Some(input) = self.scene.terms.input()
        {
            *at = forward(input, *at, t);
            cursor.end_s = cursor.end_s.min(at.1.end_s);
        }
        self.write_inputs(cursor, t, z);
        // More than the rounding between the end of one span and the start of the next.
        old.iter().zip(self.inputs(z)).any(|(a, b)| (a - b).abs() > JUMP * (a.abs() + b.abs()))
    }

    /// The inputs at `t`, within the cursor's spans, from their closed forms.
    #[inline]
    pub(crate) fn write_inputs(&self, cursor: &Cursor, t: f64, z: &mut [f64]) {
        let at = self.layout.force;
        z[at..at + 2].copy_from_slice(&self.scene.input.at(&cursor.force.1, t));
        if let (Some(at), Some((_, span))) = (self.layout.term, &cursor.term)
            && let Some(input) = self.scene.terms.input()
        {
            z[at..at + 2].copy_from_slice(&input.at(span, t));
        }
    }

    fn inputs(&self, z: &[f64]) -> [f64; 2] {
        [z[self.layout.force], self.layout.term.map_or(0.0, |at| z[at])]
    }

    /// The error of a run whose state left the numbers at a time, s.
    pub(crate) fn not_finite(&self, t_s: f64) -> DynamicsError {
        DynamicsError::NotFinite { t_s, suspect: self.scene.suspect() }
    }

    /// The error of a run that reached a limit of work at a time, s.
    pub(crate) fn too_much(&self, limit: u64, what: &'static str, t_s: f64) -> DynamicsError {
        DynamicsError::TooMuchWork { limit, what, t_s, suspect: self.scene.suspect() }
    }

    /// True if an input is a sine.
    pub(crate) fn swings(&self) -> bool {
        let term = self.scene.terms.input().map_or(0.0, |input| input.swing().0);
        self.scene.input.swing().0 > 0.0 || term > 0.0
    }

    /// `value` as a functional.
    pub(crate) fn constant(&self, value: f64) -> Row {
        Row::entry(self.layout.one(), value)
    }

    /// M_O L: what a force at the lever's end accelerates, kg m.
    pub(crate) fn inertia(&self) -> f64 {
        self.scene.plant.mass_kg * self.scene.plant.lever_m
    }
}
