//! Recordings in an object store: a real one, which the settings of the environment name.

use crate::hosts::{executor, program, run, scheduler};
use crate::studies::{Files, files, is_as_without_a_cluster, raw, workspace};
use futures::TryStreamExt as _;
use object_store::aws::AmazonS3Builder;
use object_store::path::Path as StorePath;
use object_store::{ObjectStore as _, ObjectStoreExt as _};

/// `AWS_ENDPOINT` and the other settings of the environment name a store, `ZWIDTH_BUCKET` a bucket
/// that is there. `.ci/cluster` starts two programs in turn that are such stores.
#[test]
#[ignore = "needs an object store in AWS_ENDPOINT"]
fn recordings_in_an_object_store_give_the_same_bytes_and_stay_as_they_are() {
    let bucket = std::env::var("ZWIDTH_BUCKET").expect("ZWIDTH_BUCKET names a bucket");
    let store = AmazonS3Builder::from_env().with_bucket_name(&bucket).build().unwrap();
    let runtime = tokio::runtime::Runtime::new().unwrap();
    let listed = || -> Files {
        runtime.block_on(async {
            let found: Vec<_> = store.list(None).try_collect().await.unwrap();
            let mut all = Files::new();
            for found in found {
                let bytes = store.get(&found.location).await.unwrap().bytes().await.unwrap();
                all.insert(found.location.to_string(), bytes.to_vec());
            }
            all
        })
    };
    for (path, bytes) in files(&workspace().join("raw/thesis-twin")) {
        let to = StorePath::parse(format!("some/data/raw/thesis-twin/{path}")).unwrap();
        runtime.block_on(store.put(&to, bytes.into())).unwrap();
    }
    let before = listed();
    let url = format!("s3://{bucket}/some/data");

    let (_scheduler, address) = scheduler();
    let _executors = [executor(&address, &[]), executor(&address, &[])];
    let shared = raw();
    run(shared.path(), &address, &["--raw", &url]).end().ends(0, &["13 of 13 jobs came back"]);
    is_as_without_a_cluster(shared.path());

    // A machine that has nothing of the study yet.
    let empty = tempfile::tempdir().unwrap();
    run(empty.path(), &address, &["--raw", &url])
        .end()
        .ends(1, &["zwidth-cluster fetch thesis-twin"]);
    let fetch = || {
        let mut command = program();
        command.args(["fetch", "thesis-twin", "--raw", &url, "--root"]).arg(empty.path());
        crate::hosts::Running::begin(command).end()
    };
    fetch().ends(0, &[]);
    fetch().ends(1, &["is here already"]);
    run(empty.path(), &address, &["--raw", &url]).end().ends(0, &[]);
    is_as_without_a_cluster(empty.path());

    assert_eq!(listed(), before, "nothing was written there");
}
