//! Where a path leads, even if nothing is there yet.

use std::io::{self, ErrorKind};
use std::path::{Component, Path, PathBuf, absolute};

/// More links than this lead in a circle, as on Linux.
const MOST_LINKS: usize = 40;

/// The absolute path to which a path leads: links are followed, `.` and `..` are gone. In contrast
/// to [`Path::canonicalize`], nothing needs to be there; a link to a missing path leads to that
/// path.
///
/// # Errors
/// An empty path; a folder on the way that may not be read, or that is a file; links in a circle.
pub fn real_path(path: &Path) -> io::Result<PathBuf> {
    let mut real = PathBuf::new();
    let mut ahead = backwards(&absolute(path)?);
    let mut links = 0;
    while let Some(part) = ahead.pop() {
        if part == Path::new("..") {
            // Of where the links before it led, which the text does not show.
            real.pop();
            continue;
        }
        real.push(part);
        match real.canonicalize() {
            Ok(canonical) => real = canonical,
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
            Err(_) => {
                // Nothing is there, or a link to nothing, which is followed by hand.
                let Ok(target) = real.read_link() else { continue };
                links += 1;
                if links > MOST_LINKS {
                    return Err(io::Error::other("its links lead in a circle"));
                }
                real.pop();
                ahead.extend(backwards(&target));
            }
        }
    }
    Ok(real)
}

/// The parts of a path, the last one first; `.` is none.
fn backwards(path: &Path) -> Vec<PathBuf> {
    path.components()
        .rev()
        .filter(|part| *part != Component::CurDir)
        .map(|part| PathBuf::from(part.as_os_str()))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_there_leads_where_its_text_says() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().canonicalize().unwrap();
        for text in ["a/b", "./a//b/.", "a/c/../b", "x/../a/b", "a/b/c/d/../.."] {
            assert_eq!(real_path(&folder.join(text)).unwrap(), folder.join("a/b"), "{text}");
        }
        let here = std::env::current_dir().unwrap().canonicalize().unwrap();
        assert_eq!(real_path(Path::new("no/such")).unwrap(), here.join("no/such"));
        assert_eq!(real_path(Path::new("../no")).unwrap(), here.parent().unwrap().join("no"));
        assert!(real_path(Path::new("")).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_also_where_what_they_lead_to_is_not_there_and_never_in_a_circle() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().canonicalize().unwrap();
        std::fs::create_dir_all(folder.join("deep/inside")).unwrap();
        for (name, target) in [
            ("link", "deep/inside"),
            ("chain", "link"),
            ("dangling", "missing/x"),
            ("whole", folder.join("deep").to_str().unwrap()),
            ("circle", "circle"),
            ("spiral", "missing/../spiral/x"),
        ] {
            symlink(target, folder.join(name)).unwrap();
        }
        for (text, leads_to) in [
            ("link/new", "deep/inside/new"),
            ("chain/../new", "deep/new"),
            ("dangling/new", "missing/x/new"),
            ("whole/new", "deep/new"),
            ("deep/inside/../../dangling", "missing/x"),
        ] {
            assert_eq!(real_path(&folder.join(text)).unwrap(), folder.join(leads_to), "{text}");
        }
        for text in ["circle/x", "spiral"] {
            assert!(real_path(&folder.join(text)).is_err(), "{text}");
        }
        std::fs::write(folder.join("file"), "").unwrap();
        assert!(real_path(&folder.join("file/x")).is_err());
    }
}
