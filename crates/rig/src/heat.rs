//! How warm a winding gets by a sweep, and how long it must cool before the next.
//!
//! Copper of mass m takes in E = ∫ U²/R dt, and gives it off to what is around it with a time
//! constant τ: Ṫ = U²/(R m c) − T/τ. A sweep that goes in straight lines up to U₀ and down again in
//! a time t_s has E = U₀² t_s / (3 R). What goes off meanwhile is left out, so the winding is taken
//! to be warmer than it is.

use zwidth_device::Ramp;

/// Specific heat of copper at 25 °C, J/(kg K) (CRC Handbook of Chemistry and Physics).
const COPPER_J_PER_KG_K: f64 = 385.0;

/// How warm a winding may get above what is around it, K. Its resistance rises by 0.39 % per K, so
/// that a motor driven by voltage loses force; windings bear far more.
const MOST_RISE_K: f64 = 20.0;

/// The winding of an actuator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Winding {
    /// Its resistance, Ω.
    pub resistance_ohm: f64,
    /// Its mass, kg.
    pub mass_kg: f64,
    /// Time constant with which it cools, s.
    pub cooling_s: f64,
}

impl Winding {
    /// How much warmer ∫U² dt makes it, V² s, K.
    fn rise_k(&self, v2_s: f64) -> f64 {
        v2_s / self.resistance_ohm / (self.mass_kg * COPPER_J_PER_KG_K)
    }

    /// Whether ∫U² dt, V² s, warms it by no more than is allowed.
    pub fn bears(&self, v2_s: f64) -> bool {
        self.rise_k(v2_s) < MOST_RISE_K
    }

    /// Why no pause is long enough for a ramp, in words; none if one is.
    pub fn refuses(&self, ramp: &Ramp) -> Option<String> {
        let rise_k = self.rise_k(ramp.v2_s());
        (rise_k > MOST_RISE_K).then(|| {
            format!(
                "one sweep to {} V would warm the winding of the {} by {rise_k:.0} K, more than the {MOST_RISE_K} K allowed: \
                 give a lower voltage with --to, or correct [heat] in rig.toml",
                ramp.top_v,
                ramp.actuator.as_str()
            )
        })
    }
}

/// How warm a winding is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Heat {
    winding: Winding,
    rise_k: f64,
}

impl Heat {
    /// As warm as it may be, and since then so long at rest, s. How warm it was before nobody knows.
    pub fn at_most(winding: Winding, rested_s: f64) -> Self {
        let mut heat = Self { winding, rise_k: MOST_RISE_K };
        heat.rest(rested_s);
        heat
    }

    /// Time goes by without a voltage, s.
    pub fn rest(&mut self, for_s: f64) {
        self.rise_k *= libm::exp(-for_s.max(0.0) / self.winding.cooling_s);
    }

    /// It was driven with ∫U² dt, V² s.
    pub fn drive(&mut self, v2_s: f64) {
        self.rise_k += self.winding.rise_k(v2_s);
    }

    /// How long it must rest before ∫U² dt, V² s, in s: t = τ ln(T / (T_most − ΔT)). Infinite if that
    /// alone is too much.
    pub fn pause_s(&self, v2_s: f64) -> f64 {
        let room_k = MOST_RISE_K - self.winding.rise_k(v2_s);
        if room_k <= 0.0 {
            return f64::INFINITY;
        }
        (self.winding.cooling_s * libm::log(self.rise_k / room_k)).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_study::ActuatorKind;

    const WINDING: Winding = Winding { resistance_ohm: 30.4, mass_kg: 0.0132, cooling_s: 60.0 };
    const RAMP: Ramp = Ramp { actuator: ActuatorKind::Motor, top_v: 16.0, lasts_s: 8.0 };

    /// The integral of U²/R over the ramp by its own voltages, by the midpoint rule.
    #[test]
    fn a_ramp_brings_the_energy_of_its_voltages() {
        let steps = 100_000;
        let dt_s = RAMP.lasts_s / f64::from(steps);
        let power_w = |i: u32| {
            let voltage_v = RAMP.voltage_v((f64::from(i) + 0.5) * dt_s);
            voltage_v * voltage_v / WINDING.resistance_ohm
        };
        let energy_j: f64 = (0..steps).map(power_w).sum::<f64>() * dt_s;
        let rise_k = energy_j / (WINDING.mass_kg * 385.0);
        assert!((WINDING.rise_k(RAMP.v2_s()) - rise_k).abs() < 1e-6, "{rise_k}");
        assert!((rise_k - 4.42).abs() < 0.01, "{rise_k}");
    }

    #[test]
    fn after_its_pause_a_ramp_just_reaches_what_is_allowed() {
        let mut heat = Heat::at_most(WINDING, 0.0);
        for _ in 0..20 {
            let pause_s = heat.pause_s(RAMP.v2_s());
            heat.rest(pause_s);
            heat.drive(RAMP.v2_s());
            assert!((heat.rise_k - MOST_RISE_K).abs() < 1e-9, "{heat:?}");
        }
        assert!(Heat::at_most(WINDING, 1e6).pause_s(RAMP.v2_s()) <= 0.0);
    }

    #[test]
    fn a_ramp_that_alone_is_too_much_is_refused() {
        let small = Winding { mass_kg: 0.001, ..WINDING };
        assert!(small.refuses(&RAMP).unwrap().contains("--to"));
        assert!(Heat::at_most(small, 1e9).pause_s(RAMP.v2_s()).is_infinite());
        assert_eq!(WINDING.refuses(&RAMP), None);
        assert!(WINDING.bears(RAMP.v2_s()) && !small.bears(RAMP.v2_s()));
    }
}
