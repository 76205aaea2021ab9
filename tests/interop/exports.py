"""What leaves by `zwidth export`, by programs that others wrote: every form passes its validator, holds the study's own numbers to
the last bit, and an export with other names for people has nothing of theirs in any byte.

    python exports.py --zwidth PROGRAM --root FOLDER --tools FOLDER --out FOLDER

`--root` has raw/thesis-twin and its results. `--tools` has a virtual environment for each validator (they ask for other versions
of the same packages), and node_modules with @mcap/core and ro-crate.
"""

import argparse
import getpass
import json
import os
import shutil
import socket
import struct
import subprocess
import zipfile
from pathlib import Path

import numpy as np
import openpyxl
import pandas as pd
import pyarrow.parquet as pq
import scipy.io
from mcap.reader import make_reader

from checks import check, end, equal

STUDY = "thesis-twin"
FORMS = "bids,mcap,mat,samples-csv,xlsx"
KEYS = ["participant", "session", "trial"]
# Tables that leave as they are, and where the study has them.
TABLES = {"metrics": "metrics", "answers": "answers", "means": "compare/means", "contrasts": "compare/contrasts",
          "compared": "compare/compared"}
HERE = Path(__file__).parent


def run(*command, **more):
    """What a program said, and how it ended."""
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, **more)
    return done.returncode, done.stdout + done.stderr


def passes(what, *command, **more):
    """A program must end well."""
    code, said = run(*command, **more)
    check(what, code == 0, said[-3000:])
    return said


def same(a, b):
    """Whether two columns hold the same bits; a missing number is NaN here."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    return a.shape == b.shape and np.array_equal(np.isnan(a), np.isnan(b)) and np.array_equal(a.view("u8")[~np.isnan(a)],
                                                                                             b.view("u8")[~np.isnan(b)])


def recorded(root):
    """The trials that count, by participant, session and number, with their samples as the study has them."""
    trials = pd.read_parquet(root / "derived" / STUDY / "trials.parquet")
    trials = trials[trials.counts]
    return {(t.participant, t.session, t.trial): pd.read_parquet(root / t.path) for t in trials.itertuples()}


def columns(samples):
    """The columns of samples that a trial has."""
    keys = {"trial", "repeat", "kind", "status", "environment", "mode", "likert", "interval", "level", "task"}
    return [name for name in samples.columns if name not in keys and samples[name].notna().any()]


def tables(root, out):
    """Every table is the study's own, in CSV, Parquet and the workbook."""
    sheets = openpyxl.load_workbook(out / "tables.xlsx", read_only=True)
    for name, place in TABLES.items():
        own = pd.read_parquet(root / "derived" / STUDY / f"{place}.parquet")
        if "counts" in own:
            own = own[own.counts].drop(columns=["counts", "why_not"]).reset_index(drop=True)
        parquet = pd.read_parquet(out / f"tables/{name}.parquet")
        text = pd.read_csv(out / f"tables/{name}.csv")
        equal(f"{name}: the rows", [len(parquet), len(text)], [len(own)] * 2)
        for frame, form in [(parquet, "Parquet"), (text, "CSV")]:
            numbers = [c for c in own.select_dtypes("number") if not same(own[c], frame[c])]
            equal(f"{name}: columns of other numbers in {form}", numbers, [])
            words = [c for c in own.columns if own[c].dtype not in (float, int) and c not in own.select_dtypes("number")
                     and own[c].astype("string").fillna("").tolist() != frame[c].astype("string").fillna("").tolist()]
            equal(f"{name}: columns of other words in {form}", words, [])
            equal(f"{name}: sources in {form}", set(frame["source"]), {"twin"})
        rows = list(sheets[name].iter_rows(min_row=3, values_only=True))
        place = {name: at for at, name in enumerate(rows[0])}
        for number in own.select_dtypes("number"):
            found = [np.nan if row[place[number]] is None else row[place[number]] for row in rows[1:len(own) + 1]]
            check(f"{name}: {number} in the workbook", same(found, own[number]))


def samples(trials, out):
    """All samples are the study's own, in Parquet and CSV."""
    file = pq.ParquetFile(out / "samples.parquet")
    equal("samples.parquet: a row group for each trial", file.num_row_groups, len(trials))
    silent = [f.name for f in file.schema_arrow if not {b"unit", b"description"} <= set(f.metadata or {})]
    equal("samples.parquet: columns without unit or description", silent, [])
    forms = {"Parquet": pd.read_parquet(out / "samples.parquet"),
             "CSV": pd.read_csv(out / "samples.csv")}
    for form, frame in forms.items():
        found = {key: group for key, group in frame.groupby(KEYS, sort=False)}
        equal(f"samples in {form}: the trials", sorted(found), sorted(trials))
        wrong = [(key, c) for key, own in trials.items() for c in columns(own) if not same(own[c], found[key][c])]
        equal(f"samples in {form}: trials and columns with other numbers", wrong, [])
        equal(f"samples in {form}: sources", set(frame["source"]), {"twin"})


def of_path(path):
    """Participant, session and trial of a path."""
    parts = {k: v for k, _, v in (part.partition("=") for part in path.parts)}
    return parts["participant"], parts["session"], int(path.stem.split("_")[0].removeprefix("trial-"))


def mcap(trials, out, tools):
    """Python's reader and npm's find every sample, checksums included."""
    files = sorted((out / "mcap").rglob("*.mcap"))
    equal("mcap: the trials", sorted(map(of_path, files)), sorted(trials))
    for file in files:
        own = trials[of_path(file)]
        with open(file, "rb") as stream:
            reader = make_reader(stream, validate_crcs=True)
            equal(f"{file.name}: messages by the summary", reader.get_summary().statistics.message_count, len(own))
            messages = list(reader.iter_messages())
            said = {record.name: record.metadata for record in reader.iter_metadata()}
        frame = pd.DataFrame([json.loads(message.data) for _, _, message in messages])
        wrong = [c for c in columns(own) if not same(own[c], frame[c])]
        equal(f"{file.name}: columns with other numbers", wrong, [])
        equal(f"{file.name}: its columns", sorted(frame), sorted(columns(own)))
        schema = json.loads(messages[0][0].data)["properties"]
        equal(f"{file.name}: the unit of an angle", schema["theta_rad"]["description"], "rad")
        check(f"{file.name}: its mark", "SYNTHETIC" in said["trial"]["mark"])
    said = passes("mcap: npm's reader", "node", HERE / "exports_mcap.mjs", *files, env=os.environ | {"TOOLS": str(tools)})
    equal("mcap: samples by npm's reader", int(said), sum(map(len, trials.values())))


def mat(trials, root, out):
    """SciPy and Octave read the same bits, names of columns of any length, and units."""
    files = sorted((out / "mat").rglob("trial-*.mat"))
    equal("mat: the trials", sorted(map(of_path, files)), sorted(trials))
    for file in files:
        own = trials[of_path(file)]
        found = scipy.io.loadmat(file, squeeze_me=True)
        wrong = [c for c in columns(own) if not same(own[c], found[c])]
        equal(f"{file.name}: columns with other numbers", wrong, [])
        equal(f"{file.name}: the source", str(found["about"]["source"]), "twin")
    metrics = pd.read_parquet(root / "derived" / STUDY / "metrics.parquet")
    found = scipy.io.loadmat(out / "mat/tables.mat", squeeze_me=True, struct_as_record=False)["metrics"]
    wrong = [c for c in metrics.select_dtypes("float") if not same(metrics[c], getattr(found, c))]
    equal("mat: metrics with other numbers", wrong, [])
    check("mat: there are names of more than 31 letters", max(map(len, found._fieldnames)) > 31)
    if not shutil.which("octave-cli"):
        check("mat: Octave is there", False, "install octave")
        return
    script = f"s = load('{files[0]}'); t = load('{out}/mat/tables.mat'); " \
        "disp(num2hex(s.theta_rad)); disp(s.units.theta_dot_rad_s); disp(numel(fieldnames(t.metrics)))"
    code, said = run("octave-cli", "--no-gui", "--quiet", "--eval", script)
    lines = said.split()
    own = trials[of_path(files[0])]
    bits = [struct.pack(">d", value).hex() for value in own["theta_rad"]]
    equal("mat: angles in Octave, to the last bit", lines[:len(bits)], bits)
    equal("mat: unit and metrics in Octave", lines[len(bits):len(bits) + 2], ["rad/s", str(len(metrics.columns))])


def bids(trials, out, tools):
    """The validator finds no error, and each file holds the samples."""
    code, said = run(tools / "bids/bin/bids-validator-deno", out / "bids", "--format", "json")
    found = json.loads(said[said.index("{"):said.rindex("}") + 1])
    errors = [issue for issue in found["issues"]["issues"] if issue["severity"] == "error"]
    equal("bids: errors of the validator", errors, [])
    equal("bids: how the validator ends", code, 0)
    files = sorted((out / "bids").rglob("*_motion.tsv"))
    equal("bids: the trials", len(files), len(trials))
    for file in files:
        about = json.loads(file.with_suffix(".json").read_text())["Zwidth"]
        own = trials[about["participant"], about["session"], int(about["trial"])]
        channels = pd.read_csv(str(file).replace("_motion.tsv", "_channels.tsv"), sep="\t", keep_default_na=False)
        frame = pd.read_csv(file, sep="\t", header=None, names=list(channels["name"]))
        wrong = [c for c in columns(own) if not same(own[c], frame[c])]
        equal(f"{file.name}: columns with other numbers", wrong, [])


def documents(out, tools):
    """Data Package, RO-Crate and citation pass; R reads the tables."""
    said = passes("datapackage.json: frictionless", tools / "frictionless/bin/frictionless", "validate", "--json", out / "datapackage.json")
    check("datapackage.json: is valid", json.loads(said)["valid"], said[-2000:])
    cache = tools / "roc-cache"
    passes("the context of RO-Crate in the cache", tools / "crate/bin/python", HERE / "crate_cache.py",
           tools / "node_modules/ro-crate/lib/context.json", cache)
    passes("ro-crate-metadata.json: roc-validator", tools / "crate/bin/rocrate-validator", "-y", "validate", "--offline",
           "--cache-path", cache, "--no-paging", "-v", out)
    passes("CITATION.cff: cffconvert", tools / "cff/bin/cffconvert", "--validate", "-i", out / "CITATION.cff")
    passes("SHA256SUMS", "sha256sum", "--check", "--quiet", "--strict", "SHA256SUMS", cwd=out)
    metrics = pd.read_csv(out / "tables/metrics.csv")
    script = "t <- read.csv('tables/metrics.csv'); cat(nrow(t), ncol(t), sprintf('%.15g', sum(t$theta_max_rad)))"
    said = passes("tables in R", "Rscript", "-e", script, cwd=out).split()
    equal("rows and columns in R", said[:2], [str(n) for n in metrics.shape])
    check("a sum in R", abs(float(said[2]) - metrics["theta_max_rad"].sum()) < 1e-12, said)


def texts(path):
    """Every text in a file: its bytes, and what is packed in it."""
    yield path.read_bytes()
    if path.suffix == ".parquet":
        yield pd.read_parquet(path).to_csv().encode()
        file = pq.ParquetFile(path)
        yield repr(file.metadata.metadata).encode() + str(file.schema_arrow).encode()
    if zipfile.is_zipfile(path):
        with zipfile.ZipFile(path) as packed:
            yield from (packed.read(name) for name in packed.namelist())


def hidden(root, out, key):
    """Nothing in an export with other names for people says who they are, when and where they came, and from which file."""
    own = [line.split(",")[0] for line in key.read_text().split()[1:]]
    log = [json.loads(line) for path in (root / "raw" / STUDY / "sessions").glob("*.jsonl") for line in path.read_text().splitlines()]
    trials = pd.read_parquet(root / "derived" / STUDY / "trials.parquet")
    words = {f"participant={code}" for code in own} | {f"sub-{code}" for code in own} | {f",{code}," for code in own}
    words |= {f'"{code}"' for code in own} | {f">{code}<" for code in own} | {f"\n{code}," for code in own}
    words |= set(trials["path"]) | {str(Path.home()), str(root.resolve()), f"{getpass.getuser()}@"}
    # A name of two letters is in any file.
    words |= {name for name in [socket.gethostname()] if len(name) > 4}
    # Clock times and hashes of what was recorded, wherever an event has one.
    words |= {value for line in log for value in flat(line) if isinstance(value, str) and (len(value) >= 32 or value[4:5] == "-")}
    words |= {"zwidth:metrics:", "zwidth:compare:", ".parquet: "}
    found = []
    for path in sorted(out.rglob("*")):
        found += [(str(path), word) for word in words if word in str(path.relative_to(out))]
        if path.is_file():
            found += [(path.name, word) for text in texts(path) for word in words if word.encode() in text]
    equal("a renamed export: words that must not be in it", found, [])
    check("a renamed export: what was looked for", len(words) > 60, len(words))


def flat(value):
    """The values in a JSON value."""
    if isinstance(value, dict):
        return [inner for part in value.values() for inner in flat(part)]
    if isinstance(value, list):
        return [inner for part in value for inner in flat(part)]
    return [value]


def main():
    parser = argparse.ArgumentParser()
    for name in ["zwidth", "root", "tools", "out"]:
        parser.add_argument(f"--{name}", type=Path, required=True)
    given = parser.parse_args()
    zwidth, root, tools, out = (getattr(given, name).resolve() for name in ["zwidth", "root", "tools", "out"])
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    whole, renamed, key = out / "whole", out / "renamed", out / "key.csv"
    for to, more in [(whole, ["--licence", "CC-BY-4.0"]), (renamed, ["--rename", "--key", key])]:
        passes(f"zwidth export --to {to.name}", zwidth, "--root", root, "export", STUDY, "--to", to, "--with", FORMS, *more)
    trials = recorded(root)
    tables(root, whole)
    samples(trials, whole)
    mcap(trials, whole, tools)
    mat(trials, root, whole)
    bids(trials, whole, tools)
    documents(whole, tools)
    documents(renamed, tools)
    hidden(root, renamed, key)
    end()


if __name__ == "__main__":
    main()
