//! Closed forms from the literature for the stiffest wall. Each leaves something out.

use super::SampledWall;

/// What dry friction and the angle's counts add to a device.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DryLimits {
    /// f_c: Coulomb friction, N.
    pub friction_n: f64,
    /// Δ: one count of the position, m.
    pub count_m: f64,
}

/// A formula.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Textbook {
    /// b > K T/2 + |B|, passivity.
    ColgateSchenkel,
    /// (b + B) > K (T/2 + delay), stability for a mass that is not light.
    Delay,
    /// K ≤ min(2 b/T, 2 f_c/Δ), passivity with friction and counts.
    AbbottOkamura,
    /// K ≤ min(b/(T/2 + delay), 2 f_c/Δ).
    Diolaiti,
}

impl Textbook {
    /// Every formula.
    pub const ALL: [Self; 4] =
        [Self::ColgateSchenkel, Self::Delay, Self::AbbottOkamura, Self::Diolaiti];

    /// The formula as text.
    pub fn formula(self) -> &'static str {
        match self {
            Self::ColgateSchenkel => "K = 2 (b − |B|)/T",
            Self::Delay => "K = (b + B)/(T/2 + delay)",
            Self::AbbottOkamura => "K = min(2 b/T, 2 f_c/Δ)",
            Self::Diolaiti => "K = min(b/(T/2 + delay), 2 f_c/Δ)",
        }
    }

    /// Its source.
    pub fn citation(self) -> &'static str {
        match self {
            Self::ColgateSchenkel => {
                "Colgate & Schenkel 1997, Passivity of a class of sampled-data systems, J. Robotic \
                 Systems 14:37–47"
            }
            Self::Delay => {
                "Hulin, Albu-Schäffer & Hirzinger 2014, Passivity and stability boundaries for haptic \
                 systems with time delay, IEEE Trans. Control Systems Technology, \
                 doi:10.1109/TCST.2013.2283372 (their linear condition)"
            }
            Self::AbbottOkamura => {
                "Abbott & Okamura 2005, Effects of position quantization and sampling rate on \
                 virtual-wall passivity, IEEE Trans. Robotics 21:952"
            }
            Self::Diolaiti => {
                "Diolaiti, Niemeyer, Barbagli & Salisbury 2006, Stability of haptic rendering: \
                 discretization, quantization, time delay, and Coulomb effects, IEEE Trans. Robotics, \
                 doi:10.1109/TRO.2005.862487"
            }
        }
    }

    /// The stiffest wall by this formula, N/m; none if it gives no answer: for a delay if the
    /// formula has none, without friction and counts if the formula needs them, for a damped wall
    /// if the formula has no damping.
    pub fn stiffest(self, wall: &SampledWall, dry: Option<DryLimits>) -> Option<f64> {
        let b = wall.damping_ns_per_m;
        let wall_b = wall.wall_damping_ns_per_m;
        let half_s = 0.5 * wall.period_s;
        let delay_s = wall.delay_s;
        let by_counts = dry.map(|dry| 2.0 * dry.friction_n / dry.count_m);
        let late = delay_s > 0.0;
        let damped = wall_b.abs() > 0.0;
        let stiffness = match self {
            Self::ColgateSchenkel => (!late).then(|| (b - wall_b.abs()) / half_s),
            Self::Delay => Some((b + wall_b) / (half_s + delay_s)),
            Self::AbbottOkamura if late || damped => None,
            Self::AbbottOkamura => by_counts.map(|counts| (b / half_s).min(counts)),
            Self::Diolaiti if damped => None,
            Self::Diolaiti => by_counts.map(|counts| (b / (half_s + delay_s)).min(counts)),
        };
        stiffness.map(|stiffness| stiffness.max(0.0))
    }
}
