//! What the stage `replay` finds: recorded trials through the model, and how far it departs.

use crate::column::UNIT_OF_ROW;
use crate::row::{of_trial, rows};
use crate::sentence::Sentence;
use crate::value::words;
use std::sync::Arc;
use zwidth_study::{EnvironmentId, ModeId, ParticipantId, SessionId, Source};

words! {
    /// What goes into the model, and what comes out.
    Causality {
        /// F_ex in, θ out: environment, actuators and their switching are the model's own (Fig. 24).
        ForceDriven = "force_driven",
        /// θ in, F_ex out: the force the recorded motion needs. θ̇ and θ̈ are central differences.
        PositionDriven = "position_driven",
        /// F_ex and the recorded commands of the actuators in, θ out: neither environment nor
        /// switching is modelled, only the plant.
        ClosedLoop = "closed_loop",
    }
    /// Whose plant a model has.
    ModelPlant {
        /// The thesis', chosen by eye.
        ByEye = "by_eye",
        /// The study's, fitted to half of its trials.
        Fitted = "fitted",
        /// That of the terms which the condition needs, as the ladder found, fitted by it.
        Auto = "auto",
    }
    /// What came of a replay.
    ReplayOutcome {
        /// The model ran to the end.
        Replayed = "replayed",
        /// The model's state left the finite numbers or the work limit, or its lever turned by more
        /// than 10 rad; it is compared with nothing.
        Diverged = "diverged",
        /// Fewer than three samples.
        TooShort = "too_short",
        /// No θ.
        NoAngle = "no_angle",
        /// No F_ex.
        NoForce = "no_force",
        /// No L.
        NoLever = "no_lever",
        /// No voltages of an actuator that the mode uses.
        NoVoltages = "no_voltages",
        /// No calibration, so that what the actuators can give is not known.
        NoCalibration = "no_calibration",
        /// The environment was rendered with a delay, which the model does not have.
        Delayed = "delayed",
        /// A questionnaire, or anything else that no device rendered.
        NotRendered = "not_rendered",
    }
    /// What a course is of.
    CourseSeries {
        /// What was recorded.
        Recorded = "recorded",
        /// The model with the thesis' plant.
        ByEye = "by_eye",
        /// The model with the study's.
        Fitted = "fitted",
    }
    /// What of model and recording is compared, one value a trial.
    AgreementOf {
        /// The largest angle.
        PeakAngle = "peak angle",
        /// The largest force.
        PeakForce = "peak force",
        /// When it is reached.
        PeakTime = "time of the peak",
        /// When the lever turns back.
        ReversalTime = "time of the reversal",
    }
    /// Whether model and recording agree within a bound.
    AgreementVerdict {
        /// Both limits are within the bound.
        Alike = "alike",
        /// The bias is beyond it.
        Off = "off",
        /// The bias is within it and a limit beyond.
        Scattered = "scattered",
        /// There are no limits, or there is no bound.
        TooFew = "too few",
    }
}

rows! {
    /// Which model a row of replays is of.
    ReplayedModel = "replay", "Replay: recorded trials through the model" {
        /// what went into the model and what came out
        causality: Causality,
        /// whose plant: by_eye, the thesis'; fitted, this study's
        model: ModelPlant,
    }

    /// A sample of a recorded trial, or of a model that was given its external force.
    CourseSample = "courses", "Recorded trials and their models against time" {
        /// number of the trial in the session
        trial: u32,
        /// how it was rendered
        mode: ModeId,
        /// recorded, twin or imported
        source: Source,
        /// recorded, or the model: by eye or fitted
        series: CourseSeries,
        /// time since the first sample
        t_s: f64 = "s",
        /// lever angle
        theta_rad: f64 = "rad",
        /// lever velocity
        theta_dot_rad_s: f64 = "rad/s",
        /// the user's force, which drives the model
        force_ex_n: f64 = "N",
        /// force of the actuators against the user
        feedback_n: Option<f64> = "N",
    }

    /// The angle of a recorded trial at a time, or that of the model with a plant.
    PlantRun = "runs", "Recorded trials through the model over its parameters" {
        /// number of the trial in the session
        trial: u32,
        /// how it was rendered
        mode: ModeId,
        /// recorded, twin or imported
        source: Source,
        /// mass of the model; null: recorded
        mass_kg: Option<f64> = "kg",
        /// its damping
        damping_ns_per_rad: Option<f64> = "N·s/rad",
        /// its friction in motion
        friction_n: Option<f64> = "N",
        /// RMS error of the angle over all samples
        rmse_rad: Option<f64> = "rad",
        /// time since the first sample
        t_s: f64 = "s",
        /// lever angle
        theta_rad: f64 = "rad",
    }

    /// Whether a recorded trial oscillates, where that comes from, and what the answer rests on.
    TrialOscillation = "oscillations", "Oscillations of recorded trials" {
        /// who
        participant: ParticipantId,
        /// which session
        session: SessionId,
        /// number of the trial in the session
        trial: u32,
        /// what was rendered
        environment: EnvironmentId,
        /// how it was rendered
        mode: ModeId,
        /// recorded, twin or imported
        source: Source,
        /// whether the recorded oscillation is the device's own
        answer: String,
        /// why
        why: Sentence,
        /// half the peak-to-peak angle of the least swing
        bound_rad: f64 = "rad",
        /// recorded swings in a row
        swings: Option<usize>,
        /// when they begin, since the first sample
        from_s: Option<f64> = "s",
        /// when they end
        to_s: Option<f64> = "s",
        /// their median half peak-to-peak
        amplitude_rad: Option<f64> = "rad",
        /// their frequency
        frequency_hz: Option<f64> = "Hz",
        /// of the model with the user's force
        with_force_amplitude_rad: Option<f64> = "rad",
        /// its frequency
        with_force_frequency_hz: Option<f64> = "Hz",
        /// of the model with the force's slow part
        alone_amplitude_rad: Option<f64> = "rad",
        /// its frequency
        alone_frequency_hz: Option<f64> = "Hz",
        /// the same by a step of a quarter tick
        stepped_amplitude_rad: Option<f64> = "rad",
        /// by half of that step
        half_step_amplitude_rad: Option<f64> = "rad",
        /// by a quarter of it
        quarter_step_amplitude_rad: Option<f64> = "rad",
        /// what the model's motion is with the force's slow part
        nature: Option<String>,
        /// above 0 the user's force feeds the swing
        power_factor: Option<f64>,
    }

    /// A trial through a model in one causality. Null where it does not apply, and for a model that
    /// diverged: the outcome says which.
    ReplayedTrial = "replay", "Replay: recorded trials through the model" {
        ..of_trial,
        /// what went into the model and what came out
        causality: Causality,
        /// whose plant: by_eye, the thesis'; fitted, this study's
        model: ModelPlant,
        /// replayed, diverged, or why it does not apply
        outcome: ReplayOutcome,
        /// the model's mass at the lever's end
        mass_kg: f64 = "kg",
        /// the model's viscous damping there
        damping_n_s_per_rad: f64 = "N·s/rad",
        /// the model's dry friction there
        friction_n: f64 = "N",
        /// root mean square error over the recording's range
        nrmse: Option<f64>,
        /// variance accounted for: 1 - var(error) / var(recording)
        vaf: Option<f64>,
        /// by how much the model comes later, where the cross-correlation is highest
        lag_s: Option<f64> = "s",
        /// root mean square error of the angle
        rmse_rad: Option<f64> = "rad",
        /// root mean square error of the force
        rmse_n: Option<f64> = "N",
        /// largest recorded angle
        peak_recorded_rad: Option<f64> = "rad",
        /// the model's largest angle less it
        peak_error_rad: Option<f64> = "rad",
        /// largest recorded force
        peak_recorded_n: Option<f64> = "N",
        /// the model's largest force less it
        peak_error_n: Option<f64> = "N",
        /// first time of the recording's largest angle or force
        peak_time_recorded_s: Option<f64> = "s",
        /// that of the model less it
        peak_time_error_s: Option<f64> = "s",
        /// root mean square error of the velocity
        velocity_rmse_rad_s: Option<f64> = "rad/s",
        /// that over the recorded velocity's range
        velocity_nrmse: Option<f64>,
        /// SD of the model's velocity over that of the recorded one
        velocity_sd_ratio: Option<f64>,
        /// first time of the recording's largest angle, onset to end
        reversal_recorded_s: Option<f64> = "s",
        /// that of the model less it
        reversal_error_s: Option<f64> = "s",
    }

    /// Of a trial through a model what the agreement looks at: some columns of the same table.
    ReplayedPeak = "replay", "Replay: recorded trials through the model" {
        /// how it was rendered
        mode: ModeId,
        /// recorded, twin or imported
        source: Source,
        /// what went into the model and what came out
        causality: Causality,
        /// whose plant: by_eye, the thesis'; fitted, this study's
        model: ModelPlant,
        /// the model's largest angle less it
        peak_error_rad: Option<f64> = "rad",
        /// largest recorded force
        peak_recorded_n: Option<f64> = "N",
        /// the model's largest force less it
        peak_error_n: Option<f64> = "N",
        /// that of the model less it
        peak_time_error_s: Option<f64> = "s",
        /// that of the model less it
        reversal_error_s: Option<f64> = "s",
    }

    /// How far peaks and times of a model agree with those recorded (Bland and Altman).
    ReplayAgreement =
        "replay.agreement",
        "Agreement of replay and recording (Bland and Altman), one value per trial"
    {
        /// what went into the model and what came out
        causality: Causality,
        /// how it was rendered
        mode: ModeId,
        /// whose plant: by_eye, the thesis'; fitted, this study's
        model: ModelPlant,
        /// what is compared, one value per trial
        quantity: AgreementOf,
        /// unit of the numbers in this row
        unit: Arc<str>,
        /// trials
        n: usize,
        /// alike, off, scattered or too few: bias and limits against the bound
        verdict: AgreementVerdict,
        /// up to here a difference does not matter
        bound: Option<f64> = UNIT_OF_ROW,
        /// mean of model less recording
        bias: Option<f64> = UNIT_OF_ROW,
        /// lower end of its interval
        bias_ci_low: Option<f64> = UNIT_OF_ROW,
        /// upper end of its interval
        bias_ci_high: Option<f64> = UNIT_OF_ROW,
        /// lower limit of agreement, bias - 1.96 SD
        limit_low: Option<f64> = UNIT_OF_ROW,
        /// lower end of its interval
        limit_low_ci_low: Option<f64> = UNIT_OF_ROW,
        /// upper end of its interval
        limit_low_ci_high: Option<f64> = UNIT_OF_ROW,
        /// upper limit of agreement, bias + 1.96 SD
        limit_high: Option<f64> = UNIT_OF_ROW,
        /// lower end of its interval
        limit_high_ci_low: Option<f64> = UNIT_OF_ROW,
        /// upper end of its interval
        limit_high_ci_high: Option<f64> = UNIT_OF_ROW,
    }
}
