"""Recordings in other programs' formats, made here by their own libraries: what zwidth reads of them, against those libraries."""

import json
import shlex
import struct
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import h5py
import numpy as np
import openpyxl
import pandas as pd
import polars as pl
import pyarrow as pa
import pyxdf
import scipy.io

from checks import DONE_OR_WITH_CARE, check, equal, run

MAP = """
kind = "trials"
{file}
[trial]
participant = "P01"
session = "{session}"
environment = "spring"
mode = "active"
[time]
from = {time}
unit = {unit}
[[column]]
to = "force_ex_n"
from = {force}
unit = "N"
"""
# To what times and values agree, s and N.
AGREEMENT = 1e-9
BOUNDARY = bytes.fromhex("43a546dccbf5410fb30ed5467383cbe4")


def check_all(zwidth):
    """Makes, imports and compares every format."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        run(zwidth, "--root", root, "new", "foreign")
        world = World(zwidth, root)
        xdf(world)
        workbooks(world)
        arrow(world)
        times(world)
        hdf5(world)
        packed(world)
        matlab(world)


class World:
    """A study, and how files come into it: each as a session of its own."""

    def __init__(self, zwidth, root):
        self.zwidth, self.root, self.sessions = zwidth, root, 0

    def bring(self, path, file="", time="t", force="f", unit='"s"'):
        """Imports one file; its times and forces, and what was printed."""
        self.sessions += 1
        session = f"S{self.sessions:02}"
        mapping = self.root / "map.toml"
        names = {"time": json.dumps(time), "force": json.dumps(force), "unit": unit}
        mapping.write_text(MAP.format(file=f"[file]\n{file}\n", session=session, **names))
        said = run(self.zwidth, "--root", self.root, "import", "foreign", "--map", mapping, path, codes=DONE_OR_WITH_CARE)
        frame = pd.read_parquet(self.root / "raw/foreign/trials")
        frame = frame[frame["session"].astype(str) == session].sort_values("t_s")
        return frame["t_s"].to_numpy(), frame["force_ex_n"].to_numpy(), said

    def bring_by_place(self, path, file):
        """The same with the first column as time and the second as force."""
        return self.bring(path, file, 1, 2)

    def refused(self, path, force="f"):
        """What is said of a file that is not read."""
        mapping = self.root / "map.toml"
        mapping.write_text(MAP.format(file="", session="S99", time='"t"', unit='"s"', force=json.dumps(force)))
        given = [self.zwidth, "--root", self.root, "import", "foreign", "--map", mapping, path]
        done = subprocess.run([str(part) for part in given], capture_output=True, text=True, check=False)
        return done.returncode, done.stderr

    def line(self, what, path, extension):
        """The arguments of the line that is printed for a file that is refused."""
        code, said = self.refused(path)
        line = said[said.find("python -c") :].splitlines()[0] if "python -c" in said else ""
        check(f"{what} is refused with a line", code == 1 and line.endswith(f"IN OUT.{extension}"), said)
        return shlex.split(line)[1:-2]

    def convert(self, what, path, extension):
        """Converts a file that is refused by the line that is printed."""
        converted = self.root / f"converted.{extension}"
        subprocess.run([sys.executable, *self.line(what, path, extension), path, converted], check=True)
        return converted


def same(what, found, expect):
    """Checks that two series agree."""
    found, expect = np.asarray(found, float), np.asarray(expect, float)
    off = np.abs(found - expect).max() if found.shape == expect.shape else np.inf
    check(what, off <= AGREEMENT, f"{found.shape} against {expect.shape}, off by {off}")


def chunk(tag, stream, content):
    """A chunk of an XDF file."""
    inner = struct.pack("<H", tag) + (b"" if stream is None else struct.pack("<I", stream)) + content
    return b"\x04" + struct.pack("<I", len(inner)) + inner


def stream_header(number, name, form, rate, labels):
    """The header of a stream."""
    channels = "".join(f"<channel><label>{label}</label></channel>" for label in labels)
    xml = (
        f'<?xml version="1.0"?><info><name>{name}</name><type>Force</type><channel_count>{len(labels)}</channel_count>'
        f"<nominal_srate>{rate}</nominal_srate><channel_format>{form}</channel_format>"
        f"<desc><channels>{channels}</channels></desc></info>"
    )
    return chunk(2, number, xml.encode())


def stream_samples(number, kind, times, rows):
    """A chunk of samples; a time of None is left to the rate."""
    content = b"\x04" + struct.pack("<I", len(rows))
    for time, row in zip(times, rows, strict=True):
        content += b"\0" if time is None else b"\x08" + struct.pack("<d", time)
        content += row if kind is None else struct.pack(f"<{len(row)}{kind}", *row)
    return chunk(3, number, content)


def recorded(seed, rate, kind, form, reset=False, given=1.0):
    """An XDF file of a stream of two channels whose clock drifts against the recorder's, one of markers, and boundaries between."""
    draw = np.random.default_rng(seed)
    n = 3000
    steady = 1234.5 + np.arange(n) / (rate or 50.0)
    own = steady * (1 + 2e-5) - 777.0 + draw.normal(0, 4e-4, n)
    if reset:
        own[n // 2 :] -= 900.0
    values = np.round(draw.normal(0, 50, (n, 2)))
    parts = [b"XDF:", chunk(1, None, b"<info><version>1.0</version></info>")]
    parts += [stream_header(1, "rig", form, rate, ["f", "x &amp; y"]), stream_header(2, "marks", "string", 0, ["m"])]
    parts.append(stream_samples(2, None, [1234.5], [b"\x01\x02go"]))
    for i, begin in enumerate(range(0, n, 100)):
        here = slice(begin, begin + 100)
        stamps = [t if rate == 0 or draw.random() < given else None for t in own[here]]
        parts.append(stream_samples(1, kind, stamps, values[here].astype(int if kind in "hb" else float)))
        offset = steady[begin] - own[begin] + draw.normal(0, 2e-5) + (0.05 if i == 7 else 0.0)
        parts.append(chunk(4, 1, struct.pack("<dd", own[begin], offset)))
        if i % 5 == 4:
            parts.append(chunk(5, None, BOUNDARY))
    parts.append(chunk(6, 1, f"<info><sample_count>{n}</sample_count></info>".encode()))
    return b"".join(parts)


def xdf(world):
    """Streams against pyxdf with its usual settings; files that are cut or damaged."""
    for name, content in [
        ("regular, drifting", recorded(1, 100.0, "f", "float32")),
        ("a clock set anew", recorded(2, 100.0, "d", "double64", reset=True)),
        ("irregular", recorded(3, 0, "h", "int16")),
        ("times left to the rate", recorded(4, 100.0, "f", "float32", given=0.3)),
    ]:
        path = world.root / f"{name}.xdf"
        path.write_bytes(content)
        theirs = next(s for s in pyxdf.load_xdf(path)[0] if s["info"]["name"][0] == "rig")
        stamps, values = theirs["time_stamps"], theirs["time_series"][:, 0]
        t, f, _ = world.bring(path, 'stream = "rig"', "time_s", "f")
        same(f"xdf, {name}: times as pyxdf has them", t, stamps)
        same(f"xdf, {name}: values", f, values)
    whole = recorded(1, 100.0, "f", "float32")
    path = world.root / "cut.xdf"
    path.write_bytes(whole[: len(whole) * 2 // 3])
    t, f, said = world.bring(path, 'stream = "rig"', "time_s", "f")
    theirs = next(s for s in pyxdf.load_xdf(path)[0] if s["info"]["name"][0] == "rig")
    values = theirs["time_series"][:, 0]
    check("xdf, cut off: all that pyxdf reads, and more", len(f) >= len(values) > 0, f"{len(f)}, {len(values)}")
    same("xdf, cut off: values", f[: len(values)], values)
    check("xdf, cut off: it is told", "cut off" in said and "samples of damaged chunks are lost" in said, said)


def table():
    """Times, forces and labels."""
    t = np.arange(200) / 100
    return pd.DataFrame({"t": t, "who": ["P01"] * 200, "f": np.sin(3 * t) / 3})


def workbooks(world):
    """Workbooks as openpyxl, pandas, and LibreOffice's format have them."""
    frame = table()
    path = world.root / "a.xlsx"
    frame.to_excel(path, sheet_name="data", index=False)
    t, f, _ = world.bring(path)
    same("xlsx of pandas: times", t, frame["t"])
    same("xlsx of pandas: values", f, frame["f"])
    book = openpyxl.load_workbook(path)
    book["data"]["C2"] = 0.125
    book.create_sheet("notes")["B2"] = "by hand"
    book.save(world.root / "b.xlsx")
    code, said = world.refused(world.root / "b.xlsx")
    check("xlsx of two sheets is refused by their names", code == 1 and "data, notes" in said, said)
    _, f, _ = world.bring(world.root / "b.xlsx", 'sheet = "data"')
    same("xlsx of openpyxl, a sheet by its name: values", f, [0.125, *frame["f"][1:]])
    cell = '<table:table-cell office:value-type="float" office:value="{}"/>'
    rows = "".join(f"<table:table-row>{cell.format(t)}{cell.format(f)}</table:table-row>" for t, f in zip(frame["t"], frame["f"]))
    head = "".join(f'<table:table-cell office:value-type="string"><text:p>{name}</text:p></table:table-cell>' for name in "tf")
    content = f'<office:body><table:table table:name="a"><table:table-row>{head}</table:table-row>{rows}</table:table></office:body>'
    with zipfile.ZipFile(world.root / "a.ods", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("mimetype", "application/vnd.oasis.opendocument.spreadsheet")
        archive.writestr("content.xml", content)
    t, f, _ = world.bring(world.root / "a.ods")
    same("ods: times", t, frame["t"])
    same("ods: values", f, frame["f"])


def arrow(world):
    """Arrow files as pandas and polars write them unasked, and packed."""
    frame = table()
    frame["who"] = frame["who"].astype("category")
    for name, write in [
        ("pandas, as it likes", lambda path: frame.to_feather(path)),
        ("pandas, zstd", lambda path: frame.to_feather(path, compression="zstd")),
        ("polars, as it likes", lambda path: pl.from_pandas(frame).write_ipc(path)),
        ("polars, lz4", lambda path: pl.from_pandas(frame).write_ipc(path, compression="lz4")),
    ]:
        path = world.root / f"{world.sessions}.feather"
        write(path)
        # The same values in each would be the same trial.
        t, f, _ = world.bring(path)
        same(f"arrow, {name}: times", t, frame["t"])
        same(f"arrow, {name}: values", f, frame["f"])
        frame["f"] += 0.25
    path = world.root / "stream.arrow"
    whole = pa.Table.from_pandas(frame)
    with pa.ipc.new_stream(path, whole.schema) as writer:
        writer.write_table(whole)
    converted = world.convert("an arrow stream", path, "arrow")
    _, f, _ = world.bring(converted)
    same("an arrow stream, converted by that line: values", f, frame["f"])


def hdf5(world):
    """HDF5 as h5py writes it, and as MATLAB does; what is not read is converted by the line that is printed."""
    frame = table()
    for number, (name, file_options, options) in enumerate([
        ("as it likes", {}, {}),
        ("in chunks", {}, {"chunks": True}),
        ("packed", {}, {"chunks": (7,), "compression": "gzip", "shuffle": True}),
        ("with lzf", {}, {"chunks": True, "compression": "lzf", "fletcher32": True}),
        ("that grows", {}, {"chunks": (16,), "maxshape": (None,)}),
        ("of the latest version", {"libver": "latest"}, {}),
        ("of the latest version, in chunks", {"libver": "latest"}, {"chunks": (16,), "maxshape": (None,)}),
        ("of the latest version, packed", {"libver": "latest"}, {"chunks": (16,), "compression": "gzip"}),
        ("of the latest version, packed, that grows", {"libver": "latest"}, {"chunks": (16,), "maxshape": (None,), "compression": "gzip"}),
        ("of the latest version, packed, one chunk", {"libver": "latest"}, {"chunks": (200,), "compression": "gzip"}),
        ("of the latest version, in pages of chunks", {"libver": "latest"}, {"chunks": (1,), "compression": "gzip", "fletcher32": True}),
    ]):
        path, f = world.root / f"{number}.h5", frame["f"].to_numpy() + number
        with h5py.File(path, "w", **file_options) as file:
            file.create_dataset("t", data=frame["t"].to_numpy(), **options)
            file.create_group("rig").create_dataset("f", data=f, **options)
            file["name"] = "rig 2"
            file["who"] = np.array([(1, 2.0)], dtype=[("a", "i4"), ("b", "f8")])
        t, found, _ = world.bring(path, "", "t", "rig/f")
        same(f"hdf5 {name}: times", t, frame["t"])
        same(f"hdf5 {name}: values", found, f)
    for number, (form, file_options) in enumerate([("old", {}), ("latest", {"libver": "latest"})]):
        path, f = world.root / f"links-{number}.h5", frame["f"].to_numpy() + 30 + number
        with h5py.File(path, "w", **file_options) as file:
            file["t"], file["rig/f"] = frame["t"].to_numpy(), f
            file["short"] = h5py.SoftLink("rig")
            file["rig/gone"] = h5py.SoftLink("/nothing")
            file["away"] = h5py.ExternalLink("other.h5", "/f")
        t, found, _ = world.bring(path, "", "t", "short/f")
        same(f"hdf5 behind a soft link, {form} form: values", found, f)
        code, said = world.refused(path, force="away")
        check(f"an external link of hdf5, {form} form, is refused by name", code == 1 and "other.h5" in said, said)
    matrix = np.column_stack([frame["t"], frame["f"] + 20])
    with h5py.File(world.root / "matrix.h5", "w") as file:
        file["rig/all"] = matrix
    t, f, _ = world.bring_by_place(world.root / "matrix.h5", 'matrix = "rig/all"')
    same("a matrix of hdf5: times", t, matrix[:, 0])
    same("a matrix of hdf5: values", f, matrix[:, 1])
    # MATLAB -v7.3: a block of its own first, and the last dimension counts rows.
    path = world.root / "a.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        file["all"] = matrix.T + 0.0
        file["all"].attrs["MATLAB_class"] = np.bytes_("double")
        file["what"] = np.frombuffer("rig".encode("utf-16-le"), dtype="u2")[:, None]
        file["what"].attrs["MATLAB_class"] = np.bytes_("char")
        file["#refs#/a"] = np.zeros(2)
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Mon Jan  1 00:00:00 2026 HDF5 schema 1.00 .")
        file.seek(124)
        file.write(b"\x00\x02IM")
    with h5py.File(path, "r+") as file:
        file["all"][:, :] = matrix.T + [[0.0], [1.0]]
    t, f, _ = world.bring_by_place(path, 'matrix = "all"')
    same("a matrix of MATLAB 7.3: times", t, matrix[:, 0])
    same("a matrix of MATLAB 7.3: values", f, matrix[:, 1] + 1.0)
    # A complex signal is no column.
    path = world.root / "complex.h5"
    with h5py.File(path, "w") as file:
        file["t"], file["rig/f"] = frame["t"].to_numpy(), frame["f"].to_numpy().astype(complex)
    code, said = world.refused(path, force="rig/f")
    check("a complex column of hdf5 is refused with a line", code == 1 and "python -c" in said, said)
    # The line itself, by a file that is not read: of a matrix of which both dimensions may grow.
    path = world.root / "latest.h5"
    f, both = frame["f"].to_numpy(), {"maxshape": (None, None), "chunks": (16, 1), "compression": "gzip"}
    with h5py.File(path, "w", libver="latest") as file:
        file.create_dataset("t", data=frame["t"].to_numpy()[:, None], **both)
        file["rig/f"], file["name"] = f[None, :] + 40, "rig 2"
        file["log"] = np.rec.fromarrays([np.arange(200), f], names="n,force")
        file["z"] = f + 2j * f
        file["counts"] = np.round(100 * f).astype("i2")
        file["counts"].attrs.update({"scale_factor": 0.01, "_FillValue": np.int16(-5)})
    converted = world.convert("a matrix of hdf5 that may grow both ways", path, "npz")
    t, found, _ = world.bring(converted, "", "t", "rig.f")
    same("hdf5, converted by that line: times", t, frame["t"])
    same("hdf5, converted by that line: values", found, f + 40)
    arrays = np.load(converted)
    expect = ["counts", "log.force", "log.n", "rig.f", "t", "z.imag", "z.real"]
    equal("hdf5, converted by that line: what is no number is left out", sorted(arrays), expect)
    same("hdf5, converted by that line: a field", arrays["log.force"], f)
    same("hdf5, converted by that line: an imaginary part", arrays["z.imag"], 2 * f)
    counts = np.round(100 * f)
    same("hdf5, converted by that line: what is packed", arrays["counts"][counts != -5], counts[counts != -5] * 0.01)
    equal("hdf5, converted by that line: what is missing", np.isnan(arrays["counts"]).sum(), (counts == -5).sum())


def packed(world):
    """Numbers that HDF5 packs, tables, and numbers of two bytes, against h5py."""
    frame = table()
    f = np.round(frame["f"].to_numpy(), 2)
    path = world.root / "packed.h5"
    with h5py.File(path, "w") as file:
        file["t"] = frame["t"].to_numpy()
        file["f"] = np.round((f + 1) * 100).astype("i2")
        file["f"].attrs.update({"scale_factor": 0.01, "add_offset": -1.0})
        file["log"] = np.rec.fromarrays([frame["t"], (f + 2).astype(">f4")], names="t,force")
        file["half"] = (f + 3).astype("f2")
        file["text"] = np.arange(200)
        file["text"].attrs["scale_factor"] = "0.01"
        read = [(file["f"][:] * 0.01 - 1, "f"), (file["log"]["force"], "log/force"), (file["half"][:], "half")]
    for expect, name in read:
        # Another file each time, for a recording counts once.
        with h5py.File(path, "r+") as file:
            file.attrs["read"] = name
        t, found, _ = world.bring(path, "", "t", name)
        same(f"hdf5, {name}: times", t, frame["t"])
        same(f"hdf5, {name}: values", found, expect)
    # The line that takes an attribute away, of a copy.
    code, said = world.refused(path, force="text")
    line = said[said.find("python -c") :].splitlines()[0]
    check("an attribute that is a text is refused with a line", code == 1 and "COPY DATASET ATTRIBUTES" in line, said)
    copy = world.root / "copy.h5"
    copy.write_bytes(path.read_bytes())
    subprocess.run([sys.executable, *shlex.split(line)[1:3], copy, "text", "scale_factor"], check=True)
    _, found, _ = world.bring(copy, "", "t", "text")
    same("hdf5 without that attribute: values", found, np.arange(200))


def times(world):
    """Durations and moments as pandas writes them, by the unit of their type."""
    frame = table()
    since = pd.to_timedelta(np.arange(200) * 10, unit="ms")
    for number, (name, column, unit) in enumerate([
        ("durations in us", since.as_unit("us"), "us"),
        ("durations in ns", since.as_unit("ns"), "ns"),
        ("moments in ns", pd.Timestamp("2026-01-31T23:59:59.123456789") + since.as_unit("ns"), "ns"),
    ]):
        for write, extension in [(pd.DataFrame.to_parquet, "parquet"), (pd.DataFrame.to_feather, "feather")]:
            path = world.root / f"times-{number}.{extension}"
            frame["f"] += 0.25
            write(frame.assign(t=column), path)
            t, f, _ = world.bring(path, unit=f'"{unit}"\nzero = "first"')
            same(f"{extension}, {name}: times", t, table()["t"])
            same(f"{extension}, {name}: values", f, frame["f"])
    code, said = world.refused(path)
    check("times in another unit than their type's are refused", code == 1 and 'set unit = "ns"' in said, said)


def matlab(world):
    """Structures as SciPy writes them in version 5."""
    frame = table()
    values = np.column_stack([np.zeros(200), frame["f"] + 50])
    signals = {"values": values, "dimensions": 2.0, "label": "f"}
    for packing in [False, True]:
        path = world.root / f"simout-{packing}.mat"
        scipy.io.savemat(path, {"simout": {"time": frame["t"].to_numpy()[:, None], "signals": signals}}, do_compression=packing)
        t, f, _ = world.bring(path, "", "simout.time", "simout.signals.values(2)")
        same(f"a structure with time, packed {packing}: times", t, frame["t"])
        same(f"a structure with time, packed {packing}: values", f, values[:, 1])
        values[:, 1] += 1
