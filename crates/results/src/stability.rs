//! What the stage `stability` finds: which walls a sampled device can render by each limit,
//! boundaries that others measured, and the results of a Z-width test.

use crate::row::rows;
use crate::value::{texts, words};
use std::convert::Infallible;
use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

words! {
    /// A quantity of a device against a wall, over which a map is drawn.
    WallQuantity {
        /// h, the step of a solver.
        Step = "step",
        /// M_O, the mass at the lever's end.
        Mass = "mass",
        /// b, the device's own damping.
        Damping = "damping",
        /// B_O, the wall's damping.
        WallDamping = "wall_damping",
        /// K_O, the wall's stiffness.
        Stiffness = "stiffness",
        /// L, with stiffness and dampings in N/rad kept.
        Lever = "lever",
        /// K_F, the stiffness of a fingertip that rides on the lever.
        Finger = "finger",
        /// Delay from a measurement to its force.
        Delay = "delay",
        /// Rate of the controller.
        Rate = "rate",
    }
    /// A limit of the stiffest wall.
    WallLimit {
        /// The lifted map's spectral radius is 1: exact.
        LiftedMap = "lifted_map",
        /// The same, the loop simulated.
        Measured = "measured",
        /// The wall is passive with any hand.
        Passivity = "passivity",
        /// A step of RK4 is stable.
        Rk4 = "rk4_per_step",
        /// A step of symplectic Euler is stable.
        SymplecticEuler = "symplectic_euler",
        /// The closed form of Colgate & Schenkel.
        ColgateSchenkel = "colgate_schenkel",
        /// That of Hulin.
        Hulin = "hulin",
        /// That of Abbott & Okamura.
        AbbottOkamura = "abbott_okamura",
        /// That of Diolaiti.
        Diolaiti = "diolaiti",
    }
    /// What a limit is.
    LimitKind {
        /// Exact linear stability.
        Exact = "exact",
        /// Passivity.
        Passivity = "passivity",
        /// Of a solver's step.
        Method = "method",
        /// A closed form, an approximation.
        Textbook = "textbook",
        /// By a simulated loop.
        Measured = "measured",
        /// By somebody else's experiment.
        Others = "others",
    }
}

/// How a quantity stands on an axis.
struct Axis {
    label: &'static str,
    unit: &'static str,
    /// So many of the screen's units are one SI unit.
    per_si: f64,
    /// Ends of a usual axis, SI.
    usual: [f64; 2],
    is_logarithmic: bool,
}

impl WallQuantity {
    fn axis(self) -> Axis {
        let linear =
            |label, unit, per_si, usual| Axis { label, unit, per_si, usual, is_logarithmic: false };
        let logarithmic =
            |label, unit, per_si, usual| Axis { label, unit, per_si, usual, is_logarithmic: true };
        match self {
            Self::Step => logarithmic("step *h*", "ms", 1e3, [1e-4, 0.1]),
            Self::Mass => logarithmic("mass *M*_{O}", "kg", 1.0, [0.002, 2.0]),
            Self::Damping => logarithmic("device damping *b*", "N s/m", 1.0, [0.1, 20.0]),
            Self::WallDamping => linear("wall damping *B*", "N s/m", 1.0, [0.0, 20.0]),
            Self::Stiffness => logarithmic("wall stiffness *K*", "N/m", 1.0, [10.0, 30_000.0]),
            Self::Lever => logarithmic("lever *L*", "mm", 1e3, [0.01, 1.0]),
            Self::Finger => logarithmic("finger stiffness *K*_{F}", "N/m", 1.0, [10.0, 10_000.0]),
            Self::Delay => linear("delay", "ms", 1e3, [0.0, 0.05]),
            Self::Rate => logarithmic("rate", "Hz", 1.0, [50.0, 5000.0]),
        }
    }

    /// Its name on an axis, as markup.
    pub fn label(self) -> &'static str {
        self.axis().label
    }

    /// Its unit on screens.
    pub fn unit(self) -> &'static str {
        self.axis().unit
    }

    /// Its unit in tables.
    pub fn si_unit(self) -> &'static str {
        match self {
            Self::Step | Self::Delay => "s",
            Self::Lever => "m",
            others => others.unit(),
        }
    }

    /// So many of the screen's units are one SI unit.
    pub fn per_si(self) -> f64 {
        self.axis().per_si
    }

    /// Ends of a usual axis, SI.
    pub fn usual(self) -> [f64; 2] {
        self.axis().usual
    }

    /// Whether its axis is logarithmic.
    pub fn is_logarithmic(self) -> bool {
        self.axis().is_logarithmic
    }
}

/// What the line of a limit is called.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LimitName {
    /// One of those that are computed.
    Computed(WallLimit),
    /// A boundary that others measured, by its file.
    Others(Arc<str>),
}

impl fmt::Display for LimitName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Computed(limit) => f.pad(limit.as_str()),
            Self::Others(name) => f.pad(name),
        }
    }
}

impl FromStr for LimitName {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        let computed = WallLimit::from_word(text).map(Self::Computed);
        Ok(computed.unwrap_or_else(|| Self::Others(text.into())))
    }
}

texts!(LimitName);

/// The unit of what others measured, whose files need not state one.
const AS_MEASURED: &str = "as measured";

rows! {
    /// A cell of a map: where it is, and how far each limit is passed (above 1). The table calls the
    /// places after the quantities that run along the axes.
    WallCell = "cells", "Limits in the cells of a map" {
        /// place along x
        x: f64 = "SI",
        /// place along y
        y: f64 = "SI",
        /// spectral radius of the lifted map; stable below 1
        lifted_map: Option<f64>,
        /// damping that passivity asks for over the device's; passive below 1
        passivity: Option<f64>,
        /// growth of a step over the exact flow's; stable up to 1
        rk4_per_step: Option<f64>,
        /// growth of a step over the exact flow's; stable up to 1
        symplectic_euler: Option<f64>,
        /// stiffness over the stiffest by this formula, an approximation
        colgate_schenkel: Option<f64>,
        /// stiffness over the stiffest by this formula, an approximation
        hulin: Option<f64>,
        /// stiffness over the stiffest by this formula, an approximation
        abbott_okamura: Option<f64>,
        /// stiffness over the stiffest by this formula, an approximation
        diolaiti: Option<f64>,
    }

    /// A point of a limit's line on a map.
    LimitPoint = "stability", "Limits of a sampled wall" {
        /// what runs along x
        x_quantity: WallQuantity,
        /// what runs along y
        y_quantity: WallQuantity,
        /// the limit
        limit: LimitName,
        /// exact, passivity, method, textbook, measured or others (their measurement)
        kind: LimitKind,
        /// number of the line, where a limit has several
        piece: usize,
        /// place along x, in its SI unit
        x: f64 = "SI",
        /// place along y, in its SI unit
        y: f64 = "SI",
    }

    /// The stiffest wall by a limit, and its error against the exact one.
    StiffestWall = "limits", "The stiffest wall by every limit" {
        /// the limit
        limit: WallLimit,
        /// exact, passivity, textbook or measured
        kind: LimitKind,
        /// what it says
        equation: String,
        /// where it comes from
        source: String,
        /// the stiffest wall that it allows
        stiffness_n_per_m: Option<f64> = "N/m",
        /// its error against the exact one
        error_share: Option<f64>,
        /// it allows walls that are unstable
        is_unsafe: Option<bool>,
    }

    /// A boundary that others measured, and its extent.
    BoundaryExtent = "measured_by_others", "Boundaries measured by others" {
        /// the file
        boundary: String,
        /// largest stiffness at no damping
        stiffness_undamped: Option<f64> = AS_MEASURED,
        /// largest stiffness
        stiffness_largest: f64 = AS_MEASURED,
        /// its damping
        damping_of_largest: f64 = AS_MEASURED,
        /// least damping
        damping_from: f64 = AS_MEASURED,
        /// most damping
        damping_to: f64 = AS_MEASURED,
        /// integral of stiffness over damping, by trapezia
        area: f64 = AS_MEASURED,
        /// area over that of the rectangle of undamped stiffness and most damping
        fullness: Option<f64> = AS_MEASURED,
        /// whether units are N/m and N s/m
        is_si: bool,
    }

    /// The stiffest wall of a mode, a push and a damping, with its interval.
    WallBound = "impedance", "Stiffest wall without oscillation" {
        /// which actuators render
        mode: Arc<str>,
        /// how deep the lever was let go of
        push_m: f64 = "m",
        /// damping of the wall
        damping_ns_per_m: f64 = "N s/m",
        /// the stiffest wall that came to rest
        stiffness_n_per_m: f64 = "N/m",
        /// stiffest that came to rest in every repeat
        ci_low: f64 = "N/m",
        /// softest that swung in every repeat
        ci_high: f64 = "N/m",
        /// an actuator saturated before it swung: at least so stiff
        is_censored: bool,
        /// searches
        repeats: usize,
    }

    /// What a mode renders after a push: area, K_max(0), the largest K.
    ZWidth = "zwidth", "Z-width" {
        /// which actuators render
        mode: Arc<str>,
        /// how deep the lever was let go of
        push_m: f64 = "m",
        /// stiffest wall without damping
        stiffness_undamped_n_per_m: Option<f64> = "N/m",
        /// stiffest wall
        stiffness_largest_n_per_m: Option<f64> = "N/m",
        /// its damping
        damping_of_largest_ns_per_m: Option<f64> = "N s/m",
        /// areas are from 0 to this damping
        damping_end_ns_per_m: f64 = "N s/m",
        /// integral of stiffness over damping
        area_n2_s_per_m2: f64 = "N²·s/m²",
        /// of the intervals' lower ends
        area_low_n2_s_per_m2: f64 = "N²·s/m²",
        /// of their upper ends
        area_high_n2_s_per_m2: f64 = "N²·s/m²",
        /// areas and stiffnesses are at least so large
        is_censored: bool,
    }

    /// The impedance of a condition at a frequency, with its interval and coherence. Environment and
    /// mode are as the study calls them.
    ImpedancePoint = "frequency", "Impedance against frequency" {
        /// what was rendered
        environment: Arc<str>,
        /// how it was rendered
        mode: Arc<str>,
        /// frequency
        frequency_hz: f64 = "Hz",
        /// size of the impedance F/v
        magnitude_ns_per_m: f64 = "N s/m",
        /// lower end of its interval
        ci_low: Option<f64> = "N s/m",
        /// upper end
        ci_high: Option<f64> = "N s/m",
        /// its phase: a mass has a quarter turn, a spring minus that
        phase_rad: f64 = "rad",
        /// half of the phase's interval
        phase_half_interval_rad: Option<f64> = "rad",
        /// real part: damping
        real_ns_per_m: f64 = "N s/m",
        /// imaginary part: mass less stiffness
        imaginary_ns_per_m: f64 = "N s/m",
        /// share of the force that follows linearly from the velocity
        coherence: f64,
        /// coherence that chance alone stays below, at the intervals' level
        chance: f64,
        /// spectral density of the velocity
        velocity_density: f64 = "(m/s)²/Hz",
        /// of the force
        force_density: f64 = "N²/Hz",
        /// independent segments
        averages: f64,
        /// segments, which overlap by half
        segments: usize,
        /// samples of a segment
        segment_samples: usize,
        /// rate of the samples: the force sensor's
        rate_hz: f64 = "Hz",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::Row as _;

    #[test]
    fn a_limit_of_others_keeps_its_name_and_a_computed_one_is_known() {
        let point = |limit, kind| LimitPoint {
            x_quantity: WallQuantity::WallDamping,
            y_quantity: WallQuantity::Stiffness,
            limit,
            kind,
            piece: 1,
            x: 0.5,
            y: 300.0,
        };
        let rows = [
            point(LimitName::Computed(WallLimit::Hulin), LimitKind::Textbook),
            point(LimitName::Others("Colgate 1994".into()), LimitKind::Others),
        ];
        assert_eq!(LimitPoint::read(&LimitPoint::columns(&rows)).unwrap(), rows);
    }
}
