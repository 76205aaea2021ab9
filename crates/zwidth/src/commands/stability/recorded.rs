//! `zwidth stability --study`: whether the swings in recorded trials are the device's own.

use super::super::output::Output;
use super::args::StabilityArgs;
use crate::exit::Exit;
use crate::screen::Screen;
use anyhow::{anyhow, bail};
use serde::Serialize;
use std::path::{Path, PathBuf};
use zwidth_plan::{Oscillations, oscillations};
use zwidth_replay::{SwingAnswer, VERSION, trial_oscillation};
use zwidth_store::StudyData;
use zwidth_study::{StudyId, TrialMeta};
use zwidth_tables::Table;

/// What `--json` prints of a trial.
#[derive(Serialize)]
struct TrialOut<'a> {
    participant: &'a str,
    session: &'a str,
    trial: u32,
    answer: &'static str,
    why: String,
    frequency_hz: Option<f64>,
    amplitude_rad: Option<f64>,
    power_factor: Option<f64>,
}

/// Answers for one trial, for those of a session, or for all that count.
pub(super) fn recorded(
    root: &Path,
    study: &StudyId,
    command: &StabilityArgs,
    screen: &Screen,
) -> anyhow::Result<Exit> {
    let data = super::super::load(root, study)?;
    let wanted = |meta: &TrialMeta| {
        command.participant.as_ref().is_none_or(|participant| *participant == meta.participant)
            && command.session.as_ref().is_none_or(|session| *session == meta.session)
            && command.trial.is_none_or(|trial| trial == meta.trial)
    };
    let count = data.counting().filter(|trial| wanted(&trial.meta)).count();
    if count == 0 {
        bail!("{} of {study}; `zwidth list {study}` shows which count", words::nothing(command));
    }
    let bar = screen.bar(count);
    if data.study.axes.is_some() {
        return Err(anyhow!(
            "{study} has [axes], and the model that judges swings has one coordinate: look at the paths (figures space.…) \
             and at path_m, and judge the device's loop on one axis in a study without [axes]"
        ));
    }
    let oscillations = oscillations(&data, &wanted, &|| bar.inc(1)).map_err(|e| anyhow!("{e}"))?;
    bar.finish_and_clear();
    oscillations.problems.iter().for_each(|problem| screen.warn(problem));
    let files = write(root, &data, command, &oscillations)?;
    let trials = oscillations.trials.iter().map(|(meta, one)| TrialOut {
        participant: meta.participant.as_str(),
        session: meta.session.as_str(),
        trial: meta.trial,
        answer: one.origin.answer().as_str(),
        why: one.origin.why(),
        frequency_hz: one.recorded.map(|swings| swings.frequency_hz),
        amplitude_rad: one.recorded.map(|swings| swings.amplitude_rad),
        power_factor: one.power_factor,
    });
    screen.give(&trials.collect::<Vec<_>>(), || tell(&oscillations, &files, screen))?;
    Ok(if oscillations.problems.is_empty() { Exit::Fine } else { Exit::Partly })
}

fn write(
    root: &Path,
    data: &StudyData,
    command: &StabilityArgs,
    oscillations: &Oscillations,
) -> anyhow::Result<Vec<PathBuf>> {
    let study = data.layout.study();
    let usual = root.join("reports").join(study.as_str()).join("stability");
    let folder = command.out.clone().unwrap_or(usual);
    let sources = oscillations.trials.iter().map(|(meta, _)| meta.source);
    let mark = zwidth_figures::mark(sources);
    let source = mark.clone().unwrap_or_else(|| "recorded, and model runs beside it".to_owned());
    let made_from = [
        ("study", study.to_string()),
        ("plant", words::plant(oscillations.is_fitted).to_owned()),
        ("version", VERSION.to_string()),
        ("source", source),
    ];
    let mut output = Output::new(&folder, made_from);
    let rows: Vec<_> =
        oscillations.trials.iter().map(|(meta, one)| trial_oscillation(meta, one)).collect();
    output.table("oscillations", &Table::of_rows(&rows)?)?;
    // Courses are drawn of a single trial; of several, the table has the numbers.
    if let [(meta, one)] = &oscillations.trials[..]
        && let Some(swings) = one.recorded.filter(|_| !one.courses.is_empty())
    {
        let name = format!("oscillation.{}.{}.{}", meta.participant, meta.session, meta.trial);
        let notes = [words::trial_line(meta, one), words::plant(oscillations.is_fitted).to_owned()];
        let courses: Vec<_> =
            one.courses.iter().map(|course| (&course.t_s[..], &course.theta_rad[..])).collect();
        let within_s = [swings.from_s, swings.to_s];
        let figure =
            zwidth_figures::oscillation(&courses, within_s, swings.period_s(), &notes, mark);
        output.figure(&name, figure)?;
    }
    Ok(output.files)
}

fn tell(oscillations: &Oscillations, files: &[PathBuf], screen: &Screen) {
    /// Trials of which each has a line; of more only what is not calm.
    const FEW: usize = 12;
    let is_few = oscillations.trials.len() <= FEW;
    // Of many trials the calm ones would hide the others.
    let lines = oscillations.trials.iter().filter(|row| is_few || row.1.recorded.is_some());
    lines.for_each(|(meta, one)| screen.result(words::trial_line(meta, one)));
    if oscillations.trials.len() > 1 {
        let parts = SwingAnswer::ALL.map(|answer| {
            let n = oscillations.trials.iter().filter(|t| t.1.origin.answer() == answer).count();
            format!("{n} {}", answer.as_str())
        });
        screen.result(format!("{} trials: {}", oscillations.trials.len(), parts.join(", ")));
    }
    screen.result(words::plant(oscillations.is_fitted));
    screen.files(files, &["png", "csv"], "");
}

mod words {
    use crate::commands::stability::StabilityArgs;
    use zwidth_replay::{Oscillation, RecordedSwings};
    use zwidth_study::TrialMeta;

    pub(super) fn nothing(command: &StabilityArgs) -> String {
        let parts = [
            command.participant.as_ref().map(ToString::to_string),
            command.session.as_ref().map(ToString::to_string),
            command.trial.map(|trial| format!("trial {trial}")),
        ];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        format!("no trial that counts: {}", parts.join(" "))
    }

    pub(super) fn plant(is_fitted: bool) -> &'static str {
        if is_fitted {
            "The model's plant is the study's, as fitted."
        } else {
            "The model's plant is the thesis', by eye: `zwidth run STUDY` fits the study's own."
        }
    }

    /// `P01 S01 trial 7 (spring, active): real: 24 swings, ±0.35° at 12.4 Hz, 1.20 to 3.30 s: …`
    pub(super) fn trial_line(meta: &TrialMeta, one: &Oscillation) -> String {
        let TrialMeta { participant, session, trial, environment, mode, .. } = meta;
        let answer = one.origin.answer().as_str();
        let who = format!("{participant} {session} trial {trial} ({environment}, {mode})");
        let Some(swings) = &one.recorded else {
            return format!("{who}: {answer}: {}", one.origin.why());
        };
        let seen = format!(
            "{} swings of ±{:.3}° at {:.1} Hz, {:.2} to {:.2} s",
            swings.swings,
            swings.amplitude_rad.to_degrees(),
            swings.frequency_hz,
            swings.from_s,
            swings.to_s
        );
        let beside = if one.courses.is_empty() {
            String::new()
        } else {
            let steps = one.stepped_rad.map(|rad| format!("{:.3}", rad.to_degrees()));
            let cos = one.power_factor.map_or(String::new(), |cos| format!("; cos φ {cos:+.2}"));
            format!(
                " ({}; {}, by steps halved twice ±{}°{cos})",
                model_swings("model with the user's force", &one.with_force),
                model_swings("with its slow part", &one.alone),
                steps.join(", "),
            )
        };
        format!("{who}: {answer}: {seen}: {}{beside}", one.origin.why())
    }

    fn model_swings(name: &str, swings: &Option<RecordedSwings>) -> String {
        match swings {
            None => format!("{name} no swing"),
            Some(s) => {
                let degrees = s.amplitude_rad.to_degrees();
                format!("{name} ±{degrees:.3}° at {:.1} Hz", s.frequency_hz)
            }
        }
    }
}
