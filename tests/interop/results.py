"""Tables and figures of a study, read by others: CSV against Parquet, the text of the PDFs, PDF against PNG."""

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pypdfium2 as pdfium
from PIL import Image
from pypdf import PdfReader

from checks import check, equal

MARK = "SYNTHETIC: simulated, not measured"
DPI = 200
# Blocks of so many pixels are compared, which two ways to smooth an edge do not change, ...
BLOCK = 4
# ... by so much of 255: pdfium draws bold letters a little darker, by up to 80. One block in 5,000 may differ more; where a
# figure is shifted by three pixels, 100 in 5,000 do.
FAR = 96


def tables(label, folder):
    """A table's CSV holds the numbers of its Parquet file, bit for bit; every column has unit and description."""
    files = sorted(folder.glob("*.parquet"))
    check(f"{label}: there are tables", bool(files), folder)
    for file in files:
        frame = pd.read_parquet(file)
        text = pd.read_csv(file.with_suffix(".csv"), float_precision="round_trip")
        # CSV has no notes: what was simulated says so in a last column.
        noted = b"SYNTHETIC" in (pq.read_metadata(file).metadata or {}).get(b"table_notes", b"")
        marked = list(text.columns[-1:]) == ["synthetic"] and bool(text["synthetic"].all())
        check(f"{label}: {file.stem}.csv is marked as simulated where the .parquet is", marked == noted, f"{marked}, {noted}")
        text = text.drop(columns="synthetic", errors="ignore")
        same = list(frame.columns) == list(text.columns) and all(alike(frame[c], text[c]) for c in frame.columns)
        check(f"{label}: {file.stem}.csv and .parquet hold the same", same, frame.columns)
        silent = [f.name for f in pq.read_schema(file) if not {b"unit", b"description"} <= set(f.metadata or {})]
        equal(f"{label}: columns of {file.stem}.parquet without unit or description", silent, [])


def alike(a, b):
    """Whether two columns are equal; an empty cell is null, whatever the type."""
    if pd.api.types.is_float_dtype(a):
        return np.array_equal(a.to_numpy(float), b.to_numpy(float), equal_nan=True)
    return a.astype("string").fillna("").tolist() == words(b, a)


def words(column, like):
    """A CSV column as the words of its Parquet counterpart; counts with gaps were read as floats."""
    if pd.api.types.is_numeric_dtype(like) and not pd.api.types.is_bool_dtype(like):
        column = column.astype("Int64")
    return column.astype("string").fillna("").tolist()


def figures(label, folder, synthetic):
    """Every PDF shows what the PNG shows, has text, and the mark of simulated data exactly where the study is simulated."""
    files = sorted(folder.glob("*.pdf"))
    check(f"{label}: there are figures", bool(files), folder)
    for file in files:
        text = " ".join(" ".join(page.extract_text() for page in PdfReader(file).pages).split())
        check(f"{label}: {file.name} has text", len(text) > 100, text)
        # Environments and schematics are drawn from the plan, not from data; trades of solvers and scenes are model runs, and say so.
        of_data = not file.name.startswith(("environment.", "schematic.", "scenes.", "trade."))
        marked = synthetic and of_data
        what = "bears the mark of simulated data" if marked else "bears no mark of simulated data"
        equal(f"{label}: {file.name} {what}", MARK in text, marked)
        far = apart(file)
        check(f"{label}: {file.name} looks like its PNG", far < 1 / 5000, far)


def apart(pdf):
    """The share of a figure's blocks in which pdfium's drawing of the PDF is far from the PNG."""
    image = np.asarray(Image.open(pdf.with_suffix(".png")).convert("RGB"), float)
    page = pdfium.PdfDocument(pdf)[0].render(scale=DPI / 72).to_numpy()[:, :, ::-1].astype(float)
    height, width = (min(a, b) // BLOCK * BLOCK for a, b in zip(image.shape[:2], page.shape[:2]))
    means = [a[:height, :width].reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, 3).mean((1, 3))
             for a in (image, page)]
    return (abs(means[0] - means[1]).max(2) > FAR).mean()
