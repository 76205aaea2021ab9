#!/usr/bin/env bash
# pyxdf 1.17.5: samples that a steady stream lost become time that is wrong, and a clock that was set anew does too.
#
# Library: pyxdf 1.17.5 (PyPI), with its default arguments. Source: `_jitter_removal` in pyxdf/pyxdf.py, which puts a straight
# line through the times between two breaks, and takes a step for a break only if it is longer than one second and than 500
# samples; `_detect_clock_resets`, which takes a step of the clock offsets for a reset only if the comparison itself came
# late or early too.
# Seen: of a stream at 100 Hz 2 s are lost behind sample 1750 (17.5 s). pyxdf gives evenly spaced times, and sample 1751 a time
# that is 1 s off, without a warning. With offsets that step by 10 s between two comparisons five seconds apart, a line goes
# through the step: times far from it are off by seconds.
# Meaning for us: `import::xdf` breaks the line at any step of more than three intervals that lasts, has a line on either side
# of a step of the offsets, and says so (docs/import.md, "XDF").
set -euo pipefail
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check pyxdf==1.17.5 numpy==2.3.5
cat > "$work/probe.py" <<'PYTHON'
import struct
import sys

import numpy as np
import pyxdf


def chunk(tag, content, stream=None):
    body = struct.pack("<H", tag) + (struct.pack("<I", stream) if stream else b"") + content
    return b"\x04" + struct.pack("<I", len(body)) + body


def write(path, times, offsets):
    header = (
        "<?xml version='1.0'?><info><name>rig</name><type>Force</type><channel_count>1</channel_count>"
        "<nominal_srate>100</nominal_srate><channel_format>float32</channel_format></info>"
    )
    data = b"XDF:" + chunk(1, b"<?xml version='1.0'?><info><version>1.0</version></info>") + chunk(2, header.encode(), 1)
    samples = b"".join(b"\x08" + struct.pack("<d", t) + struct.pack("<f", i) for i, t in enumerate(times))
    data += chunk(3, b"\x04" + struct.pack("<I", len(times)) + samples, 1)
    for t, offset in offsets:
        data += chunk(4, struct.pack("<dd", t, offset), 1)
    footer = f"<?xml version='1.0'?><info><sample_count>{len(times)}</sample_count></info>"
    with open(path, "wb") as file:
        file.write(data + chunk(6, footer.encode(), 1))


def loaded(path):
    streams, _ = pyxdf.load_xdf(path)
    return streams[0]["time_stamps"]


folder = sys.argv[1]
i = np.arange(3500)
true = 0.01 * i + np.where(i >= 1750, 2.0, 0.0)
write(f"{folder}/gap.xdf", true, [(t, 0.0) for t in range(0, 40, 5)])
found = loaded(f"{folder}/gap.xdf")
steps = np.diff(found)
print(f"lost samples: longest step {steps.max():.4f} s, sample 1751 off by {abs(found[1750] - true[1750]):.2f} s")

true = 0.01 * np.arange(4000)
offsets = [(t, 5.0 if t < 20 else 15.0) for t in range(0, 40, 5)]
write(f"{folder}/step.xdf", true, offsets)
found = loaded(f"{folder}/step.xdf") - 5.0
off = np.abs(found - np.where(true < 17.5, true, true + 10.0))
print(f"offsets that step by 10 s: times off by up to {off.max():.1f} s")
PYTHON
"$work/venv/bin/python" "$work/probe.py" "$work" | tee "$work/seen"
grep -q '^lost samples: longest step 0.01.. s, sample 1751 off by' "$work/seen"
grep -Eq '^offsets that step by 10 s: times off by up to [1-9]' "$work/seen"
echo "as described"
