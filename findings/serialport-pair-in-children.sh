#!/usr/bin/env bash
# serialport 4.10.1: both ends of `TTYPort::pair` stay open in every child process.
#
# Library: serialport 4.10.1 (crates.io), Linux; source: `pair` in src/posix/tty.rs, which opens both ends without
# O_CLOEXEC. (A port that is opened by its path has it.)
# Seen: the flags of both ends in /proc/self/fdinfo, which lack O_CLOEXEC (octal 02000000).
# Meaning for us: a test that closes its end hangs nothing up while any child runs that was started meanwhile, so that
# `link::Window` makes its pseudo-terminals itself.
set -euo pipefail
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/src"
cat > "$work/Cargo.toml" <<'TOML'
[package]
name = "probe"
version = "0.0.0"
edition = "2024"
[dependencies]
serialport = { version = "=4.10.1", default-features = false }
TOML
cat > "$work/src/main.rs" <<'RUST'
use std::os::fd::AsRawFd as _;

fn main() {
    let (first, second) = serialport::TTYPort::pair().expect("a pseudo-terminal");
    for (name, end) in [("first", first.as_raw_fd()), ("second", second.as_raw_fd())] {
        let info = std::fs::read_to_string(format!("/proc/self/fdinfo/{end}")).expect("its flags");
        let flags = info.lines().find_map(|line| line.strip_prefix("flags:")).expect("flags");
        let flags = u32::from_str_radix(flags.trim(), 8).expect("octal");
        println!("{name} end closed in children: {}", flags & 0o2_000_000 != 0);
    }
}
RUST
cargo run --quiet --manifest-path "$work/Cargo.toml" | tee "$work/seen"
grep -q '^first end closed in children: false$' "$work/seen"
grep -q '^second end closed in children: false$' "$work/seen"
echo "as described"
