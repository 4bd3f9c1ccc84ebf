/** The map: a canvas of cells, and over it axes, curves, the operating point, and what they mean. */

import { OVER, looks, onScale, paint, picture, scaleColours } from "./cells.js";
import { FONT, INK, axisMarks, html, legend, marks, numberText, place, set, shareAt, sideLabel, svg, symbolText, textWidth, unitText } from "./draw.js";

const [STEP, LEAP] = [0.01, 0.1]; // of an axis, by an arrow key, and with Shift
const KEYS = /** @type {Record<string, number[]>} */ ({
  ArrowLeft: [-1, NaN], ArrowRight: [1, NaN], ArrowUp: [NaN, 1], ArrowDown: [NaN, -1],
});

/** A value at a share of an axis, in as many digits as a hand can set. @param {AxisInfo} axis @param {number} share */
function valueAt({ from, to, log }, share) {
  if (log) return Number((from * (to / from) ** share).toPrecision(4));
  return Number((from + (to - from) * share).toFixed(Math.min(Math.max(Math.ceil(3 - Math.log10(to - from)), 0), 12)));
}

const axisLabel = (/** @type {AxisInfo} */ axis) => `${axis.label} ${symbolText(axis.symbol)}${axis.unit && ` [${unitText(axis.unit)}]`}`;
const valueText = (/** @type {AxisInfo} */ axis, /** @type {number} */ v) => `${numberText(v, 5)} ${unitText(axis.unit)}`.trim();
const within = (/** @type {number} */ share) => Math.min(Math.max(share, 0), 1);

export class MapView {
  /**
   * @param {Schema} schema
   * @param {(column: string) => number} numberOf tells the operating point
   * @param {(patch: State, finished: boolean) => void} move told where a hand moves it
   */
  constructor(schema, numberOf, move) {
    this.schema = schema;
    this.numberOf = numberOf;
    this.move = move;
    this.stage = place("stage");
    this.canvas = /** @type {HTMLCanvasElement} */ (place("cells"));
    /** @type {MapAnswer | null} */
    this.map = null;
    /** @type {ReturnType<typeof looks> | null} */
    this.cells = null;
    this.at = [0, 0]; // the operating point: shares of the axes, perhaps outside of them
    this.box = { left: 58, top: 30, width: 1, height: 1 };
    this.dragging = false;
    this.frame = svg("g");
    this.point = svg("g", { class: "point", role: "slider", tabindex: 0, "aria-label": "operating point", "aria-describedby": "point-keys" },
      svg("circle", { class: "reach", r: 22, fill: "transparent" }), svg("circle", { class: "focus", r: 12, fill: "none" }),
      svg("circle", { r: 6.5, fill: "#FFFFFF", stroke: "#000000", "stroke-width": 3 }));
    this.surface = svg("rect", { class: "surface", fill: "transparent" });
    this.svg = svg("svg", { role: "group", "font-family": FONT, "font-size": 12 }, this.surface, this.frame, this.point);
    this.stage.append(this.svg);
    new ResizeObserver(() => this.draw()).observe(this.stage);
    this.listen();
  }

  /** @param {MapAnswer} map @param {boolean} target whether there is one */
  show(map, target) {
    [this.map, this.cells] = [map, looks(map, this.schema, target)];
    this.draw();
    place("notes").replaceChildren(...map.header.notes.map((note) => html("p", {}, note)));
  }

  draw() {
    if (!this.map || !this.cells) return;
    const { header } = this.map;
    const width = this.stage.clientWidth;
    const { left, top } = this.box;
    this.box.width = width - left - (header.scale ? 84 : 16);
    const room = window.innerHeight * (width < 600 ? 0.4 : 0.64);
    this.box.height = Math.round(Math.max(Math.min(0.75 * this.box.width, room), 180));
    const under = top + this.box.height;
    const names = legend(this.samples(), 12, under + 50, width - 24);
    const height = under + 50 + names.height;
    const name = header.title[0].toUpperCase() + header.title.slice(1);
    const both = [name, header.progress.text].filter(Boolean).join(" – ");
    const title = textWidth(both, 15) < this.box.width ? both : header.progress.text || name;
    const size = Math.min(14, (14 * this.box.width) / textWidth(title, 15));
    const area = { x: left, y: top, width: this.box.width, height: this.box.height };
    this.frame.replaceChildren(
      svg("text", { x: left, y: 18, "font-size": size, "font-weight": 600, fill: "currentColor" }, title),
      svg("rect", { ...area, fill: "none", stroke: "currentColor" }), 
      axisMarks(this.box, "below", header.x, axisLabel(header.x)), axisMarks(this.box, "left", header.y, axisLabel(header.y)),
      ...(header.scale ? this.bar(header.scale, header.label) : []), svg("svg", { ...area, class: "curves" }, ...this.curves()), names.group);
    set(this.svg, { width, height, viewBox: `0 0 ${width} ${height}` });
    set(this.svg, { "aria-label": `${name}, over ${axisLabel(header.x)} and ${axisLabel(header.y)}` });
    set(this.surface, area);
    const zoom = window.devicePixelRatio;
    [this.canvas.width, this.canvas.height] = [Math.round(area.width * zoom), Math.round(area.height * zoom)];
    Object.assign(this.canvas.style, { left: `${left}px`, top: `${top}px`, width: `${area.width}px`, height: `${area.height}px` });
    paint(this.canvas, zoom, this.cells);
    this.put();
  }

  /** The colour bar. @param {ScaleInfo} scale @param {string} label */
  bar(scale, label) {
    const box = { ...this.box, left: this.box.left + this.box.width + 14, width: 12 };
    const area = { x: box.left, y: box.top, width: box.width, height: box.height };
    return [
      svg("image", { ...area, href: picture(scaleColours(scale), 0, 1, 128), preserveAspectRatio: "none" }),
      svg("rect", { ...area, fill: "none", stroke: "currentColor" }),
      marks(box, "right", scale.ticks, (value) => onScale(scale, value)), sideLabel(box, "right", label),
    ];
  }

  curves() {
    const { header, arrays: { points } } = /** @type {MapAnswer} */ (this.map);
    const { width, height } = this.box;
    let at = 0;
    return header.curves.flatMap((curve) => {
      let d = "";
      for (const count of curve.pieces) {
        for (let n = 0; n < count; n++, at += 2) d += `${n ? "L" : "M"}${(points[at] * width).toFixed(1)} ${((1 - points[at + 1]) * height).toFixed(1)}`;
      }
      return this.line(d, curve);
    });
  }

  /** A curve; a halo parts it from the colours of numbers. @param {string} d @param {CurveInfo} curve */
  line(d, { name, colour, width, dash }) {
    const [ink, halo] = colour === "white" ? ["#FFFFFF", INK] : [INK, "#FFFFFF"];
    const under = { d, fill: "none", stroke: halo, "stroke-width": width + 1.7, "stroke-opacity": colour === "white" ? 1 : 0.7 };
    const line = svg("path", { d, fill: "none", stroke: ink, "stroke-width": width, "stroke-dasharray": dash.join(" "), "data-curve": name });
    return colour === "white" || this.map?.header.scale ? [svg("path", under), line] : [line];
  }

  samples() {
    const paper = { width: 24, height: 14, fill: "#FFFFFF" };
    const cells = (this.cells?.names ?? []).map(({ text, face, bit }) => {
      const edge = { x: 0.5, y: 0.5, width: 23, height: 13, fill: "none", stroke: "#777777" };
      return { text, sample: svg("g", {}, svg("image", { href: picture([face], bit), width: 24, height: 14 }), svg("rect", edge)) };
    });
    const curves = (this.map?.header.curves ?? []).map((c) => ({ text: c.label, sample: svg("g", {}, svg("rect", paper), ...this.line("M0 7H24", c)) }));
    const ring = svg("circle", { cx: 12, cy: 7, r: 4.5, fill: "#FFFFFF", stroke: "#000000", "stroke-width": 2.5 });
    return [...cells, ...curves, { text: "operating point", sample: svg("g", {}, svg("rect", paper), ring) }];
  }

  /** Put the operating point where the state has it. */
  put() {
    if (!this.map) return;
    const { x, y } = this.map.header;
    this.at = [x, y].map((axis) => shareAt(axis, this.numberOf(axis.column))).map((share) => (Number.isFinite(share) ? share : -1));
    const { left, top, width, height } = this.box;
    const [u, v] = this.at.map(within);
    const outside = this.at.some((share) => Math.abs(share - 0.5) > 0.5 + 1e-6);
    set(this.point, {
      transform: `translate(${left + width * u} ${top + height * (1 - v)})`, "stroke-dasharray": outside ? "3 2.5" : "none",
      "aria-valuenow": Math.round(100 * u), "aria-valuetext": [x, y].map((axis) => `${axis.label} ${valueText(axis, this.numberOf(axis.column))}`).join(", "),
    });
    place("outside").hidden = !outside;
  }

  listen() {
    const share = (/** @type {PointerEvent} */ event) => {
      const area = this.canvas.getBoundingClientRect();
      return [within((event.clientX - area.left) / area.width), within(1 - (event.clientY - area.top) / area.height)];
    };
    const isOver = (/** @type {PointerEvent} */ { target }) => target === this.surface || this.point.contains(/** @type {Node} */ (target));
    this.svg.addEventListener("pointerdown", (event) => {
      if (!isOver(event) || event.button) return;
      this.svg.setPointerCapture(event.pointerId);
      this.dragging = true;
      if (event.target === this.surface) this.moveTo(share(event));
      this.hover(event, share(event));
    });
    this.svg.addEventListener("pointermove", (event) => {
      if (this.dragging) this.moveTo(share(event));
      if (this.dragging || isOver(event)) this.hover(event, share(event));
      else place("tip").hidden = true;
    });
    for (const end of /** @type {const} */ (["pointerup", "pointercancel"])) this.svg.addEventListener(end, () => {
      if (!this.dragging) return;
      this.dragging = false;
      this.move({}, true);
    });
    this.svg.addEventListener("pointerleave", () => (place("tip").hidden = true));
    document.addEventListener("keydown", ({ key }) => key === "Escape" && (place("tip").hidden = true));
    this.point.addEventListener("keydown", (event) => {
      if (!(event.key in KEYS) || event.ctrlKey || event.altKey || event.metaKey) return;
      event.preventDefault();
      this.moveTo(KEYS[event.key].map((way, n) => within(this.at[n] + way * (event.shiftKey ? LEAP : STEP))));
    });
    this.point.addEventListener("keyup", ({ key }) => key in KEYS && this.move({}, true));
  }

  /** Move the point to shares of the axes; NaN leaves a coordinate as it is. @param {number[]} shares */
  moveTo(shares) {
    if (!this.map) return;
    const { x, y } = this.map.header;
    const moved = [x, y].map((axis, n) => [axis.column, String(valueAt(axis, shares[n]))]);
    this.move(Object.fromEntries(moved.filter((_, n) => !Number.isNaN(shares[n]))), false);
  }

  /** Tell the numbers of the cell under a pointer. @param {PointerEvent} event @param {number[]} shares */
  hover({ clientX, clientY }, [u, v]) {
    if (!this.map) return;
    const { header: { x, y, bands, view, label }, arrays } = this.map;
    const [i, j] = [Math.round(u * (x.count - 1)), Math.round(v * (y.count - 1))];
    const cell = j * x.count + i;
    const { message = "", code = 0 } = this.schema.statuses.find((s) => s.code === arrays.status[cell]) ?? {};
    const regime = (/** @type {Numbers} */ codes) => this.schema.regimes.find((r) => r.code === codes[cell])?.label ?? "";
    const number = (/** @type {Numbers | undefined} */ values) => (!values || Number.isNaN(values[cell]) ? "" : numberText(values[cell]));
    const differ = bands && arrays.lowest[cell] !== arrays.highest[cell];
    const mark = arrays.marks[cell];
    const rows = [
      [x.label, valueText(x, valueAt(x, i / (x.count - 1)))], [y.label, valueText(y, valueAt(y, j / (y.count - 1)))],
      ["regime", differ ? `${regime(arrays.lowest)} to ${regime(arrays.highest)}` : regime(arrays.regime)],
      ["mean speed", number(arrays.speed) && `${number(arrays.speed)} mm/s`], [label, view === "speed" && !bands ? "" : number(arrays.values)],
      ["", mark & OVER.missing ? "not computed yet" : mark & OVER.preview ? "preview, not exact yet" : ""], ["", code ? message : ""],
    ];
    const tip = place("tip");
    tip.replaceChildren(...rows.filter(([, text]) => text).map(([name, text]) => html("div", {}, html("span", {}, name), html("b", {}, text))));
    tip.hidden = false;
    const area = this.stage.getBoundingClientRect();
    const [px, py] = [clientX - area.left, clientY - area.top];
    const before = px + 24 + tip.offsetWidth > area.width ? px - 16 - tip.offsetWidth : px + 16;
    Object.assign(tip.style, { left: `${Math.max(before, 0)}px`, top: `${Math.max(Math.min(py + 12, area.height - tip.offsetHeight), 0)}px` });
  }
}
