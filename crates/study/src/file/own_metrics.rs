//! The checks of `[[metrics]]` of a `study.toml`.

use super::check::Check;
use crate::{Channel, Curve, OwnMetric, Statistic};

/// No study has more metrics of its own.
const MOST_METRICS: usize = 32;

/// The unit that a metric must have; `None` if there is no such quantity.
fn unit_of(metric: &OwnMetric, channels: &[Channel]) -> Option<String> {
    let columns = OwnMetric::COLUMNS.into_iter();
    let channels = channels.iter().map(|channel| (channel.id.as_str(), channel.unit.as_str()));
    let (_, unit) = columns.chain(channels).find(|(name, _)| *name == metric.of)?;
    Some(match metric.statistic {
        Statistic::TimeToMax => "s".to_owned(),
        Statistic::Integral if unit == "1" => "s".to_owned(),
        Statistic::Integral => format!("{unit}·s"),
        _ => unit.to_owned(),
    })
}

impl Check<'_> {
    /// Metrics of quantities that there are, with names that no other column has.
    pub(super) fn own_metrics(&mut self, metrics: &[OwnMetric], channels: &[Channel]) {
        self.unique("metrics", metrics.iter().map(|metric| metric.id.as_str()));
        if metrics.len() > MOST_METRICS {
            let n = metrics.len();
            let problem = format!("the list has {n} entries; at most {MOST_METRICS} are allowed");
            self.error("metrics", problem);
        }
        for (i, metric) in metrics.iter().enumerate() {
            let key = |name: &str| format!("metrics[{i}].{name}");
            let id = metric.id.as_str();
            if id.contains("_sd_") || id.ends_with("_sd") {
                let problem = format!(
                    "'{id}' has '_sd', by which tables name the deviation of a metric; choose another id"
                );
                self.error(&key("id"), problem);
            }
            if Curve::from_word(id).is_some() {
                let problem = format!("'{id}' is a whole curve's name; choose another id");
                self.error(&key("id"), problem);
            }
            self.line(&key("label"), &metric.label);
            if metric.label.trim().is_empty() {
                self.error(&key("label"), "is empty; say what people call it, such as \"grip\"");
            }
            match unit_of(metric, channels) {
                None => {
                    let columns = OwnMetric::COLUMNS.iter().map(|(name, _)| *name);
                    let all: Vec<&str> =
                        columns.chain(channels.iter().map(|channel| channel.id.as_str())).collect();
                    let problem = format!(
                        "there is no quantity '{}'; there are {}, and what [[channels]] adds",
                        metric.of,
                        all.join(", ")
                    );
                    self.error(&key("of"), problem);
                }
                Some(unit) if unit != metric.unit => {
                    let problem = format!(
                        "'{}' is not the unit of the {}; write unit = \"{unit}\"",
                        metric.unit,
                        metric.rule()
                    );
                    self.error(&key("unit"), problem);
                }
                Some(_) => {}
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::tests::{check_refused, check_round_trip, text};
    use crate::{Better, Statistic, Study, StudyError, TrialPart};

    const GRIP: &str = "[[channels]]\nid = \"grip_n\"\nunit = \"N\"\ndescription = \"grip\"\n";

    /// The template's study with a channel and a metric that has these keys besides id and label.
    fn with(keys: &str) -> Result<Study, Vec<StudyError>> {
        let id = if keys.contains("id =") { "" } else { "id = \"grip_max_n\"\n" };
        let label = if keys.contains("label") { "" } else { "label = \"largest grip\"\n" };
        Study::from_toml(&format!("{}\n{GRIP}[[metrics]]\n{id}{label}{keys}\n", text()))
    }

    #[test]
    fn a_rule_survives_a_round_trip_and_what_is_left_out_has_its_default() {
        let study = with("of = \"grip_n\"\nstatistic = \"max\"\nunit = \"N\"").unwrap();
        let [metric] = &study.metrics[..] else { panic!("{:?}", study.metrics) };
        let found = (metric.statistic, metric.over, metric.better);
        assert_eq!(found, (Statistic::Max, TrialPart::Recording, Better::Neither));
        assert_eq!(metric.rule(), "maximum of grip_n over the recording");
        assert!(!metric.is_felt());
        check_round_trip(&study);
        let study = with(
            "of = \"force_ex_n\"\nstatistic = \"integral\"\nover = \"past_wall\"\nunit = \"N·s\"\n\
             better = \"lower\"",
        );
        check_round_trip(&study.unwrap());
    }

    #[test]
    fn what_cannot_be_meant_is_one_error_with_key_and_remedy() {
        let of_grip = "of = \"grip_n\"\nstatistic = \"max\"\n";
        for (keys, key, words) in [
            (
                "of = \"grip\"\nstatistic = \"max\"\nunit = \"N\"",
                "metrics[0].of",
                "force_cmd_n, grip_n",
            ),
            (&format!("{of_grip}unit = \"mN\""), "metrics[0].unit", "write unit = \"N\""),
            (
                "of = \"grip_n\"\nstatistic = \"integral\"\nunit = \"N\"",
                "metrics[0].unit",
                "write unit = \"N·s\"",
            ),
            (
                &format!("id = \"grip_sd_n\"\n{of_grip}unit = \"N\""),
                "metrics[0].id",
                "choose another id",
            ),
            (&format!("label = \" \"\n{of_grip}unit = \"N\""), "metrics[0].label", "is empty"),
            ("of = \"grip_n\"\nstatistic = \"most\"\nunit = \"N\"", "statistic", "unknown variant"),
            (&format!("{of_grip}unit = \"N\"\nfrom = 1"), "from", "unknown field"),
            (of_grip, "[[metrics]]", "missing field `unit`"),
        ] {
            check_refused(with(keys), key, words);
        }
    }
}
