"""A simulated study whose every text is made of what TOML, HTML, SVG, LaTeX, Typst and Markdown take for their own."""

import json
import re
import subprocess
import xml.etree.ElementTree as xml

import checks

STUDY = "hostile"
# As long as a figure has room for: longer ones are refused, with what to do.
TEXTS = [
    "<script>window.pwned=1</script>",
    "</script><img src=x onerror=x>\"'",
    "\\input{x} \\end{document} % $ ^^41",
    "#eval(\"y\") @tab:x $a$ *b* _c_",
    "| a | [x](javascript:alert(1)) |",
    "{{x}} ${y} &amp; <!-- ]]> é ≤",
]
FIELDS = re.compile(r'(?m)^((?:label|title|name|text) = )(".*")$')


def made(zwidth, root):
    """Simulates and runs it; the folder of its report, and its texts as study.toml has them."""
    checks.run(zwidth, "--root", root, "new", STUDY)
    toml = root / "raw" / STUDY / "study.toml"
    texts = []

    def replaced(field):
        texts.append(f"{len(texts) + 1}: {TEXTS[len(texts) % len(TEXTS)]}")
        return field.group(1) + json.dumps(texts[-1], ensure_ascii=False)

    toml.write_text(FIELDS.sub(replaced, toml.read_text()))
    checks.run(zwidth, "--root", root, "twin", STUDY, "--participants", 2, "--sessions", 1)
    done = subprocess.run([zwidth, "--root", root, "run", STUDY], capture_output=True, text=True, check=False)
    checks.check("hostile texts: every figure is made", done.returncode in (0, 3) and "could not be made" not in done.stderr, re.findall("figure .* could not.*", done.stderr))
    reports = root / "reports" / STUDY
    drawings = sorted((reports / "figures").glob("*.svg"))
    broken = [file.name for file in drawings if xml.parse(file).getroot().tag != "{http://www.w3.org/2000/svg}svg"]
    active = [file.name for file in drawings if any(e.tag.endswith("}script") for e in xml.parse(file).iter())]
    checks.check(f"hostile texts: {len(drawings)} figures are SVG without a script", drawings and not broken and not active, (broken, active))
    # Questions stand in the figures alone.
    return reports, texts[:-2]


def shown(texts, page):
    """Which of the texts a page of plain text lacks, blanks apart."""
    squeezed = re.sub(r"\s", "", page)
    return [text for text in texts if re.sub(r"\s", "", text) not in squeezed]
