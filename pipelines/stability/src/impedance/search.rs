//! One search for a boundary, push by push.

use zwidth_dynamics::{DriveMode, DynamicsError, Pushed};

/// What is searched: the stiffest wall of a damping that a mode renders after a push.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Probe {
    /// Which actuators render.
    pub mode: DriveMode,
    /// How deep in the wall the lever is let go of, m.
    pub push_m: f64,
    /// B, N s/m.
    pub damping_ns_per_m: f64,
    /// Number of the repeat, from 1.
    pub repeat: u32,
}

/// One stiffness that was tried.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tried {
    /// K, N/m.
    pub stiffness_n_per_m: f64,
    /// Half of the motion that went on, m.
    pub swing_m: f64,
    /// Whether it went on.
    pub goes_on: bool,
}

impl Tried {
    fn new(stiffness_n_per_m: f64, pushed: Pushed) -> Self {
        Self { stiffness_n_per_m, swing_m: pushed.swing_m, goes_on: pushed.goes_on }
    }
}

/// Why a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// The boundary lies between two stiffnesses that were tried.
    Boundary,
    /// An actuator saturated, or the guard stopped the push, before it oscillated: at least so
    /// stiff.
    Saturated,
    /// The stiffest wall that is tried did not oscillate either.
    Stiffest,
}

impl Ending {
    /// Every ending.
    pub const ALL: [Self; 3] = [Self::Boundary, Self::Saturated, Self::Stiffest];

    /// Its word in files.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Boundary => "boundary",
            Self::Saturated => "saturated",
            Self::Stiffest => "stiffest",
        }
    }
}

/// The result of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// What was tried, in order.
    pub tried: Vec<Tried>,
    /// Why it ended.
    pub ending: Ending,
}

impl Found {
    /// The stiffest wall that came to rest below every one that did not, and the softest that did
    /// not, N/m; none where no wall swung.
    pub fn bracket(&self) -> (f64, Option<f64>) {
        let swinging = self.tried.iter().filter(|t| t.goes_on);
        let high = swinging.map(|t| t.stiffness_n_per_m).reduce(f64::min);
        // A wall that came to rest above a softer one that swung does not count: the boundary is
        // below it.
        let stiffnesses = self.tried.iter().map(|t| t.stiffness_n_per_m);
        let below = stiffnesses.filter(|k| high.is_none_or(|high| *k < high));
        (below.fold(0.0, f64::max), high)
    }
}

/// The probes of a test in the order in which they are made: mode by mode, push by push, damping by
/// damping.
pub fn probes(modes: &[DriveMode], pushes_m: &[f64], dampings: &[f64], repeats: u32) -> Vec<Probe> {
    let mut probes = Vec::new();
    for mode in modes {
        for push_m in pushes_m {
            for damping in dampings {
                probes.extend((1..=repeats).map(|repeat| Probe {
                    mode: *mode,
                    push_m: *push_m,
                    damping_ns_per_m: *damping,
                    repeat,
                }));
            }
        }
    }
    probes
}

/// A search, push by push: from a soft wall on each is stiffer by a third until a push goes on, an actuator saturates, or
/// the stiffest is reached; then bisection to 2 %.
#[derive(Debug, Clone, PartialEq)]
pub struct Search {
    tried: Vec<Tried>,
    /// The stiffest wall below all that swung, N/m.
    low: f64,
    /// The wall of the next push while walls are raised; then the softest that swung, N/m.
    high: f64,
    bisects: bool,
    ending: Option<Ending>,
}

impl Default for Search {
    fn default() -> Self {
        Self { tried: Vec::new(), low: 0.0, high: STIFFNESS[0], bisects: false, ending: None }
    }
}

impl Search {
    /// The stiffness of the next push, N/m.
    ///
    /// # Errors
    /// Why nothing is left to try.
    pub fn next_n_per_m(&self) -> Result<f64, Ending> {
        let next = if self.bisects { 0.5 * (self.low + self.high) } else { self.high };
        self.ending.map_or(Ok(next), Err)
    }

    /// What a push against that wall did.
    pub fn take(&mut self, pushed: Pushed) {
        let Ok(stiffness) = self.next_n_per_m() else { return };
        self.tried.push(Tried::new(stiffness, pushed));
        match (self.bisects, pushed.goes_on) {
            (_, true) => (self.bisects, self.high) = (true, stiffness),
            (true, false) => self.low = stiffness,
            (false, false) if pushed.saturates => self.ending = Some(Ending::Saturated),
            (false, false) if stiffness >= STIFFNESS[1] => self.ending = Some(Ending::Stiffest),
            (false, false) => {
                (self.low, self.high) = (stiffness, (RAISE * stiffness).min(STIFFNESS[1]));
            }
        }
        if self.bisects && self.high - self.low <= CLOSE * self.high {
            self.ending = Some(Ending::Boundary);
        }
    }

    /// What was found; none before its end.
    pub fn found(self) -> Option<Found> {
        Some(Found { ending: self.ending?, tried: self.tried })
    }
}

/// Walls that are tried, from and to, N/m.
const STIFFNESS: [f64; 2] = [20.0, 50_000.0];
const RAISE: f64 = 4.0 / 3.0;
/// Width of the bracket, as a share of it.
const CLOSE: f64 = 0.02;

/// A whole search; `push` makes one push.
///
/// # Errors
/// A push that fails.
pub fn search(
    mut push: impl FnMut(f64) -> Result<Pushed, DynamicsError>,
) -> Result<Found, DynamicsError> {
    let mut search = Search::default();
    loop {
        match search.next_n_per_m() {
            Ok(stiffness) => search.take(push(stiffness)?),
            Err(ending) => return Ok(Found { tried: search.tried, ending }),
        }
    }
}
