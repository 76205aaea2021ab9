//! Where raw data lie: a folder that all machines share, or an object store. They are only read.

use anyhow::{Context as _, anyhow, bail, ensure};
use bytes::Bytes;
use futures::{StreamExt as _, TryStreamExt as _};
use object_store::aws::{AmazonS3Builder, AmazonS3ConfigKey};
use object_store::local::LocalFileSystem;
use object_store::path::Path as StorePath;
use object_store::{ClientConfigKey, ObjectStore, ObjectStoreExt as _, RetryConfig};
use std::path::Path;
use std::time::Duration;
use tokio::time::timeout;
use url::Url;
use zwidth_store::MOST_BYTES;

/// Longest wait for a connection to an object store.
const CONNECTING: Duration = Duration::from_secs(10);

/// Longest wait for one file from its first byte on, whatever kind of place it comes from: a network
/// folder may hang too.
const FILE: Duration = Duration::from_secs(180);

/// Files that are fetched at a time.
const AT_ONCE: usize = 8;

/// A place from which raw files are read.
#[derive(Debug)]
pub(crate) struct Source {
    store: Box<dyn ObjectStore>,
    /// What stands before each path.
    prefix: StorePath,
    /// As people name it.
    name: String,
    /// How long it may be silent.
    patience: Duration,
}

impl Source {
    /// The place with this URL, which may be silent for so long. An object store takes its keys and
    /// its endpoint from the environment (`AWS_ACCESS_KEY_ID`, `AWS_SECRET_ACCESS_KEY`,
    /// `AWS_REGION`, `AWS_ENDPOINT`, `AWS_ALLOW_HTTP`).
    ///
    /// # Errors
    /// A URL of another kind; a folder that is not there; settings that make no sense.
    pub(crate) fn open(url: &str, patience: Duration) -> anyhow::Result<Self> {
        let parsed = Url::parse(url).with_context(|| format!("{url:?} is no URL"))?;
        let mut name = url.to_owned();
        let (store, prefix): (Box<dyn ObjectStore>, StorePath) = match parsed.scheme() {
            "file" => {
                let folder = parsed.to_file_path().map_err(|()| anyhow!("{url:?} is no folder"))?;
                let store = LocalFileSystem::new_with_prefix(&folder).with_context(|| {
                    format!("there is no folder {} on this machine", folder.display())
                })?;
                (Box::new(store), StorePath::default())
            }
            "s3" => {
                let bucket = parsed.host_str().with_context(|| format!("{url:?} has no bucket"))?;
                let limit = |key| AmazonS3ConfigKey::Client(key);
                let seconds = |time: Duration| format!("{} seconds", time.as_secs());
                let retry =
                    RetryConfig { max_retries: 3, retry_timeout: patience, ..Default::default() };
                let settings = AmazonS3Builder::from_env()
                    .with_bucket_name(bucket)
                    .with_config(limit(ClientConfigKey::ConnectTimeout), seconds(CONNECTING))
                    .with_config(limit(ClientConfigKey::Timeout), seconds(patience + FILE))
                    .with_retry(retry);
                if let Some(endpoint) = settings.get_config_value(&AmazonS3ConfigKey::Endpoint) {
                    name = format!("{url} at {endpoint}");
                }
                let store = settings
                    .build()
                    .with_context(|| format!("the object store {url} cannot be used"))?;
                (Box::new(store), StorePath::parse(parsed.path())?)
            }
            other => bail!("recordings lie in a folder or in s3://BUCKET/PREFIX, not in {other}:"),
        };
        Ok(Self { store, prefix, name, patience })
    }

    /// Reads a file.
    ///
    /// # Errors
    /// A file that is missing, larger than any recording may be, or does not come in time.
    pub(crate) async fn read(&self, path: &str) -> anyhow::Result<Bytes> {
        let place = self.place(path)?;
        let reading = async {
            let found = self.in_time(self.store.get(&place)).await?;
            let size = found.meta.size;
            ensure!(size <= MOST_BYTES, "it has {size} bytes, and {MOST_BYTES} are allowed");
            let late = || format!("it did not come within {} s", FILE.as_secs());
            anyhow::Ok(timeout(FILE, found.bytes()).await.with_context(late)??)
        };
        reading.await.with_context(|| format!("{path} cannot be read from {}", self.name))
    }

    /// The paths of all files below a folder, relative to the root, sorted.
    ///
    /// # Errors
    /// A place that cannot be listed, or not in time.
    pub(crate) async fn list(&self, folder: &str) -> anyhow::Result<Vec<String>> {
        let place = self.place(folder)?;
        let mut listing = self.store.list(Some(&place)).map_ok(|found| found.location);
        let listing = async {
            let mut listed = Vec::new();
            while let Some(found) = self.in_time(listing.try_next()).await? {
                listed.push(found);
            }
            anyhow::Ok(listed)
        };
        let listed =
            listing.await.with_context(|| format!("{folder} of {} cannot be listed", self.name))?;
        let relative = |place: StorePath| {
            let parts = place.prefix_match(&self.prefix)?;
            Some(parts.map(|part| part.as_ref().to_owned()).collect::<Vec<_>>().join("/"))
        };
        let mut paths: Vec<String> = listed.into_iter().filter_map(relative).collect();
        paths.sort();
        Ok(paths)
    }

    /// Copies files into a folder on this machine, each to the same path below it. `check` says
    /// what is wrong with a content.
    ///
    /// # Errors
    /// The first file that cannot be read, is wrong, or cannot be written.
    pub(crate) async fn fetch<'p>(
        &self,
        paths: impl IntoIterator<Item = &'p str>,
        root: &Path,
        check: impl Fn(&str, &[u8]) -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        let paths: Vec<&str> = paths.into_iter().collect();
        let reading = paths.into_iter().map(|path| async move { (path, self.read(path).await) });
        let mut reading = futures::stream::iter(reading).buffer_unordered(AT_ONCE);
        while let Some((path, read)) = reading.next().await {
            let bytes = read?;
            check(path, &bytes)?;
            let to = root.join(path);
            let folder = to.parent().unwrap_or(root);
            std::fs::create_dir_all(folder)
                .and_then(|()| std::fs::write(&to, &bytes))
                .with_context(|| format!("{} cannot be written", to.display()))?;
        }
        Ok(())
    }

    /// The next that this place says, if it says something in time.
    async fn in_time<T>(
        &self,
        next: impl Future<Output = object_store::Result<T>>,
    ) -> anyhow::Result<T> {
        let silent = || format!("there was no answer within {} s", self.patience.as_secs());
        timeout(self.patience, next).await.with_context(silent)?.map_err(in_short)
    }

    fn place(&self, path: &str) -> anyhow::Result<StorePath> {
        let path = StorePath::parse(path).with_context(|| format!("{path:?} is no path"))?;
        Ok(self.prefix.parts().chain(path.parts()).collect())
    }
}

/// A store's error repeats its causes: the first and the last say all.
fn in_short(error: object_store::Error) -> anyhow::Error {
    let (error, all) = (error.to_string(), anyhow::Error::from(error));
    let last = all.root_cause().to_string();
    if error.contains(&last) { anyhow!(error) } else { anyhow!("{error}: {last}") }
}

/// The URL of a place: a folder's, or the URL itself.
///
/// # Errors
/// A folder that is not there.
pub(crate) fn url_of(place: &str) -> anyhow::Result<String> {
    if place.contains("://") {
        return Ok(place.to_owned());
    }
    let folder = std::path::absolute(place)?;
    ensure!(folder.is_dir(), "there is no folder {}", folder.display());
    let url = Url::from_directory_path(&folder);
    Ok(url.map_err(|()| anyhow!("{} cannot be written as a URL", folder.display()))?.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn runs<T>(work: impl Future<Output = T>) -> T {
        tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap().block_on(work)
    }

    #[test]
    fn a_folder_is_listed_and_read_by_paths_below_it_alone() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir_all(folder.path().join("raw/s/trials/participant=P01")).unwrap();
        for file in ["raw/s/study.toml", "raw/s/trials/participant=P01/001.parquet"] {
            std::fs::write(folder.path().join(file), file).unwrap();
        }
        let source = Source::open(&url_of(folder.path().to_str().unwrap()).unwrap(), FILE).unwrap();
        let paths = runs(source.list("raw/s")).unwrap();
        assert_eq!(paths, ["raw/s/study.toml", "raw/s/trials/participant=P01/001.parquet"]);
        assert_eq!(runs(source.read(&paths[1])).unwrap(), paths[1].as_bytes());
        let copy = tempfile::tempdir().unwrap();
        let all = paths.iter().map(String::as_str);
        runs(source.fetch(all, copy.path(), |_, _| Ok(()))).unwrap();
        assert_eq!(std::fs::read(copy.path().join(&paths[1])).unwrap(), paths[1].as_bytes());
        for bad in ["raw/s/none", "raw/../../etc/passwd", "raw//s"] {
            assert!(runs(source.read(bad)).is_err(), "{bad}");
        }
    }

    #[test]
    fn only_folders_and_s3_are_sources() {
        for bad in ["http://127.0.0.1/raw", "ftp://x/y", "s3:///prefix", "file:///no/such/folder"] {
            assert!(Source::open(bad, FILE).is_err(), "{bad}");
        }
        assert!(url_of("/no/such/folder").is_err());
        assert_eq!(url_of("s3://bucket/prefix").unwrap(), "s3://bucket/prefix");
    }
}
