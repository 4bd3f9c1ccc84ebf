// @ts-check
/** The motion in time, as panels of curves over the phases. */

import { FONT, INK, html, legend, lineSample, numberText, svg, textWidth, ticks } from "./draw.js";

const SHADES = /** @type {Record<string, string>} */ ({ F: "#6699CC", B: "#EECC66", H: "#994455", h: "#994455" });
const HIGH = 104; // [px] of a panel
const [LEFT, RIGHT] = [58, 16];

/** @param {HTMLElement} place @param {HistoryAnswer} answer */
export function drawHistory(place, { header, arrays }) {
  if (!header.panels.length) return place.replaceChildren(html("p", {}, header.note ?? ""));
  const outer = place.clientWidth;
  const width = outer - LEFT - RIGHT;
  const picture = svg("svg", { role: "img", "aria-label": `Motion over ${numberText(header.duration_ms)} ms; ${header.settled}`, "font-family": FONT, "font-size": 12 });
  let top = 18;
  for (const { start, end, name } of header.phases) {
    if (textWidth(name, 12) < width * (end - start) - 4) {
      picture.append(svg("text", { x: LEFT + (width * (start + end)) / 2, y: 12, "text-anchor": "middle", fill: "currentColor" }, name));
    }
  }
  for (const panel of header.panels) {
    const items = panel.curves.map((c) => ({ sample: lineSample("currentColor", c.dash, c.width), text: c.label }));
    for (const [n, { sample }] of items.entries()) {
      sample.prepend(svg("rect", { y: 1, width: 24, height: 12, fill: "#FFFFFF" }));
      sample.lastElementChild?.setAttribute("stroke", panel.curves[n].colour);
    }
    const title = `${panel.label} [${panel.unit}]`;
    picture.append(svg("text", { x: LEFT, y: top + 14, fill: "currentColor", "font-weight": 600 }, title));
    const names = legend(items, LEFT, top + 22, width);
    picture.append(names.group, drawPanel(panel, header, arrays, top + 24 + names.height, width));
    top += 24 + names.height + HIGH + 12;
  }
  for (const value of ticks(0, header.duration_ms, false, Math.max(2, Math.floor(width / 80)))) {
    const x = LEFT + (width * value) / header.duration_ms;
    picture.append(svg("path", { d: `M${x} ${top - 12}v5`, stroke: "currentColor" }));
    picture.append(svg("text", { x, y: top + 6, "text-anchor": "middle", fill: "currentColor" }, numberText(value)));
  }
  picture.append(svg("text", { x: LEFT + width / 2, y: top + 25, "text-anchor": "middle", "font-size": 13, fill: "currentColor" }, "time [ms]"));
  for (const [name, value] of Object.entries({ width: outer, height: top + 32 })) picture.setAttribute(name, String(value));
  place.replaceChildren(picture, html("p", {}, header.settled));
}

/** @param {Panel} panel @param {HistoryHeader} header @param {Record<string, Numbers>} arrays @param {number} top @param {number} width */
function drawPanel({ curves }, header, arrays, top, width) {
  const lines = curves.flatMap((c) => (c.mirrored ? [1, -1] : [1]).map((sign) => ({ ...c, values: arrays[c.array].map((v) => sign * v) })));
  let [low, high] = [0, 0];
  for (const { values } of lines) {
    for (const v of values) [low, high] = [v < low ? v : low, v > high ? v : high];
  }
  const margin = 0.06 * (high - low || 1);
  [low, high] = [low - margin, high + margin];
  const y = (/** @type {number} */ value) => top + (HIGH * (high - value)) / (high - low);
  const group = svg("g", { fill: "none" }, svg("rect", { x: LEFT, y: top, width, height: HIGH, fill: "#FFFFFF" }));
  for (const { kind, start, end } of header.phases) {
    if (kind in SHADES) group.append(svg("rect", { x: LEFT + width * start, y: top, width: width * (end - start), height: HIGH, fill: SHADES[kind], "fill-opacity": 0.35 }));
  }
  for (const value of ticks(low, high, false, 4)) {
    group.append(svg("path", { d: `M${LEFT} ${y(value)}h-5`, stroke: "currentColor" }));
    group.append(svg("text", { x: LEFT - 8, y: y(value) + 4, "text-anchor": "end", fill: "currentColor" }, numberText(value)));
  }
  group.append(svg("path", { d: `M${LEFT} ${y(0)}h${width}`, stroke: INK, "stroke-width": 0.7 }));
  for (const { values, colour, dash, width: thick } of lines) {
    let d = "";
    values.forEach((v, n) => {
      if (!Number.isNaN(v)) d += `${!n || Number.isNaN(values[n - 1]) ? "M" : "L"}${(LEFT + (width * arrays.time[n]) / header.duration_ms).toFixed(1)} ${y(v).toFixed(1)}`;
    });
    group.append(svg("path", { d, stroke: colour, "stroke-width": thick, "stroke-dasharray": dash.join(" "), "stroke-linejoin": "round" }));
  }
  group.append(svg("rect", { x: LEFT, y: top, width, height: HIGH, stroke: "currentColor" }));
  return group;
}
