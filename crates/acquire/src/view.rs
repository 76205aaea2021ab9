//! Everything a screen shows, as plain values: the runner fills it, a screen draws it.
//!
//! It contains nothing that would reveal a blinded session's mode, so no screen can show it by
//! mistake.

use crate::tasks::TaskNow;
use std::collections::VecDeque;
use zwidth_study::{AnswerScale, Kind, Voltages};

/// Points of a trace kept, at most: a trial of 10 s at [`TRACE_HZ`].
pub const TRACE_POINTS: usize = 1000;

/// Most points per second in a trace: twice what a terminal can show of a four-second trial.
pub const TRACE_HZ: f64 = 100.0;

/// Lines of talk kept.
pub const MESSAGES: usize = 50;

/// Everything a screen shows.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct View {
    /// The study's id.
    pub study: String,
    /// The participant's code.
    pub participant: String,
    /// The session's id.
    pub session: String,
    /// The device's name, with its version.
    pub device: String,
    /// Whether the device is a simulated one: the screen says so.
    pub simulated: bool,
    /// Whether modes and voltages are hidden.
    pub blinded: bool,
    /// The phase of the session.
    pub phase: Phase,
    /// Whether a signal, or a terminal that is gone, ends it: nobody meant it to be over.
    pub is_cut_off: bool,
    /// The trial in progress, or the next one; none before homing and after the last.
    pub trial: Option<Current>,
    /// The presentation that it belongs to, if it is of a task.
    pub task: Option<TaskNow>,
    /// Whether the last answer to a task was right, where the participant is to be told so now.
    pub feedback: Option<bool>,
    /// Trials of the order that are done.
    pub done: usize,
    /// Trials of the order that are done or still to be done.
    pub total: usize,
    /// How much is done of each part of the order: of each condition, or of each environment if
    /// modes are hidden. Familiarisation is in none.
    pub cells: Vec<Cell>,
    /// How long the session takes, this time.
    pub course: Course,
    /// Whether the pause goes on until somebody ends it.
    pub held: bool,
    /// The running step of the device check, and what is done in it.
    pub step: Option<String>,
    /// Work space, rad.
    pub theta_range_rad: (f64, f64),
    /// Where the environment's wall begins, rad, if it has one.
    pub wall_rad: Option<f64>,
    /// The trial's course so far, oldest first; it stays until the next trial begins.
    pub trace: VecDeque<Point>,
    /// Whether that trial met the protocol; none while it runs, and of a presentation of a task.
    pub verdict: Option<Verdict>,
    /// The condition of that trial, by its labels; none of a presentation of a task, whose levels differ.
    pub traced: Option<Labels>,
    /// The force that the environment of that trial commands at each angle, rad and N; none of a task's
    /// presentation, whose level is for the participant to find, and where there is no law.
    pub law: Vec<(f64, f64)>,
    /// The courses of trials before, oldest first.
    pub earlier: VecDeque<Earlier>,
    /// The least and the greatest user force of the trials before this one, N; none before the
    /// first. By these the scale of the force stays as it is within a trial.
    pub force_before_n: Option<[f64; 2]>,
    /// How the control loop keeps time.
    pub timing: Timing,
    /// The device check: name, value with unit, whether it passed.
    pub checks: Vec<CheckLine>,
    /// Messages, oldest first: refusals, warnings, stored trials.
    pub messages: VecDeque<String>,
    /// How many messages there were in all, those that went included.
    pub said: usize,
}

/// The phase of the session, with what a screen shows of it.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Phase {
    /// The device is being checked.
    #[default]
    Check,
    /// A step of the device check waits for somebody to do this, and to say so.
    Step {
        /// What is to be done.
        what: String,
        /// Whether the lever will move by itself.
        moves: bool,
    },
    /// Somebody is to hold the lever against its stop, and to say so.
    AtStop,
    /// The lever is brought to its stop, actuators off.
    Homing,
    /// The next trial waits for its start.
    Ready,
    /// A trial runs.
    Trial {
        /// Time since its start, s.
        t_s: f64,
        /// Longest it may take, s.
        limit_s: f64,
    },
    /// The trial's question waits for an answer.
    Question {
        /// Its wording.
        text: String,
        /// What may be answered.
        scale: AnswerScale,
    },
    /// The pause after a trial.
    Pause {
        /// Time left, s.
        left_s: f64,
        /// Its length, s.
        pause_s: f64,
    },
    /// Stopped, both actuators at 0 V, until someone goes on or quits.
    Stopped {
        /// What stopped it, in words.
        why: String,
    },
    /// Every trial of the order is done.
    Done,
    /// Nothing more happens.
    Left,
}

/// Trials of one kind that are done.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cell {
    /// The environment's label.
    pub environment: String,
    /// The mode's label; none in a blinded session.
    pub mode: Option<String>,
    /// How many are done.
    pub done: usize,
    /// How many there are.
    pub of: usize,
}

/// How long a session takes, since it was begun or continued.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Course {
    /// Since the first trial, s.
    pub elapsed_s: f64,
    /// The expected remaining time, s; none if nothing is left.
    pub left_s: Option<f64>,
}

/// The trial that a screen shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Current {
    /// Its number: the file's.
    pub trial: u32,
    /// Its place in the order, from 1 (a repeat keeps its place).
    pub place: usize,
    /// Experiment or familiarisation.
    pub kind: Kind,
    /// The environment's label.
    pub environment: String,
    /// The mode's label; none in a blinded session.
    pub mode: Option<String>,
    /// The trial that it replaces, if it is a repeat.
    pub repeats: Option<u32>,
}

/// Whether a trial was what the protocol asks for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Verdict {
    /// Its number.
    pub trial: u32,
    /// What was not met, in words; none where all was.
    pub unmet: Option<String>,
}

impl Verdict {
    /// The verdict in words.
    pub(crate) fn in_words(&self) -> String {
        match &self.unmet {
            None => format!("trial {} met the protocol", self.trial),
            Some(what) => format!("trial {} did not meet the protocol: {what}", self.trial),
        }
    }
}

/// A condition by its labels; the mode is hidden in a blinded session.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Labels {
    /// The environment's.
    pub environment: String,
    /// The mode's.
    pub mode: Option<String>,
}

/// The course of a trial before.
#[derive(Debug, Clone, PartialEq)]
pub struct Earlier {
    /// Its condition.
    pub labels: Labels,
    /// Its points, oldest first.
    pub points: Vec<Point>,
}

/// Trials before of one condition that are kept.
pub const EARLIER: usize = 3;

/// One point of a trace, SI.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Point {
    /// Time since the trial's start, s.
    pub t_s: f64,
    /// Lever angle, rad.
    pub theta_rad: f64,
    /// Lever velocity, rad/s.
    pub theta_dot_rad_s: f64,
    /// User force, N.
    pub force_ex_n: f64,
    /// Commanded voltages; none in a blinded session.
    pub voltages: Option<Voltages>,
}

/// How the control loop keeps time, in the trial in progress or the last one.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Timing {
    /// Nominal rate, Hz.
    pub rate_hz: f64,
    /// Samples per second so far, Hz.
    pub measured_hz: f64,
    /// Lateness of a tick against its deadline, median, s.
    pub jitter_p50_s: f64,
    /// 99th percentile, s.
    pub jitter_p99_s: f64,
    /// Worst, s.
    pub jitter_max_s: f64,
    /// Ticks that missed their deadline by a whole period or more.
    pub missed: u64,
    /// Gaps in the data: samples that come after one or more missed ones.
    pub dropouts: u64,
}

/// One line of the device check.
#[derive(Debug, Clone, PartialEq)]
pub struct CheckLine {
    /// What was checked.
    pub name: String,
    /// What was found, with its unit.
    pub value: String,
    /// Whether it passed.
    pub ok: bool,
}

impl View {
    /// Adds a line of talk; the oldest goes.
    pub(crate) fn say(&mut self, message: impl Into<String>) {
        if self.messages.len() == MESSAGES {
            self.messages.pop_front();
        }
        self.messages.push_back(message.into());
        self.said += 1;
    }

    /// The courses of trials before of the condition that is shown.
    pub(crate) fn earlier_alike(&self) -> impl Iterator<Item = &[Point]> {
        let alike = |earlier: &&Earlier| Some(&earlier.labels) == self.traced.as_ref();
        self.earlier.iter().filter(alike).map(|earlier| &*earlier.points)
    }

    /// Keeps the course that is shown beside those of its condition, of which the oldest goes.
    fn keep_course(&mut self) {
        let Some(labels) = self.traced.take().filter(|_| !self.trace.is_empty()) else { return };
        let alike = self.earlier.iter().filter(|earlier| earlier.labels == labels).count();
        let oldest = self.earlier.iter().position(|earlier| earlier.labels == labels);
        if let Some(oldest) = oldest.filter(|_| alike >= EARLIER) {
            self.earlier.remove(oldest);
        }
        let finite = self.trace.iter().filter(|point| point.force_ex_n.is_finite());
        self.earlier.push_back(Earlier { labels, points: finite.copied().collect() });
    }

    /// Makes room for the trace of the next trial, whose environment commands this force; the course of
    /// the one before is kept, and so are its forces.
    pub(crate) fn begin_trace(&mut self, law: Vec<(f64, f64)>) {
        self.keep_course();
        self.law = law;
        let trial = self.trial.as_ref().filter(|_| self.task.is_none());
        self.traced = trial.map(|trial| Labels {
            environment: trial.environment.clone(),
            mode: trial.mode.clone(),
        });
        let forces = self.trace.iter().map(|point| point.force_ex_n).filter(|n| n.is_finite());
        self.force_before_n = forces.fold(self.force_before_n, |before, n| {
            let [low, high] = before.unwrap_or([n, n]);
            Some([low.min(n), high.max(n)])
        });
        self.trace.clear();
        self.verdict = None;
    }

    /// Adds a point to the trace unless it comes sooner than [`TRACE_HZ`] allows; the oldest goes.
    pub(crate) fn trace(&mut self, point: Point) {
        // A thousandth of a point's time: a tick that comes a hair early is not left out.
        const SLACK: f64 = 0.999;
        if self.trace.back().is_some_and(|last| (point.t_s - last.t_s) * TRACE_HZ < SLACK) {
            return;
        }
        if self.trace.len() == TRACE_POINTS {
            self.trace.pop_front();
        }
        self.trace.push_back(point);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_trials_of_a_condition_are_kept_beside_the_one_that_runs() {
        let current = |mode: &str| Current {
            trial: 1,
            place: 1,
            kind: Kind::Trial,
            environment: "Spring".into(),
            mode: Some(mode.into()),
            repeats: None,
        };
        let mut view = View::default();
        for (i, mode) in ["a", "b", "a", "a", "a", "a", "a"].into_iter().enumerate() {
            view.trial = Some(current(mode));
            view.begin_trace(Vec::new());
            view.trace(Point { force_ex_n: i as f64, ..Point::default() });
        }
        let forces = |view: &View| -> Vec<i32> {
            view.earlier_alike().map(|points| points[0].force_ex_n as i32).collect()
        };
        assert_eq!(forces(&view), [3, 4, 5]);
        view.trial = Some(current("b"));
        view.begin_trace(Vec::new());
        assert_eq!(forces(&view), [1]);
    }

    #[test]
    fn a_trace_takes_in_no_more_than_its_rate_and_forgets_its_oldest_points() {
        let mut view = View::default();
        for i in 0..20_000 {
            view.trace(Point { t_s: f64::from(i) * 1e-3, ..Point::default() });
        }
        assert_eq!(view.trace.len(), TRACE_POINTS);
        assert!((view.trace[1].t_s - view.trace[0].t_s - 0.01).abs() < 1e-9);
    }
}
