// Pens: the same calls draw on a canvas and write an SVG.

const FONT = "system-ui, -apple-system, 'Segoe UI', 'Noto Sans', 'Liberation Sans', sans-serif";

/** Whether no line goes on from the first point of one: a sample between missing ones is a dot. */
const isAlone = (points, i) => !(points[i + 2] === points[i + 2]) || i + 2 >= points.length;

function canvasPen(context) {
  const trace = (points) => {
    context.beginPath();
    for (let i = 0, down = false; i < points.length; i += 2) {
      if (points[i] !== points[i]) down = false;
      else if (down) context.lineTo(points[i], points[i + 1]);
      else { context.moveTo(points[i], points[i + 1]); down = true; if (isAlone(points, i)) context.lineTo(points[i] + 1, points[i + 1]); }
    }
  };
  return {
    line(points, { colour, width = 1, dash = [], opacity = 1 }) {
      Object.assign(context, { strokeStyle: colour, lineWidth: width, globalAlpha: opacity, lineJoin: "round" });
      context.setLineDash(dash);
      trace(points);
      context.stroke();
      context.globalAlpha = 1;
    },
    rect(x, y, width, height, { colour, opacity = 1 }) {
      Object.assign(context, { fillStyle: colour, globalAlpha: opacity });
      context.fillRect(x, y, width, height);
      context.globalAlpha = 1;
    },
    text(text, x, y, { colour, halo, size = 12, align = "start", bold = false }) {
      Object.assign(context, { font: `${bold ? 600 : 400} ${size}px ${FONT}`, textAlign: align, textBaseline: "middle", fillStyle: colour });
      if (halo) {
        Object.assign(context, { strokeStyle: halo, lineWidth: 4, lineJoin: "round" });
        context.setLineDash([]);
        context.strokeText(text, x, y);
      }
      context.fillText(text, x, y);
    },
    within({ x, y, width, height }, draw) {
      context.save();
      context.beginPath();
      context.rect(x, y, width, height);
      context.clip();
      draw();
      context.restore();
    },
  };
}

function svgPen(width, height, name) {
  const parts = [];
  const clips = [];
  const escape = (text) => (String(text).toWellFormed?.() ?? String(text)).replace(/[&<>"]/g, (character) => `&#${character.charCodeAt(0)};`).replace(/[\u0000-\u0008\u000b\u000c\u000e-\u001f]/g, "\ufffd");
  const n = (value) => String(Math.round(value * 100) / 100);
  return {
    line(points, { colour, width: stroke = 1, dash = [], opacity = 1 }) {
      let path = "";
      for (let i = 0, down = false; i < points.length; i += 2) {
        if (points[i] !== points[i]) { down = false; continue; }
        path += `${down ? "L" : "M"}${n(points[i])} ${n(points[i + 1])}${!down && isAlone(points, i) ? "h1" : ""}`;
        down = true;
      }
      parts.push(`<path d="${path}" fill="none" stroke="${colour}" stroke-width="${stroke}" stroke-linejoin="round"${dash.length ? ` stroke-dasharray="${dash}"` : ""}${opacity < 1 ? ` opacity="${opacity}"` : ""}/>`);
    },
    rect(x, y, w, h, { colour, opacity = 1 }) {
      parts.push(`<rect x="${n(x)}" y="${n(y)}" width="${n(w)}" height="${n(h)}" fill="${colour}" opacity="${opacity}"/>`);
    },
    text(text, x, y, { colour, halo, size = 12, align = "start", bold = false }) {
      const anchor = { start: "start", center: "middle", end: "end" }[align];
      parts.push(`<text x="${n(x)}" y="${n(y + 0.35 * size)}" font-size="${size}" text-anchor="${anchor}" fill="${colour}"${bold ? ' font-weight="600"' : ""}${halo ? ` stroke="${halo}" stroke-width="4" stroke-linejoin="round" paint-order="stroke"` : ""}>${escape(text)}</text>`);
    },
    within(box, draw) {
      clips.push(`<clipPath id="${name}-clip${clips.length}"><rect x="${box.x}" y="${box.y}" width="${box.width}" height="${box.height}"/></clipPath>`);
      parts.push(`<g clip-path="url(#${name}-clip${clips.length - 1})">`);
      draw();
      parts.push("</g>");
    },
    finish: () => `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}" font-family="${FONT}"><defs>${clips.join("")}</defs>${parts.join("")}</svg>\n`,
  };
}

const PAPER = 690; // width of a printed page, in CSS pixels
let printing = false;
const redraws = new Set(); // what is drawn anew for paper

/** Colours from the style sheet; `light` for paper, whatever the screen shows. */
function readTheme(light = false) {
  const probe = make("div", { class: light ? "light" : null, hidden: true });
  document.body.append(probe);
  const style = getComputedStyle(probe);
  const colour = (name) => style.getPropertyValue(name).trim();
  const theme = { ink: colour("--ink"), quiet: colour("--quiet"), grid: colour("--grid"), paper: colour("--paper"), mark: colour("--mark"), modes: study.modes.map((_, i) => colour(`--mode-${i % MODE_COLOURS}`)) };
  probe.remove();
  return theme;
}
