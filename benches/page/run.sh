#!/bin/sh
# A large study: its page and its figures by `zwidth run`, beside a static page by plotly on the same Parquet files; both are
# opened in Chromium. Writes RESULTS.md.
#
#   benches/page/run.sh                                     1,000 participants, 36 trials each
#   benches/page/run.sh --participants 100 --repeats 1      smaller: 6 trials each
#
# CHROMIUM is the browser (default /usr/bin/chromium). The Python environment is made once, in VENV (default: the build
# folder). The study is made once a size, below the build folder: gigabytes.
set -eu
cd "$(dirname "$0")"
target="${CARGO_TARGET_DIR:-../../target}"
venv="${VENV:-$target/venv-page}"

cargo build --release --quiet --locked --manifest-path ../../Cargo.toml --package zwidth
[ -x "$venv/bin/python" ] || python3 -m venv "$venv"
"$venv/bin/python" -m pip install --quiet --requirement requirements.txt
"$venv/bin/python" bench.py "$target/release/zwidth" "$target/page-study" --chromium "${CHROMIUM:-/usr/bin/chromium}" "$@" |
    tee "$target/page.md"
cp "$target/page.md" RESULTS.md
