#!/usr/bin/env bash
# pyo3 0.30.1: an array of doubles by ctypes is no buffer of doubles where the machine is little-endian.
#
# Library: pyo3 0.30.1 (Rust), feature abi3-py311; source: `is_matching_endian` in src/buffer.rs. ctypes names the byte order in its format ("<d");
# array.array and NumPy name none ("d").
# Seen: `PyBuffer<f64>` takes array.array("d") and refuses (c_double * 2) with a BufferError, although both hold the same bytes.
# Meaning for us: the libraries of many haptic devices are called by ctypes. The module takes their arrays by a view that names no byte order
# (python/src/given.rs).
set -euo pipefail
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/src"
cat > "$work/Cargo.toml" <<'TOML'
[package]
name = "probe"
version = "0.0.0"
edition = "2024"
[lib]
crate-type = ["cdylib"]
[dependencies]
pyo3 = { version = "=0.30.1", features = ["abi3-py311"] }
TOML
cat > "$work/src/lib.rs" <<'RUST'
use pyo3::buffer::PyBuffer;
use pyo3::prelude::*;

#[pyfunction]
fn sum(py: Python<'_>, values: PyBuffer<f64>) -> PyResult<f64> {
    Ok(values.to_vec(py)?.iter().sum())
}

#[pymodule]
fn probe(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(sum, module)?)
}
RUST
PYO3_BUILD_EXTENSION_MODULE=1 CARGO_TARGET_DIR="$work/target" cargo build --quiet --manifest-path "$work/Cargo.toml"
cp "$work/target/debug/libprobe.so" "$work/probe.so"
PYTHONPATH="$work" python3 - <<'PYTHON' | tee "$work/seen"
import array
import ctypes
import sys

import probe

row = (ctypes.c_double * 2)(1.0, 2.0)
print("byte order:", sys.byteorder)
print("formats:", memoryview(array.array("d", row)).format, memoryview(row).format)
print("array:", probe.sum(array.array("d", row)))
try:
    print("ctypes:", probe.sum(row))
except BufferError as error:
    print("ctypes:", type(error).__name__)
PYTHON
grep -q '^byte order: little$' "$work/seen"
grep -q '^formats: d <d$' "$work/seen"
grep -q '^array: 3.0$' "$work/seen"
grep -q '^ctypes: BufferError$' "$work/seen"
echo "as described"
