//! Checks of a mapping of sweeps.

use super::check::Check;
use super::convert::Zero;
use super::mapping::{Content, Pairs, QuantityFrom, SweepForm, SweepFrom, Wide};
use super::shape::{QuantityShape, SweepShape, TimeShape, WideShape, ZeroShape, ZeroWord};
use super::table::ColumnRef;
use zwidth_store::Quantity;

impl Check<'_> {
    pub(super) fn sweeps(
        &mut self,
        sweep: Option<SweepShape>,
        time: Option<TimeShape>,
        [command, response]: [Option<QuantityShape>; 2],
        wide: Option<WideShape>,
        groups: &[&str],
    ) -> Option<Content> {
        let sweep = self.required("sweep", sweep)?;
        let actuator = self.label("sweep.actuator", sweep.actuator, groups);
        let number = self.optional("sweep.sweep", sweep.sweep, groups);
        let [command, response] =
            [("command", command), ("response", response)].map(|(key, shape)| {
                let shape = self.required(key, shape)?;
                self.quantity(key, shape, wide.is_some())
            });
        if wide.is_some() && time.is_some() {
            self.error("time", "is not used beside [wide]; remove it");
        }
        let time = time.map(|t| self.time(t));
        let actuator = actuator?;
        let (command_from, command) = command?;
        let (response_from, response) = response?;
        let form = match wide {
            Some(WideShape { pattern, header, reduce }) => {
                let pattern = self.regex("wide.pattern", &pattern)?;
                if !pattern.capture_names().flatten().any(|n| n == "value") {
                    self.error("wide.pattern", "needs a group (?<value>…) that holds the number");
                }
                SweepForm::Wide(Wide { pattern, header, reduce })
            }
            None => {
                let time = time.flatten();
                SweepForm::Pairs(Pairs { time, command: command_from?, response: response_from? })
            }
        };
        Some(Content::Sweeps(Box::new(SweepFrom { actuator, number, command, response, form })))
    }

    fn quantity(
        &mut self,
        at: &str,
        q: QuantityShape,
        wide: bool,
    ) -> Option<(Option<ColumnRef>, QuantityFrom)> {
        match (&q.from, wide) {
            (Some(_), true) => {
                self.error(&format!("{at}.from"), "is not used beside [wide]; remove it")
            }
            (None, false) => self.error(&format!("{at}.from"), "is missing; name the column"),
            _ => {}
        }
        for (key, text) in [("name", &q.name), ("unit", &q.unit)] {
            if text.trim().is_empty() {
                self.error(&format!("{at}.{key}"), "must not be empty; figures put it on an axis");
            }
        }
        let zero = match q.zero {
            None => Zero::None,
            Some(ZeroShape::Word(ZeroWord::First)) => Zero::First,
            Some(ZeroShape::Rest(_)) => {
                let what = "is \"first\" or left out in a sweep, which need not have a time";
                self.error(&format!("{at}.zero"), what);
                // Any will do: with an error the mapping is refused.
                Zero::None
            }
        };
        let line = self.line(at, q.sign, q.scale, q.offset, zero)?;
        Some((q.from, QuantityFrom { quantity: Quantity { name: q.name, unit: q.unit }, line }))
    }
}

#[cfg(test)]
mod tests {
    use super::super::check::tests::check;
    use super::super::mapping::Mapping;
    use std::path::Path;

    const WIDE: &str = "kind = \"sweeps\"
[sweep]
actuator = \"cell\"
[wide]
pattern = 'kg_(?<value>.+)'
header = \"response\"
[command]
name = \"voltage\"
unit = \"V\"
[response]
name = \"weight\"
unit = \"N\"
";

    #[test]
    fn a_wide_sweep_needs_its_group_and_has_no_columns() {
        assert!(Mapping::from_toml(WIDE, Path::new("map.toml")).is_ok());
        check(WIDE, "?<value>", "", 5, "needs a group (?<value>…)");
        check(WIDE, "unit = \"V\"", "unit = \"V\"\nfrom = 1", 10, "not used beside [wide]");
        check(WIDE, "unit = \"V\"", "unit = \" \"", 9, "must not be empty");
        check(WIDE, "\"response\"", "\"both\"", 6, "unknown variant `both`");
    }
}
