//! What one append of a journal costs: 100 ms at 1 kHz, written and synced. `cargo run --release
//! --example journal_cost -p zwidth-store -- FOLDER` on the disk in question.
#![allow(clippy::print_stdout)]

use std::path::PathBuf;
use std::time::Instant;
use zwidth_store::{Journal, Layout, Protocol, RealFiles, TrialFile};
use zwidth_study::{Kind, Sample, Source, Status, StudyId, TrialMeta};

/// Appends measured: twenty seconds of a trial.
const APPENDS: usize = 200;
/// Rows of an append.
const ROWS: usize = 100;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder =
        PathBuf::from(std::env::args().nth(1).ok_or("name a folder on the disk to measure")?);
    let layout = Layout::new(&folder, StudyId::new("journal_cost")?);
    let meta = TrialMeta {
        participant: "P01".parse()?,
        session: "S01".parse()?,
        trial: 1,
        repeat: 1,
        kind: Kind::Trial,
        status: Status::Complete,
        environment: "spring".parse()?,
        mode: "hybrid".parse()?,
        likert: None,
        source: Source::Twin,
        presented: None,
    };
    let mut journal =
        Journal::create(&RealFiles, &layout, &meta, &TrialFile::new(), &Protocol::default())?;
    let mut times_ms = Vec::new();
    for batch in 0..APPENDS {
        let rows: Vec<Sample> = (batch * ROWS..(batch + 1) * ROWS).map(row).collect();
        let start = Instant::now();
        journal.append(&rows)?;
        times_ms.push(start.elapsed().as_secs_f64() * 1e3);
    }
    journal.end()?;
    let start = Instant::now();
    journal.finish(
        &RealFiles,
        &layout,
        Some(zwidth_study::Given { value: 4, time_ms: None }),
        "2026-01-01T00:00:00Z",
    )?;
    let finish_ms = start.elapsed().as_secs_f64() * 1e3;
    times_ms.sort_by(f64::total_cmp);
    let [median, most, longest] =
        [0.5, 0.99, 1.0].map(|share| times_ms[(share * (APPENDS - 1) as f64) as usize]);
    println!(
        "append of {ROWS} rows: median {median:.2} ms, 99 % {most:.2} ms, longest {longest:.2} ms"
    );
    println!("finish of {} rows: {finish_ms:.1} ms", APPENDS * ROWS);
    Ok(std::fs::remove_dir_all(layout.raw())?)
}

fn row(i: usize) -> Sample {
    let t_s = 1e-3 * i as f64;
    Sample {
        t_s,
        t_device_s: Some(t_s + 1e-6),
        theta_rad: 0.5 * t_s.sin(),
        theta_dot_rad_s: 0.5 * t_s.cos(),
        force_ex_n: 2.0 + t_s.sin(),
        voltages: zwidth_study::Voltages { motor_v: 8.0, brake_v: 0.0 },
        force_age_s: Some(0.004),
        theta_raw: Some((i % 4096) as u16),
        force_cmd_n: 2.08,
        flags: zwidth_study::Flags::MOTOR_ON,
        extra: zwidth_study::Extra::default(),
    }
}
