//! How the twin's sensors see the plant.

use crate::participant::draw::Draw;
use std::f64::consts::TAU;

/// Turns of the shaft in one turn of the lever: 75 mm on 11 mm (thesis §4.2).
pub const SHAFT_PER_LEVER: f64 = 75.0 / 11.0;
/// Counts of the AS5600 in one turn of the shaft: 12 bit.
pub const COUNTS_PER_TURN: u32 = 4096;
/// Values a second of the HX711 at its faster setting, Hz (thesis Table 4).
pub(crate) const FORCE_RATE_HZ: f64 = 80.0;

/// AS5600: the shaft's angle in counts, from where the magnet happens to sit; whole turns are lost.
#[derive(Debug, Clone, Copy)]
pub(super) struct AngleSensor {
    zero: f64,
    pub(super) counts: u16,
    pub(super) taken_s: f64,
}

impl AngleSensor {
    /// `zero`: counts at θ = 0, where the magnet happens to sit on the shaft.
    pub(super) fn new(zero: f64) -> Self {
        Self { zero, counts: 0, taken_s: 0.0 }
    }

    pub(super) fn take(&mut self, now_s: f64, theta_rad: f64) {
        (self.counts, self.taken_s) = (self.see(theta_rad), now_s);
    }

    fn see(&self, theta_rad: f64) -> u16 {
        let counts =
            (theta_rad * SHAFT_PER_LEVER / TAU * f64::from(COUNTS_PER_TURN) + self.zero).floor();
        counts.rem_euclid(f64::from(COUNTS_PER_TURN)) as u16
    }
}

/// Load cell and HX711: a noisy value that is held until the next.
#[derive(Debug, Clone)]
pub(super) struct ForceSensor {
    noise_n: f64,
    noise: Draw,
    pub(super) value_n: f64,
    pub(super) taken_s: f64,
}

impl ForceSensor {
    pub(super) fn new(noise_n: f64, noise: Draw, now_s: f64) -> Self {
        let mut sensor = Self { noise_n, noise, value_n: 0.0, taken_s: now_s };
        // A value from the beginning on, as the HX711 holds its last one.
        sensor.take(now_s, 0.0);
        sensor
    }

    pub(super) fn take(&mut self, now_s: f64, force_n: f64) {
        (self.value_n, self.taken_s) = (force_n + self.noise_n * self.noise.normal(), now_s);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_4;

    #[test]
    fn the_stroke_is_1_7_turns_and_a_count_is_0_0129_degrees() {
        let wraps = |zero| {
            let sensor = AngleSensor::new(zero);
            let counts: Vec<u16> =
                (-1000..=1000).map(|i| sensor.see(FRAC_PI_4 * f64::from(i) / 1e3)).collect();
            counts.windows(2).filter(|pair| pair[1] < pair[0]).count()
        };
        assert_eq!((wraps(0.5), wraps(1024.0)), (1, 2));
        let sensor = AngleSensor::new(0.5);
        let count_deg = 360.0 / f64::from(COUNTS_PER_TURN) / SHAFT_PER_LEVER;
        assert!((count_deg - 0.0129).abs() < 1e-4);
        assert_eq!(sensor.see(0.0), 0);
        assert_eq!(sensor.see((count_deg * 1.01).to_radians()), 1);
        assert_eq!(sensor.see((-count_deg).to_radians()), 4095);
    }
}
