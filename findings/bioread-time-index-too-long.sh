#!/usr/bin/env bash
# bioread 2025.5.2: the times that it gives for a channel of an AcqKnowledge file run a little slow, so that the last is one sample late.
#
# Library: bioread 2025.5.2 (PyPI). Source: `time_index` in bioread/biopac.py, which spreads n samples over n/rate seconds with
# both ends, so that the step is (n/rate)/(n − 1) in place of 1/rate.
# Seen: of a channel of 123,787 samples at 2,000 Hz, which AcqKnowledge 4.4.0 wrote (it comes with bioread's source), the second time is 0.000500004 s
# in place of 0.0005, and the last 61.8935 s in place of 61.893.
# Meaning for us: the line that `zwidth import` prints for an .acq file makes the times of the number of a sample and the rate
# (docs/import.md, "AcqKnowledge"); `tests/interop/laboratory.py` tries it on files of three versions.
set -euo pipefail
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check bioread==2025.5.2 numpy==2.3.5
"$work/venv/bin/pip" download --quiet --disable-pip-version-check --no-deps --no-binary bioread --dest "$work" bioread==2025.5.2
tar -xzf "$work/bioread-2025.5.2.tar.gz" -C "$work"
cat > "$work/probe.py" <<'PYTHON'
import sys

import bioread

channel = bioread.read(sys.argv[1]).channels[0]
n, rate = channel.point_count, channel.samples_per_second
print(f"{n} samples at {rate:g} Hz: the second at {channel.time_index[1]:.9f} s in place of {1 / rate:.9f}, "
      f"the last at {channel.time_index[-1]:.4f} s in place of {(n - 1) / rate:.4f}")
PYTHON
seen="$("$work/venv/bin/python" "$work/probe.py" "$work/bioread-2025.5.2/test/data/physio/physio-4.4.0.acq")"
expected="123787 samples at 2000 Hz: the second at 0.000500004 s in place of 0.000500000, the last at 61.8935 s in place of 61.8930"
printf '%s\n' "$seen"
[ "$seen" = "$expected" ] || { echo "changed: expected '$expected'" >&2; exit 1; }
