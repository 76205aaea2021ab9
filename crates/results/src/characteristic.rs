//! What the stage `characterise` finds: what an actuator or sensor does with its command. Units of
//! command and response are those of its sweeps, one of each for a whole table.

use crate::row::rows;
use crate::sentence::Sentence;
use crate::value::words;
use std::sync::Arc;

/// The unit of a column that is in the unit of the sweeps' command.
pub const UNIT_OF_COMMAND: &str = "unit of the command";
/// The unit of a column that is in the unit of the sweeps' response.
pub const UNIT_OF_RESPONSE: &str = "unit of the response";

words! {
    /// What became of a candidate model.
    CandidateVerdict {
        /// It is the one to use.
        Chosen = "chosen",
        /// Its residuals exceed the noise, or it predicts worse than the chosen one.
        Rejected = "rejected",
        /// It predicts no better than the chosen one, with more parameters.
        NotNeeded = "not needed",
        /// There are too few points for its parameters.
        NotFitted = "not fitted",
    }
    /// A candidate model, by number of free parameters.
    CurveModel {
        /// A straight line.
        Line = "line",
        /// Flat, then a straight line.
        Hinge = "hinge",
        /// Flat, a straight line, flat.
        Saturation = "saturation",
        /// Flat, then a power of the rest of the command.
        PowerLaw = "power_law",
        /// A straight line for each way of the command.
        LineUpDown = "line_up_down",
        /// A hinge for each way.
        HingeUpDown = "hinge_up_down",
        /// A monotone spline, which is no law.
        Spline = "spline",
        /// A saturation for each way.
        SaturationUpDown = "saturation_up_down",
        /// A power law for each way.
        PowerLawUpDown = "power_law_up_down",
        /// A spline for each way.
        SplineUpDown = "spline_up_down",
    }
    /// The curve of a model, of one way of the command or of both.
    CurveShape {
        /// A straight line.
        Line = "line",
        /// Flat, then a straight line.
        Hinge = "hinge",
        /// Flat, a straight line, flat.
        Saturation = "saturation",
        /// Flat, then a power of the rest of the command.
        PowerLaw = "power law",
        /// A monotone spline.
        Spline = "spline",
    }
    /// A parameter's symbol in the equation of its model.
    CurveSymbol {
        /// The response where the curve begins.
        A = "a",
        /// What the command is multiplied by.
        B = "b",
        /// The command at which the curve begins to rise; of a spline its first knot.
        X0 = "x0",
        /// The command at which the curve ends to rise; of a spline its last knot.
        X1 = "x1",
        /// The exponent.
        P = "p",
        /// A slope of the spline.
        S0 = "s0",
        /// A slope of the spline.
        S1 = "s1",
        /// A slope of the spline.
        S2 = "s2",
        /// A slope of the spline.
        S3 = "s3",
        /// A slope of the spline.
        S4 = "s4",
        /// A slope of the spline.
        S5 = "s5",
        /// A slope of the spline.
        S6 = "s6",
    }
    /// The way of the command that a curve is of.
    CommandWay {
        /// Both.
        Both = "both",
        /// The command rises.
        Up = "up",
        /// The command falls.
        Down = "down",
    }
}

impl CurveModel {
    /// Its curve.
    pub fn shape(self) -> CurveShape {
        match self {
            Self::Line | Self::LineUpDown => CurveShape::Line,
            Self::Hinge | Self::HingeUpDown => CurveShape::Hinge,
            Self::Saturation | Self::SaturationUpDown => CurveShape::Saturation,
            Self::PowerLaw | Self::PowerLawUpDown => CurveShape::PowerLaw,
            Self::Spline | Self::SplineUpDown => CurveShape::Spline,
        }
    }

    /// Whether rising and falling commands have a curve each.
    pub fn has_hysteresis(self) -> bool {
        !matches!(self, Self::Line | Self::Hinge | Self::Saturation | Self::PowerLaw | Self::Spline)
    }
}

rows! {
    /// A candidate model of an actuator or sensor.
    FittedModel = "characteristic", "Characteristic: candidate models" {
        /// candidate model
        model: CurveModel,
        /// its equation
        formula: String,
        /// root mean square of the residuals
        rms: Option<f64> = UNIT_OF_RESPONSE,
        /// root mean square error on what was left out of the fit
        left_out_rms: Option<f64> = UNIT_OF_RESPONSE,
        /// rms over the scatter that no curve explains
        rms_over_noise: Option<f64>,
        /// coefficient of determination R²
        r2: Option<f64>,
        /// of neighbouring residuals; near 0 for a fit that fits
        autocorrelation: Option<f64>,
        /// AICc on per-command bins; reported, not decisive
        aicc: Option<f64>,
        /// chosen or not
        verdict: CandidateVerdict,
        /// why
        reason: Sentence,
    }

    /// A parameter of a candidate model, with its bootstrap interval.
    FittedParameter = "parameters", "Characteristic: parameters" {
        /// candidate model
        model: CurveModel,
        /// symbol in the model's equation
        parameter: CurveSymbol,
        /// way of the command whose curve it belongs to
        branch: CommandWay,
        /// least-squares estimate, in `unit`
        estimate: f64,
        /// standard deviation over the bootstrap resamples
        std_error: Option<f64>,
        /// lower end of the bootstrap interval
        ci_low: Option<f64>,
        /// upper end of the bootstrap interval
        ci_high: Option<f64>,
        /// unit of the estimate
        unit: Arc<str>,
        /// what the number must not be taken for
        note: Option<Sentence>,
    }

    /// A point of the chosen curve, on an even grid of commands.
    CurvePoint = "curve", "Characteristic: fitted curve" {
        /// way of the command: up, down or both
        branch: CommandWay,
        /// command
        command: f64 = UNIT_OF_COMMAND,
        /// mean of all samples within half a step of the command
        mean: Option<f64> = UNIT_OF_RESPONSE,
        /// chosen model
        fit: f64 = UNIT_OF_RESPONSE,
        /// lower end of the band of the mean
        ci_low: f64 = UNIT_OF_RESPONSE,
        /// upper end of the band of the mean
        ci_high: f64 = UNIT_OF_RESPONSE,
        /// lower end of the band of a new response
        prediction_low: f64 = UNIT_OF_RESPONSE,
        /// upper end of the band of a new response
        prediction_high: f64 = UNIT_OF_RESPONSE,
        /// straight line over all samples, as in the thesis
        first_order: f64 = UNIT_OF_RESPONSE,
    }
}
