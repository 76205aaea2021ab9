#!/usr/bin/env bash
# hdf5-pure 0.47.0 gives no value, and no error, of a data set of two-byte floats, and refuses what HDF5 2.0 writes as its latest version.
#
# Library: hdf5-pure 0.47.0 (crates.io), the newest; the files are written by h5py 3.16.0 (PyPI), and read back by h5py.
# Seen: `read_f64` of a `float16` data set of 351 values is Ok with 0 values. Of a packed data set written with libver="latest" the
# data layout message has version 5, and reading it fails with "invalid data layout version: 5".
# Meaning for us: crates/import reads two-byte floats itself, and rewrites a layout of version 5 before the library reads it.
set -euo pipefail
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check h5py==3.16.0 numpy
"$work/venv/bin/python" - "$work" <<'PY'
import sys
import h5py
import numpy as np
values = np.linspace(0, 1, 351)
with h5py.File(f"{sys.argv[1]}/half.h5", "w") as file:
    file["x"] = values.astype("float16")
with h5py.File(f"{sys.argv[1]}/latest.h5", "w", libver="latest") as file:
    file.create_dataset("x", data=values, compression="gzip", chunks=(100,))
for name in ["half", "latest"]:
    with h5py.File(f"{sys.argv[1]}/{name}.h5") as file:
        assert len(file["x"][:]) == 351 and abs(float(file["x"][350]) - 1.0) < 1e-3
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
        let read = file.dataset("x").and_then(|data| data.read_f64());
        let told = read.map_or_else(|error| format!("error: {error}"), |values| format!("{} values", values.len()));
        println!("{}: {told}", path.rsplit('/').next().unwrap_or_default());
    }
}
RUST
cargo run --quiet --manifest-path "$work/probe/Cargo.toml" -- "$work/half.h5" "$work/latest.h5" | tee "$work/seen"
grep -q '^half.h5: 0 values$' "$work/seen"
grep -q '^latest.h5: error: .*version: 5' "$work/seen"
echo "as described"
