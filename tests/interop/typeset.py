"""Do tables and captions compile with the real LaTeX and Typst, and fit their pages?

    python typeset.py --zwidth PROGRAM --root FOLDER [--engine pdflatex] [--keep FOLDER]

FOLDER holds raw/thesis-twin and reports/ after `zwidth run thesis-twin`. All tables are set in one document a size
of page: every error, overfull box, missing glyph and reference to nowhere that the compilers tell counts, and so do
glyphs that stand outside of the text block or on top of each other in the PDF. --keep leaves the documents there, with
every page as an image. The tables' own first line says what a document must load; these load no more.

The captions of all figures are set as captions of figures, by their names. Then a second study is simulated whose every text holds
what LaTeX, Typst, TOML and browsers take for their own: its tables and captions must compile, and show these texts as text.
"""

import argparse
import os
import re
import shutil
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import checks
import hostile
import numpy as np
import pypdfium2 as pdfium
import typst

STUDY = "thesis-twin"
# How far a box of TeX may stick out unseen, pt: \hfuzz as TeX has it.
HFUZZ = 0.1
# How far a glyph may: side bearings, and what a reader of PDFs rounds, pt.
BEARING = 1.0
# Share of the smaller of two glyphs that may lie on the other: accents and kerned italics touch.
TOUCH = 0.2
# Signs that no font of Typst's has, of several kinds: what they look like is what a missing one looks like.
NO_SIGNS = "\U0010fffd中ก"
# Passes until longtable and the references have settled.
PASSES = 3

# LaTeX: options of `article` and what else the document loads. The text block is 345, 360 and 390 pt wide; at last two
# columns of 252 pt, as journals of engineering have them.
COLUMNS = "10pt,twocolumn"
ARTICLES = {"10pt": "", "11pt": r"\usepackage{hyperref}", "12pt": r"\usepackage{caption}", COLUMNS: r"\usepackage[textwidth=516pt,columnsep=12pt]{geometry}"}
# Typst: its own page, and LaTeX's narrowest. Margins in pt.
PAGES = {"a4": ("", 70.87), "345pt": ('#set page(paper: "a4", margin: 125.14pt)\n#set text(10pt)\n', 125.14)}


def latex_document(size, more, files):
    tables = "\n".join(rf"\input{{{file}}}\clearpage" for file in files)
    labels = [re.search(r"\\label\{(.*?)\}", file.read_text()).group(1) for file in files]
    references = ", ".join(rf"\ref{{{label}}}" for label in labels)
    return rf"""\documentclass[{size}]{{article}}
\usepackage[T1]{{fontenc}}
\usepackage{{lmodern}}
\usepackage{{booktabs,longtable,siunitx}}
{more}
\begin{{document}}
\typeout{{block \the\dimexpr1in+\oddsidemargin\relax\space\the\textwidth}}
\listoftables
Tables {references}.
\clearpage
{tables}
\end{{document}}
"""


def compile_latex(engine, size, files, folder):
    """Writes the document and compiles it; the exit code."""
    name = f"latex-{size}"
    (folder / f"{name}.tex").write_text(latex_document(size, ARTICLES[size], files))
    command = [engine, "-interaction=nonstopmode", "-halt-on-error", f"{name}.tex"]
    wide = {**os.environ, "max_print_line": "10000"}
    for _ in range(PASSES):
        done = subprocess.run(command, cwd=folder, env=wide, capture_output=True, check=False)
    return done.returncode


def judge_latex(engine, size, code, files, folder):
    """What the compiler said, and what its PDF looks like."""
    name, what = f"latex-{size}", f"{engine}, article at {size}"
    log = (folder / f"{name}.log").read_text(errors="replace")
    told = [line for line in log.splitlines() if line.startswith("!")]
    checks.check(f"{what}: {len(files)} tables compile", code == 0, told[:3])
    overfull = [float(pt) for pt in re.findall(r"^Overfull \\[hv]box \((.*?)pt", log, re.MULTILINE)]
    checks.check(f"{what}: no box is overfull by more than {HFUZZ} pt", not [pt for pt in overfull if pt > HFUZZ], overfull)
    for complaint in ["Missing character", "Float too large", "undefined", "have changed", "multiply defined"]:
        lines = [line for line in log.splitlines() if complaint in line]
        checks.check(f"{what}: nothing of '{complaint}'", not lines, lines[:3])
    if code == 0:
        left, width = map(float, re.search(r"^block (.*?)pt (.*?)pt$", log, re.MULTILINE).groups())
        look(what, folder / f"{name}.pdf", left * 72 / 72.27, (left + width) * 72 / 72.27)
        text = read(folder / f"{name}.pdf")
        checks.check(f"{what}: no sign stands as its number", "[U+" not in text, re.findall(r"\[U\+.*?\]", text)[:3])
        words(what, text, files)


def typeset_typst(page, start, margin, files, folder):
    """Compiles the document with Typst."""
    what = f"Typst, {page}"
    document = folder / f"typst-{page}.typ"
    names = [file.stem.replace(".", "-").replace("_", "-") for file in files]
    tables = "\n".join(f'#include "{os.path.relpath(file, folder)}"\n#pagebreak(weak: true)' for file in files)
    references = ", ".join(f"@tab:{name}" for name in names)
    document.write_text(f"{start}#outline(target: figure.where(kind: table))\n{references}\n#pagebreak()\n{tables}\n")
    try:
        pdf, warnings = typst.compile_with_warnings(str(document), root="/", ignore_system_fonts=True)
    except typst.TypstError as error:
        checks.check(f"{what}: {len(files)} tables compile", False, error)
        return
    checks.check(f"{what}: {len(files)} tables compile without a warning", not warnings, [str(w) for w in warnings])
    document.with_suffix(".pdf").write_bytes(pdf)
    look(what, document.with_suffix(".pdf"), margin, 595.28 - margin)
    words(what, read(document.with_suffix(".pdf")), files)


def captions_latex(engine, what, figures, folder, names):
    """A document with a figure for each caption, by LaTeX."""
    one = lambda name: rf"\begin{{figure}}[p]\centering\rule{{1cm}}{{1cm}}\caption[\zwidthtitle{{{name}}}]{{\zwidthcaption{{{name}}}}}\end{{figure}}\clearpage"
    document = folder / f"latex-captions-{what.replace(' ', '-')}.tex"
    document.write_text("\n".join([
        r"\documentclass{article}\usepackage[T1]{fontenc}\usepackage{lmodern}", rf"\input{{{figures / 'captions'}}}", r"\begin{document}",
        r"\typeout{block \the\dimexpr1in+\oddsidemargin\relax\space\the\textwidth}", r"\listoffigures\clearpage", *map(one, names), r"\end{document}"]))
    command = [engine, "-interaction=nonstopmode", "-halt-on-error", document.name]
    wide = {**os.environ, "max_print_line": "10000"}
    for _ in range(2):
        code = subprocess.run(command, cwd=folder, env=wide, capture_output=True, check=False).returncode
    log = document.with_suffix(".log").read_text(errors="replace")
    told = [line for line in log.splitlines() if line.startswith("!") or "Missing character" in line or "undefined" in line]
    checks.check(f"{engine}: {len(names)} captions of {what} compile without a complaint", code == 0 and not told, told[:3])
    return document.with_suffix(".pdf") if code == 0 else None


def captions_typst(what, figures, folder, names):
    """The same by Typst."""
    document = folder / f"typst-captions-{what.replace(' ', '-')}.typ"
    document.write_text(f"""#import "{os.path.relpath(figures / 'captions.typ', folder)}": captions, titles
#set page(paper: "a4")
#outline(target: figure.where(kind: image))
#for name in captions.keys() [
  #pagebreak()
  #figure(rect(width: 1cm, height: 1cm), kind: image, supplement: [Figure], caption: captions.at(name))
  #titles.at(name)
]
""")
    try:
        pdf, warnings = typst.compile_with_warnings(str(document), root="/", ignore_system_fonts=True)
    except typst.TypstError as error:
        checks.check(f"Typst: {len(names)} captions of {what} compile", False, error)
        return None
    checks.check(f"Typst: {len(names)} captions of {what} compile without a warning", not warnings, [str(w) for w in warnings][:3])
    document.with_suffix(".pdf").write_bytes(pdf)
    return document.with_suffix(".pdf")


def captions(engine, what, reports, folder):
    """Every caption of a study's figures, by both; every word of them is in the document."""
    figures = (reports / "figures").resolve()
    names = sorted(file.stem for file in figures.glob("*.svg"))
    defined = re.findall(r"@namedef\{zwidth@caption@(.*?)\}", (figures / "captions.tex").read_text())
    checks.equal(f"{what}: each figure has its caption by name", sorted(defined), names)
    for maker, pdf in (("LaTeX", captions_latex(engine, what, figures, folder, names)), ("Typst", captions_typst(what, figures, folder, names))):
        # Of hostile texts LaTeX sets words over the edge of its page, where none is read.
        if pdf is None or (maker == "LaTeX" and what != STUDY):
            continue
        there, lost = squeezed(read(pdf)), []
        for name in names:
            text = (figures / f"{name}.txt").read_text().split("zwidth:")[0]
            lost += [f"{name}: {word}" for word in re.findall(r"[A-Za-z]{3,}|[0-9]+\.[0-9]{2,}", text) if word not in there]
        checks.check(f"{maker}: every word of the captions of {what} is there", not lost, lost[:5])


def glyphs_of_typst(files):
    """Every sign of the tables has a glyph in the fonts that Typst brings along."""
    signs = sorted({sign for file in files for sign in file.read_text() if ord(sign) > 126})
    missing = {picture(sign) for sign in NO_SIGNS}
    lost = [f"U+{ord(sign):04X}" for sign in signs if picture(sign) in missing]
    checks.check(f"Typst: each of {len(signs)} signs beyond ASCII has a glyph", not lost, lost)


def picture(sign):
    source = f"#set page(width: 30pt, height: 30pt, margin: 8pt)\n#set text(cjk-latin-spacing: none)\no{sign}"
    return typst.compile(source.encode(), format="png", ignore_system_fonts=True)


def read(file):
    """The text of a PDF."""
    document = pdfium.PdfDocument(file)
    return "\n".join(page.get_textpage().get_text_bounded() for page in document)


def look(what, file, left, right):
    """No glyph outside of the text block, none on top of another."""
    pages, outside, over = 0, [], []
    for number, page in enumerate(pdfium.PdfDocument(file), 1):
        text = page.get_textpage()
        signs = [chr(pdfium.raw.FPDFText_GetUnicode(text, i)) for i in range(text.count_chars())]
        shown = [i for i, sign in enumerate(signs) if sign.strip("\0\r\n\t \xa0")]
        signs, boxes = [signs[i] for i in shown], np.array([text.get_charbox(i) for i in shown]).reshape(-1, 4)
        pages += 1
        beyond = (boxes[:, 0] < left - BEARING) | (boxes[:, 2] > right + BEARING) | (boxes[:, 1] < 0)
        outside += [f"page {number}: {''.join(np.array(signs)[beyond])}"] if beyond.any() else []
        over += [f"page {number}: {signs[i]}{signs[j]}" for i, j in overlapping(boxes)]
    checks.check(f"{what}: nothing stands outside of the text block of {pages} pages", not outside, outside[:5])
    checks.check(f"{what}: no glyph stands on another", not over, over[:5])


def overlapping(boxes):
    """Pairs of boxes (left, bottom, right, top) that lie on each other; letters of one ligature have one box."""
    order = np.argsort(boxes[:, 1])
    left, bottom, right, top = boxes[order].T
    # Those that begin, upwards, before a box ends: only they can lie on it.
    until = np.searchsorted(bottom, top)
    number = np.maximum(until - np.arange(len(order)) - 1, 0)
    a = np.repeat(np.arange(len(order)), number)
    b = a + 1 + np.arange(len(a)) - np.repeat(np.cumsum(number) - number, number)
    wide = np.minimum(right[a], right[b]) - np.maximum(left[a], left[b])
    high = np.minimum(top[a], top[b]) - np.maximum(bottom[a], bottom[b])
    area = (right - left) * (top - bottom)
    on = np.clip(wide, 0, None) * np.clip(high, 0, None) > TOUCH * np.minimum(area[a], area[b])
    pairs = np.sort(np.stack([order[a[on]], order[b[on]]], axis=1))
    return [(i, j) for i, j in pairs if j != i + 1 or (boxes[i] != boxes[j]).any()]


def words(what, text, files):
    """Every word and every long number of the tables, as their Markdown has them, is in the PDF."""
    there = squeezed(text)
    lost = []
    for file in files:
        rows = [line for line in file.with_suffix(".md").read_text().splitlines() if line.startswith("| ")]
        cells = [cell for row in rows for cell in re.findall(r"[A-Za-z]{3,}|[0-9]+\.[0-9]{2,}", row)]
        lost += [f"{file.stem}: {cell}" for cell in dict.fromkeys(cells) if cell not in there]
    checks.check(f"{what}: every word and number of the tables is there", not lost, lost[:5])


def squeezed(text):
    return re.sub(r"[\s\x02\u00ad\u2010\ufffe-]", "", text)


def same_by_command(zwidth, root, files):
    """`zwidth table` prints what `zwidth run` wrote, but for the last line, which says what the file was made from."""
    listed = checks.run(zwidth, "--root", root, "table", STUDY).splitlines()
    names = [line.split()[0] for line in listed]
    checks.equal(f"zwidth table lists {len(files)} tables", sorted(names), sorted(file.stem for file in files))
    for form in ["tex", "typ"]:
        printed = {n: checks.run(zwidth, "--root", root, "table", STUDY, n, "--format", form).strip() for n in names}
        written = {n: (files[0].parent / f"{n}.{form}").read_text().strip().splitlines() for n in names}
        checks.check(f".{form}: the last line is the origin", all("zwidth:tables:" in written[n][-1] for n in names), names)
        other = [n for n in names if printed[n].splitlines() != written[n][:-1]]
        checks.check(f"zwidth table --format {form} prints what zwidth run wrote", not other, other)


def hostile_tables(engine, reports, folder):
    """The tables of a study of hostile texts, by both; how they lie on the page is not judged: LaTeX sets long words over its edge."""
    files = sorted((reports / "tables").glob("*.tex"))
    name = "latex-hostile-tables"
    (folder / f"{name}.tex").write_text(latex_document("10pt", "", files))
    command = [engine, "-interaction=nonstopmode", "-halt-on-error", f"{name}.tex"]
    for _ in range(PASSES):
        done = subprocess.run(command, cwd=folder, capture_output=True, check=False)
    log = (folder / f"{name}.log").read_text(errors="replace")
    told = [line for line in log.splitlines() if line.startswith("!") or "Missing character" in line]
    checks.check(f"{engine}: {len(files)} tables of hostile texts compile", done.returncode == 0 and not told, told[:3])
    files = sorted((reports / "tables").glob("*.typ"))
    document = folder / "typst-hostile-tables.typ"
    tables = "\n".join(f'#include "{os.path.relpath(file, folder)}"\n#pagebreak(weak: true)' for file in files)
    document.write_text(f'#set page(paper: "a4")\n{tables}\n')
    try:
        pdf, warnings = typst.compile_with_warnings(str(document), root="/", ignore_system_fonts=True)
    except typst.TypstError as error:
        checks.check(f"Typst: {len(files)} tables of hostile texts compile", False, error)
        return
    checks.check(f"Typst: {len(files)} tables of hostile texts compile without a warning", not warnings, [str(w) for w in warnings][:3])
    document.with_suffix(".pdf").write_bytes(pdf)
    words("Typst, hostile texts", read(document.with_suffix(".pdf")), files)


def images(folder):
    """Every page as a PNG beside its document."""
    for file in sorted(folder.glob("*.pdf")):
        for number, page in enumerate(pdfium.PdfDocument(file), 1):
            page.render(scale=1.6).to_pil().save(folder / f"{file.stem}-{number:02}.png")


def methods(zwidth, root, engine, folder):
    """What was done in words, by both; each word of the Markdown stands on the page, where it has letters alone."""
    told = {form: checks.run(zwidth, "--root", root, "methods", STUDY, "--format", form) for form in ("md", "tex", "typ")}
    words = sorted({word for word in re.findall(r"(?<![\w\\])[A-Za-z]{4,}(?![\w\\])", told["md"])})
    (folder / "methods.typ").write_text(told["typ"])
    (folder / "methods.tex").write_text(
        "\\documentclass{article}\\usepackage[T1]{fontenc}\\usepackage{lmodern}\\begin{document}\n" + told["tex"] + "\\end{document}\n"
    )
    done = subprocess.run([engine, "-interaction=nonstopmode", "methods.tex"], cwd=folder, capture_output=True, text=True, check=False)
    told_wrong = [line for line in done.stdout.splitlines() if line.startswith("!") or "Missing character" in line]
    checks.check(f"{engine}: methods compile", done.returncode == 0 and not told_wrong, told_wrong[:3])
    (folder / "methods-typst.pdf").write_bytes(typst.compile(str(folder / "methods.typ"), root="/", ignore_system_fonts=True))
    for name in ("methods.pdf", "methods-typst.pdf"):
        there = squeezed(read(folder / name))
        lost = [word for word in words if word not in there]
        checks.check(f"{name}: every word of {len(words)}", len(words) > 100 and not lost, lost[:5])


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--zwidth", type=Path, required=True, help="the program")
    arguments.add_argument("--root", type=Path, required=True, help="where raw/thesis-twin lies")
    arguments.add_argument("--engine", default="pdflatex", help="pdflatex, lualatex or xelatex")
    arguments.add_argument("--keep", type=Path, help="a folder for documents and images (needs Pillow)")
    given = arguments.parse_args()
    tables = given.root.resolve() / "reports" / STUDY / "tables"
    tex, typ = sorted(tables.glob("*.tex")), sorted(tables.glob("*.typ"))
    checks.check("there are tables in both languages", len(tex) == len(typ) > 0, (len(tex), len(typ)))
    if not shutil.which(given.engine):
        raise SystemExit(f"{given.engine} is not installed; docs/tables.md says what it needs")
    with tempfile.TemporaryDirectory() as scratch:
        folder = given.keep.resolve() if given.keep else Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        with ThreadPoolExecutor() as pool:
            codes = pool.map(lambda size: compile_latex(given.engine, size, tex, folder), ARTICLES)
        for size, code in zip(ARTICLES, codes):
            judge_latex(given.engine, size, code, tex, folder)
        for page, (start, margin) in PAGES.items():
            typeset_typst(page, start, margin, typ, folder)
        glyphs_of_typst(typ)
        captions(given.engine, STUDY, tables.parent, folder)
        with tempfile.TemporaryDirectory() as other:
            reports, _ = hostile.made(given.zwidth.resolve(), Path(other))
            captions(given.engine, "hostile texts", reports, folder)
            hostile_tables(given.engine, reports, folder)
        methods(given.zwidth.resolve(), given.root.resolve(), given.engine, folder)
        if given.keep:
            images(folder)
    same_by_command(given.zwidth.resolve(), given.root.resolve(), tex)
    checks.end()


main()
