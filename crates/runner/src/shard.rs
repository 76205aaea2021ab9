//! Shards: a study's parts are divided into shares, so that many machines can make what is derived
//! from trials, one share each.

use crate::hashes::Hashes;
use crate::plan::{levels, needs};
use crate::state::{Again, states_by};
use crate::{Job, Records};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::fmt;
use std::path::Path;
use std::str::FromStr;
use zwidth_store::hex_blake3;

/// Shards at most: more than any queue takes tasks in one array.
pub const MOST_SHARDS: u32 = 1_000_000;

/// Shard `number` of `of`, counted from 1; in words `3/7`.
///
/// The hash of a part's name says to which shard the part belongs. This depends on nothing else,
/// neither on the machine nor on the other parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub struct Shard {
    number: u32,
    of: u32,
}

impl Shard {
    /// Shard `number` of `of`; `None` unless 1 ≤ number ≤ of ≤ [`MOST_SHARDS`].
    pub fn new(number: u32, of: u32) -> Option<Self> {
        ((1..=of).contains(&number) && of <= MOST_SHARDS).then_some(Self { number, of })
    }

    /// All of `of` shards.
    pub fn all(of: u32) -> impl Iterator<Item = Self> {
        (1..=of).filter_map(move |number| Self::new(number, of))
    }

    /// Which of `of` shards a part belongs to.
    pub fn of_part(part: &str, of: u32) -> Option<Self> {
        // 64 bits are far more than shards: none gets noticeably more parts than another.
        let hash = u64::from_str_radix(hex_blake3(part.as_bytes()).get(..16)?, 16).ok()?;
        let number = hash.checked_rem(u64::from(of))? + 1;
        Self::new(u32::try_from(number).ok()?, of)
    }

    /// Its number, from 1.
    pub fn number(self) -> u32 {
        self.number
    }

    /// How many shards there are.
    pub fn of(self) -> u32 {
        self.of
    }

    /// Whether a job is this shard's: one of a part that belongs to it.
    pub fn takes(self, job: &Job) -> bool {
        job.part.as_ref().is_some_and(|part| Self::of_part(part, self.of) == Some(self))
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let shard = match text.split_once('/').map(|(n, of)| (n.parse(), of.parse())) {
            Some((Ok(number), Ok(of))) => Self::new(number, of),
            _ => None,
        };
        shard.ok_or_else(|| {
            format!("a shard is its number and how many there are, 1/{MOST_SHARDS} at most: 3/7")
        })
    }
}

impl TryFrom<String> for Shard {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<Shard> for String {
    fn from(shard: Shard) -> Self {
        shard.to_string()
    }
}

/// For each job the share of the work (a shard, a part) that can make it now: the one it belongs to,
/// if all that it reads is raw, up to date by the study's own records, or made by other jobs of that
/// share. The other jobs need results of several shares first, for instance the plant that is
/// identified from all trials. So it does not matter which shares are made at the same time, or what
/// they have made so far.
pub(crate) fn ready<S: Clone + PartialEq>(
    jobs: &[Job],
    share_of: impl Fn(&Job) -> Option<S>,
    up_to_date: &[bool],
) -> Vec<Option<S>> {
    let shares: Vec<Option<S>> = jobs.iter().map(share_of).collect();
    let is_shared: Vec<bool> = shares.iter().map(Option::is_some).collect();
    let needs = needs(jobs, &is_shared);
    let mut ready = vec![None; jobs.len()];
    for i in levels(jobs, &is_shared).into_iter().flatten() {
        if needs[i].iter().all(|maker| up_to_date[*maker] || ready[*maker] == shares[i]) {
            ready[i].clone_from(&shares[i]);
        }
    }
    ready
}

/// Which jobs have up-to-date results by the study's own records, of those chosen and those whose
/// outputs they need.
pub(crate) fn up_to_date(
    jobs: &[Job],
    chosen: impl Fn(&Job) -> bool + Sync,
    root: &Path,
    records: &Records,
    hashes: &Hashes,
) -> Vec<bool> {
    let states = states_by(hashes, jobs, root, records, chosen);
    let current = states.iter().filter(|state| state.again() == Again::No);
    let current: BTreeSet<&str> = current.map(|state| state.job.name.as_str()).collect();
    jobs.iter().map(|job| current.contains(job.name.as_str())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Made, Stage};
    use std::collections::BTreeMap;
    use std::path::PathBuf;

    fn job(name: &'static str, part: Option<&str>, inputs: &[PathBuf], output: PathBuf) -> Job {
        let stage = Stage { name, version: 1 };
        let job =
            Job::new(
                stage,
                name,
                (),
                inputs.to_vec(),
                vec![output],
                |(), _, _| Ok(Made::default()),
            );
        part.into_iter().fold(job, Job::of_part)
    }

    #[test]
    fn every_part_belongs_to_one_shard_and_shards_are_about_equally_large() {
        let mut parts = BTreeMap::new();
        for i in 0..7000 {
            let part = format!("P{i}.S01.spring.hybrid");
            let own: Vec<Shard> =
                Shard::all(7).filter(|s| Shard::of_part(&part, 7) == Some(*s)).collect();
            assert_eq!(own.len(), 1);
            *parts.entry(own[0]).or_insert(0) += 1;
        }
        assert!(parts.len() == 7 && parts.values().all(|n| (900..1100).contains(n)), "{parts:?}");
    }

    /// Written down: another program that shares a study out must share it out alike.
    #[test]
    fn which_shard_a_part_belongs_to_never_changes() {
        let of = |part: &str| Shard::of_part(part, 64).unwrap().to_string();
        assert_eq!(["P01.S01.spring.hybrid", "P01.S01.spring.active"].map(of), ["32/64", "20/64"]);
    }

    #[test]
    fn a_shard_reads_as_it_is_written_and_nothing_else_is_one() {
        for good in ["1/1", "3/7", "64/64"] {
            assert_eq!(good.parse::<Shard>().unwrap().to_string(), good);
        }
        for bad in ["", "0/7", "8/7", "3", "3/", "-1/7", "3/0", "1/1000001", "a/b", "1/2/3"] {
            assert!(bad.parse::<Shard>().is_err(), "{bad:?}");
        }
    }

    #[test]
    fn a_shard_makes_what_can_be_made_of_its_parts_and_nothing_of_the_whole_study() {
        let at = |name: &str| PathBuf::from(name);
        let one = Shard::new(1, 1);
        let jobs = [
            job("second", Some("P01"), &[at("first")], at("second")),
            job("first", Some("P01"), &[at("raw")], at("first")),
            job("plant", None, &[at("raw")], at("plant")),
            job("with the plant", Some("P01"), &[at("raw"), at("plant")], at("third")),
        ];
        let shard_of = |job: &Job| Shard::of_part(job.part.as_ref()?, 1);
        assert_eq!(ready(&jobs, shard_of, &[false; 4]), [one, one, None, None]);
        assert_eq!(ready(&jobs, shard_of, &[false, false, true, false]), [one, one, None, one]);
    }

    #[test]
    fn what_another_shard_is_to_make_is_waited_for_unless_it_is_up_to_date() {
        let part = |shard: Shard| {
            let mut names = (0..).map(|i| format!("P{i}"));
            names.find(|name| Shard::of_part(name, 2) == Some(shard)).unwrap()
        };
        let [a, b] = [1, 2].map(|number| Shard::new(number, 2).unwrap());
        let (raw, made) = ([PathBuf::from("raw")], [PathBuf::from("made")]);
        let jobs = [
            job("replay", Some(&part(a)), &raw, made[0].clone()),
            job("courses", Some(&part(b)), &made, PathBuf::from("courses")),
        ];
        let shard_of = |job: &Job| Shard::of_part(job.part.as_ref()?, 2);
        assert_eq!(ready(&jobs, shard_of, &[false, false]), [Some(a), None]);
        assert_eq!(ready(&jobs, shard_of, &[true, false]), [Some(a), Some(b)]);
    }
}
