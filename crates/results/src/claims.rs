//! What a study says about the thesis' claims, and facts of its device.

use crate::row::rows;
use crate::sentence::Sentence;
use crate::value::words;

words! {
    /// What a study's numbers say of a claim.
    ClaimVerdict {
        /// The whole interval lies in what is asked for.
        Supported = "supported",
        /// None of it does.
        Contradicted = "contradicted",
        /// There are numbers, and they leave it open.
        Undecided = "undecided",
        /// There are none.
        NotMeasured = "not measured",
    }
}

impl ClaimVerdict {
    /// The verdict of what is known without an error.
    pub fn of(supported: bool) -> Self {
        if supported { Self::Supported } else { Self::Contradicted }
    }
}

rows! {
    /// A statement of the thesis, judged.
    JudgedStatement = "thesis", "The thesis' statements, judged by this study" {
        /// the statement's word
        key: String,
        /// where the thesis has it
        source: String,
        /// what the thesis says, in short
        statement: String,
        /// what this study says of it
        verdict: ClaimVerdict,
        /// this study's number
        metric: Option<String>,
        /// its value, in the unit beside it
        value: Option<f64>,
        /// lower end of its interval
        ci_low: Option<f64>,
        /// upper end of its interval
        ci_high: Option<f64>,
        /// their unit
        unit: Option<String>,
        /// units of analysis
        n: Option<usize>,
        /// what n counts
        unit_of_analysis: Option<String>,
        /// what the value must be, and why
        asked: Option<Sentence>,
        /// the figure or table that shows it
        shown: Option<String>,
        /// what is to be said of it, or why it is not measured
        remark: Option<Sentence>,
    }

    /// A pro or a con of an actuator, beside what the study knows of it.
    ProOrCon = "pros_cons", "Pros and cons of brake and motor, beside this study" {
        /// brake alone or motor alone
        actuation: String,
        /// pro or con
        side: String,
        /// the thesis' Table 1
        claim: String,
        /// the study's own
        metric: Option<String>,
        /// its value, in the unit beside it
        value: Option<f64>,
        /// its unit
        unit: Option<String>,
        /// what the metric says of the claim
        verdict: ClaimVerdict,
        /// with what it is compared
        remark: Option<Sentence>,
    }

    /// Motor and brake as a mode uses them.
    ModeForces = "modes", "Motor and brake as each mode uses them" {
        /// how it is rendered
        mode: String,
        /// highest motor voltage used
        motor_max_v: Option<f64> = "V",
        /// highest brake voltage used
        brake_max_v: Option<f64> = "V",
        /// what acts while compressing
        compressing: Option<String>,
        /// its largest force against the push
        compressing_max_n: Option<f64> = "N",
        /// what acts while holding or decompressing
        decompressing: Option<String>,
        /// its largest force
        decompressing_max_n: Option<f64> = "N",
    }

    /// A component of the device.
    Component = "components", "Components" {
        /// what it is
        component: String,
        /// what it does
        function: String,
        /// highest voltage that a mode uses
        voltage_max_v or absent: Option<f64> = "V",
        /// its mass
        mass_kg or absent: Option<f64> = "kg",
        /// resistance of its winding
        resistance_ohm or absent: Option<f64> = "Ω",
        /// new values per second
        rate_hz or absent: Option<f64> = "Hz",
    }

    /// A single fact: a quantity with its own unit.
    Fact = "facts", "Facts" {
        /// what it is
        quantity: String,
        /// its value, in the unit beside it
        value: Option<f64>,
        /// its unit
        unit: Option<String>,
        /// the number that the thesis prints, in the same unit
        thesis or absent: Option<f64>,
        /// what is to be said of it
        remark or absent: Option<Sentence>,
    }
}

impl Fact {
    /// A quantity; a unit of no letters is none.
    pub fn new(quantity: impl Into<String>, value: Option<f64>, unit: &str) -> Self {
        let unit = (!unit.is_empty()).then(|| unit.to_owned());
        Self { quantity: quantity.into(), value, unit, thesis: None, remark: None }
    }

    /// The same with a remark.
    #[must_use]
    pub fn remarked(self, remark: impl Into<Sentence>) -> Self {
        Self { remark: Some(remark.into()), ..self }
    }

    /// The same beside the number that the thesis prints.
    #[must_use]
    pub fn printed(self, value: f64) -> Self {
        Self { thesis: Some(value), ..self }
    }
}
