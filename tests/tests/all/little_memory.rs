//! A recording for which the system does not give the memory: one clear error, and no end by a
//! signal. Limits are set by the shell (`ulimit -v`).

use crate::bad_import::{GOOD, World};
use crate::binary::{Ran, binary, ran};
use crate::folders::listing;
use std::fs::File;
use std::path::Path;
use std::process::Command;

/// Bytes of the recording (240 MiB), of which none is on the disk.
const LARGE: u64 = 240 << 20;
/// How much more memory is given each time, KiB.
const STEP_KIB: u64 = 32 << 10;

/// Imports a file as that format, with so much memory.
fn import(world: &World, file: &Path, kib: u64) -> Ran {
    let (root, map) = (world.folder.path(), world.file("map.toml", &world.map));
    let script = format!(
        "ulimit -v {kib}; exec \"$0\" --threads 1 --root \"$1\" import rig --map \"$2\" \"$3\""
    );
    let mut command = Command::new("sh");
    command.args(["-c", &script]).arg(binary()).args([root, &map, file]);
    ran(&command.env_remove("ZWIDTH_ROOT").output().unwrap())
}

#[test]
fn a_large_recording_for_which_there_is_no_memory_is_one_error_at_any_limit() {
    let world = World::new();
    let small = world.file("small.npy", GOOD);
    // What the program itself takes: with less it cannot say anything, or cannot start its threads.
    let is_told = |kib: &u64| import(&world, &small, *kib).err.contains("small.npy");
    let least = (4..64).map(|steps| steps * STEP_KIB).find(is_told).unwrap();
    let raw = world.folder.path().join("raw");
    let before = listing(&raw);
    let mut refused = 0;
    for format in ["npy", "mat", "h5", "parquet", "xlsx"] {
        let large = world.folder.path().join(format!("large.{format}"));
        File::create(&large).unwrap().set_len(LARGE).unwrap();
        // With 64 MiB more than that, up to what is enough.
        for steps in 2..12 {
            let ran = import(&world, &large, least + steps * STEP_KIB).exits(1).one_error();
            refused += u32::from(ran.err.contains("bytes of memory"));
        }
    }
    assert!(refused > 5, "{refused}");
    assert_eq!(listing(&raw), before);
}
