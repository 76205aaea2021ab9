//! A trajectory from its file.

use super::super::sum_up;
use std::path::Path;
use zwidth_import::{Mapping, trajectory};
use zwidth_judge::Candidate;

/// A trajectory, and which of the file's columns became what.
pub(in super::super) struct Read {
    pub(in super::super) candidate: Candidate,
    pub(in super::super) converted: Vec<String>,
}

/// Reads a trajectory; without a mapping its columns are recognised by their names.
pub(in super::super) fn read(
    path: &Path,
    mapping: Option<&Mapping>,
    lever_m: f64,
) -> anyhow::Result<Read> {
    let read = trajectory(path, mapping, lever_m).map_err(|findings| sum_up(&findings))?;
    let candidate = Candidate {
        t_s: read.t_s,
        theta_rad: read.theta_rad,
        theta_dot_rad_s: read.theta_dot_rad_s,
        velocity_computed: read.velocity_computed,
        force_ex_n: read.force_ex_n,
    };
    Ok(Read { candidate, converted: read.converted })
}
