// Effects of factors and differences between groups: rows like those of the matrix of verdicts, as the program has them.

const claimWords = (row) => [row.verdict, row.size].filter(Boolean).join(", ") + (row.remark ? `: ${row.remark}` : "");

function claimLine(row, width, range) {
  const plot = range ? makeSvg("svg", { class: "chart row", viewBox: `0 0 ${width} ${ROW.height}`, role: "img", "aria-label": row.value === null ? "no estimate" : valueWords(row) }, ...drawRow(row, scale(range, ROW.pad, width - ROW.pad))) : row.value === null ? "" : "nothing to measure it by";
  return make("tr", { "data-claim": row.of, "data-value": row.value === null ? "" : exact(row.value), "data-p": row.p_adjusted === null ? "" : exact(row.p_adjusted) },
    make("th", { scope: "row" }, row.of), make("td", { class: "plot-cell" }, plot), make("td", {}, row.value === null ? "" : make("span", { class: "number" }, valueWords(row)), make("span", { class: "judged" }, claimWords(row), row.value === null ? "" : make("span", { class: "count" }, ` (${row.who})`))));
}

function drawClaims(table, rows) {
  const width = printing ? 300 : Math.max(160, Math.min(520, table.parentElement.clientWidth * 0.4));
  table.style.setProperty("--plot", `${width}px`);
  const bodies = ["jnd", "sd", "none"].flatMap((by) => {
    const measured = rows.filter((row) => row.by === by);
    if (!measured.length) return [];
    const range = by === "none" ? null : sharedRange(measured);
    const bodies = [...groupBy(measured, ({ index }) => index)].map(([index, own]) => {
      const { label, is_primary: isPrimary } = study.metrics[index];
      const head = make("tr", { class: "metric" }, make("th", { colspan: 3, scope: "rowgroup" }, isPrimary ? make("strong", {}, label) : label));
      return make("tbody", { "data-by": by }, head, ...own.map((row) => claimLine(row, width, range)));
    });
    if (range) bodies.at(-1).append(make("tr", { class: "axis" }, make("td"), make("td", {}, makeSvg("svg", { class: "chart", viewBox: `0 0 ${width} 42`, "aria-hidden": "true" }, ...drawAxis(scale(range, ROW.pad, width - ROW.pad), range, by, width))), make("td")));
    return bodies;
  });
  table.replaceChildren(table.tHead, ...bodies);
  // A name of several lines makes its row taller than its plot: band and zero line reach over all of it.
  for (const plot of table.querySelectorAll(".chart.row")) {
    const over = Math.max(6, (plot.closest("tr").getBoundingClientRect().height - ROW.height) / 2 + 1), all = { y: -over, height: ROW.height + 2 * over, y1: -over, y2: ROW.height + over };
    for (const part of plot.querySelectorAll(".unfelt, .none")) for (const [name, value] of Object.entries(all)) if (part.hasAttribute(name)) part.setAttribute(name, value);
  }
}

function buildClaims(host) {
  const rows = study.metrics.flatMap(({ claims }, index) => (claims ?? []).map((claim) => {
    const one = claim.jnd ?? claim.deviation;
    return { ...claim, index, isSingle: false, dots: [], one, by: claim.value === null || !(one > 0) ? "none" : claim.jnd === null ? "sd" : "jnd" };
  }));
  const what = [rows.some(({ is_of_groups: isOfGroups }) => !isOfGroups) && "effect", rows.some(({ is_of_groups: isOfGroups }) => isOfGroups) && "groups"].filter(Boolean).join(" or ");
  const col = (text) => make("th", { scope: "col" }, text);
  const table = make("table", { class: "verdicts" }, make("thead", {}, make("tr", {}, col(`environment, ${what}`), col("mean and interval"), col("difference and verdict"))));
  const percent = `${Number((100 * study.level).toPrecision(6))} %`;
  const family = { metric: "all claims about a metric", environment: "all claims about a metric in an environment", study: "all claims about primary metrics, and about each other metric" }[study.families];
  const legend = make("p", { class: "caption" }, [
    rows.some(({ by }) => by === "jnd") && "Grey band: within ±1 just noticeable difference (JND), below what is felt.",
    rows.some(({ by }) => by === "sd") && `Standard deviations are those of ${what === "effect" ? "everybody’s effects" : what === "groups" ? "people within both groups" : "everybody’s effects, or of people within both groups"}.`,
    `Disc and whiskers: mean and ${percent} interval, not adjusted. Verdicts are adjusted for ${family}${study.metrics.some(({ differences }) => differences.length) ? ", differences between modes among them" : ""} (Holm).`,
  ].filter(Boolean).join(" "));
  const title = what === "effect" ? "Effects of factors" : what === "groups" ? "Differences between groups" : "Effects of factors, and differences between groups";
  host.style.marginTop = "2rem";
  host.replaceChildren(make("h3", {}, title), make("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": title }, table), legend);
  // The figure of all verdicts has these rows, too.
  for (const still of document.querySelectorAll("#verdicts > figure")) still.hidden = true;
  const draw = () => drawClaims(table, rows);
  draw();
  onWidth(host, draw);
  host.dataset.ready = "true";
}

buildClaims(byId("claims"));
