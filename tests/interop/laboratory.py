"""Recordings of laboratories (TDMS, C3D, MCAP, OpenSim), written by other people's libraries: what zwidth reads of them, to the last
bit of what those libraries read."""

import importlib.metadata
import json
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

import asammdf
import bioread
import c3d
import ezc3d
import lvm_read
import matio
import mcap.writer
import mcap_ros2.writer
import nptdms
import numpy as np
import opensim
import pandas as pd
import rosbags.highlevel
import rosbags.rosbag2
import rosbags.typesys

from checks import check, run
from foreign import World, same

RNG = np.random.default_rng(5)
# Of a force that an instrument gave.
FORCE = np.round(RNG.normal(0.0, 3.0, 400), 6)


def check_all(zwidth):
    """Makes, imports and compares every format."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        run(zwidth, "--root", root, "new", "foreign")
        world = World(zwidth, root)
        tdms(world)
        tdms_of_labview(world)
        lvm(world)
        points(world)
        bags(world)
        tables(world)
        motions(world)
        converted(world)


def bits(what, found, expect):
    """Checks that two series are the same to the last bit."""
    found, expect = np.asarray(found, float), np.asarray(expect, float)
    equal = found.shape == expect.shape and np.array_equal(found.view(np.int64), expect.view(np.int64))
    off = np.abs(found - expect).max() if found.shape == expect.shape else np.inf
    check(what, equal, f"{found.shape} against {expect.shape}, off by {off}")


def tdms(world):
    """npTDMS writes, and reads what zwidth is held against."""
    timing = {"wf_increment": 0.001, "wf_start_offset": 0.25, "unit_string": "N"}
    linear = {
        "NI_Number_Of_Scales": 1,
        "NI_Scale[0]_Scale_Type": "Linear",
        "NI_Scale[0]_Linear_Slope": 0.0125,
        "NI_Scale[0]_Linear_Y_Intercept": -3.7,
        "NI_Scale[0]_Linear_Input_Source": 0xFFFFFFFF,
    }
    polynomial = {"NI_Number_Of_Scales": 1, "NI_Scale[0]_Scale_Type": "Polynomial", "NI_Scale[0]_Polynomial_Coefficients_Size": 4}
    polynomial |= {f"NI_Scale[0]_Polynomial_Coefficients[{i}]": value for i, value in enumerate([0.3, -0.02, 1e-5, 3e-9])}
    table = {"NI_Number_Of_Scales": 1, "NI_Scale[0]_Scale_Type": "Table"}
    for of, values in {"Pre_Scaled": [-4000.0, -100.0, 3000.0], "Scaled": [-9.0, 0.1, 11.0]}.items():
        table |= {f"NI_Scale[0]_Table_{of}_Values[{i}]": value for i, value in enumerate(values)}
        table[f"NI_Scale[0]_Table_{of}_Values_Size"] = 3
    counts = RNG.integers(-3000, 3000, FORCE.size).astype(np.int16)
    kinds = [
        ("of doubles", FORCE, {}),
        ("of float32", FORCE.astype(np.float32), {}),
        ("of counts with a line", counts, linear),
        ("of counts with a polynomial", counts, polynomial),
        ("of counts with a table", counts, table),
        ("scaled already", FORCE, linear | {"NI_Scaling_Status": "scaled"}),
    ]
    for what, values, properties in kinds:
        path = world.root / "a.tdms"
        with nptdms.TdmsWriter(path) as file:
            # In segments of different lengths, as LabVIEW appends to a file.
            for part in np.split(values, [100, 101, 250]):
                file.write_segment([nptdms.ChannelObject("rig", "F", part, properties | timing), nptdms.ChannelObject("rig", "note", ["a", "bc"])])
        channel = nptdms.TdmsFile.read(path)["rig"]["F"]
        t, force, _ = world.bring(path, time="time_s", force="F")
        bits(f"TDMS {what}: values as npTDMS reads them", force, channel[:])
        same(f"TDMS {what}: times as npTDMS reads them", t, channel.time_track())
    # A stale index: zwidth reads the file.
    path = world.root / "b.tdms"
    with nptdms.TdmsWriter(str(path), index_file=True) as file:
        file.write_segment([nptdms.ChannelObject("rig", "F", FORCE, timing)])
    with nptdms.TdmsWriter(path) as file:
        file.write_segment([nptdms.ChannelObject("rig", "F", -FORCE[:50], timing)])
    _, force, _ = world.bring(path, time="time_s", force="F")
    bits("TDMS with the index of an older file is read by itself", force, -FORCE[:50])


def source_of(world, package):
    """A package's own source, which has recordings that others made."""
    version = importlib.metadata.version(package)
    folder = world.root / f"source of {package}"
    download = ["download", "--quiet", "--disable-pip-version-check", "--no-deps", "--no-binary", package]
    subprocess.run([sys.executable, "-m", "pip", *download, "--dest", folder, f"{package}=={version}"], check=True)
    (packed,) = folder.glob("*.tar.gz")
    with tarfile.open(packed) as archive:
        archive.extractall(folder, filter="data")
    return folder


def tdms_of_labview(world):
    """LabVIEW wrote these, which come with the source of npTDMS: big-endian, interleaved, of three rates, of DAQmx."""
    data = next(source_of(world, "nptdms").glob("*/nptdms/test/data"))
    for name, group, label in [
        ("big_endian", "Measured Data", "Phase sweep"),
        ("raw_timestamps", "Untitled", "Untitled"),
        ("Digital_Input", "07/09/2012 06:58:23 PM - Digital Input - All Data", "Dev1_port3_line7 - line 0"),
    ]:
        path = data / f"{name}.tdms"
        channel = nptdms.TdmsFile.read(path)[group][label]
        t, found, _ = world.bring(path, f"group = {json.dumps(group)}", time="time_s", force=label)
        bits(f"TDMS of LabVIEW, {name}: values as npTDMS reads them", found, channel[:])
        # npTDMS gives no times where no offset is named.
        timed = "wf_start_offset" in channel.properties
        theirs = channel.time_track() if timed else np.arange(len(channel)) * channel.properties["wf_increment"]
        same(f"TDMS of LabVIEW, {name}: times as npTDMS reads them", t, theirs)
    code, said = world.refused(data / "raw1.tdms")
    check("TDMS of LabVIEW with DAQmx is refused with the line that converts it", code == 1 and "as_dataframe(time_index=True)" in said, said)


def lvm(world):
    """Texts as LabVIEW writes them, which lvm_read reads too."""
    end = "***End_of_Header***"
    for x_columns, comma in [("One", False), ("One", True), ("Multi", True), ("No", False)]:
        path = world.root / f"{x_columns}{comma}.lvm"
        number = (lambda value: f"{value:.6f}".replace(".", ",")) if comma else (lambda value: f"{value:.6f}")
        first = ["LabVIEW Measurement", "Writer_Version\t2", "Reader_Version\t2", "Separator\tTab"]
        first += [f"Decimal_Separator\t{',' if comma else '.'}", "Multi_Headings\tNo", f"X_Columns\t{x_columns}", "Time_Pref\tRelative", end, ""]
        second = ["Channels\t2", f"Samples\t{FORCE.size}\t{FORCE.size}", "Y_Unit_Label\tN\tN", "X_Dimension\tTime\tTime"]
        second += [f"X0\t{number(0)}\t{number(0)}", f"Delta_X\t{number(0.002)}\t{number(0.002)}", end]
        names = {"One": "X_Value\tF\tG\tComment", "Multi": "X_Value\tF\tX_Value\tG\tComment", "No": "X_Value\tF\tG\tComment"}[x_columns]
        rows = []
        for i, force in enumerate(FORCE):
            t, f, g = number(0.002 * i), number(force), number(-force)
            rows.append({"One": f"{t}\t{f}\t{g}", "Multi": f"{t}\t{f}\t{t}\t{g}", "No": f"\t{f}\t{g}"}[x_columns])
        path.write_text("\r\n".join([*first, *second, names, *rows]) + "\r\n")
        theirs = lvm_read.read(str(path), read_from_pickle=False, dump_file=False)[0]["data"]
        head = len(first) + len(second)
        keys = f'format = "tsv"\ndecimal = "{"," if comma else "."}"\n'
        where = {"One": (f"skip = {head}", "X_Value", "F", 1), "Multi": (f"skip = {head + 1}\nheader = false", 1, 2, 1), "No": (f"skip = {head}", None, "F", 1)}
        skip, time, force, place = where[x_columns]
        if time is None:
            # A file without times has a rate, which its second head names.
            guessed = run(world.zwidth, "import", "--guess", path)
            check("LVM without times: the guess has its rate", "rate_hz = 500.0" in guessed, guessed)
            continue
        t, found, _ = world.bring(path, keys + skip, time=time, force=force)
        bits(f"LVM with X_Columns {x_columns}, {'comma' if comma else 'point'}: values as lvm_read reads them", found, theirs[:, place])
        bits(f"LVM with X_Columns {x_columns}, {'comma' if comma else 'point'}: times as lvm_read reads them", t, theirs[:, 0])


def points(world):
    """ezc3d and c3d write, and read what zwidth is held against."""
    frames, a_frame = 200, 5
    path = world.root / "a.c3d"
    made = ezc3d.c3d()
    made["parameters"]["POINT"]["RATE"]["value"] = [100.0]
    made["parameters"]["POINT"]["LABELS"]["value"] = ["hand", "elbow"]
    made["parameters"]["POINT"]["UNITS"]["value"] = ["mm"]
    made["parameters"]["ANALOG"]["RATE"]["value"] = [100.0 * a_frame]
    made["parameters"]["ANALOG"]["LABELS"]["value"] = ["Fx", "Fy"]
    made["parameters"]["ANALOG"]["UNITS"]["value"] = ["N", "N"]
    made["data"]["points"] = RNG.normal(0, 100, (4, 2, frames))
    made["data"]["analogs"] = RNG.normal(0, 10, (1, 2, frames * a_frame))
    made.write(str(path))
    read = ezc3d.c3d(str(path))
    t, force, _ = world.bring(path, 'group = "analog"', time="time_s", force="Fy")
    bits("C3D of ezc3d: analog values as ezc3d reads them", force, read["data"]["analogs"][0, 1])
    same("C3D of ezc3d: times at the analog rate", t, np.arange(frames * a_frame) / 500.0)
    with path.open("rb") as file:
        theirs = np.concatenate([analog[1] for *_, analog in c3d.Reader(file).read_frames()])
    same("C3D of ezc3d: analog values as c3d reads them", force, theirs)
    for place, axis in enumerate("xyz"):
        # A recording counts once.
        made["data"]["points"] = RNG.normal(0, 100, (4, 2, frames))
        made.write(str(path))
        read = ezc3d.c3d(str(path))
        _, force, _ = world.bring(path, 'group = "points"', time="time_s", force=f"elbow.{axis}")
        bits(f"C3D of ezc3d: {axis} of a point as ezc3d reads it", force, read["data"]["points"][place, 1])
    # A file of another writer, in whole numbers and more frames than a word counts.
    path = world.root / "b.c3d"
    writer = c3d.Writer(point_rate=1000.0, analog_rate=1000.0, point_scale=-1.0)
    long = 70_000
    values = np.zeros((long, 1, 5), np.float32)
    values[:, 0, 0] = np.arange(long) % 977
    writer.add_frames([(frame, np.zeros((0, 1), np.float32)) for frame in values])
    writer.set_point_labels(["hand"])
    with path.open("wb") as file:
        writer.write(file)
    t, force, _ = world.bring(path, time="time_s", force="hand.x")
    bits("C3D of c3d: more frames than a word counts", force, values[:, 0, 0])
    same("C3D of c3d: their times", t, np.arange(long) / 1000.0)


def bags(world):
    """mcap's writers for ROS 2, with and without packing, and rosbags' bags."""
    stamps = 1_764_500_000_000_000_000 + np.arange(FORCE.size) * 1_000_003
    definition = "\n".join([
        "std_msgs/Header header", "geometry_msgs/Wrench wrench",
        "=" * 80, "MSG: std_msgs/Header", "builtin_interfaces/Time stamp", "string frame_id",
        "=" * 80, "MSG: geometry_msgs/Wrench", "geometry_msgs/Vector3 force", "geometry_msgs/Vector3 torque",
        "=" * 80, "MSG: geometry_msgs/Vector3", "float64 x", "float64 y", "float64 z",
        "=" * 80, "MSG: builtin_interfaces/Time", "int32 sec", "uint32 nanosec",
    ])
    path = world.root / "a.mcap"
    expect = (stamps - stamps[0]) * 1e-9
    for packing in mcap.writer.CompressionType:
        with path.open("wb") as file:
            writer = mcap_ros2.writer.Writer(file, compression=packing, chunk_size=2000)
            schema = writer.register_msgdef("geometry_msgs/msg/WrenchStamped", definition)
            for stamp, force in zip(stamps, FORCE, strict=True):
                stamped = {"sec": int(stamp // 10**9), "nanosec": int(stamp % 10**9)}
                wrench = {"force": {"x": 1.0, "y": force, "z": -force}, "torque": {"x": 0.0, "y": 0.0, "z": 0.0}}
                message = {"header": {"stamp": stamped, "frame_id": "tool"}, "wrench": wrench}
                # Logged late, and not evenly.
                writer.write_message("/force", schema, message, log_time=int(stamp + RNG.integers(0, 10**7)))
            writer.finish()
        t, force, _ = world.bring(path, time="header.stamp", force="wrench.force.y", unit='"ns"\nzero = "first"')
        bits(f"MCAP packed by {packing.name}: values", force, FORCE)
        same(f"MCAP packed by {packing.name}: times by the stamps", t, expect)
    # A second writer, and a second reader of what the first one wrote.
    store = rosbags.typesys.get_typestore(rosbags.typesys.Stores.ROS2_HUMBLE)
    kinds = {name: store.types[f"{name}"] for name in ["geometry_msgs/msg/WrenchStamped", "geometry_msgs/msg/Wrench", "geometry_msgs/msg/Vector3", "std_msgs/msg/Header", "builtin_interfaces/msg/Time"]}
    stamped, wrench, vector, header, time = kinds.values()
    bag = world.root / "bag"
    with rosbags.rosbag2.Writer(bag, version=8) as writer:
        connection = writer.add_connection("/force", stamped.__msgtype__, typestore=store)
        zero = vector(0.0, 0.0, 0.0)
        for stamp, force in zip(stamps, FORCE, strict=True):
            of = header(time(int(stamp // 10**9), int(stamp % 10**9)), "tool")
            message = stamped(of, wrench(vector(1.0, float(force), 0.0), zero))
            writer.write(connection, int(stamp), store.serialize_cdr(message, stamped.__msgtype__))
    path_of_rosbags = world.root / "bag of rosbags"
    with rosbags.rosbag2.Writer(path_of_rosbags, version=8, storage_plugin=rosbags.rosbag2.StoragePlugin.MCAP) as writer:
        connection = writer.add_connection("/force", stamped.__msgtype__, typestore=store)
        for stamp, force in zip(stamps, FORCE, strict=True):
            of = header(time(int(stamp // 10**9), int(stamp % 10**9)), "tool")
            message = stamped(of, wrench(vector(1.0, float(-force), 0.0), zero))
            writer.write(connection, int(stamp), store.serialize_cdr(message, stamped.__msgtype__))
    (written,) = path_of_rosbags.glob("*.mcap")
    t, force, _ = world.bring(written, time="header.stamp", force="wrench.force.y", unit='"ns"\nzero = "first"')
    with rosbags.highlevel.AnyReader([path_of_rosbags], default_typestore=store) as reader:
        theirs = [reader.deserialize(raw, one.msgtype).wrench.force.y for one, _, raw in reader.messages()]
    bits("MCAP of rosbags: values as rosbags reads them", force, theirs)
    same("MCAP of rosbags: times", t, expect)
    # The line that converts a bag of the older form.
    (older,) = bag.glob("*.db3")
    code, said = world.refused(older)
    line = said[said.find("rosbags-convert") :].splitlines()[0] if "rosbags-convert" in said else ""
    check("a bag in SQLite is refused with the line that converts it", code == 1 and line != "", said)
    if line:
        given = line.replace("FOLDER", str(bag)).replace("OUT", str(world.root / "converted"))
        program = Path(sys.executable).parent
        subprocess.run([program / given.split()[0], *given.split()[1:]], check=True)
        (converted,) = (world.root / "converted").glob("*.mcap")
        t, force, _ = world.bring(converted, time="header.stamp", force="wrench.force.y", unit='"ns"\nzero = "first"')
        bits("a bag in SQLite, converted by that line: values", force, FORCE)
        same("a bag in SQLite, converted by that line: times", t, expect)
    guessed = run(world.zwidth, "import", "--guess", path)
    check("the guess takes the stamp for the time, not when it was logged", 'from = "header.stamp"' in guessed, guessed)
    check("the guess names the force by its path", json.dumps("wrench.force.y") in guessed, guessed)


def tables(world):
    """mat-io writes tables and timetables as MATLAB has them, and reads what zwidth is held against."""
    t = np.arange(FORCE.size) * 0.004
    # A timetable counts in ms, as whole numbers or not.
    times = pd.Index(pd.to_timedelta(np.arange(FORCE.size) * 4, unit="ms"), name="Time")
    path = world.root / "tables.mat"
    frame = pd.DataFrame({"t": t, "who": "P01", "F": FORCE, "count": np.arange(FORCE.size, dtype=np.int16)})
    matio.save_to_mat(str(path), {"rig": frame, "log": pd.DataFrame({"F": -FORCE}, index=times)}, version="v7")
    read = matio.load_from_mat(str(path))
    found, force, _ = world.bring(path, time="rig.t", force="rig.F")
    bits("a table of MATLAB: values as mat-io reads them", force, read["rig"]["F"])
    bits("a table of MATLAB: times as mat-io reads them", found, read["rig"]["t"])
    matio.save_to_mat(str(path), {"log": pd.DataFrame({"F": -FORCE}, index=times), "x": 1.0}, version="v7")
    found, force, _ = world.bring(path, 'matrix = "log"', time="Time", force="F", unit='"ms"')
    read = matio.load_from_mat(str(path))["log"]
    bits("a timetable of MATLAB: values as mat-io reads them", force, read["F"])
    same("a timetable of MATLAB: times as mat-io reads them", found, read.index.total_seconds())


def motions(world):
    """OpenSim writes both of its forms: tables to the last digit, and storages of eight decimals."""
    table = opensim.TimeSeriesTable()
    table.setColumnLabels(["elbow", "force_y"])
    for i, force in enumerate(FORCE):
        table.appendRow(0.01 * i, opensim.RowVector([float(np.cos(i)), float(force)]))
    table.addTableMetaDataString("inDegrees", "no")
    path = world.root / "a.sto"
    opensim.STOFileAdapter.write(table, str(path))
    read = opensim.TimeSeriesTable(str(path))
    t, force, _ = world.bring(path, time="time", force="force_y")
    bits("OpenSim's table: values as OpenSim reads them", force, read.getDependentColumn("force_y").to_numpy())
    bits("OpenSim's table: times as OpenSim reads them", t, read.getIndependentColumn())
    storage = opensim.Storage(str(path))
    # A recording counts once.
    storage.multiplyColumn(1, -2.0)
    opensim.Storage.printResult(storage, "b", str(world.root), -1, ".mot")
    path = world.root / "b.mot"
    read = opensim.TimeSeriesTable(str(path))
    t, force, _ = world.bring(path, time="time", force="force_y")
    bits("OpenSim's storage: values as OpenSim reads them", force, read.getDependentColumn("force_y").to_numpy())
    bits("OpenSim's storage: times as OpenSim reads them", t, read.getIndependentColumn())


def converted(world):
    """asammdf writes channels of two rates, and the line that is printed keeps each at its own."""
    path = world.root / "a.mf4"
    measured = asammdf.MDF()
    slow, fast = np.arange(40) * 0.1, np.arange(FORCE.size) * 0.01
    measured.append([asammdf.Signal(np.sin(slow), slow, name="angle", unit="rad")])
    measured.append([asammdf.Signal(FORCE, fast, name="F", unit="N")])
    path = measured.save(path)
    archive = world.convert("an MF4 file", path, "npz")
    with np.load(archive) as arrays:
        force = next(name for name in arrays if name.startswith("F_"))
        times = force.replace("F_", "t_s_")
    t, found, _ = world.bring(archive, time=times, force=force)
    bits("an MF4 file, converted by its line: values", found, FORCE)
    bits("an MF4 file, converted by its line: times", t, fast)
    # Files that AcqKnowledge wrote come with the source of bioread.
    data = next(source_of(world, "bioread").glob("*/test/data/physio"))
    for name in ["physio-3.8.1", "physio-4.4.0-c", "physio-5.0.1"]:
        path = data / f"{name}.acq"
        channel = bioread.read(str(path)).channels[0]
        archive = world.convert(f"AcqKnowledge's {name}", path, "npz")
        t, found, _ = world.bring(archive, time="t_s_1", force=f"{channel.name}_1")
        bits(f"AcqKnowledge's {name}, converted by its line: values", found, channel.data)
        # A sample after the other at the channel's rate; its own time_index is longer by one sample.
        same(f"AcqKnowledge's {name}, converted by its line: times", t, np.arange(channel.point_count) / channel.samples_per_second)
