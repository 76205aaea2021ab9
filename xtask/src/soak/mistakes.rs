//! Imports studies of another device, clean or with one mistake: a mistake that leaves a trace and
//! changes a result must be found or refused.
//!
//! A clean study is drawn from its seed: people, modes, repeats, a rate, a spring, noise. A mistake is then
//! made in its files or its mapping. The import must refuse it, or say "read with care"; if it says nothing,
//! the means of the two modes must be those of the clean study, within the interval of each.
//! Mistakes that leave no trace (labels exchanged, a force off by a factor below two) are tried
//! too. They may leave a trace only by chance: samples lost around the turn of a motion can leave
//! one sample that stands alone.

use crate::shell::{remove, scratch};
use crate::tried::held;
use anyhow::{Context as _, ensure};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;
use zwidth_import::{By, Mapping, import};
use zwidth_store::{Layout, Memory, Signal, StudyData, hex_blake3, read_trial_from};
use zwidth_study::{Study, StudyId};

const PEOPLE: usize = 3;
const REPEATS: usize = 3;
const MODES: [&str; 2] = ["a", "b"];
/// Student's t at 97.5 % with one degree of freedom less than the trials of a mode, 9.
const T_8: f64 = 2.306_004_135_204_166;
/// A hand moves where it is faster than this, rad/s (5°/s).
const ONSET_RAD_S: f64 = 0.087;

/// Makes a mistake; beside the files it takes a share of a trial, and what it draws from.
type Spoil = fn(Files, f64, &mut Draw) -> Files;

/// What is done to a clean study, and whether it leaves a trace.
const MISTAKES: [(&str, bool, Spoil); 34] = [
    ("a label flips just before files end", true, |mut files, _, draw| {
        let seconds = draw.between(0.1, 0.3);
        for trial in files.trials.iter_mut().filter(|trial| trial.mode[0] == "b") {
            let end = trial.rows[trial.rows.len() - 1][0] - seconds;
            let flips = trial.rows.iter().position(|row| row[0] > end).unwrap_or(0);
            trial.mode[flips..].fill("a");
        }
        // No number tells the second trial from the first.
        files.unnumbered()
    }),
    ("a label flips in the middle of a file", true, |files, _, draw| {
        let flipped = files.in_one(draw, |trial| {
            let middle = trial.rows.len() / 2;
            let other = if trial.mode[0] == "a" { "b" } else { "a" };
            trial.mode[middle..].fill(other);
        });
        flipped.unnumbered()
    }),
    ("an attempt that was cut short counts", true, |files, share, draw| {
        files.attempted(draw, |rows| (share * rows as f64) as usize)
    }),
    ("an attempt counts twice", true, |files, _, draw| files.attempted(draw, |rows| rows)),
    ("a trial is missing", true, |mut files, _, draw| {
        let one = draw.below(files.trials.len());
        files.trials.remove(one);
        files
    }),
    ("files in a shell's order", true, |mut files, _, _| {
        files.trials.reverse();
        files.unnumbered()
    }),
    ("a counter of microseconds starts over", true, |mut files, _, _| {
        const TURN: f64 = 4_294_967_296.0;
        files.time = |t| format!("{}", (1e6 * t + TURN - 1.2e6).rem_euclid(TURN).round());
        files.mapped("unit = \"s\"", "unit = \"us\"")
    }),
    ("samples are missing, their times are there", true, |files, share, draw| {
        let seconds = draw.between(0.15, 0.4);
        files.in_all(|trial| trial.loses(share, seconds))
    }),
    ("samples are missing at a rate, a counter shows them", true, |files, share, draw| Files {
        is_counted: true,
        ..files.at_a_rate(share, draw)
    }),
    ("each row twice", true, |files, _, _| Files { is_doubled: true, ..files }),
    ("a clock is set back", true, |files, _, draw| files.in_half(draw, |row| row[0] -= 0.3)),
    ("a clock is set forward", true, |files, _, draw| files.in_half(draw, |row| row[0] += 10.0)),
    ("milliseconds taken for seconds", true, |files, _, _| Files {
        time: |t| format!("{:.3}", 1e3 * t),
        ..files
    }),
    ("seconds taken for milliseconds", true, |files, _, _| {
        files.mapped("unit = \"s\"", "unit = \"ms\"")
    }),
    ("mN taken for N", true, |files, _, _| files.in_rows(|row| row[3] *= 1e3)),
    ("a torque taken for a force", true, |files, _, _| files.in_rows(|row| row[3] *= 0.1)),
    ("a force of the other sign", true, |files, _, _| files.in_rows(|row| row[3] = -row[3])),
    ("degrees taken for radians", true, |files, _, _| {
        files.mapped("from = \"angle\"\nunit = \"deg\"", "from = \"angle\"\nunit = \"rad\"")
    }),
    ("deg/s taken for rad/s", true, |files, _, _| {
        files.mapped("unit = \"deg/s\"", "unit = \"rad/s\"")
    }),
    ("a first sample that is no zero", true, |files, _, draw| {
        let off = files.in_all(|trial| {
            let offset = draw.between(1.5, 3.0);
            trial.rows.iter_mut().for_each(|row| row[3] += offset);
            trial.rows[0][3] /= 2.0;
        });
        off.mapped("unit = \"N\"", "unit = \"N\"\nzero = \"first\"")
    }),
    ("a zero over a stretch in motion", true, |files, _, _| {
        files.mapped("unit = \"N\"", "unit = \"N\"\nzero = { from_s = 0.4, to_s = 1.0 }")
    }),
    ("a word for a missing value", true, |files, _, draw| {
        let word = ["NA", "n/a", "None", "-nan(ind)", "#N/A", "null"][draw.below(6)];
        files.with_word(draw, word)
    }),
    ("a number for a missing value", true, |files, _, draw| files.with_word(draw, "-9999")),
    ("decimal commas", true, |files, _, _| Files { decimal: ',', ..files }),
    ("an angle that starts over", true, |files, _, _| {
        files.in_rows(|row| row[1] = (row[1] + 340.0).rem_euclid(360.0))
    }),
    ("a sensor at the end of its range", true, |files, _, draw| {
        let forces = files.trials.iter().flat_map(|trial| &trial.rows).map(|row| row[3]);
        let end = draw.between(0.5, 0.7) * forces.fold(0.0, f64::max);
        files.in_rows(|row| row[3] = row[3].min(end))
    }),
    ("a sensor that stops", true, |files, _, draw| {
        files.in_one(draw, |trial| {
            let from = trial.rows.len() * 2 / 5;
            let held = trial.rows[from][3];
            trial.rows[from..].iter_mut().for_each(|row| row[3] = held);
        })
    }),
    ("an angle that is stuck in one trial", true, |files, _, draw| {
        files.in_one(draw, |trial| trial.rows.iter_mut().for_each(|row| row[1] = 0.0))
    }),
    ("another rate in one file", true, |files, _, draw| {
        files.in_one(draw, |trial| trial.rows.iter_mut().for_each(|row| row[0] *= 2.0))
    }),
    ("a stump of a trial", true, |files, _, draw| files.attempted(draw, |rows| rows / 8)),
    ("rows out of order", true, |files, _, draw| {
        files.in_one(draw, |trial| {
            let middle = trial.rows.len() / 2;
            trial.rows.swap(middle, middle + 5);
        })
    }),
    ("samples are missing at a rate, and nothing counts them", false, |files, share, draw| {
        files.at_a_rate(share, draw)
    }),
    ("two labels exchanged", false, |mut files, _, _| {
        let [one, other] = [0, REPEATS].map(|trial| files.trials[trial].mode[0]);
        files.trials[0].mode.fill(other);
        files.trials[REPEATS].mode.fill(one);
        files
    }),
    ("a force off by a half", false, |files, _, _| files.in_rows(|row| row[3] *= 1.5)),
];

/// Tries so many seeds, one mistake each and as many clean studies.
pub(crate) fn mistakes(studies: u64, first: u64) -> anyhow::Result<()> {
    let began = Instant::now();
    let folder = &scratch("mistakes");
    remove(folder)?;
    let tried: Vec<(usize, Outcome, Outcome)> = (first..first + studies)
        .into_par_iter()
        .map(|seed| one(folder, seed).with_context(|| format!("seed {seed}")))
        .collect::<anyhow::Result<_>>()?;
    let mut rows: BTreeMap<usize, [u64; 4]> = BTreeMap::new();
    let mut wrong = Vec::new();
    let mut false_findings = 0;
    let mut untraced = 0;
    let mut unlike = Vec::new();
    for (seed, (mistake, clean, spoilt)) in (first..).zip(&tried) {
        let (name, leaves_trace, _) = MISTAKES[*mistake];
        let row = rows.entry(*mistake).or_default();
        match spoilt {
            Outcome::Refused => row[0] += 1,
            Outcome::Flagged(_) => row[1] += 1,
            Outcome::Silent { is_off: false, .. } => row[2] += 1,
            Outcome::Silent { is_off: true, .. } => row[3] += 1,
        }
        let is_silent = matches!(spoilt, Outcome::Silent { .. });
        if leaves_trace && matches!(spoilt, Outcome::Silent { is_off: true, .. }) {
            wrong.push(format!("seed {seed}: {name}: nothing is said, and a mean is off"));
        }
        untraced += u64::from(!leaves_trace);
        if !leaves_trace && !is_silent {
            unlike.push(format!("seed {seed}: {name}: it leaves a trace: {spoilt:?}"));
        }
        if !matches!(clean, Outcome::Silent { .. }) {
            false_findings += 1;
            if false_findings <= 3 {
                println!("seed {seed}, clean: {clean:?}");
            }
        }
    }
    println!("{:<58} refused flagged harmless  silent", format!("{studies} studies from {first}"));
    for (mistake, [refused, flagged, harmless, silent]) in rows {
        println!("{:<58} {refused:>7} {flagged:>7} {harmless:>8} {silent:>7}", MISTAKES[mistake].0);
    }
    println!("{false_findings} of {studies} clean studies have a finding");
    for line in wrong.iter().chain(&unlike).take(20) {
        println!("{line}");
    }
    std::fs::remove_dir_all(folder).ok();
    ensure!(wrong.is_empty(), "{} mistakes went in without a word", wrong.len());
    ensure!(
        100 * unlike.len() as u64 <= untraced,
        "{} of {untraced} mistakes leave a trace that are said to leave none",
        unlike.len()
    );
    ensure!(
        100 * false_findings < studies.max(100),
        "{false_findings} of {studies} clean studies have a finding"
    );
    let what = "recordings of others with one mistake each, and as many clean ones: what leaves a trace and changes a result \
                is found or refused";
    held(what, format!("cargo xtask soak mistakes {studies} {first}"), studies, began)
}

/// What came of an import.
#[derive(Debug, Clone)]
enum Outcome {
    Refused,
    /// Something was said, here what.
    Flagged(#[allow(dead_code)] String),
    /// Nothing was said; the means of each mode, and whether one is off.
    Silent {
        means: Vec<(f64, f64)>,
        is_off: bool,
    },
}

/// A clean study and one with a mistake, of a seed.
fn one(folder: &Path, seed: u64) -> anyhow::Result<(usize, Outcome, Outcome)> {
    let mut draw = Draw(seed, 0);
    let mistake = (seed % MISTAKES.len() as u64) as usize;
    let clean = Files::clean(&mut draw);
    let share = draw.between(0.35, 0.5);
    let (_, _, spoil) = MISTAKES[mistake];
    let spoilt = spoil(clean.clone(), share, &mut draw);
    let mut found = imported(&folder.join(format!("{seed}-clean")), &clean)?;
    let mut other = imported(&folder.join(format!("{seed}-spoilt")), &spoilt)?;
    if let (Outcome::Silent { means, .. }, Outcome::Silent { means: spoilt, is_off }) =
        (&mut found, &mut other)
    {
        *is_off = means.len() != spoilt.len()
            || means.iter().zip(spoilt).any(|((mean, half), (found, _))| {
                (*mean - *found).abs() > *half || !found.is_finite()
            });
    }
    Ok((mistake, found, other))
}

/// Numbers that follow from a seed.
#[derive(Clone)]
struct Draw(u64, u64);

impl Draw {
    /// A number in [low, high).
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.1 += 1;
        let hash = hex_blake3(format!("mistakes {} {}", self.0, self.1).as_bytes());
        let bits = u64::from_str_radix(&hash[..13], 16).unwrap_or_default();
        low + (high - low) * bits as f64 / 2_f64.powi(52)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.between(0.0, n as f64) as usize).min(n - 1)
    }
}

/// A trial's file before it is written: a row a sample, time (s), angle (°), velocity (°/s), force (N).
#[derive(Clone)]
struct Trial {
    name: String,
    mode: Vec<&'static str>,
    rows: Vec<[f64; 4]>,
    /// Cells that are written otherwise: by row and column.
    words: BTreeMap<(usize, usize), &'static str>,
}

/// The files of a study, and how they are mapped.
#[derive(Clone)]
struct Files {
    trials: Vec<Trial>,
    map: String,
    study: String,
    /// How times are written.
    time: fn(f64) -> String,
    decimal: char,
    is_doubled: bool,
    is_counted: bool,
}

const MAP: &str = r#"kind = "trials"
[file]
delimiter = ";"
[name]
pattern = '(?<who>P\d+)_(?<mode>[a-z])_(?<repeat>\d+)'
[trial]
participant = { name = "who" }
session = "S01"
environment = "spring"
mode = { column = "mode" }
repeat = { name = "repeat" }
[time]
from = "t"
unit = "s"
zero = "first"
[[column]]
to = "theta_rad"
from = "angle"
unit = "deg"
[[column]]
to = "theta_dot_rad_s"
from = "velocity"
unit = "deg/s"
[[column]]
to = "force_ex_n"
from = "force"
unit = "N"
"#;

fn study(stiffness: f64) -> String {
    format!(
        "schema = 2\n[study]\nid = \"theirs\"\ntitle = \"x\"\n[design]\nrepeats = {REPEATS}\nfamiliarisation = 0\n\
         trial_limit_s = 60.0\npause_s = 0.0\n[coordinate]\nkind = \"rotational\"\n[device]\nname = \"x\"\nlever_m = 0.1\n\
         [[environments]]\nid = \"spring\"\nlabel = \"x\"\nkind = \"spring\"\nstiffness_n_per_rad = {stiffness:?}\nrest_deg = 0.0\n\
         [analysis]\nonset_deg_s = 5.0\noffset_deg_s = 2.0\n[[modes]]\nid = \"a\"\nlabel = \"A\"\n[[modes]]\nid = \"b\"\nlabel = \"B\"\n"
    )
}

impl Files {
    fn clean(draw: &mut Draw) -> Self {
        let rate_hz = [50.0, 100.0, 200.0][draw.below(3)];
        let stiffness = draw.between(3.0, 8.0);
        let noise_n = draw.between(0.005, 0.03);
        let mut trials = Vec::new();
        for person in 1..=PEOPLE {
            let pace = draw.between(0.8, 1.2);
            for mode in MODES {
                for repeat in 1..=REPEATS {
                    let slower = if mode == "b" { 1.25 } else { 1.0 };
                    let move_s = pace * slower * draw.between(0.55, 0.65);
                    let far = draw.between(35.0, 45.0);
                    let rest_s = draw.between(0.5, 0.8);
                    let reach = [far, rest_s, move_s, draw.between(0.1, 0.3)];
                    let rows = rows(reach, rate_hz, stiffness, noise_n, draw);
                    trials.push(Trial {
                        name: format!("P{person}_{mode}_{repeat}.csv"),
                        mode: vec![mode; rows.len()],
                        rows,
                        words: BTreeMap::new(),
                    });
                }
            }
        }
        Self {
            trials,
            map: MAP.to_owned(),
            study: study(stiffness),
            time: |t| format!("{t:.6}"),
            decimal: '.',
            is_doubled: false,
            is_counted: false,
        }
    }

    /// With a change in one trial that is drawn.
    fn in_one(mut self, draw: &mut Draw, change: impl FnOnce(&mut Trial)) -> Self {
        let one = draw.below(self.trials.len());
        change(&mut self.trials[one]);
        self
    }

    /// With a change in the second half of such a trial.
    fn in_half(self, draw: &mut Draw, change: fn(&mut [f64; 4])) -> Self {
        self.in_one(draw, |trial| {
            let middle = trial.rows.len() / 2;
            trial.rows[middle..].iter_mut().for_each(change);
        })
    }

    /// With a change in every trial.
    fn in_all(mut self, change: impl FnMut(&mut Trial)) -> Self {
        self.trials.iter_mut().for_each(change);
        self
    }

    /// With a change in every row.
    fn in_rows(mut self, change: impl FnMut(&mut [f64; 4])) -> Self {
        self.trials.iter_mut().flat_map(|trial| &mut trial.rows).for_each(change);
        self
    }

    /// With a word in the place of a force.
    fn with_word(self, draw: &mut Draw, word: &'static str) -> Self {
        self.in_one(draw, |trial| {
            let row = trial.rows.len() / 2;
            trial.words.insert((row, 3), word);
        })
    }

    /// With another attempt at a trial, of so many of its rows.
    fn attempted(mut self, draw: &mut Draw, kept: impl FnOnce(usize) -> usize) -> Self {
        let mut trial = self.trials[draw.below(self.trials.len())].clone();
        trial.name = trial.name.replace(".csv", "_2.csv");
        trial.rows.iter_mut().for_each(|row| row[3] += 0.001);
        let kept = kept(trial.rows.len());
        trial.rows.truncate(kept);
        trial.mode.truncate(kept);
        self.trials.push(trial);
        self.unnumbered()
    }

    /// With samples missing, and times that are told by their rate alone.
    fn at_a_rate(self, share: f64, draw: &mut Draw) -> Self {
        let rate_hz = 1.0 / (self.trials[0].rows[1][0] - self.trials[0].rows[0][0]);
        let seconds = draw.between(0.15, 0.4);
        let timed = "from = \"t\"\nunit = \"s\"\nzero = \"first\"";
        let lacking = self.in_all(|trial| trial.loses(share, seconds));
        let at_a_rate = lacking.mapped(timed, &format!("rate_hz = {rate_hz:?}"));
        Self { time: |_| "0".to_owned(), ..at_a_rate }
    }

    fn mapped(mut self, from: &str, to: &str) -> Self {
        assert!(self.map.contains(from), "{from}");
        self.map = self.map.replacen(from, to, 1);
        self
    }

    /// No file says which repeat it is.
    fn unnumbered(self) -> Self {
        self.mapped("repeat = { name = \"repeat\" }\n", "")
    }

    /// Writes the files; their paths in the order of the trials.
    fn write(&self, folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
        std::fs::create_dir_all(folder)?;
        let mut paths = Vec::new();
        for trial in &self.trials {
            let mut text = String::from(if self.is_counted { "n;" } else { "" })
                + "t;angle;velocity;force;mode\n";
            for (i, row) in trial.rows.iter().enumerate() {
                let mut line = String::new();
                if self.is_counted {
                    let _ = write!(line, "{};", (row[0] * 1000.0).round());
                }
                line += &(self.time)(row[0]);
                for (column, value) in row.iter().enumerate().skip(1) {
                    match trial.words.get(&(i, column)) {
                        Some(word) => line += &format!(";{word}"),
                        None => line += &format!(";{value:.4}"),
                    }
                }
                if self.decimal == ',' {
                    line = line.replace('.', ",");
                }
                let _ = writeln!(text, "{line};{}", trial.mode[i]);
                if self.is_doubled {
                    let _ = writeln!(text, "{line};{}", trial.mode[i]);
                }
            }
            let path = folder.join(&trial.name);
            std::fs::write(&path, text)?;
            paths.push(path);
        }
        Ok(paths)
    }
}

impl Trial {
    /// Loses the samples of so many seconds, from this share of the trial on.
    fn loses(&mut self, share: f64, seconds: f64) {
        let last = self.rows[self.rows.len() - 1][0];
        let lost = share * last..share * last + seconds;
        self.rows.retain(|row| !lost.contains(&row[0]));
        self.mode.truncate(self.rows.len());
    }
}

/// There and back with least jerk: how far (°), a rest, how long each way takes, a rest between (s); at this rate,
/// against this spring (N/rad), with this noise (N).
fn rows(
    [far, rest_s, move_s, dwell_s]: [f64; 4],
    rate_hz: f64,
    stiffness: f64,
    noise_n: f64,
    draw: &mut Draw,
) -> Vec<[f64; 4]> {
    let back_s = rest_s + move_s + dwell_s;
    let end_s = back_s + move_s + rest_s;
    let place = |t: f64| {
        let u = if t < back_s { (t - rest_s) / move_s } else { 1.0 - (t - back_s) / move_s };
        let u = u.clamp(0.0, 1.0);
        far * u.powi(3) * (10.0 - 15.0 * u + 6.0 * u * u)
    };
    let interval_s = 1.0 / rate_hz;
    let mut rows = Vec::new();
    for i in 0..(end_s * rate_hz) as u32 {
        let t = f64::from(i) * interval_s;
        let velocity = (place(t + 1e-4) - place(t - 1e-4)) / 2e-4;
        let noise = draw.between(-1.0, 1.0) * noise_n;
        rows.push([t, place(t), velocity, stiffness * place(t).to_radians() + noise]);
    }
    rows
}

/// Imports files into a study of their own; what was said, or the means.
fn imported(folder: &Path, files: &Files) -> anyhow::Result<Outcome> {
    // In memory: a disk would sync each of a million files.
    let disk = Memory::new();
    let layout = Layout::new(Path::new("/theirs"), StudyId::new("theirs")?);
    disk.put(&layout.study_toml(), files.study.as_bytes());
    let paths = files.write(folder)?;
    let study = Study::from_toml(&files.study).map_err(|e| anyhow::anyhow!("{e:?}"))?;
    let mapping = Mapping::from_toml(&files.map, Path::new("map.toml"));
    let mapping = mapping.map_err(|e| anyhow::anyhow!("{e:?}"))?;
    let by = By { utc: "2026-01-01T00:00:00Z", software: "zwidth mistakes" };
    let outcome = match import(&layout, &study, &mapping, &paths, by, &disk, &|_| {}) {
        Err(_) => Outcome::Refused,
        Ok(report) if report.is_doubtful() => {
            let text = report.to_string();
            let first =
                text.lines().find(|line| line.contains("read with care")).unwrap_or_default();
            Outcome::Flagged(first.to_owned())
        }
        Ok(_) => Outcome::Silent { means: means(&disk, &layout)?, is_off: false },
    };
    std::fs::remove_dir_all(folder)?;
    Ok(outcome)
}

/// Of each mode the mean over people of duration, largest angle and largest force, and half of its interval at
/// 95 %.
fn means(disk: &Memory, layout: &Layout) -> anyhow::Result<Vec<(f64, f64)>> {
    let data = StudyData::load_from(disk, layout).map_err(|e| anyhow::anyhow!("{e:?}"))?;
    let mut of: BTreeMap<(String, usize), Vec<f64>> = BTreeMap::new();
    for entry in data.counting() {
        let signals = [Signal::Time, Signal::Theta, Signal::ThetaDot, Signal::ForceEx];
        let trial = read_trial_from(disk, &entry.path, signals)?;
        let column = |signal| trial.samples.get(signal).unwrap_or_default();
        let t = column(Signal::Time);
        let moving: Vec<usize> =
            (0..t.len()).filter(|i| column(Signal::ThetaDot)[*i].abs() > ONSET_RAD_S).collect();
        let duration =
            moving.first().zip(moving.last()).map_or(0.0, |(from, to)| t[*to] - t[*from]);
        let largest = |signal| column(signal).iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let values = [duration, largest(Signal::Theta), largest(Signal::ForceEx)];
        for (which, value) in values.into_iter().enumerate() {
            of.entry((entry.meta.mode.to_string(), which)).or_default().push(value);
        }
    }
    let mean = |values: &Vec<f64>| {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0);
        (mean, T_8 * (variance / n).sqrt())
    };
    Ok(of.values().map(mean).collect())
}
