//! `[[metrics]]` of a `study.toml`: metrics of a study's own, each by a rule.

use crate::words::words;
use crate::{Better, MetricId};
use serde::{Deserialize, Serialize};

/// A metric of a study's own: one number of one quantity over one part of a trial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
// What was expected is told in the same words as for [`crate::Design`].
#[serde(deny_unknown_fields, expecting = "struct OwnMetricTable")]
pub struct OwnMetric {
    /// Its name: the column's in the table of metrics.
    pub id: MetricId,
    /// The quantity: a channel of the study, or one of [`Self::COLUMNS`].
    pub of: String,
    /// What is computed of it.
    pub statistic: Statistic,
    /// Over which part of the trial.
    #[serde(default = "recording")]
    pub over: TrialPart,
    /// What people call it.
    pub label: String,
    /// Its unit, which follows from those of the quantity and of the statistic.
    pub unit: String,
    /// Which values are better.
    #[serde(default = "neither")]
    pub better: Better,
}

fn recording() -> TrialPart {
    TrialPart::Recording
}

fn neither() -> Better {
    Better::Neither
}

words! {
    /// What is computed of a quantity. Between samples it is taken as straight lines.
    Statistic {
        /// ∫ y dt / Δt.
        Mean = "mean",
        /// √(∫ y² dt / Δt).
        Rms = "rms",
        /// √(∫ (y − mean)² dt / Δt).
        Sd = "sd",
        /// The smallest sample.
        Min = "min",
        /// The largest sample.
        Max = "max",
        /// The largest |y| of a sample.
        MaxAbs = "max_abs",
        /// The largest sample less the smallest.
        Range = "range",
        /// ∫ |dy|: every way up and down.
        Path = "path",
        /// ∫ y dt.
        Integral = "integral",
        /// Time from the part's first sample to the first of its largest ones.
        TimeToMax = "time_to_max",
    }

    /// A part of a trial.
    TrialPart {
        /// From its first sample to its last.
        Recording = "recording",
        /// From onset to end.
        Movement = "movement",
        /// From onset to reversal.
        Compression = "compression",
        /// From reversal to end.
        Decompression = "decompression",
        /// Where the angle lies past the wall.
        PastWall = "past_wall",
    }
}

impl OwnMetric {
    /// The columns of trial files that a metric can be of, and their units.
    pub const COLUMNS: [(&str, &str); 8] = [
        ("theta_rad", "rad"),
        ("theta_dot_rad_s", "rad/s"),
        ("theta_ddot_rad_s2", "rad/s²"),
        ("force_ex_n", "N"),
        ("torque_ex_nm", "N·m"),
        ("voltage_motor_v", "V"),
        ("voltage_brake_v", "V"),
        ("force_cmd_n", "N"),
    ];

    /// Its rule in words: `maximum of grip_n from onset to end`.
    pub fn rule(&self) -> String {
        let statistic = match self.statistic {
            Statistic::Mean => "mean over time",
            Statistic::Rms => "root mean square over time",
            Statistic::Sd => "standard deviation over time",
            Statistic::Min => "minimum",
            Statistic::Max => "maximum",
            Statistic::MaxAbs => "largest magnitude",
            Statistic::Range => "maximum less minimum",
            Statistic::Path => "sum of all changes, up and down,",
            Statistic::Integral => "integral over time",
            Statistic::TimeToMax => "time to the maximum",
        };
        let part = match self.over {
            TrialPart::Recording => "over the recording",
            TrialPart::Movement => "from onset to end",
            TrialPart::Compression => "from onset to reversal",
            TrialPart::Decompression => "from reversal to end",
            TrialPart::PastWall => "past the wall",
        };
        format!("{statistic} of {} {part}", self.of)
    }

    /// Whether it describes something that a person could feel and whose threshold is known: a value of
    /// the angle or of the user's force. What a channel measures nobody knows here.
    pub fn is_felt(&self) -> bool {
        use Statistic::{Max, MaxAbs, Mean, Min, Range};
        ["theta_rad", "force_ex_n"].contains(&self.of.as_str())
            && [Mean, Min, Max, MaxAbs, Range].contains(&self.statistic)
    }
}
