"""Streams beside a session: a real session whose markers go through to_lsl.py, an outlet of pylsl beside it, both recorded into an
XDF file; what `zwidth beside` keeps of it, against pyxdf and against the clock that both streams share."""

import json
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pylsl
import pyarrow.parquet as pq
import pyxdf

from checks import check, run

WORKSPACE = Path(__file__).parents[2]
RATE_HZ = 500
# The recorder is on another machine: its clock is so far ahead, s.
AHEAD_S = 5000.0
# The loop of a session and a thread of Python read the same clock, but not at once, s.
NEAR_S = 2e-4
EMG = "EMG of the arm"


def check_all(zwidth):
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        run(zwidth, "--root", root, "new", "beside")
        study = root / "raw/beside/study.toml"
        # A session of six trials, one after the other.
        text = study.read_text()
        for old, new in [("repeats = 6", "repeats = 1"), ("familiarisation = 3", "familiarisation = 0"), ("pause_s = 5.0", "pause_s = 0.2")]:
            check(f"beside: the study has {old}", old in text, text[:600])
            text = text.replace(old, new)
        study.write_text(text)
        said = record(zwidth, root)
        check("beside: no trial began before the stream was there", said, "it did not wait")
        path = root / "lab.xdf"
        out = run(zwidth, "--root", root, "beside", "beside", "--from", path, "-p", "P01", "-s", "S01")
        check("beside: the machine's clock is found", "by the machine's clock" in out, out)
        against_pyxdf(root, path)
        listed = json.loads(run(zwidth, "--root", root, "--json", "beside", "beside", "--list"))
        check("beside: both streams are listed", [one["stream"] for one in listed] == ["emg_of_the_arm", "keys"], str(listed))
        run(zwidth, "--root", root, "verify", "beside")
        by_arrival(zwidth, root, path)


class Recorder:
    """Writes outlets into an XDF file as LabRecorder does: raw stamps, and every second what a clock is behind its own."""

    def __init__(self, path):
        self.file = open(path, "wb")
        self.file.write(b"XDF:")
        self.chunk(1, None, b"<?xml version='1.0'?><info><version>1.0</version></info>")
        self.lock = threading.Lock()
        self.ends = False
        self.threads = []

    def chunk(self, tag, stream, content):
        number = b"" if stream is None else struct.pack("<I", stream)
        inner = struct.pack("<H", tag) + number + content
        self.file.write(b"\x04" + struct.pack("<I", len(inner)) + inner)

    def add(self, number, name, is_text):
        found = pylsl.resolve_byprop("name", name, timeout=30)
        inlet = pylsl.StreamInlet(found[0], recover=False)
        inlet.open_stream(timeout=30)
        with self.lock:
            self.chunk(2, number, inlet.info().as_xml().encode())
        thread = threading.Thread(target=self.pull, args=(number, inlet, is_text))
        thread.start()
        self.threads.append(thread)

    def pull(self, number, inlet, is_text):
        compared = 0.0
        while not self.ends:
            if time.monotonic() - compared > 1.0:
                compared = time.monotonic()
                offset = inlet.time_correction(timeout=30)
                with self.lock:
                    self.chunk(4, number, struct.pack("<dd", pylsl.local_clock() - offset, offset + AHEAD_S))
            rows, stamps = inlet.pull_chunk(timeout=0.2, max_samples=256)
            if not stamps:
                continue
            content = b"\x04" + struct.pack("<I", len(stamps))
            for row, stamp in zip(rows, stamps):
                content += b"\x08" + struct.pack("<d", stamp)
                for value in row:
                    text = value.encode() if is_text else b""
                    content += b"\x04" + struct.pack("<I", len(text)) + text if is_text else struct.pack("<d", value)
            with self.lock:
                self.chunk(3, number, content)

    def close(self):
        self.ends = True
        for thread in self.threads:
            thread.join()
        self.file.close()


def record(zwidth, root):
    """A session with its markers and an EMG into a file; whether it waited for the EMG."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    bridge = subprocess.Popen(
        [sys.executable, WORKSPACE / "examples/markers/to_lsl.py", "--port", str(port)], stdout=subprocess.PIPE, text=True
    )
    check("beside: the bridge listens", "listening" in bridge.stdout.readline(), "it does not")
    recorder = Recorder(root / "lab.xdf")
    recorder.add(1, "zwidth", True)
    command = [zwidth, "--root", root, "acquire", "beside", "-p", "P01", "-s", "S01", "--auto", "--plain", "--wait-for", EMG]
    session = subprocess.Popen(
        [*map(str, command), "--markers", f"tcp:127.0.0.1:{port}"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    lines = []
    waited = False
    # Until it says that it waits: nobody sends an EMG yet.
    for line in session.stdout:
        lines.append(line)
        if f"'{EMG}' is not there" in line:
            waited = not any("recorded" in before for before in lines)
            break
    ends = threading.Event()
    info = pylsl.StreamInfo(EMG, "EMG", 2, RATE_HZ, "double64", "emg-17")
    channels = info.desc().append_child("channels")
    for label, unit in [("clock", "s"), ("wave", "mV")]:
        channels.append_child("channel").append_child_value("label", label).append_child_value("unit", unit)
    outlet = pylsl.StreamOutlet(info)
    keys = pylsl.StreamOutlet(pylsl.StreamInfo("keys", "Markers", 1, pylsl.IRREGULAR_RATE, "string", "keys-3"))
    recorder.add(2, EMG, False)
    recorder.add(3, "keys", True)
    sender = threading.Thread(target=send, args=(outlet, keys, ends))
    sender.start()
    lines += list(session.stdout)
    check("beside: the session ends", session.wait() == 0, "".join(lines[-20:]))
    time.sleep(1.5)
    ends.set()
    sender.join()
    recorder.close()
    bridge.terminate()
    bridge.wait()
    return waited


def send(outlet, keys, ends):
    """The clock itself as the EMG, and a word now and then."""
    begun = pylsl.local_clock()
    sent = 0
    while not ends.is_set():
        now = pylsl.local_clock()
        while begun + sent / RATE_HZ <= now:
            at = begun + sent / RATE_HZ
            outlet.push_sample([at, float(np.sin(at))], at)
            if sent % RATE_HZ == 0:
                keys.push_sample([f"key {sent // RATE_HZ}"], at)
            sent += 1
        time.sleep(0.002)


def kept(root, stream, table=1):
    file = root / f"raw/beside/beside/participant=P01/session=S01/{stream}.{table:04}.parquet"
    return pq.read_table(file, partitioning=None)


def against_pyxdf(root, path):
    ours = kept(root, "emg_of_the_arm")
    frame = ours.to_pandas()
    theirs, _ = pyxdf.load_xdf(path, dejitter_timestamps=False)
    emg = next(stream for stream in theirs if stream["info"]["name"][0] == EMG)
    same = np.abs(frame["recorder_s"].to_numpy() - emg["time_stamps"]).max()
    check("beside: the recorder's times are those of pyxdf", same < 1e-6, f"{same}")
    check("beside: the values are those of pyxdf", np.array_equal(frame[["clock", "wave"]].to_numpy(), emg["time_series"]), "")
    raw, _ = pyxdf.load_xdf(path, synchronize_clocks=False, dejitter_timestamps=False)
    emg = next(stream for stream in raw if stream["info"]["name"][0] == EMG)
    check("beside: the stamps are those of the source", np.array_equal(frame["stamp_s"].to_numpy(), emg["time_stamps"]), "")
    unit = ours.schema.field("wave").metadata[b"unit"]
    check("beside: a channel has its unit", unit == b"mV", str(unit))
    log = [json.loads(line)["what"] for line in (root / "raw/beside/sessions/P01_S01.events.jsonl").read_text().splitlines()]
    begun = {}
    ended = {}
    for event in log:
        if event.get("event") == "marker":
            begun[event["trial"]] = (event["monotonic_us"] - event["t_us"]) * 1e-6
        if event.get("event") == "marker" and event["moment"] == "end":
            ended[event["trial"]] = event["t_us"] * 1e-6
    inside = frame[frame["trial"].notna()]
    check("beside: every trial has samples", set(inside["trial"]) == set(begun), str(sorted(begun)))
    # The value of a sample is the moment at which it was taken, by the clock that the trial began by.
    off = inside["clock"] - inside["trial"].map(begun) - inside["t_s"]
    print(f"a sample's time in its trial is off by {off.abs().max() * 1e6:.1f} us at most")
    check("beside: a sample's time in its trial is right", off.abs().max() < NEAR_S, f"{off.abs().max()}")
    trials = pd.read_parquet(root / "raw/beside/trials")
    for trial, end in ended.items():
        times = inside.loc[inside["trial"] == trial, "t_s"]
        check(f"beside: trial {trial} from its start to its end", times.min() < 0.004 and end - 0.004 < times.max() <= end + 1e-4, f"{times.min()} {times.max()} {end}")
        last = trials.loc[trials["trial"] == trial, "t_s"].max()
        check(f"beside: trial {trial} ends with its last sample", abs(last - end) < 2e-6, f"{last} {end}")
    keys = kept(root, "keys").to_pandas()
    check("beside: words are kept as words", keys["channel_1"].str.startswith("key ").all(), str(keys.head()))


def by_arrival(zwidth, root, path):
    """The same from markers that were stamped by another machine: later by a marker's way, and told."""
    rig = "-p", "P01", "-s", "S01"
    run(zwidth, "--root", root, "beside", "beside", *rig, "--withdraw", "emg_of_the_arm", "another way")
    content = bytearray(path.read_bytes())
    at = 4
    while at < len(content):
        (length,) = struct.unpack_from("<I", content, at + 1)
        tag, number = struct.unpack_from("<HI", content, at + 5)
        if number == 1 and tag == 4:
            time_s, offset = struct.unpack_from("<dd", content, at + 11)
            struct.pack_into("<dd", content, at + 11, time_s + 100.0, offset - 100.0)
        if number == 1 and tag == 3:
            (count,) = struct.unpack_from("<I", content, at + 12)
            place = at + 16
            for _ in range(count):
                (stamp,) = struct.unpack_from("<d", content, place + 1)
                struct.pack_into("<d", content, place + 1, stamp + 100.0)
                (text,) = struct.unpack_from("<I", content, place + 10)
                place += 14 + text
        at += 5 + length
    shifted = root / "shifted.xdf"
    shifted.write_bytes(content)
    out = run(zwidth, "--root", root, "beside", "beside", "--from", shifted, *rig, "--stream", f"{EMG}=emg")
    check("beside: arrival is told", "by the arrival of their first marker" in out, out)
    first = kept(root, "emg_of_the_arm").to_pandas().dropna(subset=["trial"])
    second = kept(root, "emg").to_pandas().dropna(subset=["trial"])
    both = first.merge(second, on=["trial", "stamp_s"])
    late = both["t_s_x"] - both["t_s_y"]
    print(f"by arrival, trials begin {late.min() * 1e3:.2f} to {late.max() * 1e3:.2f} ms late")
    check("beside: by arrival trials begin some ms late", (late > -NEAR_S).all() and late.max() < 0.1, f"{late.min()} {late.max()}")


if __name__ == "__main__":
    check_all(sys.argv[1])
