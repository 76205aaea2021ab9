//! What the answers to a task tell: its thresholds, and the metrics as which they are compared.

use crate::words::words;
use crate::{Asks, IdError, Method, MetricId, Study, Task};

words! {
    /// A number that the answers to a task tell.
    TaskQuantity {
        /// The point of subjective equality: where both answers are as likely.
        Pse = "pse",
        /// The threshold of detection, or the level at which a staircase settles.
        Threshold = "threshold",
        /// The just noticeable difference. People are compared by its natural logarithm, so that a difference is a ratio.
        Jnd = "jnd",
    }
}

/// Units by the ends of keys, longer ends before those that they end in.
const UNITS: [(&str, &str); 24] = [
    ("_n_per_rad", "N/rad"),
    ("_n_per_mm", "N/mm"),
    ("_n_per_m", "N/m"),
    ("_ns_per_rad", "N·s/rad"),
    ("_ns_per_m", "N·s/m"),
    ("_nm_per_rad", "N·m/rad"),
    ("_rad_per_s", "rad/s"),
    ("_rad_s", "rad/s"),
    ("_m_per_s", "m/s"),
    ("_m_s", "m/s"),
    ("_rad", "rad"),
    ("_deg", "°"),
    ("_nm", "N·m"),
    ("_hz", "Hz"),
    ("_kg", "kg"),
    ("_mm", "mm"),
    ("_um", "µm"),
    ("_ms", "ms"),
    ("_mn", "mN"),
    ("_m", "m"),
    ("_n", "N"),
    ("_s", "s"),
    ("_g", "g"),
    ("_v", "V"),
];

impl TaskQuantity {
    /// What stands before the unit of a JND in that of its metric: differences of logarithms are those of ratios.
    pub const LN: &str = "ln ";

    /// The unit of the numbers of whose logarithms a metric is, by its own unit.
    pub fn logarithm_of(unit: &str) -> Option<&str> {
        unit.strip_prefix(Self::LN)
    }

    /// What it is called, in a sentence.
    pub const fn in_words(self) -> &'static str {
        match self {
            Self::Pse => "PSE",
            Self::Threshold => "threshold",
            Self::Jnd => "JND",
        }
    }

    /// What stands before the task in the name of its metric.
    const fn prefix(self) -> &'static str {
        match self {
            Self::Pse => "pse_",
            Self::Threshold => "threshold_",
            Self::Jnd => "ln_jnd_",
        }
    }

    /// The number of a metric of tasks, by its name.
    pub fn of_metric(metric: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|own| metric.starts_with(own.prefix()))
    }
}

impl Task {
    /// The unit of its levels: that in which the key of what varies ends.
    pub fn unit(&self) -> &str {
        let of_key = UNITS.iter().find(|(end, _)| self.varies.ends_with(end));
        let unit = of_key.map(|(_, unit)| *unit);
        unit.or_else(|| self.varies.rsplit('_').next()).unwrap_or("1")
    }

    /// Whether half of the answers to it are positive where nothing differs, so that its threshold is the point of
    /// subjective equality.
    pub fn has_pse(&self) -> bool {
        let is_more = matches!(self.asks, Asks::MoreOfTwo | Asks::MoreLess | Asks::Set);
        is_more
            && match &self.method {
                // Steps that are as often up as down.
                Method::Staircase(plan) => {
                    plan.up_after == plan.down_after && plan.up.total_cmp(&plan.down).is_eq()
                }
                _ => true,
            }
    }

    /// Whether its answers tell a JND: staircases give a threshold alone.
    pub fn has_jnd(&self) -> bool {
        !matches!(self.method, Method::Staircase(_))
    }

    /// The numbers that its answers tell.
    pub fn quantities(&self) -> Vec<TaskQuantity> {
        let threshold = if self.has_pse() { TaskQuantity::Pse } else { TaskQuantity::Threshold };
        let jnd = self.has_jnd().then_some(TaskQuantity::Jnd);
        [threshold].into_iter().chain(jnd).collect()
    }

    /// The metric as which one of them is compared: `pse_stiffer`, `ln_jnd_stiffer`.
    ///
    /// # Errors
    /// An id that is too long with what stands before it.
    pub fn metric(&self, quantity: TaskQuantity) -> Result<MetricId, IdError> {
        let id = self.id.as_str().to_ascii_lowercase().replace('-', "_");
        MetricId::new(format!("{}{id}", quantity.prefix()))
    }

    /// What that metric is, in words.
    pub fn metric_in_words(&self, quantity: TaskQuantity) -> String {
        let what = match quantity {
            TaskQuantity::Pse => "point of subjective equality (PSE)",
            TaskQuantity::Threshold => "threshold",
            TaskQuantity::Jnd => "just noticeable difference (JND)",
        };
        format!("{what} of “{}”", self.text)
    }

    /// The unit of that metric.
    pub fn metric_unit(&self, quantity: TaskQuantity) -> String {
        let before = if quantity == TaskQuantity::Jnd { TaskQuantity::LN } else { "" };
        format!("{before}{}", self.unit())
    }
}

impl Study {
    /// The metrics of its tasks, each with its task and number.
    pub fn task_metrics(&self) -> impl Iterator<Item = (MetricId, &Task, TaskQuantity)> {
        self.tasks.iter().flat_map(|task| {
            let all = task.quantities().into_iter();
            all.filter_map(move |own| Some((task.metric(own).ok()?, task, own)))
        })
    }

    /// The task and the number that are compared as a metric of that name.
    pub fn task_metric(&self, metric: &str) -> Option<(&Task, TaskQuantity)> {
        let mut all = self.task_metrics();
        all.find(|(id, ..)| id.as_str() == metric).map(|(_, task, own)| (task, own))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{StaircasePlan, TaskEstimate, TaskFit, TaskLevel};

    fn level(value: f64) -> TaskLevel {
        TaskLevel::nearest(value).unwrap()
    }

    fn task(asks: Asks, method: Method) -> Task {
        Task {
            id: "stiffer-1".parse().unwrap(),
            text: "Which one was stiffer?".to_owned(),
            asks,
            environment: "spring".parse().unwrap(),
            varies: "stiffness_n_per_rad".to_owned(),
            standard: Some(level(4.0)),
            method,
            catch: 0.0,
            feedback: false,
            fit: TaskFit::default(),
            estimate: TaskEstimate::Likelihood,
        }
    }

    fn staircase(down_after: u8) -> Method {
        Method::Staircase(StaircasePlan {
            up_after: 1,
            down_after,
            starts: vec![level(6.0)],
            up: 0.5,
            down: 0.5,
            is_factor: false,
            bounds: [level(1.0), level(8.0)],
            reversals: 12,
            of_last: 8,
            most_trials: 80,
        })
    }

    #[test]
    fn what_a_task_tells_depends_on_question_and_method() {
        use TaskQuantity::{Jnd, Pse, Threshold};
        let constant = || Method::Constant { levels: vec![level(3.0), level(5.0)], trials: 20 };
        for (asks, method, expected) in [
            (Asks::MoreOfTwo, constant(), vec![Pse, Jnd]),
            (Asks::OneOfTwo, constant(), vec![Threshold, Jnd]),
            (Asks::YesNo, constant(), vec![Threshold, Jnd]),
            (Asks::MoreOfTwo, staircase(1), vec![Pse]),
            (Asks::MoreOfTwo, staircase(2), vec![Threshold]),
            (Asks::OneOfTwo, staircase(2), vec![Threshold]),
        ] {
            assert_eq!(task(asks, method.clone()).quantities(), expected, "{asks:?} {method:?}");
        }
    }

    #[test]
    fn its_metrics_are_named_by_it_and_found_by_their_names() {
        let own = task(Asks::MoreOfTwo, staircase(1));
        assert_eq!(own.metric(TaskQuantity::Jnd).unwrap().as_str(), "ln_jnd_stiffer_1");
        assert_eq!(TaskQuantity::of_metric("pse_stiffer_1"), Some(TaskQuantity::Pse));
        assert_eq!(TaskQuantity::of_metric("duration_s"), None);
        assert_eq!(own.metric_unit(TaskQuantity::Jnd), "ln N/rad");
        assert_eq!(TaskQuantity::logarithm_of("ln N/rad"), Some("N/rad"));
        assert_eq!((own.unit(), TaskQuantity::logarithm_of("N/rad")), ("N/rad", None));
    }

    #[test]
    fn a_key_ends_in_its_unit() {
        let mut own = task(Asks::YesNo, staircase(1));
        for (key, unit) in [
            ("force_n", "N"),
            ("stiffness_n_per_m", "N/m"),
            ("delay_ms", "ms"),
            ("contrast_db", "db"),
        ] {
            own.varies = key.to_owned();
            assert_eq!(own.unit(), unit, "{key}");
        }
        for (i, (end, _)) in UNITS.iter().enumerate() {
            let earlier = UNITS[..i].iter().find(|(other, _)| end.ends_with(other));
            assert_eq!(earlier, None, "{end} is never reached");
        }
    }
}
