/** The motion in time: panels of curves over the phases. */

import { INK, axis, curve, html, legend, place, plot, set, svg, textWidth, way } from "./draw.js";

const UNIT = 88; // [px] of a panel whose height is 1
const [LEFT, RIGHT] = [58, 16]; // [px] beside the panels

/** What fills the box of a panel. @param {Panel} panel @param {Box} box @param {HistoryAnswer} answer */
function drawPanel({ low, high, ticks, curves }, box, { header, arrays: { time, ...arrays } }) {
  const share = (/** @type {number} */ value) => (value - low) / (high - low);
  const shades = header.phases.map(({ colour, start, end }) =>
    svg("rect", { x: 1000 * start, width: 1000 * (end - start), height: 1000, fill: colour, "fill-opacity": 0.35 }));
  const zero = curve(way(2, (n) => [n, share(0)]), { colour: INK, width: 0.7, dash: [] });
  const lines = curves.map((c) =>
    curve(way(time.length, (n) => [time[n] / header.duration_ms, share(arrays[c.array][n])]), c));
  return [plot(box, {}, svg("rect", { width: 1000, height: 1000, fill: "#FFFFFF" }), ...shades, zero, ...lines),
    axis(box, "left", ticks)];
}

/** @param {HistoryAnswer} answer */
export function drawHistory(answer) {
  const { header: { title, phases, panels, ticks, note } } = answer;
  const wide = Math.max(place("history").clientWidth, LEFT + RIGHT); // 0 before the page is laid out
  const box = { left: LEFT, top: 0, width: wide - LEFT - RIGHT, height: 0 };
  const picture = svg("svg", { role: "img", "aria-label": title, "font-size": 12 });
  for (const { name, start, end } of phases.filter((p) => textWidth(p.name) < box.width * (p.end - p.start) - 4)) {
    const x = LEFT + (box.width * (start + end)) / 2;
    picture.append(svg("text", { x, y: 12, "text-anchor": "middle", fill: "currentColor" }, name));
  }
  for (const panel of panels) {
    const samples = panel.curves.filter((c) => c.label).map((c) => ({ text: c.label, sample: [curve("M0 7H24", c)] }));
    const names = legend(samples, LEFT, box.top + 42, box.width);
    picture.append(svg("text", { x: LEFT, y: box.top + 34, "font-weight": 600, fill: "currentColor" }, panel.title));
    box.top += 42 + names.height;
    box.height = UNIT * panel.height;
    picture.append(names.group, ...drawPanel(panel, box, answer));
    box.top += box.height - 10;
  }
  if (panels.length) picture.append(axis({ ...box, height: 10 }, "below", ticks, "time [ms]"));
  set(picture, { width: wide, height: box.top + 54 });
  place("history").replaceChildren(...(panels.length ? [picture] : []), html("p", {}, note));
}
