// @ts-check
/** The map: a canvas of cells, and over it axes, curves, the operating point, and what they mean. */

import { MARK, OVER, looks, onScale, paint, picture, pixel, scaleColours } from "./cells.js";
import { FONT, INK, byId, html, legend, lineSample, numberText, svg, textWidth, ticks } from "./draw.js";

const STEP = 0.01; // of an axis, by an arrow key
const LEAP = 0.1; // with Shift
const OVERLAYS = /** @type {[number, string][]} */ ([
  [MARK.backwards, "moves backwards"], [MARK.averaged, "mean of motion without a short period"],
  [MARK.coexists, "another motion exists"], [MARK.preview, "preview, not exact yet"],
  [MARK.missing, "not computed yet"], [OVER.either, "either regime, as friction may be"],
  [OVER.veil, "does not meet the target"],
]);

/** A value at a share of an axis, in as many digits as a hand can set. @param {AxisInfo} axis @param {number} share */
export function valueAt({ from, to, log }, share) {
  if (log) return Number((from * (to / from) ** share).toPrecision(4));
  const digits = Math.min(Math.max(Math.ceil(3 - Math.log10(to - from)), 0), 12);
  return Number((from + (to - from) * share).toFixed(digits));
}

/** @param {AxisInfo} axis @param {number} value */
function shareAt({ from, to, log }, value) {
  return log ? Math.log(value / from) / Math.log(to / from) : (value - from) / (to - from);
}

/** @param {AxisInfo} axis */
const axisLabel = ({ label, symbol, unit }) => `${label} ${symbol}${unit ? ` [${unit}]` : ""}`;
/** @param {AxisInfo} axis @param {number} value */
const valueText = ({ unit }, value) => numberText(value, 5) + (unit && unit !== "°" ? ` ${unit}` : unit);
const clamp = (/** @type {number} */ share) => Math.min(Math.max(share, 0), 1);

export class MapView {
  /** @param {(patch: State, finished: boolean) => void} move told of the point that a hand moves */
  constructor(move) {
    this.move = move;
    this.stage = byId("stage", HTMLElement);
    this.canvas = byId("cells", HTMLCanvasElement);
    this.tip = byId("tip", HTMLElement);
    /** @type {MapAnswer | null} */
    this.map = null;
    /** @type {ReturnType<typeof looks> | null} */
    this.cells = null;
    this.at = [NaN, NaN]; // the operating point: shares of the axes
    this.box = { left: 0, top: 0, width: 1, height: 1 };
    this.dragging = false;
    this.frame = svg("g");
    this.point = svg("g", { class: "point", role: "slider", tabindex: 0, "aria-label": "operating point", "aria-roledescription": "point on the map",
      "aria-describedby": "point-keys", "aria-valuemin": 0, "aria-valuemax": 100 },
      svg("circle", { class: "reach", r: 22, fill: "transparent" }),
      svg("circle", { class: "focus", r: 12, fill: "none" }),
      svg("circle", { r: 6.5, fill: "#FFFFFF", stroke: "#000000", "stroke-width": 3 }));
    this.surface = svg("rect", { class: "surface", fill: "transparent" });
    this.svg = svg("svg", { role: "group", "font-family": FONT, "font-size": 12 }, this.surface, this.frame, this.point);
    this.stage.append(this.svg);
    new ResizeObserver(() => this.draw()).observe(this.stage);
    this.listen();
  }

  /** @param {MapAnswer} map */
  show(map) {
    this.map = map;
    this.cells = looks(map);
    this.draw();
    byId("notes", HTMLElement).replaceChildren(...map.header.notes.map((note) => html("p", {}, note)));
  }

  draw() {
    if (!this.map || !this.cells || !this.stage.clientWidth) return;
    const { header } = this.map;
    const width = this.stage.clientWidth;
    const [left, right] = [58, header.scale ? 84 : 16];
    const box = (this.box = { left, top: 30, width: width - left - right, height: 0 });
    const room = window.innerHeight * (width < 600 ? 0.4 : 0.64);
    box.height = Math.round(Math.max(Math.min(0.75 * box.width, room), 180));
    const under = box.top + box.height;
    const names = legend(this.legendItems(), 12, under + 50, width - 24);
    const height = under + 50 + names.height;
    const title = textWidth(header.title, 14) < width - 24 ? header.title : (header.title.split(" – ")[0]);
    this.frame.replaceChildren(
      svg("text", { x: left, y: 18, "font-size": 14, "font-weight": 600, fill: "currentColor" }, title),
      this.axes(header), this.bar(header), this.curves(header), this.progress(header), names.group);
    for (const [name, value] of Object.entries({ width, height, viewBox: `0 0 ${width} ${height}` })) this.svg.setAttribute(name, String(value));
    this.svg.setAttribute("aria-label", `Map: ${header.title}, over ${axisLabel(header.x)} and ${axisLabel(header.y)}`);
    for (const [name, value] of Object.entries({ x: left, y: box.top, width: box.width, height: box.height })) this.surface.setAttribute(name, String(value));
    const zoom = window.devicePixelRatio;
    [this.canvas.width, this.canvas.height] = [Math.round(box.width * zoom), Math.round(box.height * zoom)];
    Object.assign(this.canvas.style, { left: `${left}px`, top: `${box.top}px`, width: `${box.width}px`, height: `${box.height}px` });
    paint(this.canvas, zoom, this.cells, header.x.count, header.y.count);
    this.putPoint();
  }

  /** @param {MapHeader} header */
  axes({ x, y }) {
    const { left, top, width, height } = this.box;
    const group = svg("g", { stroke: "currentColor", fill: "none" }, svg("rect", { x: left, y: top, width, height }));
    const words = svg("g", { fill: "currentColor" });
    for (const value of ticks(x.from, x.to, x.log, Math.max(2, Math.floor(width / 80)))) {
      const at = left + width * shareAt(x, value);
      group.append(svg("path", { d: `M${at} ${top + height}v5` }));
      words.append(svg("text", { x: at, y: top + height + 18, "text-anchor": "middle" }, numberText(value)));
    }
    for (const value of ticks(y.from, y.to, y.log, Math.max(2, Math.floor(height / 55)))) {
      const at = top + height * (1 - shareAt(y, value));
      group.append(svg("path", { d: `M${left} ${at}h-5` }));
      words.append(svg("text", { x: left - 8, y: at + 4, "text-anchor": "end" }, numberText(value)));
    }
    words.append(
      svg("text", { x: left + width / 2, y: top + height + 37, "text-anchor": "middle", "font-size": 13 }, axisLabel(x)),
      svg("text", { transform: `translate(14 ${top + height / 2}) rotate(-90)`, "text-anchor": "middle", "font-size": 13 }, axisLabel(y)));
    return svg("g", {}, group, words);
  }

  /** The colour bar. @param {MapHeader} header */
  bar({ scale, label }) {
    if (!scale) return svg("g");
    const { left, top, width, height } = this.box;
    const x = left + width + 14;
    const href = picture([...scaleColours(scale)], 0, 0, 1, 128);
    const group = svg("g", { fill: "currentColor" },
      svg("image", { href, x, y: top, width: 12, height, preserveAspectRatio: "none" }),
      svg("rect", { x, y: top, width: 12, height, fill: "none", stroke: "currentColor" }),
      svg("text", { transform: `translate(${left + width + 78} ${top + height / 2}) rotate(-90)`, "text-anchor": "middle", "font-size": 13 }, label));
    for (const value of scale.ticks) {
      const at = top + height * (1 - onScale(scale, value));
      group.append(svg("path", { d: `M${x + 12} ${at}h4`, stroke: "currentColor" }), svg("text", { x: x + 19, y: at + 4 }, numberText(value)));
    }
    return group;
  }

  /** @param {MapHeader} header */
  curves({ curves, scale }) {
    const { left, top, width, height } = this.box;
    const points = this.map?.arrays.points ?? [];
    const group = svg("svg", { x: left, y: top, width, height, fill: "none", "stroke-linejoin": "round" });
    let at = 0;
    for (const curve of curves) {
      let d = "";
      for (const count of curve.pieces) {
        for (let n = 0; n < count; n++, at += 2) d += `${n ? "L" : "M"}${(points[at] * width).toFixed(1)} ${((1 - points[at + 1]) * height).toFixed(1)}`;
      }
      const white = curve.colour === "white";
      if (white || scale) group.append(svg("path", { d, stroke: white ? INK : "#FFFFFF", "stroke-width": curve.width + 1.6, "stroke-opacity": white ? 1 : 0.7 }));
      group.append(svg("path", { d, stroke: white ? "#FFFFFF" : INK, "stroke-width": curve.width, "stroke-dasharray": curve.dash.join(" "), "data-curve": curve.name }));
    }
    return group;
  }

  /** A plate on the map while it is not exact everywhere. @param {MapHeader} header */
  progress({ progress }) {
    if (!progress.text) return svg("g");
    const wide = textWidth(progress.text, 12) + 16;
    const x = this.box.left + this.box.width - wide - 8;
    return svg("g", { class: "progress" },
      svg("rect", { x, y: this.box.top + 8, width: wide, height: 22, rx: 4, fill: "#FFFFFF", stroke: INK, "stroke-width": 0.75 }),
      svg("text", { x: x + 8, y: this.box.top + 23, fill: INK }, progress.text));
  }

  legendItems() {
    const { header, arrays } = /** @type {MapAnswer} */ (this.map);
    const { over } = /** @type {ReturnType<typeof looks>} */ (this.cells);
    const regimes = new Set(header.bands && !header.scale ? [...arrays.lowest, ...arrays.highest] : arrays.regime);
    const statuses = new Set(arrays.status);
    const seen = over.reduce((all, bits) => all | bits, 0);
    const sample = (/** @type {number} */ bits, face = 0xffffffff, second = 0xff994444) =>
      svg("g", {}, svg("image", { href: picture([face], bits, second), width: 24, height: 14 }),
        svg("rect", { x: 0.5, y: 0.5, width: 23, height: 13, fill: "none", stroke: "#777777" }));
    const items = header.regimes
      .filter(({ code }) => regimes.has(code) && (!header.scale || code === 0))
      .map(({ label, colour }) => ({ sample: sample(0, pixel(colour)), text: label }));
    for (const { code, label, hatch } of header.statuses) {
      const bit = OVER[/** @type {keyof typeof OVER} */ (hatch)] ?? 0;
      if (seen & bit && statuses.has(code)) items.push({ sample: sample(bit, 0xffe9e9e9), text: label.replaceAll("-", " ") });
    }
    const [, forward, back] = header.regimes.map((r) => pixel(r.colour));
    for (const [bit, text] of OVERLAYS) {
      const face = bit & (MARK.preview | OVER.veil) ? 0xff666666 : bit === MARK.missing ? 0xffe9e9e9 : bit === OVER.either ? forward : 0xffffffff;
      if (seen & bit) items.push({ sample: sample(bit, face, back), text });
    }
    for (const { label, dash, width, colour, pieces } of header.curves) {
      const line = lineSample("currentColor", dash, width);
      if (colour === "white") line.append(svg("path", { d: "M0 7H24", stroke: "#FFFFFF", "stroke-width": 1.2 * width }));
      if (colour === "white") line.firstElementChild?.setAttribute("stroke-width", String(width + 3));
      if (pieces.length) items.push({ sample: line, text: label });
    }
    const ring = svg("g", {}, svg("circle", { cx: 12, cy: 7, r: 4.5, fill: "#FFFFFF", stroke: "#000000", "stroke-width": 2.5 }));
    return [...items, { sample: ring, text: "operating point" }];
  }

  /** Put the operating point where a state has it. @param {State} state */
  place(state) {
    if (!this.map) return;
    const { x, y } = this.map.header;
    this.at = [x, y].map((axis) => shareAt(axis, Number(state[axis.column])));
    const texts = [x, y].map((axis) => `${axis.label} ${valueText(axis, Number(state[axis.column]))}`);
    this.point.setAttribute("aria-valuetext", texts.join(", "));
    this.point.setAttribute("aria-valuenow", String(Math.round(100 * clamp(this.at[0] || 0))));
    this.putPoint();
  }

  putPoint() {
    const [u, v] = this.at.map((share) => (Number.isNaN(share) ? -1 : share));
    const outside = [u, v].some((share) => share < -1e-6 || share > 1 + 1e-6);
    const { left, top, width, height } = this.box;
    this.point.setAttribute("transform", `translate(${left + width * clamp(u)} ${top + height * (1 - clamp(v))})`);
    this.point.classList.toggle("outside", outside);
    this.point.lastElementChild?.setAttribute("stroke-dasharray", outside ? "3 2.5" : "none");
    byId("outside", HTMLElement).hidden = !outside;
  }

  listen() {
    const share = (/** @type {PointerEvent | MouseEvent} */ event) => {
      const place = this.canvas.getBoundingClientRect();
      return [clamp((event.clientX - place.left) / place.width), clamp(1 - (event.clientY - place.top) / place.height)];
    };
    const over = (/** @type {EventTarget | null} */ target) => target instanceof Node && (target === this.surface || this.point.contains(target));
    this.svg.addEventListener("pointerdown", (event) => {
      if (!over(event.target) || event.button !== 0) return;
      // A finger that starts beside the point scrolls the page, or taps; on the point it drags.
      if (event.pointerType === "touch" && event.target === this.surface) return;
      this.svg.setPointerCapture(event.pointerId);
      this.dragging = true;
      this.tip.hidden = true;
      if (event.target === this.surface) this.moveTo(...share(event));
    });
    this.svg.addEventListener("pointermove", (event) => {
      if (this.dragging) this.moveTo(...share(event));
      else if (over(event.target)) this.hover(event, share(event));
      else this.tip.hidden = true;
    });
    const stop = () => {
      const dragged = this.dragging;
      this.dragging = false;
      if (dragged) this.moveTo(NaN, NaN, true);
    };
    this.svg.addEventListener("pointerup", stop);
    this.svg.addEventListener("pointercancel", stop);
    this.svg.addEventListener("pointerleave", () => (this.tip.hidden = true));
    this.svg.addEventListener("click", (event) => {
      if (/** @type {PointerEvent} */ (event).pointerType !== "touch" || event.target !== this.surface) return;
      this.moveTo(...share(event), true);
      this.hover(event, share(event));
    });
    document.addEventListener("keydown", (event) => event.key === "Escape" && (this.tip.hidden = true));
    const keys = /** @type {Record<string, [number, number]>} */ ({ ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] });
    const point = /** @type {SVGGElement} */ (this.point);
    point.addEventListener("keydown", (event) => {
      if (!(event.key in keys) || event.ctrlKey || event.altKey || event.metaKey) return;
      event.preventDefault();
      const size = event.shiftKey ? LEAP : STEP;
      const [u, v] = keys[event.key].map((way, n) => (way ? clamp((this.at[n] || 0) + way * size) : NaN));
      this.moveTo(u, v);
    });
    point.addEventListener("keyup", ({ key }) => key in keys && this.moveTo(NaN, NaN, true));
  }

  /** Move the point to shares of the axes; NaN leaves a coordinate as it is. */
  moveTo(u = NaN, v = NaN, finished = false) {
    if (!this.map) return;
    const { x, y } = this.map.header;
    /** @type {State} */
    const patch = {};
    if (!Number.isNaN(u)) patch[x.column] = String(valueAt(x, u));
    if (!Number.isNaN(v)) patch[y.column] = String(valueAt(y, v));
    this.move(patch, finished);
  }

  /** Show the numbers of the cell under a pointer. @param {MouseEvent} event @param {number[]} at */
  hover(event, [u, v]) {
    if (!this.map) return;
    const { header, arrays } = this.map;
    const { x, y } = header;
    const [i, j] = [Math.round(u * (x.count - 1)), Math.round(v * (y.count - 1))];
    const cell = j * x.count + i;
    const status = header.statuses.find((s) => s.code === arrays.status[cell]);
    const name = (/** @type {Numbers} */ codes) => header.regimes.find((r) => r.code === codes[cell])?.label ?? "";
    const number = (/** @type {Numbers} */ values) => (Number.isNaN(values[cell]) ? "" : numberText(values[cell]));
    const doubtful = header.bands && arrays.lowest[cell] !== arrays.highest[cell];
    const rows = [
      [x.label, valueText(x, valueAt(x, i / (x.count - 1)))], [y.label, valueText(y, valueAt(y, j / (y.count - 1)))],
      ["regime", doubtful ? `${name(arrays.lowest)} to ${name(arrays.highest)}` : name(arrays.regime)],
      ["mean speed", number(arrays.speed) && `${number(arrays.speed)} mm/s`],
      ...(arrays.values && header.view !== "speed" ? [[header.label, number(arrays.values)]] : []),
      ["", arrays.marks[cell] & MARK.missing ? "not computed yet" : arrays.marks[cell] & MARK.preview ? "preview, not exact yet" : ""],
      ["", status && status.code ? status.message : ""],
    ];
    this.tip.replaceChildren(...rows.filter(([, text]) => text).map(([term, text]) => html("div", {}, html("span", {}, term), html("b", {}, text))));
    this.tip.hidden = false;
    const place = this.stage.getBoundingClientRect();
    const [px, py] = [event.clientX - place.left, event.clientY - place.top];
    const flip = px + 24 + this.tip.offsetWidth > place.width;
    this.tip.style.left = `${Math.max(flip ? px - 16 - this.tip.offsetWidth : px + 16, 0)}px`;
    this.tip.style.top = `${Math.max(Math.min(py + 12, place.height - this.tip.offsetHeight), 0)}px`;
  }
}
