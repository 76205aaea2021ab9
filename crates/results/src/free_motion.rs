//! What the stage `freemotion` finds: the device itself, from each trial in which nothing was
//! rendered.

use crate::row::{of_trial, one_row, rows};

/// The columns of every fit: which trial, and what any of them estimates.
macro_rules! of_fit {
    ($head:tt $($fields:tt)*) => {
        one_row! {
            $head
            ..of_trial,
            /// offset c: estimate
            offset_nm: f64 = "N·m",
            /// offset c: standard error (Newey-West, a tenth of the recording)
            offset_std_error_nm: f64 = "N·m",
            /// offset c: lower end of the interval within this recording
            offset_ci_low_nm: f64 = "N·m",
            /// offset c: upper end of the interval within this recording
            offset_ci_high_nm: f64 = "N·m",
            /// inertia I: estimate
            inertia_kg_m2: f64 = "kg·m²",
            /// inertia I: standard error (Newey-West, a tenth of the recording)
            inertia_std_error_kg_m2: f64 = "kg·m²",
            /// inertia I: lower end of the interval within this recording
            inertia_ci_low_kg_m2: f64 = "kg·m²",
            /// inertia I: upper end of the interval within this recording
            inertia_ci_high_kg_m2: f64 = "kg·m²",
            /// damping b: estimate
            damping_nm_s_per_rad: f64 = "N·m·s/rad",
            /// damping b: standard error (Newey-West, a tenth of the recording)
            damping_std_error_nm_s_per_rad: f64 = "N·m·s/rad",
            /// damping b: lower end of the interval within this recording
            damping_ci_low_nm_s_per_rad: f64 = "N·m·s/rad",
            /// damping b: upper end of the interval within this recording
            damping_ci_high_nm_s_per_rad: f64 = "N·m·s/rad",
            $($fields)*
        }
    };
}

rows! {
    /// The plane through a trial with an acceleration: torque = c + I·acceleration + b·velocity.
    FreePlane =
        "free_motion",
        "Plane fits of free motion: torque = c + I·acceleration + b·velocity"
    {
        ..of_fit,
        /// R² of the plane
        r2: Option<f64>,
        /// RMS of the residuals
        rms_nm: f64 = "N·m",
        /// samples of the fit
        samples: usize,
        /// lags of the covariance, samples
        lags: usize,
        /// the lags in time
        bandwidth_s: f64 = "s",
    }

    /// The plant through a trial with an angle.
    FreePlant =
        "plant",
        "The plant in free motion: torque = c + I·acceleration + b·velocity + friction·direction + stiffness·angle"
    {
        ..of_fit,
        /// dry friction: estimate
        friction_nm: f64 = "N·m",
        /// dry friction: standard error (Newey-West, a tenth of the recording)
        friction_std_error_nm: f64 = "N·m",
        /// dry friction: lower end of the interval within this recording
        friction_ci_low_nm: f64 = "N·m",
        /// dry friction: upper end of the interval within this recording
        friction_ci_high_nm: f64 = "N·m",
        /// stiffness: estimate
        stiffness_nm_per_rad: f64 = "N·m/rad",
        /// stiffness: standard error (Newey-West, a tenth of the recording)
        stiffness_std_error_nm_per_rad: f64 = "N·m/rad",
        /// stiffness: lower end of the interval within this recording
        stiffness_ci_low_nm_per_rad: f64 = "N·m/rad",
        /// stiffness: upper end of the interval within this recording
        stiffness_ci_high_nm_per_rad: f64 = "N·m/rad",
        /// R² of the fit
        r2: Option<f64>,
        /// RMS of the residuals
        rms_nm: f64 = "N·m",
        /// slipping stretches of the fit
        samples: usize,
        /// lags of the covariance, stretches
        lags: usize,
        /// the lags in time
        bandwidth_s: f64 = "s",
    }
}
