"""Files of laboratories of 100 MB, read by zwidth and by each format's own library, in turns: seconds of each, as Markdown.

    python formats.py --reader PROGRAM --zwidth PROGRAM [--mb 100] [--turns 3] [--formats tdms,c3d,...]

Both read the same numbers of the same file, a time and seven channels, and their sums must agree. Seconds are those of the processor, which
other work on the machine does not change: of ours of the whole process, of the library from the opening of the file to arrays of doubles.
Beside it stands what a whole import takes: reading, converting, checking and writing.
"""

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

CHANNELS = 7
RATE_HZ = 1000.0
MAP = """
kind = "trials"
[file]
{file}
[trial]
participant = "P01"
session = "S01"
environment = "spring"
mode = "active"
[time]
{time}
[[column]]
to = "force_ex_n"
from = {column}
unit = "N"
"""


def samples(mb, size):
    """Seven channels of so many rows that a file of `size` bytes a number has so many MB."""
    rows = int(mb * 1e6 / (CHANNELS * size))
    t = np.arange(rows) / RATE_HZ
    return [np.round(np.sin(t * (i + 1)), 5) for i in range(CHANNELS)]


class Tdms:
    name, peer, format, part = "TDMS", "npTDMS", "tdms", ""
    keys = 'format = "tdms"', 'from = "time_s"\nunit = "s"', '"c0"'

    def write(self, path, mb):
        import nptdms

        channels = samples(mb, 8)
        timing = {"wf_increment": 1 / RATE_HZ, "wf_start_offset": 0.0}
        with nptdms.TdmsWriter(path) as file:
            for part in np.array_split(np.arange(channels[0].size), channels[0].size // 1000):
                file.write_segment([nptdms.ChannelObject("rig", f"c{i}", values[part], timing) for i, values in enumerate(channels)])

    def read(self, path):
        import nptdms

        began = time.process_time()
        group = nptdms.TdmsFile.read(path)["rig"]
        columns = [group["c0"].time_track(), *(group[f"c{i}"][:] for i in range(CHANNELS))]
        return time.process_time() - began, columns


class C3d:
    name, peer, format, part = "C3D", "ezc3d", "c3d", "analog"
    keys = 'format = "c3d"\ngroup = "analog"', 'from = "time_s"\nunit = "s"', '"c0"'

    def write(self, path, mb):
        import ezc3d

        # Ten samples a frame.
        channels = np.array(samples(mb, 4))
        channels = channels[:, : channels.shape[1] // 10 * 10]
        file = ezc3d.c3d()
        file["parameters"]["POINT"]["RATE"]["value"] = [RATE_HZ / 10]
        file["parameters"]["ANALOG"]["RATE"]["value"] = [RATE_HZ]
        file["parameters"]["ANALOG"]["LABELS"]["value"] = tuple(f"c{i}" for i in range(CHANNELS))
        file["data"]["points"] = np.zeros((4, 0, channels.shape[1] // 10))
        file["data"]["analogs"] = channels[None]
        file.write(str(path))

    def read(self, path):
        import ezc3d

        began = time.process_time()
        analogs = ezc3d.c3d(str(path))["data"]["analogs"][0]
        return time.process_time() - began, [np.arange(analogs.shape[1]) / RATE_HZ, *analogs]


class Mcap:
    name, peer, format, part = "MCAP", "mcap, mcap-ros2-support", "mcap", ""
    keys = 'format = "mcap"', 'from = "stamp"\nunit = "ns"\nzero = "first"', '"values[0]"'

    def write(self, path, mb):
        import mcap_ros2.writer

        channels = samples(mb, 12)
        definition = "builtin_interfaces/Time stamp\nfloat64[7] values\n" + "=" * 80 + "\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
        with path.open("wb") as stream:
            writer = mcap_ros2.writer.Writer(stream)
            schema = writer.register_msgdef("rig/msg/Sample", definition)
            for i, row in enumerate(zip(*(channel.tolist() for channel in channels), strict=True)):
                ns = i * 1_000_000
                message = {"stamp": {"sec": ns // 10**9, "nanosec": ns % 10**9}, "values": list(row)}
                writer.write_message("/rig", schema, message, log_time=ns, publish_time=ns, sequence=i)
            writer.finish()

    def read(self, path):
        import mcap.reader
        import mcap_ros2.decoder

        began = time.process_time()
        rows = []
        with path.open("rb") as stream:
            reader = mcap.reader.make_reader(stream, decoder_factories=[mcap_ros2.decoder.DecoderFactory()])
            for _, _, _, message in reader.iter_decoded_messages():
                rows.append((message.stamp.sec * 10**9 + message.stamp.nanosec, *message.values))
        columns = list(np.array(rows, float).T)
        return time.process_time() - began, columns


class Mat:
    name, peer, format, part = "MAT (v7)", "SciPy", "mat", ""
    keys = 'format = "mat"', "rate_hz = 1000.0", '"c0"'

    def write(self, path, mb):
        import scipy.io

        # Compressed, as MATLAB writes it, numbers of five digits take a part of their bytes.
        channels = samples(mb, 8)
        time_s = np.arange(channels[0].size) / RATE_HZ
        scipy.io.savemat(path, {"t": time_s} | {f"c{i}": values for i, values in enumerate(channels)}, do_compression=True)

    def read(self, path):
        import scipy.io

        began = time.process_time()
        found = scipy.io.loadmat(path)
        columns = [found["t"].ravel(), *(found[f"c{i}"].ravel() for i in range(CHANNELS))]
        return time.process_time() - began, columns


class Lvm:
    name, peer, format, part = "LVM", "lvm_read", None, ""

    def __init__(self):
        self.head = [
            "LabVIEW Measurement", "Writer_Version\t2", "Reader_Version\t2", "Separator\tTab", "Decimal_Separator\t.", "Multi_Headings\tNo",
            "X_Columns\tOne", "Time_Pref\tRelative", "***End_of_Header***", "",
        ]  # fmt: skip
        self.second = [f"Channels\t{CHANNELS}", "Samples" + "\t1" * CHANNELS, "X0" + "\t0" * CHANNELS, "Delta_X" + "\t0.001" * CHANNELS, "***End_of_Header***"]
        self.keys = f'format = "tsv"\nskip = {len(self.head) + len(self.second)}', 'from = "X_Value"\nunit = "s"', '"c0"'

    def write(self, path, mb):
        # Of a time and seven channels a line has some 76 bytes.
        channels = samples(mb, 76 / CHANNELS)
        names = "X_Value\t" + "\t".join(f"c{i}" for i in range(CHANNELS)) + "\tComment"
        columns = np.column_stack([np.arange(channels[0].size) / RATE_HZ, *channels])
        with path.open("w", newline="") as file:
            file.write("\r\n".join([*self.head, *self.second, names]) + "\r\n")
            np.savetxt(file, columns, fmt="%.6f", delimiter="\t", newline="\r\n")

    def read(self, path):
        import lvm_read

        began = time.process_time()
        data = lvm_read.read(str(path), read_from_pickle=False, dump_file=False)[0]["data"]
        return time.process_time() - began, list(data.T)


FORMATS = {"tdms": Tdms, "c3d": C3d, "mcap": Mcap, "mat": Mat, "lvm": Lvm}


def measured(line, codes=(0,)):
    """Seconds of the processor that a program took, and what it printed."""
    with tempfile.TemporaryFile("w+") as out:
        process = subprocess.Popen(line, stdout=out, stderr=subprocess.DEVNULL)
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        assert process.returncode in codes, (line, process.returncode)
        out.seek(0)
        return used.ru_utime + used.ru_stime, out.read()


def ours(reader, kind, path):
    """Seconds that our reader took, and the sum of what it read."""
    seconds, said = measured([reader, kind.format, path, kind.part])
    return seconds, float(said.split()[1])


def theirs(name, path):
    """The same of the format's own library, in a process of its own."""
    line = [sys.executable, __file__, "--peer", name, path]
    seconds, total = subprocess.run(line, capture_output=True, text=True, check=True).stdout.split()
    return float(seconds), float(total)


def imported(zwidth, kind, folder, path):
    """Seconds of a whole import, by the program's own process."""
    with tempfile.TemporaryDirectory(dir=folder) as root:
        subprocess.run([zwidth, "--root", root, "new", "bench"], check=True, capture_output=True)
        mapping = Path(root) / "map.toml"
        file, at, column = kind.keys
        mapping.write_text(MAP.format(file=file, time=at, column=column))
        return measured([zwidth, "--root", root, "import", "bench", "--map", mapping, path], codes=(0, 3))[0]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--reader")
    parser.add_argument("--zwidth")
    parser.add_argument("--mb", type=float, default=100)
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--formats", default=",".join(FORMATS))
    parser.add_argument("--peer", nargs=2, metavar=("FORMAT", "FILE"))
    given = parser.parse_args()
    if given.peer:
        seconds, columns = FORMATS[given.peer[0]]().read(Path(given.peer[1]))
        print(seconds, repr(float(sum(float(np.sum(column)) for column in columns))))
        return
    print("| format | MB | beside | zwidth, s | its time, s | times as long | a whole import, s |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    with tempfile.TemporaryDirectory() as folder:
        for name in given.formats.split(","):
            kind = FORMATS[name]()
            path = Path(folder) / f"long.{'lvm' if name == 'lvm' else kind.format}"
            kind.write(path, given.mb)
            own, other, whole = [], [], []
            for _ in range(given.turns):
                whole.append(imported(given.zwidth, kind, folder, path))
                seconds, expect = theirs(name, path)
                other.append(seconds)
                if kind.format:
                    seconds, found = ours(given.reader, kind, path)
                    own.append(seconds)
                    assert abs(found - expect) <= 1e-9 * max(1.0, abs(expect)), (name, found, expect)
            # Of a text numbers are read where they become samples: there is no reading alone.
            own = own or whole
            a, b, c = (statistics.median(list_) for list_ in (own, other, whole))
            print(f"| {kind.name} | {path.stat().st_size / 1e6:.0f} | {kind.peer} | {a:.3f} | {b:.3f} | {b / a:.2f} | {c:.2f} |", flush=True)
            path.unlink()


if __name__ == "__main__":
    main()
