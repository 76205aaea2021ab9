"""Does a study's page do in a browser what it promises, and show what was recorded?

    python page.py --zwidth PROGRAM --report reports/thesis-twin --raw raw/thesis-twin --out FOLDER [--axe axe.min.js] [--chromium PROGRAM]

Drives Chromium without a window and without a network, by mouse and by keyboard alone. Values that the page shows are
compared with the Parquet files of raw/ bit for bit. What others bring into the page is neither run nor loaded, and the page as one file does the same. Screenshots, the printed page and the saved plots are written to --out, for
people to look at. At last a study is simulated whose every text is a script or a tag: they are shown, not run. Times are printed, not judged.
One line a check; the exit code is 1 where one failed.
"""

import argparse
import csv
import io
import json
import math
import random
import re
import shutil
import struct
import subprocess
import tempfile
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import axe_playwright_python
import pyarrow.parquet as parquet
import pypdfium2 as pdfium
from playwright.sync_api import Error, sync_playwright

import checks
import hostile

# Parts that every page has; the others only where the study has something to put there.
PARTS = ["top", "contents", "matrix", "findings", "trials", "dots", "figures", "tables", "provenance"]
COLUMNS = ["t_s", "theta_rad", "theta_dot_rad_s", "force_ex_n", "torque_ex_nm", "force_cmd_n", "state_bits"]
# A screenshot that is taller takes a browser's memory and shows a reader nothing.
TALLEST = 16_000
DRAWN = "Number(document.querySelector('#surface')?.dataset.drawn ?? 0)"


def bits(value):
    """The 64 bits of a number; every missing value is alike."""
    return "missing" if value is None or value != value else struct.pack("<d", value)


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--zwidth", type=Path, required=True, help="the program")
    arguments.add_argument("--report", type=Path, required=True, help="folder with index.html")
    arguments.add_argument("--raw", type=Path, help="raw/<study>, to compare values with")
    arguments.add_argument("--out", type=Path, required=True, help="where screenshots and saved plots go")
    arguments.add_argument("--axe", type=Path, default=Path(axe_playwright_python.__file__).parent / "axe.min.js", help="axe.min.js of axe-core")
    arguments.add_argument("--chromium", default="/usr/bin/chromium", help="the browser [default: /usr/bin/chromium]")
    arguments.add_argument("--exclusions", type=int, default=6, help="random exclusions that the matrix is compared with the program after [default: 6]")
    given = arguments.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    with sync_playwright() as playwright:
        flags = ["--no-sandbox", "--host-resolver-rules=MAP * ~NOTFOUND"]
        browser = playwright.chromium.launch(executable_path=given.chromium, args=flags)
        visit = Visit(browser, given.report.resolve())
        readable_without_script(browser, visit.report)
        every_part(visit)
        by_mouse(visit, given.raw)
        by_keyboard(visit, given.raw)
        every_sample(visit, given.raw)
        brush_and_zoom(visit)
        the_matrix_is_opened(visit)
        another_condition_beside_it(visit)
        cells_and_dots_open_trials(visit)
        dots_have_the_tables_intervals(visit)
        the_model_is_turned(visit)
        labels_have_their_curves(visit)
        address_keeps_the_view(visit)
        saved_plots(visit, given.out)
        printed(visit, given.out)
        colours_and_buttons(visit)
        every_mode_on_a_telephone(browser, visit.report)
        no_white_cards_in_the_dark(browser, visit.report)
        a_mean_opens_the_trials_of_everybody(browser, given.zwidth.resolve())
        what_is_left_out_is_estimated_as_by_the_program(browser, given.zwidth.resolve(), given.exclusions)
        effects_groups_and_scores_have_their_people(browser, given.zwidth.resolve(), given.axe, given.out)
        scores_without_recordings_open_their_answers(browser, given.zwidth.resolve(), given.out)
        differences_of_jnds_are_ratios(browser, given.zwidth.resolve(), given.out)
        screens(browser, visit.report, given)
        says_what_is_missing(browser, visit.report)
        what_is_missing_has_no_label(browser, visit.report)
        nothing_left_the_page(visit)
        what_is_brought_in_does_nothing(browser, visit.report)
        as_one_file(browser, visit.report, given.zwidth.resolve())
        texts_are_shown_and_not_run(browser, given.zwidth.resolve())
        browser.close()
    checks.end()


class Visit:
    """One page in one browser, with a log of its requests and complaints."""

    def __init__(self, browser, report, watched=False, **context):
        self.report, self.requests, self.refused, self.errors = report, [], [], []
        self.context = browser.new_context(**{"viewport": {"width": 1440, "height": 900}, "accept_downloads": True, "reduced_motion": "reduce", **context})
        self.context.set_offline(True)
        self.page = self.context.new_page()
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.on("requestfailed", lambda request: request.failure == "csp" and self.refused.append(request.url))
        self.page.on("console", lambda message: message.type in ("error", "warning") and self.errors.append(message.text))
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("dialog", self.refuse)
        if watched:
            self.page.add_init_script("window.refused = []; addEventListener('securitypolicyviolation', (event) => window.refused.push([event.effectiveDirective, event.blockedURI]))")
        self.page.goto((report / "index.html").as_uri())
        self.study = json.loads(self.page.locator("#study-data").text_content())

    def refuse(self, dialog):
        """A text of the study that opens a dialog was run, not shown."""
        self.errors.append(f"a dialog: {dialog.message}")
        dialog.dismiss()

    def ready(self):
        wait_until(self.page, f"{DRAWN} > 0")
        return self

    def after(self, act):
        """Does something, and waits until the plots were drawn anew; milliseconds it took as the page's clock has them."""
        before = self.page.evaluate(DRAWN)
        self.page.evaluate("window.began = performance.now()")
        act()
        wait_until(self.page, f"{DRAWN} > {before}")
        return self.page.evaluate("performance.now() - window.began")

    def address(self, has, lacks=None):
        """Whether the address comes to have one part and to lack another: it follows the plots after a pause."""
        says = f"location.hash.includes({has!r})" if has else "true"
        says += f" && !location.hash.includes({lacks!r})" if lacks else ""
        try:
            wait_until(self.page, says, seconds=10)
        except Error:
            return False
        return True

    def readout(self):
        """What the cursor is on, and the stored numbers there."""
        return self.page.evaluate("""() => { const out = document.getElementById('readout');
            return { ...out.dataset, values: Object.fromEntries([...out.querySelectorAll('[data-column]')].map((e) => [e.dataset.column, e.dataset.value])) }; }""")

    def complaints(self):
        found, self.errors = self.errors, []
        return found


def wait_until(page, condition, seconds=30):
    """Waits for a condition, looked at before each frame. Playwright's `wait_for_function` looks once before it asks the page to evaluate a text, which the page's policy forbids: it passes when the condition holds at once."""
    page.evaluate(f"""new Promise((done, fail) => {{
        const began = performance.now();
        const look = () => ({condition}) ? done() : performance.now() - began > {1000 * seconds} ? fail(new Error("waited in vain for " + {json.dumps(condition)})) : requestAnimationFrame(look);
        look();
    }})""")


def trial_file(raw, participant, session, trial):
    path = raw / "trials" / f"participant={participant}" / f"session={session}" / f"trial-{int(trial):03}.parquet"
    return parquet.ParquetFile(path).read().to_pydict()


def comparable(visit):
    """Columns that stand in the page as in the file: a linear study's positions are metres there, angles here."""
    linear = visit.study["angle_unit"] == "mm"
    return [name for name in COLUMNS if not (linear and name.startswith("theta"))]


def same_as_recorded(visit, raw, shown):
    """Differences between the readout and the trial's file, as text."""
    table = trial_file(raw, shown["participant"], shown["session"], shown["trial"])
    index = int(shown["index"])
    wrong = []
    for column in comparable(visit):
        if column in shown["values"]:
            recorded = table[column][index]
            if bits(float(shown["values"][column])) != bits(None if recorded is None else float(recorded)):
                wrong.append(f"trial {shown['trial']} sample {index} {column}: {shown['values'][column]} is not {recorded!r}")
    return wrong


def readable_without_script(browser, report):
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto((report / "index.html").as_uri())
    checks.check("without scripts the matrix and the findings are there", page.locator("table.matrix td").count() > 0 and page.locator("#findings li").count() > 0)
    checks.check("without scripts the trial browser says what to look at instead", len(page.locator("#browser noscript").inner_text()) > 20 if page.locator("#browser").count() else True)
    context.close()


def every_part(visit):
    visit.ready()
    page = visit.page
    for part in PARTS:
        checks.equal(f"#{part} is there once", page.locator(f"#{part}").count(), 1)
    wanted = [link.get_attribute("href") for link in page.locator("#contents a").all()]
    checks.equal("each entry of the contents leads to a part", [href for href in wanted if page.locator(href).count() != 1], [])
    simulated = visit.study["simulated"]
    checks.equal("simulated data are marked", page.locator(".synthetic").count() > 0, simulated)
    scroll_through(page)
    checks.check("dots are drawn", page.locator("#dot-plot .point").count() > 0)
    if page.locator("#answer-plot").count():
        checks.check("answers are drawn", page.locator("#answer-plot .point").count() > 0)
    broken = page.evaluate("[...document.images].filter((image) => image.complete && !image.naturalWidth).map((image) => image.src)")
    checks.equal("each figure that was loaded can be shown", broken, [])
    checks.equal("no complaint while it was read", visit.complaints(), [])
    paint = page.evaluate("performance.getEntriesByName('first-contentful-paint')[0]?.startTime")
    print(f"      first paint after {paint:.0f} ms, plots drawn in {page.get_attribute('#surface', 'data-draw-ms')} ms")


def scroll_through(page):
    height = page.evaluate("document.body.scrollHeight")
    for top in range(0, height, 600):
        page.evaluate(f"scrollTo({{ top: {top}, behavior: 'instant' }})")
        page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")


def pick(visit, name, value):
    return visit.after(lambda: visit.page.locator(f"#pick-{name}").select_option(value))


def only(visit, fieldset, values):
    """Sets the boxes of a fieldset to exactly these."""
    boxes = visit.page.locator(f"#pick-{fieldset} input")
    wanted = [box.get_attribute("value") for box in boxes.all()]
    for value in sorted(wanted, key=lambda value: value not in values):
        box = visit.page.locator(f'#pick-{fieldset} input[value="{value}"]')
        if box.is_enabled() and box.is_checked() != (value in values):
            visit.after(lambda: box.set_checked(value in values))


def by_mouse(visit, raw):
    page = visit.page
    only(visit, "show", ["repeats"])
    wrong, seen = [], set()
    for environment in visit.study["environments"]:
        pick(visit, "environment", environment["id"])
        for panel in ("theta", "velocity", "force", "loop"):
            plot = page.locator(f'.plot[data-panel="{panel}"]')
            if not plot.count():
                continue
            plot.scroll_into_view_if_needed()
            box = plot.bounding_box()
            for step in range(1, 12):
                page.mouse.move(box["x"] + 46 + (box["width"] - 58) * step / 12, box["y"] + box["height"] * (0.25 + 0.05 * step))
                wait_until(page, "document.getElementById('readout').dataset.index !== undefined")
                shown = visit.readout()
                seen.add((shown["trial"], shown["index"]))
                if raw:
                    wrong += same_as_recorded(visit, raw, shown)
    checks.check("the mouse reaches different samples of different trials", len(seen) > 20 and len({trial for trial, _ in seen}) > 2, f"{len(seen)} samples")
    if raw:
        checks.equal(f"by mouse, {len(seen)} samples are bit for bit as recorded", wrong[:3], [])
    checks.equal("no complaint by mouse", visit.complaints(), [])


def tab_to(page, selector, most=400):
    """Presses Tab until the element has the focus."""
    for _ in range(most):
        page.keyboard.press("Tab")
        if page.evaluate(f"document.activeElement?.matches({json.dumps(selector)})"):
            return True
    return False


def by_keyboard(visit, raw):
    page = visit.page
    page.evaluate("document.activeElement.blur(); getSelection().removeAllRanges(); scrollTo({ top: 0, behavior: 'instant' })")
    page.locator("h1").first.click()
    checks.check("Tab reaches the choice of the environment", tab_to(page, "#pick-environment"))
    checks.check("Tab goes on to the modes", tab_to(page, "#pick-modes input:not(:disabled)"))
    visit.after(lambda: page.keyboard.press("Space"))
    checks.check("a box keeps the focus after it was switched", page.evaluate("document.activeElement.matches('#pick-modes input')"))
    checks.check("Tab goes on to the plots", tab_to(page, "#surface"))
    wrong = []
    for keys, expect in ((["Home"], 0), (["ArrowRight"], 1), (["ArrowRight"] * 3, 4), (["ArrowLeft"], 3), (["PageDown"], 13), (["PageDown"] * 5, 63), (["PageUp"], 53)):
        for key in keys:
            page.keyboard.press(key)
        shown = visit.readout()
        checks.equal(f"{len(keys)} × {keys[0]} leads to sample {expect}", int(shown["index"]), expect)
        if raw:
            wrong += same_as_recorded(visit, raw, shown)
    page.keyboard.press("End")
    last = visit.readout()
    first = last["trial"]
    if raw:
        wrong += same_as_recorded(visit, raw, last)
        checks.equal("End leads to the last sample", int(last["index"]) + 1, len(trial_file(raw, last["participant"], last["session"], last["trial"])["t_s"]))
        checks.equal("by keyboard, samples are bit for bit as recorded", wrong, [])
    page.keyboard.press("ArrowDown")
    checks.check("arrow down leads to another curve", visit.readout()["trial"] != first)
    wait_until(page, "document.getElementById('live').textContent.includes('t ')")
    checks.check("the live region speaks after a pause", "Curve" in page.locator("#live").text_content())
    page.keyboard.press("Home")
    page.keyboard.press("PageDown")
    page.keyboard.press("[")
    for _ in range(4):
        page.keyboard.press("PageDown")
    visit.after(lambda: page.keyboard.press("]"))
    checks.check("[ and ] mark a span", visit.address("b="), page.url)
    visit.after(lambda: page.keyboard.press("z"))
    checks.check("Z zooms to it", visit.address("t=", "b="), page.url)
    visit.after(lambda: page.keyboard.press("Escape"))
    checks.check("Escape shows all again", visit.address(None, "t="), page.url)
    checks.check("Tab leaves the plots", tab_to(page, "#trial-table summary", 3))
    page.keyboard.press("Enter")
    page.wait_for_selector("#trial-table tbody tr")
    checks.check("the table of samples is made when it is opened", page.locator("#trial-table tbody tr").count() > 10)
    checks.equal("no complaint by keyboard", visit.complaints(), [])


def downloaded(visit, export):
    """The bytes that a button of `Save plots and samples` gives."""
    page = visit.page
    if not page.locator("#saves").get_attribute("open") == "":
        page.locator("#saves > summary").click()
    with page.expect_download() as waiting:
        page.locator(f'[data-export="{export}"]').click()
    return Path(waiting.value.path()).read_bytes(), waiting.value.suggested_filename


def every_sample(visit, raw):
    """Each sample of each trial of the first participant, as the page gives it for download."""
    if not raw:
        return
    compared, wrong = 0, []
    only(visit, "modes", [mode["id"] for mode in visit.study["modes"]])
    for environment in visit.study["environments"]:
        pick(visit, "environment", environment["id"])
        text, _ = downloaded(visit, "csv")
        rows = {}
        for row in csv.DictReader(io.StringIO(text.decode())):
            rows.setdefault((row["participant"], row["session"], row["trial"]), []).append(row)
        for (participant, session, trial), lines in rows.items():
            table = trial_file(raw, participant, session, trial)
            for column in comparable(visit):
                if column in lines[0]:
                    shown = [bits(float(line[column]) if line[column] else None) for line in lines]
                    recorded = [bits(None if value is None else float(value)) for value in table[column]]
                    compared += len(recorded)
                    if shown != recorded:
                        wrong.append(f"trial {trial}, {column}")
    checks.equal(f"{compared} downloaded values are bit for bit as recorded", wrong, [])
    checks.check("trials were compared at all", compared > 1000)


def brush_and_zoom(visit):
    page = visit.page
    plot = page.locator('.plot[data-panel="theta"]')
    plot.scroll_into_view_if_needed()
    box = plot.bounding_box()
    page.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + 60)
    page.mouse.down()
    visit.after(lambda: page.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + 70, steps=5))
    page.mouse.up()
    checks.check("dragging over time marks a span", visit.address("b="), page.url)
    visit.after(lambda: page.locator("#zoom-span").click())
    checks.check("a button zooms to the span", visit.address("t="), page.url)
    walls = [environment["id"] for environment in visit.study["environments"] if environment["wall_rad"] is not None]
    if walls:
        pick(visit, "environment", walls[0])
        visit.after(lambda: page.locator("#zoom-wall").click())
        checks.equal("the wall's button is pressed", page.locator("#zoom-wall").get_attribute("aria-pressed"), "true")
    visit.after(lambda: page.locator("#zoom-reset").click())
    checks.equal("no complaint while zooming", visit.complaints(), [])


ROWS = """[...document.querySelectorAll('.verdicts tr[data-row]')].map((line) => ({ row: line.dataset.row, value: line.dataset.value, low: line.dataset.low, high: line.dataset.high, p: line.dataset.p, n: line.dataset.n,
    words: line.querySelector('.number').textContent, judged: line.querySelector('.judged').firstChild.textContent }))"""


def the_matrix_is_opened(visit):
    """By mouse and keyboard: a row opens its metric, a dot the traces behind it, a box leaves a trial out."""
    page = visit.page
    page.wait_for_selector("#verdict-matrix[data-ready]")
    page.evaluate("scrollTo({ top: 0, behavior: 'instant' })")
    rows = page.evaluate(ROWS)
    differences = sum(len(metric["differences"]) for metric in visit.study["metrics"])
    checks.check(f"{len(rows)} of {differences} differences have a row", 0 < len(rows) <= differences)
    checks.check("the figure that the matrix stands for is not shown twice", not page.locator("#verdicts > figure").is_visible())
    name = page.locator(".verdicts .row-name").first
    name.click()
    checks.equal("a name opens its metric", (name.get_attribute("aria-expanded"), page.locator(".detail .chart").count() > 0, page.locator(".detail table tbody tr").count() > 1), ("true", True, True))
    checks.check("the address names the open row", "row=" in page.url, page.url)
    page.locator(".detail details summary").first.click()
    page.wait_for_selector(".detail details img")
    checks.check("a metric's figures open in it", page.evaluate("document.querySelector('.detail details img').decode().then(() => true, () => false)"))
    summary = page.locator(".detail details summary").first
    summary.focus()
    page.set_viewport_size({"width": 1100, "height": 900})
    wait_until(page, "document.querySelector('.detail .chart').viewBox.baseVal.width < 520")
    page.set_viewport_size({"width": 1440, "height": 900})
    checks.equal("a narrower window leaves open what is open, and the focus where it is", (page.locator(".detail details[open]").count(), summary.evaluate("(it) => it === document.activeElement")), (1, True))
    name.focus()
    page.keyboard.press("Enter")
    checks.equal("Enter closes it", (name.get_attribute("aria-expanded"), page.locator(".detail").count()), ("false", 0))
    dots = page.locator(".verdicts svg.row").first
    dots.focus()
    first = dots.get_attribute("aria-valuetext")
    page.keyboard.press("ArrowRight")
    checks.check("arrows go from dot to dot", dots.get_attribute("aria-valuetext") != first, first)
    print(f"      a dot's traces drawn {visit.after(lambda: page.keyboard.press('Enter')):.0f} ms after Enter")
    checks.equal("a dot opens the traces of both modes in place", (page.locator(".detail #surface").count(), len(page.locator("#pick-modes input:checked").all())), (1, 2))
    checks.check("the focus is on the traces", page.evaluate("document.activeElement.id === 'surface'"))
    checks.check("the browser's own part says where they are", page.locator("#trials .elsewhere").is_visible())
    page.locator("#left-out > summary").click()
    box = page.locator("#left-out-trials input").first
    box.uncheck()
    page.set_viewport_size({"width": 1200, "height": 900})
    page.set_viewport_size({"width": 1440, "height": 900})
    checks.equal("the traces stay open, and the box keeps the focus, while rows are estimated again", (page.locator(".detail #surface").count(), box.evaluate("(box) => box === document.activeElement")), (1, True))
    box.check()
    page.locator("#left-out > summary").click()
    page.locator("#trials .elsewhere button").click()
    checks.equal("they are brought back", (page.locator("#trials #surface").count(), page.locator(".detail").count()), (1, 0))
    for form, begin in (("svg", b"<svg"), ("png", b"\x89PNG"), ("csv", b"metric,")):
        with page.expect_download() as waiting:
            page.locator(f'#verdict-matrix [data-save-matrix="{form}"]').click()
        saved = Path(waiting.value.path()).read_bytes()
        checks.check(f"the matrix is saved as {form}", saved.startswith(begin) and len(saved) > 500, saved[:40])
    lines = list(csv.DictReader(io.StringIO(saved.decode())))
    checks.equal("every row is in it", len(lines), len(rows))
    page.locator("#verdict-matrix .copy-values").click()
    wait_until(page, "document.querySelector('#verdict-matrix .copy-values').textContent !== 'Copy values'")
    page.locator("#left-out > summary").click()
    box = page.locator("#left-out-trials input").first
    trial = box.get_attribute("value")
    box.uncheck()
    shown = page.locator(".explored").inner_text()
    checks.check("what is explored says so, and how it would be made so", "Explored, not the analysis" in shown and "zwidth exclude" in shown and f"--trial {trial.split('/')[2]}" in shown, shown)
    checks.check("the address records it", "x=" in page.url, page.url)
    explored = page.evaluate(ROWS)
    checks.check("rows are estimated again", explored != rows)
    page.reload()
    visit.ready()
    page.wait_for_selector("#verdict-matrix[data-ready]")
    checks.equal("an address brings it back", page.evaluate(ROWS), explored)
    page.locator(".explored button").click()
    checks.equal("taken back in, all is as the tables have it", page.evaluate(ROWS), rows)
    checks.equal("no complaint in the matrix", visit.complaints(), [])


def another_condition_beside_it(visit):
    page = visit.page
    other = page.locator("#pick-beside option").nth(1)
    if not other.count():
        return
    visit.after(lambda: page.locator("#pick-beside").select_option(other.get_attribute("value")))
    checks.check("another condition is laid over it", "Dotted: " in page.locator("#browser").inner_text() and visit.address("beside="), page.url)
    _, name = downloaded(visit, "csv")
    checks.check("a saved file names it", f".beside.{other.get_attribute('value')[2:]}." in name, name)
    visit.after(lambda: page.locator("#pick-beside").select_option(""))


# The modes as combinations of two factors, one of which lacks a condition.
LEVELS = {"active": ("yes", "no"), "passive": ("no", "yes"), "hybrid": ("yes", "yes")}


def what_is_left_out_is_estimated_as_by_the_program(browser, zwidth, exclusions):
    """Rows without random trials and people are those of `zwidth compare` after `zwidth exclude`."""
    draw = random.Random(1)

    def trials_and_people(trials, case):
        person = draw.choice(trials)[0]
        return set(draw.sample(trials, draw.randint(1, 12))) | ({t for t in trials if t[0] == person} if case % 3 == 2 else set()), set()

    def people_alone(trials, case):
        return set(), set(draw.sample(sorted({who for who, _, _ in trials}), 1 + case % 2))

    # Two primary metrics are one family, which shares alpha with the claims on a curve; every other metric is one of its own.
    curves = '\n[compare]\nprimary = ["wall_past_max_rad", "duration_s", "force_over_angle"]\n'
    checks.check("rows were compared", left_out(browser, zwidth, ({}, curves, 4), trials_and_people, exclusions) >= 10 * exclusions)
    # Effects of factors are in the families, too; the page knows everybody's over all trials, so that people alone can be left out.
    factors = "".join(f'[[factors]]\nid = "{name}"\nlevels = ["no", "yes"]\n' for name in ("motor", "brake"))
    effects = f'\n{factors}[compare]\nprimary = ["duration_s", "force_mean_n"]\ncontrasts = [["hybrid", "active"]]\n'
    checks.check("rows beside effects were compared", left_out(browser, zwidth, (LEVELS, effects, 6), people_alone, 3) >= 6)


def left_out(browser, zwidth, study, choose, exclusions):
    """How many rows were compared in a study with these levels of modes, these tables and so many people."""
    levels, tables, participants = study
    rows = ROWS.replace(".verdicts tr", "#verdict-matrix tr")
    with tempfile.TemporaryDirectory() as root:
        base = Path(root) / "base"
        checks.run(zwidth, "--root", base, "new", "left")
        file = base / "raw" / "left" / "study.toml"
        text = file.read_text()
        for mode, (motor, brake) in levels.items():
            text = text.replace(f'id = "{mode}"\n', f'id = "{mode}"\nfactors = {{ motor = "{motor}", brake = "{brake}" }}\n')
        file.write_text(text + tables)
        checks.run(zwidth, "--root", base, "twin", "left", "--participants", participants, "--sessions", 1)
        checks.run(zwidth, "--root", base, "run", "left")
        visit = Visit(browser, base / "reports" / "left").ready()
        page = visit.page
        page.wait_for_selector("#verdict-matrix[data-ready]")
        if not levels:
            # A curve is compared in each environment, as durations are.
            curve_claims = next(len(metric["differences"]) for metric in visit.study["metrics"] if metric["name"] == "duration_s")
            checks.equal("the page knows the claims on curves", visit.study["curve_claims"], curve_claims)
            legend = page.locator("#verdict-matrix p.caption").text_content()
            checks.check("and its legend names them", f"Bonferroni for {curve_claims} claims on primary curves" in legend, legend)
        trials = [(t["participant"], t["session"], t["trial"]) for t in visit.study["trials"]]
        compared, wrong = 0, []
        for case in range(exclusions):
            gone, people = choose(trials, case)
            keys = sorted("/".join(map(str, key)) for key in gone) + sorted(people)
            gone |= {trial for trial in trials if trial[0] in people}
            copy = Path(root) / "copy"
            shutil.copytree(base, copy)
            for who in sorted({(p, s) for p, s, _ in gone}):
                numbers = ",".join(str(n) for p, s, n in sorted(gone) if (p, s) == who)
                checks.run(zwidth, "--root", copy, "exclude", "left", "-p", who[0], "-s", who[1], "--trial", numbers, "left out")
            checks.run(zwidth, "--root", copy, "compare", "left")
            table = parquet.read_table(copy / "derived" / "left" / "compare" / "contrasts.parquet")
            stems = [with_its_unit(table.column_names, stem) for stem in ("difference", "difference_ci_low", "difference_ci_high")]
            told = table.to_pylist()
            shutil.rmtree(copy)
            page.evaluate("(x) => { location.hash = `verdicts?x=${encodeURIComponent(x)}`; }", ",".join(keys))
            wait_until(page, "!document.querySelector('.explored').hidden")
            found = {row["row"]: row for row in page.evaluate(rows)}
            for row in told:
                mine = found.get(f"{row['metric']}/{row['environment']}/{row['contrast']}")
                if mine is None:
                    continue
                compared += 1
                theirs = [row[stem] for stem in stems] + [row["p_adjusted"]]
                ours = [mine[name] for name in ("value", "low", "high", "p")]
                # The program rounds quantiles and p values to nine digits, the same on every machine.
                wrong += [(case, mine["row"], our, their) for our, their in zip(ours, theirs) if (our == "") != (their is None) or (our != "" and abs(float(our) - their) > 2e-8 * (abs(their) + abs(theirs[2] - theirs[1] if theirs[1] is not None else 0)))]
                said = row["verdict"] + (f", {row['size']}" if row["size"] else "")
                if not mine["judged"].startswith(said):
                    wrong.append((case, mine["row"], mine["judged"], said))
        checks.equal(f"{compared} rows after {exclusions} random exclusions are those of the program", wrong[:5], [])
        if levels:
            key = "/".join(map(str, trials[0]))
            page.evaluate("(x) => { location.hash = `verdicts?x=${encodeURIComponent(x)}`; }", key)
            wait_until(page, f"document.querySelector('.explored').textContent.includes('1 trial')")
            judged = {row["judged"].split(",")[0] for row in page.evaluate(rows) if row["row"].startswith("duration_s/")}
            checks.equal("beside effects nothing is judged without a trial", judged, {"not judged here"})
        checks.equal("no complaint while leaving out", visit.complaints(), [])
        visit.context.close()
        return compared


# Two groups, and a score of two answers.
MORE = """
[[questions]]
id = "steady"
text = "The lever felt steady."
[[factors]]
id = "motor"
levels = ["no", "yes"]
[[factors]]
id = "brake"
levels = ["no", "yes"]
[[people]]
id = "group"
levels = ["novice", "expert"]
[[scores]]
id = "feel"
kind = "mean"
questions = ["felt_spring", "felt_wall", "steady"]
min_answered = 0.5
[compare]
contrasts = [["hybrid", "active"]]
groups = "group"
primary = "force_mean_n"
metrics = ["score_feel"]
"""


def effects_groups_and_scores_have_their_people(browser, zwidth, axe, out):
    """Dots of effects and columns of groups are the rows of `compare`, every value bit for bit; a dot opens its traces, of a score the answers too."""
    with tempfile.TemporaryDirectory() as root:
        checks.run(zwidth, "--root", root, "new", "crossed")
        file = Path(root) / "raw" / "crossed" / "study.toml"
        study = file.read_text()
        for mode, (motor, brake) in LEVELS.items():
            study = study.replace(f'id = "{mode}"\n', f'id = "{mode}"\nfactors = {{ motor = "{motor}", brake = "{brake}" }}\n')
        study = study.replace("repeats = 6", "repeats = 2")
        file.write_text(re.sub(r'question = "(felt_\w+)"', r'questions = ["\1", "steady"]', study) + MORE)
        people = {f"P{n:02}": "expert" if n > 4 else "novice" for n in range(1, 9)}
        (file.parent / "participants.csv").write_text("participant,group\n" + "".join(f"{who},{group}\n" for who, group in people.items()))
        checks.run(zwidth, "--root", root, "twin", "crossed", "--participants", 8, "--sessions", 1)
        checks.run(zwidth, "--root", root, "run", "crossed")
        visit = Visit(browser, Path(root) / "reports" / "crossed").ready()
        page = visit.page
        page.wait_for_selector("#claims[data-ready]")
        tables = Path(root) / "derived" / "crossed" / "compare"
        values = {}
        for row in parquet.read_table(tables / "person_values.parquet").to_pylist():
            values.setdefault((row["metric"], row["environment"], row["effect"]), {})[row["participant"]] = row["value"]
        effect_of = lambda row: " × ".join(row["effect"].split(":")) + f": {row['levels']}"
        means = {(row["metric"], row["environment"], effect_of(row)): row["difference"] for row in parquet.read_table(tables / "effects.parquet").to_pylist() if row["difference"] is not None}
        for key, mean in means.items():
            # Each group has the same weight.
            own = [[value for who, value in values[key].items() if people[who] == group] for group in ("novice", "expert")]
            checks.close(f"everybody's {key[2]} in {key[0]}, {key[1]} make the effect", sum(sum(group) / len(group) for group in own) / 2, mean, 1e-9)
        claims = [(metric["name"], claim) for metric in visit.study["metrics"] for claim in metric["claims"]]
        wrong = []
        for metric, claim in claims:
            if "people" in claim:
                own = next((own for (name, environment, effect), own in values.items() if name == metric and environment == claim["environment"] and claim["of"].endswith(f": {effect}")), {})
                wrong += [] if {who["participant"]: bits(who["value"]) for who in claim["people"]} == {who: bits(value) for who, value in own.items()} else [claim["of"]]
            elif claim["is_of_groups"]:
                drawn = [sorted(map(bits, group["values"])) for group in claim["groups"]]
                fits = lambda own: [sorted(bits(value) for who, value in own.items() if people[who] == group["label"]) for group in claim["groups"]] == drawn
                wrong += [] if any(name == metric and environment == claim["environment"] and fits(own) for (name, environment, _), own in values.items()) else [claim["of"]]
        checks.equal(f"people of {len(claims)} effects and differences between groups are those of the table", wrong, [])
        checks.check("there are effects with people, one without an estimate, groups, and a score", {"people" in claim or claim["is_of_groups"] for _, claim in claims} == {True, False} and any(name == "score_feel" for name, _ in claims), f"{len(claims)}")
        rows = page.evaluate(ROWS.replace(".verdicts tr", "#claims tr").replace("line.querySelector('.number').textContent", "''"))
        checks.equal("every claim has a row", len(rows), len(claims))
        for row, n in page.evaluate("[...document.querySelectorAll('#claims svg[role=slider]')].map((plot) => [plot.closest('tr').dataset, Number(plot.getAttribute('aria-valuemax'))]).map(([row, n]) => [row.row, [n, Number(row.n)]])"):
            if n[0] != n[1]:
                wrong.append((row, n))
        checks.equal("a row has as many dots as people", wrong, [])
        for form, begin in (("svg", b"<svg"), ("png", b"\x89PNG"), ("csv", b"metric,")):
            with page.expect_download() as waiting:
                page.locator(f'#claims [data-save-matrix="{form}"]').click()
            saved = Path(waiting.value.path()).read_bytes()
            (out / f"claims.{form}").write_bytes(saved)
            checks.check(f"effects and groups are saved as {form}", saved.startswith(begin) and len(saved) > 500 and b"NaN" not in saved, saved[:40])
            if form == "svg":
                checks.check("and marked as simulated", b"SYNTHETIC" in saved and saved.count(b'class="estimate"') == sum(claim["value"] is not None and (claim["jnd"] or claim["deviation"] or 0) > 0 for _, claim in claims))
        lines = list(csv.DictReader(io.StringIO(saved.decode())))
        scales = {(metric["label"], claim["of"]): (claim["value"], metric["scale"]) for metric in visit.study["metrics"] for claim in metric["claims"]}
        checks.equal("every claim is in it with its value", [line["contrast"] for line in lines if line["difference"] != "" and float(line["difference"]) != math.prod(scales[line["metric"], line["contrast"]])] + [len(lines) - len(claims)], [0])
        page.locator("#claims .copy-values").click()
        wait_until(page, "document.querySelector('#claims .copy-values').textContent !== 'Copy values'")
        open_claim = lambda text, at=0: page.locator("#claims .row-name", has_text=text).nth(at)
        open_claim("expert − novice").click()
        checks.equal("a name of groups opens a column for each, with everybody", (page.locator(".detail .charts svg").count(), page.locator(".detail .point[role=img]").count(), page.locator(".detail .mean").count()), (1, 8, 2))
        checks.check("the address names the open row", "row=" in page.url, page.url)
        page.locator("#claims").screenshot(path=str(out / "groups.png"))
        open_claim("motor: yes").click()
        checks.equal("a name of an effect opens the conditions and everybody's effect", (page.locator(".detail .charts svg").count(), page.locator(".detail .charts svg").last.locator(".point").count()), (2, 8))
        page.locator("#claims").screenshot(path=str(out / "effects.png"))
        address = page.url
        page.goto("about:blank")
        page.goto(address)
        visit.ready()
        page.wait_for_selector("#claims[data-ready]")
        checks.equal("an address opens it again", page.locator("#claims .detail .charts svg").count(), 2)
        dots = page.locator("#claims tr[data-row^='force_mean_n'] svg[role=slider]").first
        dots.focus()
        page.keyboard.press("End")
        who = dots.get_attribute("aria-valuetext").split(":")[0]
        visit.after(lambda: page.keyboard.press("Enter"))
        modes = page.evaluate("[...document.querySelectorAll('#pick-modes input:checked')].map((box) => box.value)")
        checks.equal("a dot of an effect opens its person's traces in the modes that it weighs", (page.locator("#claims .detail #surface").count(), page.locator("#pick-participant").input_value(), modes), (1, who, ["passive", "hybrid"]))
        checks.equal("no answers are shown beside a metric of trials", page.locator("#score-answers").count(), 0)
        dots = page.locator("#verdict-matrix tr[data-row^='score_feel/spring/'] svg[role=slider]").first
        dots.focus()
        page.keyboard.press("Home")
        who = dots.get_attribute("aria-valuetext").split(":")[0]
        visit.after(lambda: page.keyboard.press("Enter"))
        trials = [trial for trial in visit.study["trials"] if (trial["participant"], trial["environment"]) == (who, "spring") and trial["mode"] in ("hybrid", "active")]
        answers = page.evaluate("[...document.querySelectorAll('.detail #score-answers tbody tr')].map((line) => [...line.querySelectorAll('td')].map((cell) => cell.textContent))")
        asked = [question["id"] for question in visit.study["questions"]]
        wanted = [["–" if (value := trial["answers"][asked.index(item)]) is None else str(value) for trial in trials] for item in ("felt_spring", "felt_wall", "steady")]
        checks.equal("a dot of a score opens the traces, and the answers that it is made of", (page.locator(".detail #surface").count(), [[text.split(" (")[0] for text in line] for line in answers[:-1]]), (1, wanted))
        means = [(float(felt) + float(steady)) / 2 for felt, steady in zip(wanted[0], wanted[2])]
        checks.equal("whose mean is the score", [float(text) for text in answers[-1]], means)
        page.locator("#verdict-matrix").screenshot(path=str(out / "score.png"))
        scroll_through(page)
        place = next(i for i, metric in enumerate(visit.study["metrics"]) if metric["name"] == "score_feel")
        page.locator("#dots-metric").select_option(str(place))
        page.locator("#dot-plot .point").first.focus()  # equal scores lie on each other
        visit.after(lambda: page.keyboard.press("Enter"))
        checks.equal("a point of a score opens its trial and its answers", (page.locator("#trials #surface").count(), page.locator("#trials #score-answers thead th").count()), (1, 2))
        visit.after(lambda: page.locator(".matrix td a").first.click())
        narrow = Visit(browser, visit.report, viewport={"width": 360, "height": 800}).ready()
        scroll_through(narrow.page)
        wide = narrow.page.evaluate("document.documentElement.scrollWidth")
        checks.check("360 px with effects and groups: nothing is wider than the screen", wide <= 360, f"{wide} px")
        narrow.context.close()
        accessible(visit, axe, "effects and groups")
        visit.page.pdf(path=str(out / "claims.pdf"), format="A4", print_background=True)
        checks.equal("no complaint about effects, groups and scores", visit.complaints(), [])
        nothing_left_the_page(visit)
        visit.context.close()


QUESTIONNAIRE = """schema = 2
[study]
id = "asked"
title = "A questionnaire"
[design]
repeats = 1
trial_limit_s = 60.0
[device]
name = "lever"
[[environments]]
id = "task"
label = "Task"
kind = "none"
[[modes]]
id = "active"
label = "Active"
[[modes]]
id = "hybrid"
label = "Hybrid"
[[questions]]
id = "easy"
text = "It was easy."
[[questions]]
id = "tiring"
text = "It was tiring."
reversed = true
[[scores]]
id = "comfort"
kind = "sum"
questions = ["easy", "tiring"]
[compare]
primary = "score_comfort"
"""
QUESTIONNAIRE_MAP = """kind = "likert"
simulated = true
[trial]
participant = { column = "participant" }
session = "S01"
environment = "task"
mode = { column = "mode" }
[questions.columns]
easy = "easy"
tiring = "tiring"
"""


def scores_without_recordings_open_their_answers(browser, zwidth, out):
    """A questionnaire alone: a dot of its score opens the answers that the table has."""
    with tempfile.TemporaryDirectory() as root:
        raw = Path(root) / "raw" / "asked"
        raw.mkdir(parents=True)
        (raw / "study.toml").write_text(QUESTIONNAIRE)
        given = {(f"P{p:02}", mode): (1 + (2 * p + 3 * m) % 5, 1 + (p + m) % 4) for p in range(1, 7) for m, mode in enumerate(("active", "hybrid"))}
        (Path(root) / "map.toml").write_text(QUESTIONNAIRE_MAP)
        (Path(root) / "answers.csv").write_text("participant,mode,easy,tiring\n" + "".join(f"{who},{mode},{easy},{tiring}\n" for (who, mode), (easy, tiring) in given.items()))
        checks.run(zwidth, "--root", root, "import", "asked", "--map", Path(root) / "map.toml", Path(root) / "answers.csv")
        checks.run(zwidth, "--root", root, "run", "asked")
        visit = Visit(browser, Path(root) / "reports" / "asked")
        page = visit.page
        page.wait_for_selector("#verdict-matrix[data-ready]")
        checks.equal("without recordings there is no browser of trials, and no link to one", (page.locator("#trials").count(), page.locator("a[href='#trials']").count()), (0, 0))
        dots = page.locator("#verdict-matrix svg[role=slider]").first
        words = "[...document.querySelectorAll('#score-answers tbody tr')].map((line) => [...line.querySelectorAll('td')].map((cell) => cell.textContent.split(' (')[0]))"
        wrong = []
        dots.focus()
        page.keyboard.press("Home")
        for _ in range(6):
            who = dots.get_attribute("aria-valuetext").split(":")[0]
            page.keyboard.press("Enter")
            columns = [given[who, mode] for mode in ("active", "hybrid")]
            wanted = [[str(easy) for easy, _ in columns], [str(tiring) for _, tiring in columns], [str(easy + 6 - tiring) for easy, tiring in columns]]
            found = page.evaluate(words)
            wrong += [] if found == wanted else [(who, found, wanted)]
            dots.focus()
            page.keyboard.press("ArrowRight")
        checks.equal("everybody's dot of a score opens the answers that it is the sum of", wrong, [])
        page.keyboard.press("Enter")
        checks.check("the answers take the focus", page.evaluate("document.activeElement.id === 'score-answers'"))
        page.screenshot(path=str(out / "asked.png"))
        scroll_through(page)
        page.locator("#dot-plot .point").first.focus()
        page.keyboard.press("Enter")
        checks.equal("a point of a score opens the answers of its trial", page.locator("#dots #score-answers thead th").count(), 2)
        checks.equal("no complaint about a questionnaire", visit.complaints(), [])
        nothing_left_the_page(visit)
        visit.context.close()


def cells_and_dots_open_trials(visit):
    page = visit.page
    cell = page.locator(".matrix td a").last
    environment, mode = cell.get_attribute("data-environment"), cell.get_attribute("data-mode")
    print(f"      a cell's trials drawn {visit.after(cell.click):.0f} ms after the click")
    checks.equal("a cell opens its environment", page.locator("#pick-environment").input_value(), environment)
    checked = page.evaluate("[...document.querySelectorAll('#pick-modes input:checked')].map((box) => box.value)")
    checks.equal("a cell opens its mode", checked, [mode])
    checks.check("a cell takes the focus to the plots", page.evaluate("document.activeElement.id === 'surface'"))
    scroll_through(page)
    dot = page.locator("#dot-plot .point").first
    words = dot.get_attribute("aria-label")
    print(f"      a dot's trial drawn {visit.after(dot.click):.0f} ms after the click")
    repeat = page.locator("#pick-repeat").input_value()
    checks.check("a dot opens its trial", words.startswith(page.locator("#pick-participant").input_value()) and (f"repeat {repeat}" in words or repeat == "all"), f"{words}, repeat {repeat}")
    checks.check("a dot takes the focus to the plots", page.evaluate("document.activeElement.id === 'surface'"))
    points = page.locator("#dot-plot svg").first.locator(".point")
    points.first.focus()
    page.keyboard.press("ArrowRight")
    checks.equal("arrows go from dot to dot", page.evaluate("document.activeElement.getAttribute('aria-label')"), points.nth(1).get_attribute("aria-label"))
    visit.after(lambda: page.keyboard.press("Enter"))
    checks.check("Enter opens the dot's trial", page.evaluate("document.activeElement.id === 'surface'"))
    if page.locator("#answer-plot .point").count():
        visit.after(lambda: page.locator("#answer-plot .point").first.click())
    checks.equal("no complaint while opening", visit.complaints(), [])


def dots_have_the_tables_intervals(visit):
    """Means and differences that the script draws are those of the tables, bit for bit."""
    drawn, wrong = 0, []
    for metric in visit.study["metrics"]:
        given = [("means", "mode", "mean", ""), ("contrasts", "contrast", "difference", "difference_")]
        for table, of, value, prefix in given:
            path = visit.report / "tables" / f"{table}_{metric['name']}.parquet"
            if not path.exists():
                continue
            rows = parquet.read_table(path)
            ends = [with_its_unit(rows.column_names, stem) for stem in (value, f"{prefix}ci_low", f"{prefix}ci_high")]
            wanted = {(row["environment"], row[of]): tuple(bits(row[end]) for end in ends) for row in rows.to_pylist() if row[ends[0]] is not None}
            estimates = metric["means" if table == "means" else "differences"]
            found = {(one["environment"], one["of"]): tuple(bits(one[end]) for end in ("value", "low", "high")) for one in estimates}
            drawn += len(found)
            wrong += [] if found == wanted else [path.name]
    checks.equal("means and differences are those of the tables", wrong, [])
    checks.check(f"{drawn} means and differences were compared", drawn > 0)
    whiskers = visit.page.locator("#dot-plot .whisker").count()
    checks.check("intervals are drawn, and said to be the tables'", whiskers > 0 and "as in the tables" in visit.page.locator("#dot-plot").inner_text())


# A task whose JNDs people have in modes of two factors, and with it two groups.
TASK = """schema = 3
[study]
id = "felt"
title = "What is stiffer"
[design]
repeats = 1
trial_limit_s = 60.0
[device]
name = "lever"
[[factors]]
id = "motor"
levels = ["no", "yes"]
[[factors]]
id = "brake"
levels = ["no", "yes"]
[[environments]]
id = "spring"
label = "Spring"
kind = "spring"
stiffness_n_per_rad = 4.0
rest_deg = 0.0
[[tasks]]
id = "stiffer"
text = "Was it stiffer?"
asks = "more_less"
environment = "spring"
varies = "stiffness_n_per_rad"
standard = 4.0
method = "constant"
levels = [2.8, 3.2, 3.6, 4.0, 4.4, 4.8, 5.2]
trials = 40
"""
TASK_COMPARED = """[compare]
contrasts = [["hybrid", "active"]]
primary = "ln_jnd_stiffer"
metrics = ["pse_stiffer"]
[compare.bounds]
ln_jnd_stiffer = 0.22
[compare.better]
ln_jnd_stiffer = "lower"
"""
TASK_MAP = """kind = "psychometric"
simulated = true
[trial]
participant = { column = "participant" }
session = "S01"
mode = { column = "mode" }
[task]
id = "stiffer"
level = "level"
unit = "N/rad"
presentations = "presented"
positive = { column = "stiffer" }
"""
TASK_LEVELS = {"still": ("no", "no"), "active": ("yes", "no"), "passive": ("no", "yes"), "hybrid": ("yes", "yes")}


def differences_of_jnds_are_ratios(browser, zwidth, out):
    """Rows, dots and means of a metric of logarithms are read as ratios and JNDs: of everybody as the tables have them, and of those who are left."""
    metric = "ln_jnd_stiffer"
    numbers = lambda text: [float(number) for number in re.findall(r"\d+(?:\.\d+)?", text)]
    near = lambda found, wanted: len(found) >= len(wanted) and all(abs(own - other) <= 0.006 * other for own, other in zip(found, wanted))
    for groups in (False, True):
        with tempfile.TemporaryDirectory() as root:
            raw = Path(root) / "raw" / "felt"
            raw.mkdir(parents=True)
            modes = "".join(f'[[modes]]\nid = "{mode}"\nlabel = "{mode.title()}"\nfactors = {{ motor = "{motor}", brake = "{brake}" }}\n' for mode, (motor, brake) in TASK_LEVELS.items())
            people = '[[people]]\nid = "group"\nlevels = ["novice", "expert"]\n' if groups else ""
            (raw / "study.toml").write_text(TASK + modes + people + (TASK_COMPARED.replace("primary", 'groups = "group"\nprimary') if groups else TASK_COMPARED))
            who = [f"P{p:02}" for p in range(1, 11)]
            if groups:
                (raw / "participants.csv").write_text("participant,group\n" + "".join(f"{one},{'novice' if p % 2 else 'expert'}\n" for p, one in enumerate(who)))
            (Path(root) / "map.toml").write_text(TASK_MAP)
            lines = ["participant,mode,level,presented,stiffer"]
            for p, one in enumerate(who):
                for m, mode in enumerate(TASK_LEVELS):
                    sigma = 0.5 * math.exp(0.15 * m + 0.25 * math.sin(3 * p) + 0.1 * math.sin(7 * p + 5 * m) + (0.2 * m * (p % 2) if groups else 0))
                    middle = 4.0 + 0.2 * math.sin(11 * p + 2 * m) + 0.1 * m
                    for level in (2.8, 3.2, 3.6, 4.0, 4.4, 4.8, 5.2):
                        lines.append(f"{one},{mode},{level},40,{round(40 * (0.01 + 0.98 * 0.5 * math.erfc(-(level - middle) / sigma / math.sqrt(2))))}")
            (Path(root) / "answers.csv").write_text("\n".join(lines) + "\n")
            checks.run(zwidth, "--root", root, "import", "felt", "--map", Path(root) / "map.toml", Path(root) / "answers.csv")
            checks.run(zwidth, "--root", root, "run", "felt")
            visit = Visit(browser, Path(root) / "reports" / "felt")
            page = visit.page
            page.wait_for_selector("#verdict-matrix[data-ready]")
            page.wait_for_selector("#claims[data-ready]")
            tables = Path(root) / "derived" / "felt" / "compare"
            wrong = []
            told = {row["row"]: row for row in page.evaluate(ROWS)}
            claims = {claim["of"]: claim for own in visit.study["metrics"] if own["name"] == metric for claim in own["claims"]}
            rows = [(f"{metric}/{row['environment']}/{row['contrast']}", row) for row in parquet.read_table(tables / "contrasts.parquet").to_pylist() if row["metric"] == metric]
            effects = [row for row in parquet.read_table(tables / "effects.parquet").to_pylist() if row["metric"] == metric]
            rows += [(f"{metric}/spring/Spring: {row['effect'].replace(':', ' × ')}: {row['levels'].replace(' − ', ' / ')}", row) for row in effects]
            for name, row in rows:
                words = told[name]["words"] if name in told else ""
                wanted = [math.exp(row[stem]) for stem in ("difference", "difference_ci_low", "difference_ci_high")]
                is_ratio_of_ratios = "times as large a ratio (" in words
                if not near(numbers(words), wanted) or " times" not in words or is_ratio_of_ratios != (":" in row.get("effect", "")):
                    wrong.append((name, words, wanted))
            checks.equal(f"{len(rows)} differences and effects of JNDs are read as ratios{' beside groups' if groups else ''}", wrong, [])
            checks.check("no number of a JND is a logarithm", "ln " not in page.locator("#verdicts").inner_text() and "logarithm" not in page.locator("#verdict-matrix").inner_text())
            lower = told[f"{metric}/spring/hybrid − active"]
            checks.check("the smaller JND is better", not lower["judged"].startswith("different") or ("Active is better" in lower["judged"]) == (float(lower["value"]) > 0), lower["judged"])
            open_row = lambda name: page.locator("tr[data-row]").and_(page.locator(f"[data-row='{name}']")).locator(".row-name").click()
            open_row(f"{metric}/spring/hybrid − active")
            means = {row["mode"]: row for row in parquet.read_table(tables / "means.parquet").to_pylist() if row["metric"] == metric}
            lines = dict(page.evaluate("[...document.querySelectorAll('.detail table tbody tr')].map((line) => [line.children[0].textContent.toLowerCase(), [...line.querySelectorAll('td')].map((cell) => cell.textContent)])"))
            wrong = [(mode, lines.get(mode)) for mode, row in means.items() if mode not in lines or not near(numbers(lines[mode][0]), [math.exp(row["mean"])]) or "N/rad" not in lines[mode][0] or "×/÷" not in lines[mode][-2]]
            checks.equal("means of JNDs are geometric, in the unit of the levels", wrong, [])
            page.screenshot(path=str(out / f"jnds{'.groups' if groups else ''}.png"), full_page=True)
            if groups:
                between = {name: claim for name, claim in claims.items() if claim["is_of_groups"]}
                wrong = [(name, told[f"{metric}/spring/{name}"]["words"]) for name, claim in between.items() if claim["value"] is not None and (not near(numbers(told[f"{metric}/spring/{name}"]["words"]), [math.exp(claim["value"])]) or ("as large a ratio" in told[f"{metric}/spring/{name}"]["words"]) != ("mean over modes" not in name))]
                checks.equal(f"{len(between)} differences between groups are ratios, or ratios of ratios", wrong, [])
            else:
                page.evaluate("() => { location.hash = 'verdicts?x=P03,P07'; }")
                wait_until(page, "!document.querySelector('.explored').hidden")
                place = next(i for i, own in enumerate(visit.study["metrics"]) if own["name"] == metric)
                value = {(trial["participant"], trial["mode"]): trial["metrics"][place] for trial in visit.study["trials"]}
                left = [value[one, "hybrid"] - value[one, "active"] for one in who if one not in ("P03", "P07")]
                again = {row["row"]: row for row in page.evaluate(ROWS)}[f"{metric}/spring/hybrid − active"]
                checks.check("without two people the ratio is that of the others", near(numbers(again["words"]), [math.exp(sum(left) / len(left))]) and "times (" in again["words"], again["words"])
                dots = page.locator(f"tr[data-row='{metric}/spring/hybrid − active'] svg[role=slider]")
                dots.focus()
                page.keyboard.press("Home")
                checks.check("everybody's ratio is read", near(numbers(dots.get_attribute("aria-valuetext").split(":")[1]), [math.exp(min(left))]), dots.get_attribute("aria-valuetext"))
            scroll_through(page)
            page.locator("#dots-metric").select_option(label=next(text for text in page.locator("#dots-metric option").all_inner_texts() if "JND" in text))
            words = page.locator("#dot-plot .point").first.get_attribute("aria-label")
            jnds = [math.exp(trial["metrics"][next(i for i, own in enumerate(visit.study["metrics"]) if own["name"] == metric)]) for trial in visit.study["trials"]]
            checks.check("a dot is a JND in its unit", "N/rad" in words and any(near(numbers(words.split(": ")[-1]), [jnd]) for jnd in jnds), words)
            with page.expect_download() as waiting:
                page.locator('#verdict-matrix [data-save-matrix="csv"]').click()
            saved = [line for line in csv.DictReader(io.StringIO(Path(waiting.value.path()).read_text())) if line["contrast"] == "hybrid − active" and line["unit"].startswith("ln")]
            checks.equal("for programs it is a logarithm, which its unit says", [(line["unit"], line["difference"]) for line in saved], [("ln N/rad", {row["row"]: row for row in page.evaluate(ROWS)}[f"{metric}/spring/hybrid − active"]["value"])])
            checks.equal("no complaint about JNDs", visit.complaints(), [])
            nothing_left_the_page(visit)
            visit.context.close()


def the_model_is_turned(visit):
    """Sliders by keyboard alone; the error that is told is that of the run with these parameters in the derived table."""
    page = visit.page
    if not page.locator("#model-plot").count():
        return
    page.locator("#model-plot").scroll_into_view_if_needed()
    page.wait_for_selector("#model-plot[data-ready]")
    folder = visit.report.parent.parent / "derived" / visit.report.name / "runs"
    of = visit.study["turned"]
    lever = 180 / math.pi
    checked, wrong, moved = 0, [], 0
    options = page.locator("#model-condition option").all()
    for place, option in enumerate(options):
        page.select_option("#model-condition", str(place))
        environment, mode = [(e["id"], m["id"]) for e in visit.study["environments"] for m in visit.study["modes"] if f"{e['label']}, {m['label']}" == option.text_content()][0]
        rows = parquet.read_table(folder / f"{of['participant']}.{of['session']}.{environment}.parquet").to_pylist()
        rows = [row for row in rows if row["mode"] == mode and row["mass_kg"] is not None]
        for key, slider in [("End", 0), ("ArrowLeft", 0), ("Home", 1), ("ArrowRight", 1), ("End", 2), ("Home", 2)]:
            before = page.locator("#model-plot .model").first.get_attribute("d")
            page.focus(f"#model-{slider}")
            page.keyboard.press(key)
            moved += page.locator("#model-plot .model").first.get_attribute("d") != before
            at = [float(page.get_attribute(f"#model-{k}", "aria-valuetext").split()[0]) for k in range(3)]
            is_it = lambda row: all(abs(row[name] - value) <= 5e-4 * max(value, 1e-9) for name, value in zip(("mass_kg", "damping_ns_per_rad", "friction_n"), at))
            wanted = {row["rmse_rad"] for row in rows if is_it(row)}
            told = re.search(r"angle: ([0-9.]+)", page.locator("#model-error").text_content())
            checked += 1
            if len(wanted) != 1 or not told or abs(float(told[1]) - wanted.pop() * lever) > 5e-4 * float(told[1]):
                wrong.append((environment, mode, at))
    checks.equal(f"{checked} errors of {len(options)} turned models are those of the table of runs", wrong, [])
    checks.check("turning redraws the model", moved > checked / 2, str(moved))


def with_its_unit(names, stem):
    """The column of a name without its unit: the first that begins so, `difference_n` before `difference_ci_low_n` and `difference_jnd`."""
    return next(name for name in names if name == stem or name.startswith(f"{stem}_"))


SVG = "{http://www.w3.org/2000/svg}"
PANELS = ("theta", "velocity", "force", "states", "loop")
# What a button would save, without a download: a browser takes its time for hundreds of them.
SAVED = """(name) => {
    const [address, click] = [URL.createObjectURL, HTMLAnchorElement.prototype.click];
    let saved = null;
    URL.createObjectURL = (blob) => { saved = blob; return ''; };
    HTMLAnchorElement.prototype.click = () => {};
    document.querySelector(`[data-export="${name}"]`).click();
    [URL.createObjectURL, HTMLAnchorElement.prototype.click] = [address, click];
    return saved.text();
}"""


class Drawn:
    """A panel as the page saves it: what is drawn within its frame, and its texts."""

    def __init__(self, content):
        root = ElementTree.fromstring(content)
        self.texts = list(root.iter(f"{SVG}text"))
        clips = {clip.get("id"): clip.find(f"{SVG}rect") for clip in root.iter(f"{SVG}clipPath")}
        self.lines, self.bars, self.marks = [], [], set()
        for group in root.iter(f"{SVG}g"):
            frame = clips[group.get("clip-path")[5:-1]]
            left, top, width, height = (float(frame.get(name)) for name in ("x", "y", "width", "height"))
            inside = lambda x, y: left <= x <= left + width and top <= y <= top + height
            for path in group.iter(f"{SVG}path"):
                if len(re.findall("[Lh]", path.get("d"))) and any(inside(float(x), float(y)) for x, y in re.findall(r"[ML](\S+?) (-?[\d.]+)", path.get("d"))):
                    self.lines.append(path)
            self.bars += [rect for rect in group.iter(f"{SVG}rect") if float(rect.get("x")) + float(rect.get("width")) >= left and float(rect.get("x")) <= left + width]
            self.marks |= {text.text for text in group.iter(f"{SVG}text") if inside(float(text.get("x")), float(text.get("y")) - 4)}

    def colours(self):
        """Of the lines and bars that can be seen."""
        return {line.get("stroke") for line in self.lines} | {bar.get("fill") for bar in self.bars}

    def unlike(self):
        """Labels that stand for nothing that is drawn."""
        wrong = []
        names = [text for text in self.texts if text.get("font-weight") == "600" and text.get("paint-order")]
        wrong += [name.text for name in names if not any(line.get("stroke") == name.get("fill") for line in self.lines)]
        walls = [text.text for text in self.texts if (text.text or "").startswith("wall ")]
        wrong += walls if not any(line.get("stroke-dasharray") == "5,4" for line in self.lines) else []
        for row in [text for text in self.texts if text.text in ("motor", "brake")]:
            near = [bar for bar in self.bars if abs(float(bar.get("y")) + 5 - (float(row.get("y")) - 4)) < 8]
            wrong += [] if near else [row.text]
        return wrong


def disagreements(visit):
    """Labels of the trial browser without what they name: on the plots, in the boxes of the modes and in the note."""
    page, wrong, panels = visit.page, [], {}
    for panel in PANELS:
        shown = page.locator(f'.plot[data-panel="{panel}"]').is_visible()
        if not page.locator("#saves").get_attribute("open") == "":
            page.locator("#saves > summary").click()
        if page.locator(f'[data-export="{panel}.svg"]').is_visible() != shown:
            wrong.append(f"{panel} can be saved, and is not shown")
        if shown:
            panels[panel] = Drawn(page.evaluate(SAVED, f"{panel}.svg"))
            wrong += [f"{panel}: {label}" for label in panels[panel].unlike()]
            if panel != "states" and not panels[panel].lines and not visit.zoomed:
                wrong.append(f"{panel}: a panel without a curve")
    colours = set().union(*[drawn.colours() for drawn in panels.values()])
    light = page.evaluate("[...document.querySelectorAll('#pick-modes input')].map((_, i) => getComputedStyle(document.documentElement).getPropertyValue(`--mode-${i % 6}`).trim())")
    boxes = page.evaluate("[...document.querySelectorAll('#pick-modes label')].map((label) => { const line = label.querySelector('.swatch'); return [label.querySelector('input').value, Boolean(line) && getComputedStyle(line).visibility === 'visible']; })")
    wrong += [f"the line beside {mode}: shown {has}" for (mode, has), colour in zip(boxes, light) if has != (colour in colours)]
    note = page.locator("#browser > p.caption").first.inner_text()
    lines = [line for drawn in panels.values() for line in drawn.lines]
    if "Thick:" in note and not any(line.get("stroke") in light and line.get("stroke-width") in ("2.5", "1.5") for line in lines):
        wrong.append("the note: mean")
    if "Fine dots:" in note and not any(line.get("stroke-dasharray") == "2,2" and line.get("stroke") in light for line in lines):
        wrong.append("the note: command")
    if "Replay:" in note and not any(line.get("stroke-dasharray") in ("7,3,1,3", "2,2") and line.get("stroke") not in light for line in lines):
        wrong.append("the note: replay")
    marks = set().union(*[drawn.marks for drawn in panels.values()])
    wrong += [f"the note: {sign}" for sign in "○×△◇□" if sign in note and sign not in marks]
    return wrong


def agrees(visit, what, zoomed=False):
    visit.zoomed = zoomed
    checks.equal(f"labels and curves agree: {what}", disagreements(visit), [])


def labels_have_their_curves(visit):
    """After each choice that takes curves away, no label of the trial browser stands for one that is not drawn."""
    page, everything = visit.page, ["repeats", "mean", "replay", "command", "states", "events"]
    modes = [mode["id"] for mode in visit.study["modes"]]
    for environment in visit.study["environments"]:
        pick(visit, "environment", environment["id"])
        only(visit, "modes", modes)
        only(visit, "show", everything)
        agrees(visit, f"{environment['id']}, all is shown")
        for mode in modes:
            only(visit, "modes", [mode])
            agrees(visit, f"{environment['id']}, {mode} alone")
            only(visit, "modes", modes)
        for shown in (["repeats"], ["mean"], ["replay"], ["command"], ["repeats", "events"], ["mean", "events", "states"], []):
            only(visit, "show", shown)
            agrees(visit, f"{environment['id']}, shown: {', '.join(shown) or 'nothing'}")
        only(visit, "show", everything)
        address = page.url.split("#")[0]
        for zoom in ("-9,-8", "0.4,0.41", "0,0.3", "1.2,1.25"):
            page.goto("about:blank")
            page.goto(f"{address}#trials?p={visit.study['trials'][0]['participant']}&s={visit.study['trials'][0]['session']}&e={environment['id']}&m={','.join(modes)}&t={zoom}&show={','.join(everything)}")
            visit.ready()
            agrees(visit, f"{environment['id']}, {zoom} s", zoomed=True)
        if page.locator("#zoom-wall").is_visible():
            visit.after(lambda: page.locator("#zoom-wall").click())
            agrees(visit, f"{environment['id']}, at the wall", zoomed=True)
        visit.after(lambda: page.locator("#zoom-reset").click())
    if page.locator("#model-plot").count():
        scroll_through(page)
        wait_until(page, "document.querySelector('#model-plot')?.dataset.ready")
        wrong = page.evaluate("""() => { const wrong = [];
            for (const slider of document.querySelectorAll('#model-plot input[type=range]'))
                for (const stop of [slider.min, slider.max]) {
                    slider.value = stop;
                    slider.dispatchEvent(new Event('input'));
                    for (const name of ['recorded', 'model']) {
                        const named = [...document.querySelectorAll('#model-plot text')].some((text) => text.textContent === name);
                        if (named !== [...document.querySelectorAll(`#model-plot path.${name}`)].some((path) => path.getAttribute('d'))) wrong.push(`${slider.id} ${stop}: ${name}`);
                    }
                }
            return wrong; }""")
        checks.equal("labels and curves agree: the model, turned", wrong, [])
    only(visit, "show", ["repeats", "mean", "states"])
    checks.equal("no complaint about labels", visit.complaints(), [])


def without(report, folder, trials, lacks):
    """A copy of the page without the trials that `trials` names, and of the others' data without the columns that `lacks` gives for the beginning of a condition's line."""
    copy = Path(folder) / report.name
    shutil.copytree(report, copy)
    page = (copy / "index.html").read_text()
    begin = page.index(">", page.index('id="study-data"')) + 1
    end = page.index("</script>", begin)
    study = json.loads(page[begin:end])
    study["trials"] = [trial for trial in study["trials"] if not trials(trial)]
    (copy / "index.html").write_text(page[:begin] + json.dumps(study).replace("<", "\\u003c") + page[end:])
    for file in (copy / "report-data").glob("*.js"):
        lines = file.read_text().splitlines()
        for number, line in enumerate(lines):
            for column in lacks(line.partition('", ')[0]):
                lines[number] = lines[number].replace(f'"{column}"', f'"no_{column}"')
        file.write_text("\n".join(lines))
    return copy


def what_is_missing_has_no_label(browser, report):
    """A mode without trials in an environment, one whose trials lack a signal, and a signal that no trial has."""
    with tempfile.TemporaryDirectory() as folder:
        study = json.loads(re.search(r'id="study-data"[^>]*>(.*?)</script>', (report / "index.html").read_text(), re.DOTALL)[1])
        modes, environment = [mode["id"] for mode in study["modes"]], study["environments"][0]["id"]
        first, last = modes[0], modes[-1]
        cases = [
            (f"{first} has no trial", lambda trial: trial["mode"] == first and trial["environment"] == environment, lambda begin: []),
            (f"trials in {last} lack the force", lambda trial: False, lambda begin: ["force_ex_n"] if begin.endswith(f".{last}") else []),
            ("no trial has an angle or a velocity", lambda trial: False, lambda begin: ["theta_rad", "theta_dot_rad_s"]),
            ("no trial has a force", lambda trial: False, lambda begin: ["force_ex_n"]),
        ]
        for number, (what, trials, lacks) in enumerate(cases):
            visit = Visit(browser, without(report, Path(folder) / str(number), trials, lacks)).ready()
            pick(visit, "environment", environment) if len(study["environments"]) > 1 else None
            only(visit, "show", ["repeats", "mean", "command", "states", "events"])
            agrees(visit, what)
            checks.equal(f"no complaint: {what}", visit.complaints(), [])
            visit.context.close()


def address_keeps_the_view(visit):
    page = visit.page
    only(visit, "show", ["mean", "events"])
    address = page.url
    checks.check("the view stands in the address", "#trials?" in address and "events" in address, address)
    page.goto("about:blank")
    page.goto(address)
    visit.ready()
    checked = page.evaluate("[...document.querySelectorAll('#pick-show input:checked')].map((box) => box.value)")
    checks.equal("an address opens its view", checked, ["mean", "events"])
    page.goto("about:blank")
    page.goto(f"{address.split('#')[0]}#trials?p=nobody&s=&e=%3Cscript%3E&m=,,&r=1e9&a=x&t=9,1&b=NaN,2&show=toString")
    visit.ready()
    checks.check("an address that makes no sense opens something", page.locator("#pick-participant").input_value() != "")
    checks.equal("no complaint about addresses", visit.complaints(), [])


def saved_plots(visit, out):
    only(visit, "show", ["repeats", "mean", "states"])
    for export in [button.get_attribute("data-export") for button in visit.page.locator("[data-export]").all()]:
        if export == "csv":
            continue
        content, name = downloaded(visit, export)
        (out / f"saved.{export}").write_bytes(content)
        good = content.startswith(b"\x89PNG") if export.endswith("png") else content.startswith(b"<svg") and b"NaN" not in content
        checks.check(f"{export} is saved", good and name.endswith(export) and len(content) > 1000, f"{name}, {len(content)} bytes")
        if export.endswith("svg") and visit.study["simulated"]:
            checks.check(f"{export} is marked as simulated", b"SYNTHETIC" in content)


def printed(visit, out):
    content = visit.page.pdf(path=str(out / "printed.pdf"), format="A4", print_background=True)
    checks.check("the page prints", content.startswith(b"%PDF") and len(content) > 20_000, f"{len(content)} bytes")
    # What stands below a part's plots is on the page of its heading, and so are the plots between.
    pages = pdfium.PdfDocument(content)
    checks.check("it takes at most 12 pages", len(pages) <= 12, f"{len(pages)}")
    checks.check("the matrix is on the first", "difference ÷" in pages[0].get_textpage().get_text_range() or "difference and verdict" in pages[0].get_textpage().get_text_range())
    parts = visit.page.evaluate("""['trials', 'dots'].map((id) => document.getElementById(id)).filter((part) => part)
        .map((part) => [part.querySelector('h2').textContent.trim(), [...part.querySelectorAll('p.caption:not(#surface-keys)')].map((note) => note.textContent.trim()).filter((text) => text).pop()])""")
    pages = [" ".join(page.get_textpage().get_text_range().split()) for page in pdfium.PdfDocument(content)]
    for title, note in parts:
        begin = " ".join(note.split()[:4])
        checks.check(f"in print “{title}” stands with its plots", any(title in text and begin in text for text in pages), begin)
    checks.equal("no complaint while printing", visit.complaints(), [])


# Contrast of two colours as a browser gives them (WCAG 2.2).
CONTRAST = """(element) => {
    const luminance = (text) => {
        const [r, g, b] = text.match(/[\\d.]+/g).map((c) => { const s = Number(c) / 255; return s <= 0.04045 ? s / 12.92 : ((s + 0.055) / 1.055) ** 2.4; });
        return 0.2126 * r + 0.7152 * g + 0.0722 * b;
    };
    const style = getComputedStyle(element);
    const [a, b] = [luminance(style.color), luminance(style.backgroundColor)];
    return (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
}"""


def colours_and_buttons(visit):
    page = visit.page
    edges = page.evaluate("[...document.querySelectorAll('.order tr')].map((row) => [...row.querySelectorAll('td')].map((cell) => getComputedStyle(cell).borderBottomWidth))")
    if edges:
        checks.check("every row of the order has its colours", all(edge == "4px" for row in edges for edge in row), f"{edges[-1][:2]} in the last")
    colours = page.evaluate("study => study.modes.map((_, i) => getComputedStyle(document.documentElement).getPropertyValue(`--mode-${i % 6}`).trim())", visit.study)
    checks.check("every mode has a colour", all(re.fullmatch("#[0-9a-f]{6}", colour) for colour in colours), f"{colours}")
    for environment in visit.study["environments"]:
        pick(visit, "environment", environment["id"])
        button = page.locator("#zoom-wall")
        if not button.is_visible():
            continue
        visit.after(button.click)
        button.hover()
        checks.equal("a pressed button says so", button.get_attribute("aria-pressed"), "true")
        contrast = button.evaluate(CONTRAST)
        checks.check("a pressed button is legible under the pointer", contrast >= 4.5, f"contrast {contrast:.1f}")
        visit.after(button.click)
    checks.equal("no complaint about buttons", visit.complaints(), [])


def every_mode_on_a_telephone(browser, report):
    visit = Visit(browser, report, viewport={"width": 390, "height": 844}).ready()
    rows = visit.page.evaluate("[...document.querySelectorAll('.matrix tbody tr')].map((row) => [...row.querySelectorAll('td')].map((cell) => { const box = cell.getBoundingClientRect(); return [cell.dataset.label, box.left >= 0 && box.right <= innerWidth && box.width > 0]; }))")
    labels = {label for row in rows for label, _ in row}
    checks.check("390 px: every mode's number is on the screen", all(seen for row in rows for _, seen in row), f"{len(rows)} rows")
    checks.check("390 px: and beside its mode's name", len(labels) == max(len(row) for row in rows), f"{sorted(labels)}")
    visit.context.close()


def no_white_cards_in_the_dark(browser, report):
    visit = Visit(browser, report, color_scheme="dark").ready()
    if visit.page.locator("#figures img").count():
        filters = visit.page.evaluate("[...new Set([...document.querySelectorAll('#figures img')].map((image) => getComputedStyle(image).filter))]")
        checks.check("dark: figures are dark too", len(filters) == 1 and filters[0].startswith("invert"), f"{filters}")
    visit.context.close()


def a_mean_opens_the_trials_of_everybody(browser, zwidth):
    """A study of eight people: a number of the first table is a mean over them."""
    with tempfile.TemporaryDirectory() as folder:
        for command in (["twin", "eight", "--participants", "8", "--sessions", "1"], ["run", "eight"]):
            subprocess.run([zwidth, "--root", folder, *command], check=False, capture_output=True)
        visit = Visit(browser, Path(folder) / "reports/eight").ready()
        page = visit.page
        cell = page.locator(".matrix td a").first
        environment, mode = cell.get_attribute("data-environment"), cell.get_attribute("data-mode")
        visit.after(cell.click)
        people = {trial["participant"] for trial in visit.study["trials"] if (trial["environment"], trial["mode"]) == (environment, mode)}
        checks.equal("a mean over eight people opens the trials of all", page.locator("#pick-participant").input_value(), "*")
        checks.check("and says how many sessions these are", f"{len(people)} sessions" in page.locator("#browser").text_content(), f"{len(people)} people")
        seen = set()
        page.locator("#surface").focus()
        for _ in range(80):
            page.keyboard.press("ArrowDown")
            seen.add(visit.readout()["participant"])
        checks.equal("the cursor goes through the curves of each of them", seen, people)
        pick(visit, "participant", sorted(people)[0])
        checks.check("one of them can be chosen again", page.locator("#pick-participant").input_value() == sorted(people)[0])
        checks.equal("no complaint of eight people", visit.complaints(), [])
        visit.context.close()


def screens(browser, report, given):
    for width in (360, 1440):
        for scheme in ("light", "dark"):
            visit = Visit(browser, report, viewport={"width": width, "height": 800}, color_scheme=scheme).ready()
            scroll_through(visit.page)
            visit.page.evaluate("scrollTo({ top: 0, behavior: 'instant' })")
            tall = min(visit.page.evaluate("document.documentElement.scrollHeight"), TALLEST)
            visit.page.screenshot(path=str(given.out / f"{width}.{scheme}.png"), full_page=True, clip={"x": 0, "y": 0, "width": width, "height": tall})
            wide = visit.page.evaluate("document.documentElement.scrollWidth")
            checks.check(f"{width} px, {scheme}: nothing is wider than the screen", wide <= width, f"{wide} px")
            if given.axe:
                accessible(visit, given.axe, f"{width} px, {scheme}")
            checks.equal(f"{width} px, {scheme}: no complaint", visit.complaints(), [])
            visit.context.close()


def accessible(visit, axe, name):
    """What axe-core finds serious or critical, everything opened."""
    visit.page.evaluate("for (const details of document.querySelectorAll('details')) details.open = true")
    visit.page.evaluate(axe.read_text())  # no tag: the page's policy runs none
    found = visit.page.evaluate("axe.run(document, { resultTypes: ['violations'] }).then((result) => result.violations.map(({ id, impact, nodes }) => ({ id, impact, nodes: nodes.slice(0, 3).map(({ target, failureSummary }) => [target, failureSummary]) })))")
    checks.equal(f"{name}: axe finds nothing serious", [one for one in found if one["impact"] in ("serious", "critical")], [])
    lesser = [one["id"] for one in found if one["impact"] not in ("serious", "critical")]
    if lesser:
        print(f"      axe, {name}, lesser: {', '.join(lesser)}")


def says_what_is_missing(browser, report):
    """A page without its data beside it says what to do."""
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(report / "index.html", folder)
        visit = Visit(browser, Path(folder))
        if visit.study["single_file"]:
            checks.check("one file holds its data", visit.ready() is visit)
        else:
            visit.page.wait_for_selector(".status.bad")
            text = visit.page.locator(".status").text_content()
            checks.check("missing data are named, with what to do", "report-data" in text, text)
        visit.context.close()


# What somebody might bring into a page, and which rule of its policy refuses it.
BROUGHT_IN = """<script>window.pwned = "inline"</script><script src="brought.js"></script><script src="https://example.org/x.js"></script>
<img alt="" src="https://example.org/x.png" onerror="window.pwned = 'handler'"><link rel="stylesheet" href="https://example.org/x.css">
<style>h1 { color: rgb(1, 2, 3) }</style><p style="color: rgb(1, 2, 3)" id="coloured">text</p><iframe src="https://example.org/"></iframe>
<object data="https://example.org/x.svg"></object><base href="https://example.org/">"""
REFUSED = {"script-src-elem", "script-src-attr", "style-src-elem", "style-src-attr", "img-src", "frame-src", "object-src", "base-uri", "connect-src"}


def what_is_brought_in_does_nothing(browser, report):
    """Scripts, pictures, styles and frames that were put into the page, and a request of its own; without the policy the scripts run."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / report.name
        shutil.copytree(report, copy)
        (copy / "brought.js").write_text("window.pwned = 'beside';")
        page = (copy / "index.html").read_text()
        (copy / "index.html").write_text(page.replace("</main>", f"{BROUGHT_IN}</main>", 1))
        visit = Visit(browser, copy, watched=True).ready()
        scroll_through(visit.page)
        visit.page.evaluate("fetch('https://example.org/').catch(() => {})")
        found = visit.page.evaluate("[window.pwned, getComputedStyle(document.querySelector('h1')).color, getComputedStyle(document.getElementById('coloured')).color, document.baseURI === location.href]")
        checks.check("nothing that was brought in ran, coloured or moved the page", found[0] is None and "rgb(1, 2, 3)" not in found and found[3], str(found))
        checks.equal("each kind of it was refused", {rule for rule, _ in visit.page.evaluate("window.refused")}, REFUSED)
        visit.requests = [url for url in visit.requests if url not in visit.refused]  # the browser tells these too
        nothing_left_the_page(visit)
        visit.context.close()
        (copy / "index.html").write_text(page.replace("Content-Security-Policy", "none", 1).replace("</main>", f"{BROUGHT_IN}</main>", 1))
        visit = Visit(browser, copy, watched=True)
        checks.check("without the policy it would have run", visit.page.evaluate("window.pwned") is not None)
        visit.context.close()


def as_one_file(browser, report, zwidth):
    """The page as one file does what the page does, with nothing beside it."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "index.html"
        subprocess.run([zwidth, "--root", report.parent.parent, "open", report.name, "--single-file", file], check=True, capture_output=True)
        visit = Visit(browser, Path(folder)).ready()
        checks.check("one file says that it is one", visit.study["single_file"])
        for environment in visit.study["environments"][1:]:
            pick(visit, "environment", environment["id"])
        text, _ = downloaded(visit, "csv")
        checks.check("one file gives its samples", text.count(b"\n") > 100, f"{text.count(chr(10).encode())} lines")
        checks.check("one file is smaller than 4 MB", file.stat().st_size < 4e6, f"{file.stat().st_size / 1e6:.2f} MB")
        visit.page.evaluate("for (const details of document.querySelectorAll('#figures details')) details.open = true; for (const still of document.querySelectorAll('#verdicts > figure')) still.remove()")
        for _ in range(10):  # the page grows while its figures are unpacked
            scroll_through(visit.page)
        wait_until(visit.page, "!document.querySelector('img[data-packed]')")
        pictures = visit.page.evaluate("Promise.all([...document.images].map((image) => image.decode().then(() => image.naturalWidth, () => 0)))")
        checks.check(f"one file shows its {len(pictures)} figures", len(pictures) > 0 and all(pictures))
        checks.equal("one file: no complaint", visit.complaints(), [])
        nothing_left_the_page(visit)
        visit.context.close()


def texts_are_shown_and_not_run(browser, zwidth):
    """The page of a study whose texts are scripts, tags and quotes."""
    with tempfile.TemporaryDirectory() as root:
        report, texts = hostile.made(zwidth, Path(root))
        visit = Visit(browser, report).ready()
        scroll_through(visit.page)
        visit.page.evaluate("for (const details of document.querySelectorAll('details')) details.open = true")
        text = visit.page.evaluate("document.body.textContent")
        checks.equal("hostile texts stand in the page as they were written", hostile.shown(texts, text), [])
        checks.check("no text was run as a script", visit.page.evaluate("window.pwned") is None)
        scripts = visit.page.locator("script:not([type='application/json'])").count()
        checks.equal("no text is a script of the page", scripts, 1)
        checks.equal("hostile texts: no complaint", visit.complaints(), [])
        nothing_left_the_page(visit)
        visit.context.close()


def nothing_left_the_page(visit):
    inside = visit.report.as_uri()
    outside = [url for url in visit.requests if not url.startswith((inside, "blob:", "data:", "about:"))]
    checks.equal(f"none of {len(visit.requests)} requests left the folder", outside, [])


main()
