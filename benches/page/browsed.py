"""How soon pages can be read and used, in Chromium without a window and without a network."""

import statistics
from pathlib import Path

from playwright.sync_api import sync_playwright

# Choices of another participant, and openings of the page.
CHOICES, OPENINGS = 20, 3
# Of our page and of the peer's: how often plots were drawn, and the list of participants.
OURS = ("Number(document.querySelector('#surface')?.dataset.drawn ?? 0)", "#pick-participant")
PEER = ("Number(document.body?.dataset.drawn ?? 0)", "#participant")
# What a page may take to show its first trial before it counts as not usable, ms.
PATIENCE_MS = 300_000


def browsed(file: Path, drawn: str, people: str, chromium: str):
    """Medians in ms: first paint, first trial drawn; from the choice of a participant to their trials: median and largest; MB of the
    script's heap; seconds until the first trial in each opening."""
    with sync_playwright() as playwright:
        flags = ["--no-sandbox", "--host-resolver-rules=MAP * ~NOTFOUND", "--enable-precise-memory-info", "--js-flags=--expose-gc"]
        paints, firsts, waits, heap = [], [], [], 0.0
        for opening in range(OPENINGS):
            browser = playwright.chromium.launch(executable_path=chromium, args=flags)
            page = browser.new_page(viewport={"width": 1440, "height": 900}, reduced_motion="reduce")
            page.goto(file.as_uri(), timeout=PATIENCE_MS)
            # Playwright's `wait_for_function` evaluates a text in the page, which our page's policy forbids.
            page.evaluate(f"""async () => {{
                while (!({drawn} > 0) && performance.now() < {PATIENCE_MS}) await new Promise((next) => requestAnimationFrame(next));
                if (!({drawn} > 0)) throw new Error("no trial was drawn");
            }}""")
            firsts.append(page.evaluate("performance.now()"))
            paints.append(page.evaluate("performance.getEntriesByName('first-contentful-paint')[0]?.startTime"))
            if opening == 0:
                waits = choices(page, drawn, people)
                page.evaluate("gc()")
                heap = page.evaluate("performance.memory.usedJSHeapSize") / 1e6
            browser.close()
    return {"paint_ms": statistics.median(paints), "first_ms": statistics.median(firsts), "choice_ms": statistics.median(waits),
            "choice_max_ms": max(waits), "heap_mb": heap}


def choices(page, drawn, people):
    """Milliseconds from each choice of a participant to the plots of their trials, by the page's own clock."""
    ids = page.evaluate(f"[...document.querySelector('{people}').options].map((option) => option.value)")
    wanted = [ids[(k * len(ids)) // CHOICES] for k in range(CHOICES)]
    act = f"""async (id) => {{
        const before = {drawn}, list = document.querySelector('{people}');
        const began = performance.now();
        list.value = id;
        list.dispatchEvent(new Event('change', {{ bubbles: true }}));
        while ({drawn} === before) await new Promise((next) => requestAnimationFrame(next));
        return performance.now() - began;
    }}"""
    return [page.evaluate(act, chosen) for chosen in wanted[1:]]
