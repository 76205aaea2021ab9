//! The checks of `[[stage]]` of a `study.toml`.

use super::check::Check;
use crate::id::is_of_samples;
use crate::{Channel, GivenFigure, GivenMetric, OutsideMetric, OwnStage, StageId, is_unit};
use std::collections::BTreeSet;
use std::path::{Component, Path};

/// No study has more stages of its own.
const MOST_STAGES: usize = 32;
/// No command has more words, and no stage more files.
const MOST_WORDS: usize = 100;
/// No stage gives more metrics.
const MOST_GIVEN: usize = 32;
/// No stage draws more figures.
const MOST_FIGURES: usize = 20;
/// No stage runs longer, s: a day is a mistake.
const LONGEST_S: u32 = 86_400;

impl Check<'_> {
    /// Checks the stages, and gives the metrics that they give.
    pub(super) fn stages(
        &mut self,
        stages: &[OwnStage],
        channels: &[Channel],
    ) -> Vec<(StageId, OutsideMetric)> {
        self.unique("stage", stages.iter().map(|stage| stage.id.as_str()));
        self.at_most("stage", stages.len(), MOST_STAGES);
        let mut given: Vec<(StageId, OutsideMetric)> = Vec::new();
        for (i, stage) in stages.iter().enumerate() {
            let at = format!("stage[{i}]");
            if OwnStage::INPUTS.contains(&stage.id.as_str()) {
                let problem =
                    format!("'{}' is what stages get from zwidth; choose another id", stage.id);
                self.error(&format!("{at}.id"), problem);
            }
            self.stage_command(&at, stage);
            self.stage_files(&at, stage);
            self.stage_inputs(&at, stage, stages);
            self.stage_columns(&at, stage, channels);
            if !(1..=LONGEST_S).contains(&stage.timeout_s) {
                let problem = format!("{} must be from 1 to {LONGEST_S} seconds", stage.timeout_s);
                self.error(&format!("{at}.timeout_s"), problem);
            }
            if stage.gives.is_empty() && stage.figures.is_empty() {
                let problem = "the stage gives nothing; list its metrics in gives = [...], or its figures in \
                               figures = [...]";
                self.error(&format!("{at}.id"), problem);
            }
            self.at_most(&format!("{at}.gives"), stage.gives.len(), MOST_GIVEN);
            for (k, metric) in stage.gives.iter().enumerate() {
                let at = format!("{at}.gives[{k}]");
                let Some(metric) = self.given_metric(&at, metric, stage) else { continue };
                if given.iter().any(|(_, other)| other.column == metric.column) {
                    let problem =
                        format!("'{}' is given twice; a metric has one source", metric.id);
                    self.error(&format!("{at}.id"), problem);
                }
                given.push((stage.id.clone(), metric));
            }
            self.given_figures(&at, &stage.figures);
        }
        given
    }

    fn at_most(&mut self, key: &str, n: usize, most: usize) {
        if n > most {
            self.error(key, format!("the list has {n} entries; at most {most} are allowed"));
        }
    }

    fn stage_command(&mut self, at: &str, stage: &OwnStage) {
        let key = format!("{at}.command");
        self.at_most(&key, stage.command.len(), MOST_WORDS);
        if stage.command.first().is_none_or(|program| program.trim().is_empty()) {
            let problem = "names no program; write a list such as [\"python3\", \"grip.py\"]";
            self.error(&key, problem);
        }
        for word in &stage.command {
            self.line(&key, word);
        }
    }

    fn stage_files(&mut self, at: &str, stage: &OwnStage) {
        let key = format!("{at}.files");
        self.at_most(&key, stage.files.len(), MOST_WORDS);
        let mut seen = BTreeSet::new();
        for file in &stage.files {
            let shown = file.escape_default();
            if !is_below(file) {
                let problem = format!(
                    "'{shown}' is no file below analysis/<study>; write a path from there on, such as \"grip.py\", \
                     of letters, digits and ._-/"
                );
                self.error(&key, problem);
            } else if let Some(folder) =
                ["in", "out"].into_iter().find(|own| Path::new(file).starts_with(own))
            {
                let problem = format!(
                    "'{shown}' would lie among what the stage gets and gives; use another folder than {folder}/"
                );
                self.error(&key, problem);
            }
            // Not every disk knows case.
            if !seen.insert(file.to_ascii_lowercase()) {
                self.error(&key, format!("'{shown}' stands twice; list each file once"));
            }
        }
    }

    fn stage_inputs(&mut self, at: &str, stage: &OwnStage, stages: &[OwnStage]) {
        let key = format!("{at}.inputs");
        if stage.inputs.is_empty() {
            self.error(&key, "the list is empty; a stage needs at least one input");
        }
        let mut seen = BTreeSet::new();
        for input in &stage.inputs {
            if !seen.insert(input) {
                self.error(&key, format!("'{input}' stands twice; list each input once"));
            }
            if OwnStage::INPUTS.contains(&input.as_str()) {
                continue;
            }
            match stages.iter().find(|other| other.id == *input) {
                None => {
                    let others = stages.iter().map(|other| other.id.as_str());
                    let others = others.filter(|other| *other != stage.id.as_str());
                    let all: Vec<&str> = OwnStage::INPUTS.into_iter().chain(others).collect();
                    let all = all.join(", ");
                    self.error(&key, format!("'{input}' is no input; there are {all}"));
                }
                Some(other) if other.gives.is_empty() => {
                    let problem = format!(
                        "the stage '{input}' gives no metrics, and so it has no table to read"
                    );
                    self.error(&key, problem);
                }
                Some(_) if needs(input.as_str(), stages).contains(stage.id.as_str()) => {
                    let problem = format!(
                        "'{input}' needs '{}' itself, so that neither could begin; leave one of them out",
                        stage.id
                    );
                    self.error(&key, problem);
                }
                Some(_) => {}
            }
        }
    }

    fn stage_columns(&mut self, at: &str, stage: &OwnStage, channels: &[Channel]) {
        let key = format!("{at}.columns");
        if !stage.columns.is_empty() && !stage.gets("samples") {
            self.error(&key, "are those of samples; add \"samples\" to inputs, or remove them");
        }
        let mut seen = BTreeSet::new();
        for column in &stage.columns {
            let is_channel = channels.iter().any(|channel| channel.id.as_str() == column);
            if !is_of_samples(column) && !is_channel {
                let shown = column.escape_default();
                let problem = format!(
                    "'{shown}' is no column of samples; there are t_s, theta_rad, force_ex_n and others (docs/data.md, \"A \
                     trial's columns\"), and the study's [[channels]]"
                );
                self.error(&key, problem);
            } else if !seen.insert(column) {
                self.error(&key, format!("'{column}' stands twice; list each column once"));
            }
        }
    }

    /// The metric that a stage gives, if it can be one.
    fn given_metric(
        &mut self,
        at: &str,
        metric: &GivenMetric,
        stage: &OwnStage,
    ) -> Option<OutsideMetric> {
        self.line(&format!("{at}.label"), &metric.label);
        if ["participant", "session", "trial", "environment", "mode", "repeat", "source"]
            .contains(&metric.id.as_str())
        {
            let problem =
                format!("'{}' says which trial a row is of; choose another id", metric.id);
            self.error(&format!("{at}.id"), problem);
        }
        match OutsideMetric::new(metric.id.clone(), &metric.unit, &metric.label) {
            Ok(own) => Some(OutsideMetric {
                better: metric.better,
                program: Some(stage.in_words()),
                ..own
            }),
            Err(problem) => {
                let key = match (is_unit(&metric.unit), metric.label.trim().is_empty()) {
                    (false, _) => "unit",
                    (true, true) => "label",
                    (true, false) => "id",
                };
                self.error(&format!("{at}.{key}"), problem);
                None
            }
        }
    }

    fn given_figures(&mut self, at: &str, figures: &[GivenFigure]) {
        self.at_most(&format!("{at}.figures"), figures.len(), MOST_FIGURES);
        let mut seen = BTreeSet::new();
        for (k, figure) in figures.iter().enumerate() {
            let key = format!("{at}.figures[{k}]");
            let path = Path::new(&figure.file);
            let has_ending = path
                .extension()
                .is_some_and(|ending| ["svg", "pdf", "png"].iter().any(|known| ending == *known));
            if !is_below(&figure.file) || figure.file.contains('/') || !has_ending {
                let problem = format!(
                    "'{}' is no name of a figure; write one of letters, digits and _-. that ends in .svg, .pdf \
                     or .png",
                    figure.file.escape_default()
                );
                self.error(&format!("{key}.file"), problem);
            }
            if !seen.insert(figure.file.to_ascii_lowercase()) {
                self.error(&format!("{key}.file"), "stands twice; list each figure once");
            }
            self.line(&format!("{key}.caption"), &figure.caption);
            if figure.caption.trim().is_empty() {
                self.error(&format!("{key}.caption"), "is empty; say what the figure shows");
            }
        }
    }
}

/// The stages that a stage needs, directly or through others.
fn needs<'s>(id: &'s str, stages: &'s [OwnStage]) -> BTreeSet<&'s str> {
    let mut all = BTreeSet::new();
    let mut ask = vec![id];
    while let Some(id) = ask.pop() {
        for stage in stages.iter().filter(|stage| stage.id.as_str() == id) {
            for input in &stage.inputs {
                if all.insert(input.as_str()) {
                    ask.push(input.as_str());
                }
            }
        }
    }
    // So that a stage that reads itself is found, too.
    all.insert(id);
    all
}

/// Whether a path stays below the folder it is read from, on any machine.
fn is_below(file: &str) -> bool {
    !file.is_empty()
        && file.chars().all(|c| c.is_ascii_alphanumeric() || "/._-".contains(c))
        && file.split('/').all(|part| !part.is_empty() && part != ".")
        && Path::new(file).components().all(|part| matches!(part, Component::Normal(_)))
}

#[cfg(test)]
mod tests {
    use crate::tests::{check_refused, check_round_trip, text};
    use crate::{Affects, Better, Study, StudyError, study_changes};

    const GRIP: &str = "[[stage]]\nid = \"grip\"\ncommand = [\"python3\", \"grip.py\", \"two words\"]\n\
                        files = [\"grip.py\", \"lib/uv.lock\"]\ninputs = [\"samples\", \"metrics\"]\n\
                        gives = [{ id = \"grip_peak\", unit = \"N\", label = \"largest grip\" }]\n";

    fn with(stages: &str) -> Result<Study, Vec<StudyError>> {
        Study::from_toml(&format!("{}\n{stages}\n", text()))
    }

    #[test]
    fn a_stage_survives_a_round_trip_and_what_is_left_out_has_its_default() {
        let study = with(GRIP).unwrap();
        let [stage] = &study.stages[..] else { panic!("{:?}", study.stages) };
        assert_eq!((stage.timeout_s, stage.gives[0].better), (600, Better::Neither));
        assert_eq!(stage.command_line(), "python3 grip.py \"two words\"");
        check_round_trip(&study);
        let second = "[[stage]]\nid = \"drawn\"\ncommand = [\"Rscript\", \"a.R\"]\ninputs = [\"grip\"]\n\
                      format = \"csv\"\ntimeout_s = 5\nfigures = [{ file = \"a.svg\", caption = \"Grip.\" }]\n";
        let study = with(&format!("{second}{GRIP}")).unwrap();
        check_round_trip(&study);
        let changes = study_changes(&crate::tests::demo(), &study);
        assert!(changes.iter().all(|change| change.affects == Affects::Nothing), "{changes:?}");
    }

    #[test]
    fn what_cannot_be_meant_is_one_error_with_key_and_remedy() {
        for (from, to, key, words) in [
            ("id = \"grip\"", "id = \"samples\"", "stage[0].id", "choose another id"),
            ("id = \"grip\"", "id = \"a/b\"", "id", "not a valid stage id"),
            ("command = [\"python3\"", "command = [\"\"", "stage[0].command", "names no program"),
            ("grip.py\", \"lib", "../grip.py\", \"lib", "stage[0].files", "no file below analysis"),
            ("grip.py\", \"lib", "/grip.py\", \"lib", "stage[0].files", "no file below analysis"),
            ("grip.py\", \"lib", "c:\\\\grip.py\", \"lib", "stage[0].files", "no file below"),
            ("grip.py\", \"lib", "./grip.py\", \"lib", "stage[0].files", "no file below analysis"),
            ("lib/uv.lock", "in/uv.lock", "stage[0].files", "use another folder than in/"),
            ("lib/uv.lock", "Grip.py", "stage[0].files", "stands twice"),
            ("\"metrics\"]", "\"metrics\", \"samples\"]", "stage[0].inputs", "stands twice"),
            ("\"samples\", ", "\"sample\", ", "stage[0].inputs", "there are samples, metrics"),
            ("[\"samples\", \"metrics\"]", "[]", "stage[0].inputs", "at least one input"),
            ("\"samples\", ", "\"grip\", ", "stage[0].inputs", "needs 'grip' itself"),
            ("gives = [", "timeout_s = 0\ngives = [", "stage[0].timeout_s", "from 1 to 86400"),
            ("gives = [", "timeout = 1\ngives = [", "timeout", "unknown field"),
            ("unit = \"N\"", "unit = \"newton\"", "stage[0].gives[0].unit", "not a unit"),
            ("largest grip", " ", "stage[0].gives[0].label", "one line of text"),
            ("id = \"grip_peak\"", "id = \"own_grip\"", "stage[0].gives[0].id", "leave it out"),
            ("id = \"grip_peak\"", "id = \"trial\"", "stage[0].gives[0].id", "another id"),
            ("id = \"grip_peak\"", "id = \"Grip\"", "gives", "lower case"),
        ] {
            assert!(GRIP.contains(from), "{from}");
            check_refused(with(&GRIP.replacen(from, to, 1)), key, words);
        }
        let gives = "gives = [{ id = \"grip_peak\", unit = \"N\", label = \"largest grip\" }]\n";
        check_refused(with(&GRIP.replace(gives, "")), "stage[0].id", "gives nothing");
        let figures = |figures: &str| with(&GRIP.replace(gives, &format!("figures = [{figures}]")));
        for name in ["a.jpg", "../a.svg", "b/a.svg", "svg", ".svg"] {
            let figure = format!("{{ file = \"{name}\", caption = \"x\" }}");
            check_refused(figures(&figure), "stage[0].figures[0].file", "no name of a figure");
        }
        let one = "{ file = \"a.svg\", caption = \"x\" }, ";
        check_refused(figures(&one.repeat(2)), "stage[0].figures[1].file", "stands twice");
        let many = (0..21).map(|i| one.replace("a.svg", &format!("a{i}.svg")));
        check_refused(figures(&many.collect::<String>()), "stage[0].figures", "at most 20");
        check_refused(
            figures("{ file = \"a.svg\", caption = \"\" }"),
            "stage[0].figures[0].caption",
            "is empty",
        );
    }

    #[test]
    fn columns_are_those_of_samples_and_channels() {
        let of = |columns: &str, inputs: &str| {
            let channel = "[[channels]]\nid = \"grip_n\"\nunit = \"N\"\ndescription = \"grip\"\n";
            let gives = "gives = [{ id = \"x\", unit = \"N\", label = \"x\" }]\n";
            let stage = "[[stage]]\nid = \"a\"\ncommand = [\"a\"]\n";
            with(&format!(
                "{channel}{stage}inputs = [\"{inputs}\"]\ncolumns = [{columns}]\n{gives}"
            ))
        };
        let study = of("\"t_s\", \"grip_n\", \"x_m\", \"state_bits\"", "samples").unwrap();
        assert!(study.stages[0].takes("grip_n") && !study.stages[0].takes("theta_rad"));
        check_round_trip(&study);
        for other in ["likert", "mode", "level", "grip"] {
            let refused = of(&format!("\"{other}\""), "samples");
            check_refused(refused, "stage[0].columns", "is no column of samples");
        }
        check_refused(of("\"t_s\", \"t_s\"", "samples"), "stage[0].columns", "stands twice");
        check_refused(of("\"t_s\"", "metrics"), "stage[0].columns", "add \"samples\" to inputs");
    }

    #[test]
    fn stages_that_need_each_other_or_give_the_same_are_refused() {
        let stage = |id: &str, input: &str| {
            let gives = format!("gives = [{{ id = \"{id}_x\", unit = \"N\", label = \"x\" }}]\n");
            format!("[[stage]]\nid = \"{id}\"\ncommand = [\"a\"]\ninputs = [\"{input}\"]\n{gives}")
        };
        let three = [stage("a", "c"), stage("b", "a"), stage("c", "b")].concat();
        let errors = with(&three).unwrap_err();
        let keys: Vec<&str> = errors.iter().map(|error| error.key.as_str()).collect();
        assert_eq!(keys, ["stage[0].inputs", "stage[1].inputs", "stage[2].inputs"]);
        check_round_trip(&with(&[stage("a", "samples"), stage("b", "a")].concat()).unwrap());
        let same = stage("b", "samples").replace("b_x", "a_x");
        check_refused(
            with(&[stage("a", "samples"), same].concat()),
            "stage[1].gives[0].id",
            "is given twice",
        );
        let twice = [stage("a", "samples"), stage("A", "samples").replace("A_x", "b_x")].concat();
        check_refused(with(&twice), "stage[1].id", "stands twice");
        let drawn = "[[stage]]\nid = \"a\"\ncommand = [\"a\"]\ninputs = [\"samples\"]\n\
                     figures = [{ file = \"a.svg\", caption = \"x\" }]\n";
        check_refused(
            with(&[drawn, &stage("b", "a")].concat()),
            "stage[1].inputs",
            "gives no metrics",
        );
    }
}
