// What happens on the page as a whole, and what is built when.

function linkCopies() {
  for (const button of document.querySelectorAll("button.copy[data-copy]")) {
    button.addEventListener("click", async () => {
      const text = byId(button.dataset.copy);
      try {
        await navigator.clipboard.writeText(text.textContent);
        button.textContent = "Copied";
      } catch {
        getSelection().selectAllChildren(text); // no clipboard on a page from disk: select it for the reader
        button.textContent = "Selected: press Ctrl+C";
      }
    });
  }
}

/** Paper is light. */
function preparePrint() {
  const opened = [];
  addEventListener("beforeprint", () => {
    printing = true;
    for (const build of unbuilt) build();
    for (const redraw of redraws) redraw();
    for (const image of document.querySelectorAll("#practice img, #answers img")) { image.loading = "eager"; show(image); }
    for (const details of document.querySelectorAll("#quality details")) if (!details.open) { details.open = true; opened.push(details); }
    if (parts.surface) paperPanels();
  });
  addEventListener("afterprint", () => {
    printing = false;
    for (const details of opened.splice(0)) details.open = false;
    for (const redraw of redraws) redraw();
    for (const drawing of document.querySelectorAll(".plot > svg")) drawing.remove();
  });
}

/** The panels as drawings of lines, which paper shows sharper than pixels, at the width of a page. */
function paperPanels() {
  fineness = 3;
  const theme = readTheme(true);
  for (const { panel, plot, height } of screen.plots.values()) {
    if (plot.hidden || !height) continue;
    const width = panel.id === "loop" ? PAPER * 0.46 : PAPER * 0.54;
    const pen = svgPen(width, height, `paper-${panel.id}`);
    drawPanel(pen, panel, width, height, theme, screen.range, false);
    const drawing = new DOMParser().parseFromString(pen.finish(), "image/svg+xml").documentElement;
    if (drawing.nodeName === "svg") plot.append(document.importNode(drawing, true));
  }
}

/** Marks in the contents the section that is being read. */
function followReading() {
  const links = [...document.querySelectorAll("#contents a[href^='#']")];
  const watcher = new IntersectionObserver((entries) => {
    for (const { isIntersecting, target } of entries) {
      if (!isIntersecting) continue;
      for (const link of links) link.toggleAttribute("aria-current", link.hash === `#${target.id}`);
    }
  }, { rootMargin: "-20% 0px -70% 0px" });
  for (const link of links) { const target = byId(link.hash.slice(1)); if (target) watcher.observe(target); }
}

/** Builds a part when it is about to be seen, so that a large study's page is there at once. */
const unbuilt = new Set();
function whenNear(host, build) {
  if (!host) return;
  const now = () => { watcher.disconnect(); if (unbuilt.delete(now)) build(host); };
  const watcher = new IntersectionObserver((entries) => entries.some((entry) => entry.isIntersecting) && now(), { rootMargin: "600px" });
  unbuilt.add(now);
  watcher.observe(host);
}

function startBrowser(host) {
  buildBrowser(host);
  const named = readHash();
  touched = named;
  settle();
  writeControls();
  refresh();
  if (named) byId("trials").scrollIntoView();
  host.addEventListener("change", () => { touched = true; }, true);
  addEventListener("hashchange", () => { if (readHash()) { if (matrix.open?.view) closeRow(); writeControls(); refresh(); byId("trials").scrollIntoView(); } });
  onWidth(parts.surface, drawAll);
  redraws.delete(drawAll);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", drawAll);
  linkMatrix();
}

/** Pictures of a page in one file, when they are about to be seen. */
function showPictures() {
  const images = document.querySelectorAll("img[data-packed]");
  const watcher = new IntersectionObserver((entries) => {
    for (const { isIntersecting, target } of entries) if (isIntersecting) { watcher.unobserve(target); show(target); }
  }, { rootMargin: "1200px" });
  for (const image of images) watcher.observe(image);
}

preparePrint();
showPictures();
linkCopies();
followReading();
if (study.trials.length) {
  if (byId("browser")) startBrowser(byId("browser"));
  buildVerdicts();
  whenNear(byId("dot-plot"), buildDots);
  whenNear(byId("answer-plot"), buildAnswers);
  whenNear(byId("model-plot"), buildModel);
}
