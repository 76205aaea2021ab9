//! What shards have made of a study, compared with the study as it is.

use crate::change::{Change, changes, first_change};
use crate::hashes::{Hashes, show_path};
use crate::manifest::{Manifest, ManifestFile, refusal};
use crate::plan::{levels, with_needs};
use crate::record::Record;
use crate::shard::ready;
use crate::{HashesRead, Job, Records, Results, Shard};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;
use zwidth_store::{MOST_BYTES, Seen, StoreError, hex_blake3};

/// Which parts of a study have been made.
pub struct Survey<'r> {
    /// The study's own records.
    pub(crate) records: Records,
    /// Shards that made what a run would make now, by their manifests.
    pub(crate) accepted: Vec<Offer<'r>>,
    /// Why each of the other shards is refused.
    pub refused: Vec<StoreError>,
    /// What is wrong with the study's own records.
    pub remarks: Vec<StoreError>,
    /// How many shards there are, by each manifest.
    counts: BTreeSet<u32>,
    /// Whether each job has up-to-date results, in the study's own folder or in a shard's.
    available: Vec<bool>,
    /// Whether each job has them by the study's own records.
    up_to_date: Vec<bool>,
    /// Jobs that were held against their results, and files that a merge would copy.
    pub(crate) steps: usize,
}

/// A shard's manifest, and where its results lie.
pub(crate) struct Offer<'r> {
    pub(crate) results: &'r Results<'r>,
    /// Whether these are in the study's own folder.
    pub(crate) is_own: bool,
    pub(crate) path: PathBuf,
    /// BLAKE3 of the manifest.
    pub(crate) blake3: String,
    pub(crate) manifest: Manifest,
    /// Why it is refused, once that is known.
    refused: Option<String>,
}

/// The jobs of one shard.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Share<'j> {
    /// The shard.
    pub shard: Shard,
    /// How many jobs it can make as things are.
    pub jobs: usize,
    /// The names of those without up-to-date results.
    pub missing: Vec<&'j str>,
}

impl Survey<'_> {
    /// How many shards the manifests speak of; `None` if there are none, or they differ.
    pub fn count(&self) -> Option<u32> {
        self.counts.first().copied().filter(|_| self.counts.len() == 1)
    }

    /// What each of `of` shards can make now, and what of it is missing. Without a number there are
    /// as many shards as the manifests say, or one if they do not say.
    pub fn shares<'j>(&self, jobs: &'j [Job], of: Option<u32>) -> Vec<Share<'j>> {
        let of = of.or(self.count()).unwrap_or(1);
        let mut shares: BTreeMap<Shard, Share> = Shard::all(of)
            .map(|shard| (shard, Share { shard, jobs: 0, missing: Vec::new() }))
            .collect();
        let ready = ready(jobs, |job| Shard::of_part(job.part.as_ref()?, of), &self.up_to_date);
        for ((job, shard), is_available) in jobs.iter().zip(ready).zip(&self.available) {
            let Some(share) = shard.and_then(|shard| shares.get_mut(&shard)) else { continue };
            share.jobs += 1;
            share.missing.extend((!is_available).then_some(job.name.as_str()));
        }
        shares.into_values().collect()
    }
}

/// Checks the manifests in the study's own results and in those of other roots. `known` are hashes
/// of files that were already read, and `seen` is what others were when they were last read.
/// `progress` is called after each job that was compared with its results, with the number of jobs,
/// and the number of files of other roots that a merge would copy after them.
///
/// # Errors
/// Records or manifests that cannot be reached: a link on the way to them.
pub fn survey<'r>(
    jobs: &[Job],
    own: &'r Results<'r>,
    others: &'r [Results<'r>],
    known: &HashesRead,
    seen: &Arc<Seen>,
    progress: &dyn Fn(usize),
) -> Result<Survey<'r>, StoreError> {
    let (records, remarks) = Records::read(own)?;
    let mut offers = Vec::new();
    let mut refused = Vec::new();
    let mut counts = BTreeSet::new();
    let planned: BTreeSet<&str> = jobs.iter().map(|job| job.name.as_str()).collect();
    let roots = std::iter::once((own, true)).chain(others.iter().map(|results| (results, false)));
    for (results, is_own) in roots {
        for ManifestFile { path, shard, blake3, manifest } in Manifest::all(results)? {
            counts.insert(shard.of());
            match manifest {
                Ok(manifest) => {
                    let records = &manifest.records;
                    let other = records.iter().find(|(name, _)| !planned.contains(name));
                    let refused = other.map(|(other, _)| {
                        format!("it was made from other inputs: the study has no job {other:?} now")
                    });
                    offers.push(Offer { results, is_own, path, blake3, manifest, refused });
                }
                Err(error) => refused.push(error),
            }
        }
    }
    let root = own.root();
    let hashes = Hashes::seen(known, seen.clone());
    // Those that others need first: what a shard made is what its next job read.
    let wanted = with_needs(jobs, |job| job.part.is_some());
    let to_copy = offers.iter().filter(|offer| !offer.is_own && offer.refused.is_none());
    let to_copy: usize = to_copy.map(|offer| offer.manifest.records.outputs().count()).sum();
    let steps = wanted.iter().filter(|is_wanted| **is_wanted).count() + to_copy;
    let mut up_to_date = vec![false; jobs.len()];
    let mut offered: Vec<Vec<usize>> = vec![Vec::new(); jobs.len()];
    for i in levels(jobs, &wanted).into_iter().flatten() {
        let job = &jobs[i];
        let now = Record::now(job, root, &hashes);
        up_to_date[i] = records.get(&job.name).is_some_and(|before| {
            first_change(&before, &now, || hashes.of(root, &job.outputs)).is_none()
        });
        let mut first: Option<Arc<Record>> = None;
        for (k, offer) in offers.iter_mut().enumerate().filter(|(_, o)| o.refused.is_none()) {
            let Some(record) = offer.manifest.records.get(&job.name) else { continue };
            match why_not(job, &now, &record, own, offer.results, first.as_deref()) {
                Some(why) => offer.refused = Some(format!("{}: {why}", job.name)),
                None => {
                    first.get_or_insert(record);
                    offered[i].push(k);
                }
            }
        }
        // The jobs that read these are held against what a merge would bring, not what lies here.
        for (path, hash) in first.iter().flat_map(|record| &record.outputs) {
            hashes.set(&root.join(path), hash);
        }
        progress(steps);
    }
    // One that was refused for a later job offers nothing.
    let available = up_to_date
        .iter()
        .zip(&offered)
        .map(|(up_to_date, by)| *up_to_date || by.iter().any(|k| offers[*k].refused.is_none()));
    let available = available.collect();
    refused.extend(offers.iter().filter_map(|offer| {
        let why = offer.refused.as_ref()?;
        Some(refusal(offer.results.layout(), offer.manifest.shard, &offer.path, why))
    }));
    offers.retain(|offer| offer.refused.is_none());
    Ok(Survey { records, accepted: offers, refused, remarks, counts, available, up_to_date, steps })
}

/// Why a shard's results of a job are not those that a run would make now.
fn why_not(
    job: &Job,
    now: &Record,
    record: &Record,
    own: &Results,
    results: &Results,
    other: Option<&Record>,
) -> Option<String> {
    // Its outputs are held against the files below.
    let all = changes(Some(record), now, &record.outputs);
    let of_version = all.iter().find(|change| matches!(change, Change::Version { .. }));
    // Before parameters: a recording that changed changes what they have of it, too.
    let of_input = all.iter().find(|change| matches!(change, Change::Input(_)));
    if let Some(change) = of_version.or(of_input).or(all.first()) {
        let how = match change {
            Change::Version { .. } => "by another version",
            Change::Parameters { .. } => "with other parameters",
            _ => "from other inputs",
        };
        return Some(format!("it was made {how}: {change}"));
    }
    let declared: BTreeSet<String> =
        job.outputs.iter().map(|path| show_path(own.root(), path)).collect();
    if record.outputs.keys().ne(&declared) {
        return Some("it names other results than the job has".to_owned());
    }
    if other.is_some_and(|other| other.outputs != record.outputs) {
        return Some("another shard made something else of the same inputs".to_owned());
    }
    record.outputs.iter().find_map(|(path, hash)| match content(results, path) {
        Ok(bytes) if hex_blake3(&bytes) == *hash => None,
        Ok(_) => Some(format!("its result {path} is not the one it made")),
        Err(why) => Some(format!("its result {path} is not there: {why}")),
    })
}

/// What a file of a shard's results holds.
pub(crate) fn content(results: &Results, path: &str) -> Result<Vec<u8>, String> {
    let path = Results::named(results.layout(), path)?;
    let bytes = results.read(&path, MOST_BYTES).map_err(|error| error.what)?;
    bytes.ok_or("it is missing")?.map_err(|error| error.what)
}
