//! From the text of a `study.toml` to a checked study in SI units.

use super::check::{Check, FARTHEST_DEG, MOST_REDONE, MOST_TRIALS};
use super::compare::Comparable;
use super::shape::*;
use super::tasks::Around;
use super::units::MILLI;
use crate::form::READ_CHANNELS;
use crate::id::COLUMNS_OF_THREE;
use crate::model::{
    Analysis, Coordinate, Design, Device, Environment, Masses, Mode, Resistances, Study,
};
use crate::{
    ActuatorKind, Axes, Channel, Control, MOST_CHANNELS, Schema, StudyError, VelocityFilter, locate,
};
use std::collections::BTreeSet;

/// Movement begins above this velocity: well above a held sensor's jitter, well below a slow push.
const ONSET_DEG_S: f64 = 10.0;
/// Movement ends below this velocity (half the onset: hysteresis).
const OFFSET_DEG_S: f64 = 5.0;
/// As [`ONSET_DEG_S`], for a linear coordinate.
const ONSET_MM_S: f64 = 5.0;
/// As [`OFFSET_DEG_S`], for a linear coordinate.
const OFFSET_MM_S: f64 = 2.5;

/// No trial and no pause is longer, s: a day is a mistake.
const LONGEST_S: f64 = 86_400.0;
/// No loop ticks faster, Hz: a hundred times what hands feel.
const FASTEST_HZ: f64 = 100_000.0;
/// No trial has more samples: what is longer could not be read again.
pub(super) const MOST_SAMPLES: f64 = 4_194_304.0;
/// No mean has more points: no figure shows as many.
const MOST_POINTS: usize = 100_000;
/// No study has more environments, modes or questions.
const MOST_LISTED: usize = 1000;
/// No title, label or question is longer, in characters.
const LONGEST_TEXT: usize = 1000;
impl Study {
    /// Reads and checks a `study.toml`. Every problem found is in the error, each with its key and
    /// line.
    pub fn from_toml(text: &str) -> Result<Self, Vec<StudyError>> {
        // Some editors put a byte-order mark first.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let file: File = toml::from_str(text).map_err(|e| vec![locate::toml_error(text, &e)])?;
        let mut check = Check::new(text);
        let study = check.study(file);
        if check.errors.is_empty() { Ok(study) } else { Err(check.errors) }
    }
}

impl Check<'_> {
    /// A text that people will read: on one line, and not without end.
    pub(super) fn line(&mut self, key: &str, text: &str) {
        // Characters that start a line, or turn the direction of what follows: in a label they could
        // forge a line of a table or a terminal.
        if let Some(c) = text.chars().find(|c| {
            c.is_control() || matches!(c, '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
        }) {
            let problem = format!(
                "contains {}, which breaks a line or turns its direction; leave it out",
                c.escape_default()
            );
            self.error(key, problem);
        }
        if text.chars().count() > LONGEST_TEXT {
            self.error(key, format!("is longer than {LONGEST_TEXT} characters; shorten it"));
        }
    }

    /// Every text of the file.
    fn lines(&mut self, file: &File) {
        self.line("study.title", &file.study.title);
        self.line("device.name", &file.device.name);
        for (i, environment) in file.environments.iter().enumerate() {
            self.line(&format!("environments[{i}].label"), &environment.label);
        }
        for (i, mode) in file.modes.iter().enumerate() {
            self.line(&format!("modes[{i}].label"), &mode.label);
        }
        for (i, question) in file.questions.iter().enumerate() {
            self.line(&format!("questions[{i}].text"), &question.text);
            for (key, text) in [("group", &question.group), ("label", &question.label)] {
                self.line(&format!("questions[{i}].{key}"), text.as_deref().unwrap_or_default());
            }
        }
    }

    /// The trials of a session, and the samples of one.
    fn sizes(&mut self, file: &File) {
        let Design { repeats, familiarisation, trial_limit_s, .. } = file.design;
        // The trials of an environment of a task are the task's.
        let repeated = file
            .environments
            .iter()
            .filter(|own| file.tasks.iter().all(|task| task.environment != own.id));
        let conditions = repeated.count().saturating_mul(file.modes.len()) as u64;
        let trials =
            conditions.saturating_mul(repeats.into()).saturating_add(familiarisation.into());
        // What is too large by itself is reported by `design`, and not twice.
        if repeats <= MOST_TRIALS && trials > MOST_TRIALS.into() {
            let problem = format!(
                "{trials} trials in a session must be at most {MOST_TRIALS}: fewer repeats"
            );
            self.error("design.repeats", problem);
        }
        let samples = trial_limit_s * file.control.rate_hz;
        if trial_limit_s <= LONGEST_S
            && file.control.rate_hz <= FASTEST_HZ
            && samples > MOST_SAMPLES
        {
            let problem = format!(
                "at control.rate_hz = {} a trial could have {samples} samples; at most {MOST_SAMPLES} can be \
                 read again: give a shorter limit",
                file.control.rate_hz
            );
            self.error("design.trial_limit_s", problem);
        }
    }

    /// The version of the trial files' form, and whether the channels are ones that it has.
    fn schema(&mut self, file: &File) -> Schema {
        let schema = Schema::try_from(file.schema).unwrap_or_else(|problem| {
            self.error("schema", problem);
            Schema::default()
        });
        let needs = [("[[tasks]]", !file.tasks.is_empty()), ("[axes]", file.axes.is_some())];
        if let Some((what, _)) = needs.into_iter().find(|(_, is_there)| *is_there)
            && schema < Schema::Three
        {
            let problem = format!(
                "trial files of schema {} have no columns for {what}; write schema = 3, before anything is recorded",
                schema.number()
            );
            self.error("schema", problem);
        }
        let n = file.channels.len();
        if n > MOST_CHANNELS {
            let problem = format!("the list has {n} entries; at most {MOST_CHANNELS} are allowed");
            self.error("channels", problem);
        }
        for (i, channel) in file.channels.iter().enumerate() {
            if schema >= Schema::Three && COLUMNS_OF_THREE.contains(&channel.id.as_str()) {
                let problem = format!(
                    "'{}' is a column of every trial file of schema {}; choose another id",
                    channel.id,
                    schema.number()
                );
                self.error(&format!("channels[{i}].id"), problem);
            }
            for (key, text) in [("unit", &channel.unit), ("description", &channel.description)] {
                let key = format!("channels[{i}].{key}");
                self.line(&key, text);
                if text.trim().is_empty() {
                    self.error(&key, "is empty; a unit of a pure number is \"1\"");
                }
            }
            // A channel that a stage reads has the unit in which it is read.
            let Channel { id, unit: own, .. } = channel;
            let read = READ_CHANNELS.iter().find(|(name, _)| *name == id.as_str());
            if let Some((_, unit)) = read.filter(|(_, unit)| unit != own) {
                let problem = format!(
                    "'{own}' is not the unit of {id}, which is read in {unit}; write unit = \"{unit}\" and \
                     convert, or give the channel another id"
                );
                self.error(&format!("channels[{i}].unit"), problem);
            }
        }
        schema
    }

    fn study(&mut self, file: File) -> Study {
        // Those that look at the whole file come first: further below, parts are moved out of it.
        let schema = self.schema(&file);
        self.lines(&file);
        self.sizes(&file);
        let device = self.device(&file.device);
        let coordinate = self.coordinate(file.coordinate.kind, &device);
        self.unique("environments", file.environments.iter().map(|e| e.id.as_str()));
        self.unique("modes", file.modes.iter().map(|m| m.id.as_str()));
        self.unique("questions", file.questions.iter().map(|q| q.id.as_str()));
        self.unique("channels", file.channels.iter().map(|c| c.id.as_str()));
        let questions: BTreeSet<&str> = file.questions.iter().map(|q| q.id.as_str()).collect();
        let ids: Vec<&str> = file.environments.iter().map(|e| e.id.as_str()).collect();
        let figures = self.figures(&file.figures, &ids);
        let environments: Vec<Environment> = file
            .environments
            .iter()
            .enumerate()
            .map(|(i, e)| {
                self.environment(&format!("environments[{i}]"), e, coordinate, &questions)
            })
            .collect();
        for (i, mode) in file.modes.iter().enumerate() {
            self.mode(i, mode);
        }
        let labels: Vec<&str> = file.modes.iter().map(|mode| mode.label.as_str()).collect();
        let analysis = self.analysis(&file.analysis, coordinate);
        let people = self.people(file.people);
        self.own_metrics(&file.metrics, &file.channels);
        let from_stages = self.stages(&file.stage, &file.channels);
        self.factors(&file.factors, &file.modes, &file.environments);
        let compare = self.compare(
            file.compare,
            &Comparable {
                modes: &file.modes,
                environments: &file.environments,
                factors: &file.factors,
                people: &people,
            },
            &analysis,
        );
        let mut questions = self.questions(file.questions, &labels);
        self.scores(&file.scores, &questions, &file.metrics);
        self.weigh(&file.scores, &environments, &mut questions);
        let around = Around {
            environments: &environments,
            coordinate,
            device: &device,
            force_limit_n: file.control.force_limit_n,
            modes: file.modes.len(),
        };
        let tasks = self.tasks(&file.tasks, &around, &mut questions);
        Study {
            id: file.study.id,
            title: file.study.title,
            design: self.design(file.design),
            coordinate,
            device,
            control: self.control(&file.control),
            masses: file.masses.map(|m| Masses {
                motor_kg: self.positive("masses.motor_g", m.motor_g) * MILLI,
                brake_kg: self.positive("masses.brake_g", m.brake_g) * MILLI,
            }),
            resistances: Resistances {
                motor_ohm: file
                    .resistances
                    .motor_ohm
                    .map(|r| self.positive("resistances.motor_ohm", r)),
                brake_ohm: file
                    .resistances
                    .brake_ohm
                    .map(|r| self.positive("resistances.brake_ohm", r)),
            },
            environments,
            modes: file.modes.clone(),
            questions,
            schema,
            channels: file.channels,
            people,
            metrics: file.metrics,
            stages: file.stage,
            scores: file.scores,
            tasks,
            axes: self.axes(file.axes),
            factors: file.factors,
            from_tables: Vec::new(),
            from_stages,
            analysis,
            compare,
            perception: self.perception(file.perception),
            replay: file.replay.model,
            figures,
            scenes: self.scenes(file.scenes),
        }
    }

    /// The axes of space; the direction of the push has length 1.
    fn axes(&mut self, axes: Option<Axes>) -> Option<Axes> {
        let axes = axes?;
        self.line("axes.frame", &axes.frame);
        if axes.frame.trim().is_empty() {
            let problem =
                "is empty; say where the axes point, such as \"x right, y up, z to the person\"";
            self.error("axes.frame", problem);
        }
        let [x, y, z] = axes.push;
        let length = (x * x + y * y + z * z).sqrt();
        if !(length > 0.0 && length.is_finite()) {
            let problem = format!("[{x}, {y}, {z}] has no direction; give one such as [0, 0, -1]");
            self.error("axes.push", problem);
        } else if (length - 1.0).abs() > Axes::UNIT {
            let [x, y, z] = axes.push.map(|part| part / length);
            let problem = format!("has the length {length} and must have 1: write [{x}, {y}, {z}]");
            self.error("axes.push", problem);
        }
        if !Axes::LOW_PASS_HZ.contains(&axes.low_pass_hz) {
            let problem = format!(
                "{} must be a number from {} to {}",
                axes.low_pass_hz,
                Axes::LOW_PASS_HZ.start(),
                Axes::LOW_PASS_HZ.end()
            );
            self.error("axes.low_pass_hz", problem);
        }
        let onset_m_s = self.positive("axes.onset_m_s", axes.onset_m_s);
        let offset_m_s = self.positive("axes.offset_m_s", axes.offset_m_s);
        // A wrong onset is told alone.
        if offset_m_s > onset_m_s && onset_m_s > 0.0 {
            let problem = format!(
                "{} must be at most onset_m_s, {onset_m_s}: a movement that began must end below that",
                axes.offset_m_s
            );
            self.error("axes.offset_m_s", problem);
        }
        Some(axes)
    }

    pub(super) fn unique<'b>(&mut self, list: &str, ids: impl Iterator<Item = &'b str>) {
        let mut seen = BTreeSet::new();
        let mut count = 0;
        for (i, id) in ids.enumerate() {
            count = i + 1;
            // Some stand in names of files, and not every disk knows case.
            if !seen.insert(id.to_ascii_lowercase()) {
                let what = format!("'{id}' stands twice; ids must differ, and by more than case");
                self.error(&format!("{list}[{i}].id"), what);
            }
        }
        self.at_most_listed(list, count);
        if count == 0 && ["environments", "modes"].contains(&list) {
            self.error(list, "the list is empty; a study needs at least one");
        }
    }

    pub(super) fn at_most_listed(&mut self, list: &str, count: usize) {
        if count > MOST_LISTED {
            let problem =
                format!("the list has {count} entries; at most {MOST_LISTED} are allowed");
            self.error(list, problem);
        }
    }

    fn design(&mut self, mut d: Design) -> Design {
        if d.repeats == 0 {
            self.error("design.repeats", "0 must be at least 1");
        }
        for (key, trials) in
            [("design.repeats", d.repeats), ("design.familiarisation", d.familiarisation)]
        {
            if trials > MOST_TRIALS {
                self.error(key, format!("{trials} must be at most {MOST_TRIALS}"));
            }
        }
        if d.redo_unmet > MOST_REDONE {
            let problem = format!("{} must be at most {MOST_REDONE}", d.redo_unmet);
            self.error("design.redo_unmet", problem);
        }
        self.within("design.trial_limit_s", d.trial_limit_s, LONGEST_S);
        // No pause is fine, and `within` takes nothing but numbers above 0.
        if d.pause_s == 0.0 {
            d.pause_s = 0.0; // without a sign
        } else {
            self.within("design.pause_s", d.pause_s, LONGEST_S);
        }
        d
    }

    fn device(&mut self, d: &DeviceTable) -> Device {
        if let (Some(low), Some(high)) = (d.theta_min_deg, d.theta_max_deg)
            && low >= high
        {
            let problem = format!("{high} must lie above theta_min_deg, which is {low}");
            self.error("device.theta_max_deg", problem);
        }
        Device {
            name: d.name.clone(),
            lever_m: d.lever_m.map(|v| self.positive("device.lever_m", v)),
            theta_min_rad: d
                .theta_min_deg
                .map(|v| self.near("device.theta_min_deg", v, FARTHEST_DEG).to_radians()),
            theta_max_rad: d
                .theta_max_deg
                .map(|v| self.near("device.theta_max_deg", v, FARTHEST_DEG).to_radians()),
            force_rate_hz: d.force_rate_hz.map(|v| self.positive("device.force_rate_hz", v)),
        }
    }

    fn control(&mut self, c: &ControlTable) -> Control {
        let velocity = match (c.velocity, c.velocity_cutoff_hz) {
            (VelocityKind::SecondOrder, cutoff_hz) => VelocityFilter::SecondOrder {
                cutoff_hz: self.positive(
                    "control.velocity_cutoff_hz",
                    cutoff_hz.unwrap_or(VelocityFilter::CUTOFF_HZ),
                ),
            },
            (VelocityKind::Difference, None) => VelocityFilter::Difference,
            (VelocityKind::Difference, Some(_)) => {
                let problem =
                    "is not used for a plain difference; remove it, or choose \"second_order\"";
                self.error("control.velocity_cutoff_hz", problem);
                VelocityFilter::Difference
            }
        };
        Control {
            rate_hz: self.within("control.rate_hz", c.rate_hz, FASTEST_HZ),
            let_go_n: self.not_negative("control.let_go_n", c.let_go_n),
            force_limit_n: self.positive("control.force_limit_n", c.force_limit_n),
            velocity,
        }
    }

    fn coordinate(&mut self, kind: CoordinateKind, device: &Device) -> Coordinate {
        match (kind, device.lever_m) {
            (CoordinateKind::Rotational, _) => Coordinate::Rotational,
            (CoordinateKind::Linear, Some(lever_m)) => Coordinate::Linear { lever_m },
            (CoordinateKind::Linear, None) => {
                let problem = "a linear coordinate x = L θ needs device.lever_m (1.0 for a slide)";
                self.error("coordinate.kind", problem);
                // So that no other finding follows from this one.
                Coordinate::Linear { lever_m: 1.0 }
            }
        }
    }

    fn mode(&mut self, i: usize, mode: &Mode) {
        if mode.id.is_code() {
            let problem =
                format!("'{}' looks like the code of a sealed mode; choose another id", mode.id);
            self.error(&format!("modes[{i}].id"), problem);
        }
        for (key, max_v) in [("motor_max_v", mode.motor_max_v), ("brake_max_v", mode.brake_max_v)] {
            if let Some(max_v) = max_v {
                self.not_negative(&format!("modes[{i}].{key}"), max_v);
            }
        }
        for drive in ActuatorKind::ALL {
            let has = mode.has(drive);
            if let Some(law) = mode.law.filter(|law| law.uses(drive) != has) {
                let law = law.as_str();
                let drive = drive.as_str();
                let what = match has {
                    true => format!("'{law}' does not use the {drive}; leave {drive}_max_v out"),
                    false => format!("'{law}' uses the {drive}; add {drive}_max_v, above 0"),
                };
                self.error(&format!("modes[{i}].law"), what);
            }
        }
    }

    fn analysis(&mut self, a: &AnalysisTable, coordinate: Coordinate) -> Analysis {
        let linear = coordinate != Coordinate::Rotational;
        let (onset, offset) =
            if linear { (ONSET_MM_S, OFFSET_MM_S) } else { (ONSET_DEG_S, OFFSET_DEG_S) };
        // The keys of a rotational and of a linear study, and their values.
        let numbers = [
            (["onset_deg_s", "onset_mm_s"], [a.onset_deg_s, a.onset_mm_s], onset),
            (["offset_deg_s", "offset_mm_s"], [a.offset_deg_s, a.offset_mm_s], offset),
            (["slope_from_deg", "slope_from_mm"], [a.slope_from_deg, a.slope_from_mm], 0.0),
        ];
        let [used, unused] = if linear { [1, 0] } else { [0, 1] };
        for (keys, values, _) in &numbers {
            if let Some(value) = values[used] {
                self.not_negative(&format!("analysis.{}", keys[used]), value);
            }
            if values[unused].is_some() {
                let key = format!("analysis.{}", keys[unused]);
                self.error(&key, "is not used for this coordinate; remove it");
            }
        }
        if a.grid_points < 2 {
            self.error("analysis.grid_points", format!("{} must be at least 2", a.grid_points));
        }
        if a.grid_points > MOST_POINTS {
            let problem = format!("{} must be at most {MOST_POINTS}", a.grid_points);
            self.error("analysis.grid_points", problem);
        }
        if !(a.confidence > 0.0 && a.confidence < 1.0) {
            self.error("analysis.confidence", format!("{} must lie between 0 and 1", a.confidence));
        }
        let [onset_rad_s, offset_rad_s, slope_from_rad] = numbers.map(|(keys, values, default)| {
            self.position("analysis", keys, values, coordinate, Some(default))
        });
        let analysis = Analysis {
            onset_rad_s,
            offset_rad_s,
            slope_from_rad,
            grid_points: a.grid_points,
            confidence: a.confidence,
        };
        if analysis.offset_rad_s > analysis.onset_rad_s {
            self.error("analysis", "the offset velocity must not exceed the onset velocity");
        }
        analysis
    }
}
