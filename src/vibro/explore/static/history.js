/** The motion in time: panels of curves over the phases. */

import { FONT, INK, axisMarks, html, legend, set, svg, textWidth } from "./draw.js";

const UNIT = 88; // [px] of a panel whose height is 1
const LEFT = 58;

/** @param {HTMLElement} place @param {HistoryAnswer} answer */
export function drawHistory(place, { header, arrays }) {
  const width = place.clientWidth - LEFT - 16;
  const span = { from: 0, to: header.duration_ms, log: false };
  const picture = svg("svg", { role: "img", "aria-label": header.title, "font-family": FONT, "font-size": 12 });
  const box = { left: LEFT, top: 0, width, height: UNIT };
  const phases = header.phases.map((p) => ({ ...p, x: LEFT + width * p.start, wide: width * (p.end - p.start) }));
  for (const { name, x, wide } of phases.filter((p) => textWidth(p.name) < p.wide - 4)) {
    picture.append(svg("text", { x: x + wide / 2, y: 12, "text-anchor": "middle", fill: "currentColor" }, name));
  }
  for (const { label, unit, curves, height, most } of header.panels) {
    const title = { x: LEFT, y: box.top + 34, "font-weight": 600, fill: "currentColor" };
    const lines = curves.map((c) => {
      const look = { stroke: c.colour, "stroke-width": c.width, "stroke-dasharray": c.dash.join(" "), fill: "none" };
      const sides = (c.mirrored ? [1, -1] : [1]).map((sign) => arrays[c.array].map((v) => sign * v));
      return { look, sides, text: c.label };
    });
    const paper = { y: 1, width: 24, height: 12, fill: "#FFFFFF" };
    const samples = lines.map(({ look, text }) => {
      return { text, sample: svg("g", {}, svg("rect", paper), svg("path", { d: "M0 7H24", ...look })) };
    });
    const names = legend(samples.filter(({ text }) => text), LEFT, box.top + 42, width);
    box.top += 42 + names.height;
    box.height = UNIT * height;
    const known = lines.flatMap(({ sides }) => sides.flatMap((side) => [...side].filter((v) => !Number.isNaN(v))));
    const [low, high] = [Math.max(Math.min(0, ...known), -(most ?? Infinity)), Math.min(Math.max(0, ...known), most ?? Infinity)];
    const margin = 0.06 * (high - low || 1);
    const y = (/** @type {number} */ v) => box.top + (box.height * (high + margin - v)) / (high - low + 2 * margin);
    const area = { x: LEFT, y: box.top, width, height: box.height };
    const shades = phases.map(({ colour, x, wide }) => svg("rect", { ...area, x, width: wide, fill: colour, "fill-opacity": 0.35 }));
    const zero = svg("path", { d: `M${LEFT} ${y(0)}h${width}`, stroke: INK, "stroke-width": 0.7 });
    const drawn = lines.flatMap(({ look, sides }) => sides.map((side) => {
      let d = "";
      side.forEach((v, n) => {
        const pen = n && !Number.isNaN(side[n - 1]) ? "L" : "M";
        if (!Number.isNaN(v)) d += `${pen}${(LEFT + (width * arrays.time[n]) / span.to).toFixed(1)} ${y(v).toFixed(1)}`;
      });
      return svg("path", { d, ...look, transform: `translate(0 ${-box.top})` });
    }));
    const paths = svg("svg", area, svg("g", { transform: `translate(${-LEFT} 0)` }, ...drawn)); // cut at its edges
    picture.append(svg("text", title, unit ? `${label} [${unit}]` : label), names.group, svg("rect", { ...area, fill: "#FFFFFF" }),
      ...shades, zero, paths, svg("rect", { ...area, fill: "none", stroke: "currentColor" }),
      axisMarks(box, "left", { from: low - margin, to: high + margin, log: false }));
    box.top += box.height - 10;
  }
  picture.append(axisMarks({ ...box, top: box.top + 10 - box.height }, "below", span, "time [ms]"));
  set(picture, { width: place.clientWidth, height: box.top + 54 });
  place.replaceChildren(...(header.panels.length ? [picture] : []), html("p", {}, header.note));
}
