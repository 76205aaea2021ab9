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
# Times that two programs compute from one file agree within this, s.
SAME_S = 1e-5
# Whatever does not come by then does not come, s.
PATIENCE_S = 60
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
        self.taken = {}

    def chunk(self, tag, stream, content):
        number = b"" if stream is None else struct.pack("<I", stream)
        inner = struct.pack("<H", tag) + number + content
        self.file.write(b"\x04" + struct.pack("<I", len(inner)) + inner)

    def add(self, number, name, is_text):
        found = pylsl.resolve_byprop("name", name, timeout=PATIENCE_S)
        inlet = pylsl.StreamInlet(found[0], recover=False)
        inlet.open_stream(timeout=PATIENCE_S)
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
                offset = inlet.time_correction(timeout=PATIENCE_S)
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
                self.taken[number] = self.taken.get(number, 0) + len(stamps)

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
    # A session that waits for something else is no session for ever.
    late = threading.Timer(5 * PATIENCE_S, session.kill)
    late.start()
    lines = []
    waited = False
    # Until it says that it waits: nobody sends an EMG yet.
    for line in session.stdout:
        lines.append(line)
        if f"'{EMG}' is missing" in line:
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
    late.cancel()
    check("beside: the session ends", session.wait() == 0, "".join(lines[-20:]))
    log = (root / "raw/beside/sessions/P01_S01.events.jsonl").read_text()
    begun = time.monotonic()
    while recorder.taken.get(1, 0) < log.count('"event":"marker"') and time.monotonic() - begun < PATIENCE_S:
        time.sleep(0.05)
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


def named(streams, name):
    """The stream of a file by its name."""
    return next(stream for stream in streams if stream["info"]["name"][0] == name)


def against_pyxdf(root, path):
    ours = kept(root, "emg_of_the_arm")
    frame = ours.to_pandas()
    corrected, _ = pyxdf.load_xdf(path, dejitter_timestamps=False)
    raw, _ = pyxdf.load_xdf(path, synchronize_clocks=False, dejitter_timestamps=False)
    emg = named(corrected, EMG)
    off = np.abs(frame["recorder_s"].to_numpy() - emg["time_stamps"]).max()
    check("beside: the recorder's times are those of pyxdf", off < SAME_S, f"{off}")
    check("beside: the values are those of pyxdf", np.array_equal(frame[["clock", "wave"]].to_numpy(), emg["time_series"]), "")
    stamps = named(raw, EMG)["time_stamps"]
    check("beside: the stamps are those of the source", np.array_equal(frame["stamp_s"].to_numpy(), stamps), "")
    unit = ours.schema.field("wave").metadata[b"unit"]
    check("beside: a channel has its unit", unit == b"mV", str(unit))
    # When each trial began and ended: the log has the clock of the markers, and pyxdf what the recorder's is ahead of it.
    log = [json.loads(line)["what"] for line in (root / "raw/beside/sessions/P01_S01.events.jsonl").read_text().splitlines()]
    logged = [event for event in log if event["event"] == "marker"]
    lines = [json.loads(row[0]) for row in named(raw, "zwidth")["time_series"]]
    check("beside: every marker was recorded", len(lines) == len(logged) > 0, f"{len(lines)} of {len(logged)}")
    ahead = named(corrected, "zwidth")["time_stamps"] - named(raw, "zwidth")["time_stamps"]
    begun = {event["trial"]: (event["monotonic_us"] - event["t_us"]) * 1e-6 for event in logged}
    ended = {event["trial"]: event["t_us"] * 1e-6 for event in logged if event["moment"] == "end"}
    trials = pd.read_parquet(root / "raw/beside/trials")
    for trial, end in ended.items():
        zero = begun[trial] + min(by for by, line in zip(ahead, lines, strict=True) if line["trial"] == trial)
        expect = emg["time_stamps"] - zero
        inside = (expect > SAME_S) & (expect < end - SAME_S)
        rows = frame[inside]
        check(f"beside: the samples of trial {trial}", inside.any() and (rows["trial"] == trial).all(), f"{rows['trial'].unique()}")
        off = np.abs(rows["t_s"].to_numpy() - expect[inside]).max()
        check(f"beside: their times in trial {trial}", off < SAME_S, f"{off}")
        outside = (frame["trial"] == trial) & ((expect < -SAME_S) | (expect > end + SAME_S))
        check(f"beside: no other sample is of trial {trial}", not outside.any(), str(outside.sum()))
        last = trials.loc[trials["trial"] == trial, "t_s"].max()
        check(f"beside: trial {trial} ends with its last sample", abs(last - end) < 2e-6, f"{last} {end}")
    # A measurement, not a check: the value of a sample is the moment at which it was taken, by the clock of the trials.
    of_trials = frame[frame["trial"].notna()]
    off = of_trials["clock"] - of_trials["trial"].map(begun) - of_trials["t_s"]
    print(f"a sample's time in its trial is off by {off.abs().max() * 1e6:.1f} us at most")
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
    check("beside: by arrival no trial begins early", (late > -SAME_S).all(), f"{late.min()}")


if __name__ == "__main__":
    check_all(sys.argv[1])
