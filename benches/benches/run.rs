//! The main job on the study that comes along, as a user starts it: fresh, and with nothing to do.
//! Needs the release binary: `cargo build --release` first. Beside a script that makes the same,
//! and with one changed trial: `benches/peers/study/run.sh`.
#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, clippy::print_stdout)] // a bench may panic

use criterion::{Criterion, criterion_group, criterion_main};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The release binary, beside this bench's own folder.
fn binary() -> PathBuf {
    let here = std::env::current_exe().unwrap();
    let release = here.ancestors().find(|p| p.ends_with("release")).expect("a release folder");
    release.join("zwidth")
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let target = to.join(path.file_name().unwrap());
        if path.is_dir() {
            copy(&path, &target);
        } else {
            std::fs::copy(&path, &target).unwrap();
        }
    }
}

fn zwidth(root: &Path, arguments: &[&str]) {
    let status = Command::new(binary())
        .arg("--root")
        .arg(root)
        .arg("--quiet")
        .args(arguments)
        .output()
        .unwrap()
        .status;
    assert!(status.success());
}

fn run(c: &mut Criterion) {
    let folder = tempfile::tempdir().unwrap();
    copy(
        &Path::new(env!("CARGO_MANIFEST_DIR")).join("../raw/thesis-twin"),
        &folder.path().join("raw/thesis-twin"),
    );
    zwidth(folder.path(), &["run"]);
    let mut group = c.benchmark_group("zwidth run thesis-twin");
    group.bench_function("nothing to do", |b| b.iter(|| zwidth(folder.path(), &["run"])));
    group.sample_size(10);
    group.bench_function("fresh", |b| b.iter(|| zwidth(folder.path(), &["run", "--fresh"])));
    group.bench_function("fresh, one thread", |b| {
        b.iter(|| zwidth(folder.path(), &["run", "--fresh", "--threads", "1"]))
    });
    group.finish();
}

criterion_group!(benches, run);
criterion_main!(benches);
