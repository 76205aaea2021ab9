//! A recorded trial as a device.

use crate::error::unable;
use crate::{Angle, Capabilities, Cue, Device, DeviceError, Reading};
use zwidth_study::{Extra, Sample, Source, Voltages};

/// Plays a recorded trial: lever and force as they were, whatever is commanded. In real time with
/// [`crate::RealClock`], at once with [`crate::SimulatedClock`].
///
/// Before its first row and past its last one, that row holds. In between, the latest row holds
/// until the next, and its age grows, so a gap in the recording is a gap here too.
///
/// The results were not measured in the condition that they are recorded for: their source is
/// [`Source::Twin`], whatever the recording's was, and everything made from them is marked as
/// simulated.
#[derive(Debug, Clone)]
pub struct Playback {
    capabilities: Capabilities,
    rows: Vec<Sample>,
    stop_rad: f64,
    began_s: f64,
    /// The row that stands.
    at: usize,
}

impl Playback {
    /// From a trial's rows. `stop_rad` is the work space's lower end.
    ///
    /// # Errors
    /// No rows, or times that do not rise.
    pub fn new(rows: Vec<Sample>, stop_rad: f64) -> Result<Self, DeviceError> {
        let remedy = "choose another trial";
        if rows.len() < 2 {
            return Err(unable("playback", "a trial of fewer than two samples", remedy));
        }
        if !rows.windows(2).all(|pair| pair[1].t_s > pair[0].t_s) {
            return Err(unable("playback", "a trial whose time does not rise", remedy));
        }
        let duration_s = rows[rows.len() - 1].t_s - rows[0].t_s;
        let capabilities = capabilities(rows.len() as f64 / duration_s);
        Ok(Self { capabilities, rows, stop_rad, began_s: 0.0, at: 0 })
    }
}

/// A playback drives nothing, so no voltage is too high for it and nothing of it needs watching.
fn capabilities(rate_hz: f64) -> Capabilities {
    Capabilities {
        name: format!("playback {}", env!("CARGO_PKG_VERSION")),
        rate_hz,
        force_rate_hz: crate::FORCE_RATE_HZ, // the HX711's, as every recording of ours was made
        counts_per_turn: None,
        shaft_per_lever: 1.0,
        motor_max_v: f64::INFINITY,
        brake_max_v: f64::INFINITY,
        watchdog_s: Some(0.0),
        shows_moments: false,
        source: Source::Twin,
        channels: Vec::new(),
    }
}

impl Device for Playback {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn home(&mut self, _now_s: f64) -> Result<Reading, DeviceError> {
        let angle = Angle::Lever(self.stop_rad);
        Ok(Reading {
            t_device_s: None,
            angle,
            angle_age_s: 0.0,
            force_n: 0.0,
            force_age_s: None,
            extra: Extra::default(),
        })
    }

    fn read(&mut self, now_s: f64) -> Result<Reading, DeviceError> {
        let t_s = now_s - self.began_s;
        while self.rows.get(self.at + 1).is_some_and(|next| next.t_s <= t_s) {
            self.at += 1;
        }
        let row = &self.rows[self.at];
        // The last row stays new, or the guard would trip on its age before the trial's limit.
        let played_out = self.at + 1 == self.rows.len();
        let age_s = if played_out { 0.0 } else { (t_s - row.t_s).max(0.0) };
        Ok(Reading {
            t_device_s: row.t_device_s,
            angle: Angle::Lever(row.theta_rad),
            angle_age_s: age_s,
            force_n: row.force_ex_n,
            force_age_s: row.force_age_s.map(|recorded_s| recorded_s + age_s),
            extra: row.extra,
        })
    }

    fn write(&mut self, _now_s: f64, _voltages: Voltages) -> Result<(), DeviceError> {
        Ok(())
    }

    fn begin(&mut self, now_s: f64, _cue: &Cue<'_>) {
        (self.began_s, self.at) = (now_s, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial::tests::{environment, sample};
    use zwidth_study::Scene;

    fn row(t_s: f64, theta_rad: f64, force_ex_n: f64) -> Sample {
        Sample { force_age_s: Some(0.002), ..sample(t_s, theta_rad, 0.0, force_ex_n) }
    }

    fn playback() -> Playback {
        Playback::new(vec![row(0.0, -0.7, 0.0), row(0.1, -0.5, 1.0), row(0.2, -0.4, 2.0)], -0.785)
            .unwrap()
    }

    #[test]
    fn each_row_stands_until_the_next_and_the_last_one_for_good() {
        let mut playback = playback();
        let environment = environment(Scene::None);
        for begin_s in [5.0, 7.0] {
            playback.begin(begin_s, &Cue { trial: 1, environment: &environment, limit_s: 4.0 });
            for (t_s, theta_rad, age_s) in
                [(0.0, -0.7, 0.0), (0.125, -0.5, 0.025), (0.5, -0.4, 0.0)]
            {
                let reading = playback.read(begin_s + t_s).unwrap();
                assert_eq!(reading.angle, Angle::Lever(theta_rad));
                assert!((reading.angle_age_s - age_s).abs() < 1e-9);
                assert!((reading.force_age_s.unwrap() - 0.002 - age_s).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn what_no_trial_can_be_is_refused() {
        assert!(Playback::new(vec![row(0.0, 0.0, 0.0)], 0.0).is_err());
        let back = vec![row(0.1, 0.0, 0.0), row(0.1, 0.0, 0.0)];
        let error = Playback::new(back, 0.0).unwrap_err().to_string();
        assert!(error.contains("does not rise"), "{error}");
    }
}
