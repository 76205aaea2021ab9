//! Checks a mapping of answers to tasks: where levels and answers are.

use super::check::Check;
use super::convert::Zero;
use super::label::LabelShape;
use super::mapping::{Content, EachFrom, SaidFrom, TaskFrom};
use super::shape::{TaskShape, TrialShape};
use super::table::ColumnRef;

impl Check<'_> {
    pub(super) fn psychometric(
        &mut self,
        trial: Option<TrialShape>,
        task: Option<TaskShape>,
        groups: &[&str],
    ) -> Option<Content> {
        if let Some(trial) = &trial {
            let own = [
                (
                    "environment",
                    trial.environment.is_some(),
                    "it is that of the task in study.toml",
                ),
                ("repeat", trial.repeat.is_some(), "presentations are counted"),
                ("likert", trial.likert.is_some(), "answers stand under [task]"),
            ];
            for (key, _, why) in own.into_iter().filter(|(_, is_present, _)| *is_present) {
                let what = format!("is not used in a mapping of this kind: {why}; remove it");
                self.error(&format!("trial.{key}"), what);
            }
        }
        // Which environment it is, study.toml says.
        let trial = trial.map(|trial| TrialShape {
            environment: Some(LabelShape::Text(String::new())),
            ..trial
        });
        let who = self.who(trial, groups);
        let shape = self.required("task", task)?;
        let id = self.label("task.id", shape.id.clone(), groups);
        let unit = self.required("task.unit", shape.unit.clone());
        let line = self.line("task", shape.sign, shape.scale, shape.offset, Zero::None);
        let time_unit =
            self.time_unit("task.time_unit", shape.time_unit.as_deref(), shape.time.is_some());
        let track = self.optional("task.track", shape.track.clone(), groups);
        let said = match &shape.presentations {
            Some(presentations) => self.counts(presentations, &shape),
            None => self.each(&shape, groups),
        };
        let is_numbered = who.as_ref().is_some_and(|who| who.trial.is_some());
        if shape.presentations.is_some() && is_numbered {
            let what = "is not used beside presentations: a row is many trials; remove it";
            self.error("trial.trial", what);
        }
        let when = shape.when.into_iter().map(|(column, words)| (ColumnRef::Name(column), words));
        Some(Content::Psychometric(Box::new(TaskFrom {
            who: who?,
            id: id?,
            level: shape.level,
            unit: unit?,
            line: line?,
            said: said?,
            track,
            time: shape.time,
            time_unit,
            when: when.collect(),
        })))
    }

    /// Counts: how many presentations of a level, and how many answers were positive or right.
    fn counts(&mut self, presentations: &ColumnRef, shape: &TaskShape) -> Option<SaidFrom> {
        for (key, is_present) in [
            ("answer", shape.answer.is_some()),
            ("standard", shape.standard.is_some()),
            ("comparison", shape.comparison.is_some()),
            ("track", shape.track.is_some()),
            ("time", shape.time.is_some()),
        ] {
            if is_present {
                let what = "is of one answer, and is not used beside presentations; remove it";
                self.error(&format!("task.{key}"), what);
            }
        }
        let [positive, correct] =
            [("positive", &shape.positive), ("correct", &shape.correct)].map(|(key, label)| {
                let label = label.clone()?;
                let label = self.label(&format!("task.{key}"), label, &[])?;
                if label.column().is_none() || !label.translate.is_empty() {
                    self.error(&format!("task.{key}"), "must be a column of counts");
                }
                label.column().cloned()
            });
        if shape.positive.is_none() && shape.correct.is_none() {
            let what = "needs positive or correct beside it: how many of the answers were so";
            self.error("task.presentations", what);
        }
        Some(SaidFrom::Counts { presentations: presentations.clone(), positive, correct })
    }

    /// A row a presentation.
    fn each(&mut self, shape: &TaskShape, groups: &[&str]) -> Option<SaidFrom> {
        let before = self.errors.len();
        let [answer, positive, correct, standard, comparison] = [
            ("answer", &shape.answer),
            ("positive", &shape.positive),
            ("correct", &shape.correct),
            ("standard", &shape.standard),
            ("comparison", &shape.comparison),
        ]
        .map(|(key, label)| {
            let key = format!("task.{key}");
            let label = self.optional(&key, label.clone(), groups)?;
            // Which interval held the standard may be the same in all of them.
            let is_of_row = ["task.answer", "task.positive", "task.correct"].contains(&&*key);
            if is_of_row && label.column().is_none() {
                self.error(&key, "must come from a column: { column = … }");
            }
            Some(label)
        });
        if standard.is_some() && comparison.is_some() {
            let what =
                "is not used beside standard, which is the other interval; remove one of them";
            self.error("task.comparison", what);
        }
        (self.errors.len() == before).then(|| {
            SaidFrom::Each(Box::new(EachFrom { answer, positive, correct, standard, comparison }))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::check::tests::check;

    #[test]
    fn what_a_mapping_of_answers_to_tasks_lacks_or_has_too_much_is_told_with_its_line() {
        let good = "kind = \"psychometric\"\n[trial]\nparticipant = \"P01\"\nsession = \"S01\"\nmode = \"active\"\n\
                    [task]\nid = \"stiffer\"\nlevel = \"k\"\nunit = \"N/rad\"\ncorrect = { column = \"corr\" }\n";
        let corr = "correct = { column = \"corr\" }";
        let counts = "presentations = \"n\"\ncorrect = { column = \"corr\" }\n";
        for (from, to, line, words) in [
            ("mode = \"active\"", "mode = \"active\"\nenvironment = \"e\"", 6, "that of the task"),
            ("mode = \"active\"", "mode = \"active\"\nrepeat = 1", 6, "presentations are counted"),
            ("unit = \"N/rad\"\n", "", 6, "task.unit: is missing"),
            (corr, "correct = 1", 10, "must come from a column"),
            (corr, "presentations = \"n\"", 10, "needs positive or correct beside it"),
            (corr, &format!("{counts}time = \"rt\"\ntime_unit = \"s\""), 12, "of one answer"),
            (corr, "standard = 1\ncomparison = 2", 11, "the other interval"),
            (corr, "time = \"rt\"", 6, "task.time_unit: is missing"),
            ("[task]\n", "[task]\nscale = 0.0\n", 7, "other than 0"),
            ("\"psychometric\"", "\"likert\"", 6, "task: is not used in a mapping of this kind"),
        ] {
            check(good, from, to, line, words);
        }
    }
}
