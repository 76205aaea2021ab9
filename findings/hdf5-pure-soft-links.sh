#!/usr/bin/env bash
# hdf5-pure 0.47.0 cannot list a group of the old form (a symbol table, h5py's default) that holds a soft link.
#
# Library: hdf5-pure 0.47.0 (crates.io); the file is written by h5py 3.16.0 with its default options (PyPI), and read
# back by h5py without complaint.
# Seen: `Group::datasets` of the group fails; the error names 18446744073709551615 bytes (2^64 - 1, the undefined address
# of the HDF5 File Format Specification: a soft link's entry in a symbol table has no object header). In a group of the
# new form (libver="latest") the same link is passed by.
# Meaning for us: crates/import takes soft links of groups of the old form out before the library reads them.
set -euo pipefail
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check h5py==3.16.0 numpy
"$work/venv/bin/python" - "$work" <<'PY'
import sys
import h5py
for name, options in [("old", {}), ("new", {"libver": "latest"})]:
    with h5py.File(f"{sys.argv[1]}/{name}.h5", "w", **options) as file:
        file["rig/force"] = [1.0, 2.0]
        file["rig/again"] = h5py.SoftLink("/rig/force")
    with h5py.File(f"{sys.argv[1]}/{name}.h5") as file:
        assert list(file["rig/again"][:]) == [1.0, 2.0]
PY
mkdir -p "$work/probe/src"
cat > "$work/probe/Cargo.toml" <<'TOML'
[package]
name = "probe"
version = "0.0.0"
edition = "2024"
[dependencies]
hdf5-pure = { version = "=0.47.0", default-features = false, features = ["std", "checksum", "deflate"] }
TOML
cat > "$work/probe/src/main.rs" <<'RUST'
fn main() {
    for path in std::env::args().skip(1) {
        let file = hdf5_pure::File::open(&path).expect("the file opens");
        let listed = file.group("rig").and_then(|group| group.datasets());
        println!("{}: {listed:?}", path.rsplit('/').next().unwrap_or_default());
    }
}
RUST
cargo run --quiet --manifest-path "$work/probe/Cargo.toml" -- "$work/old.h5" "$work/new.h5" | tee "$work/seen"
grep -q '^old.h5: Err(.*18446744073709551615' "$work/seen"
grep -q '^new.h5: Ok(\["force"' "$work/seen"
echo "as described"
