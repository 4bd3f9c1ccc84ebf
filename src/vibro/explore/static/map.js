/** The map: a canvas of cells, and over it axes, curves, the operating point, and what they mean. */

import { colours, paint, picture, piecesOf } from "./cells.js";
import { axis, curve, html, legend, place, plot, set, shape, svg, valueText, way } from "./draw.js";
import { drawnMap, tipRows } from "./fields.js";
import { MAP_HEIGHT, MAP_WIDTH, jobOf, shareOf } from "./jobs.js";
import { Pool, solveMap, solverWorkers } from "./pool.js";

const [STEP, LEAP] = [0.01, 0.1]; // of an axis, by an arrow key, and with Shift
/** @type {Record<string, number[]>} */
const KEYS = { ArrowLeft: [-1, NaN], ArrowRight: [1, NaN], ArrowUp: [NaN, 1], ArrowDown: [NaN, -1] };

/** @typedef {import("./state.js").Shown} Shown @typedef {import("./state.js").Axis} Axis
 * @typedef {import("./fields.js").DrawnMap} DrawnMap @typedef {import("./fields.js").CurveInfo} CurveInfo
 * @typedef {import("./fields.js").Scale} Scale @typedef {import("./cells.js").Cells} Cells */

/** A value at a share of an axis, in as many digits as a hand can set. @param {Axis} axis @param {number} share */
function valueAt({ from, to, log }, share) {
  if (log) return Number((from * (to / from) ** share).toPrecision(4));
  const digits = Math.ceil(3 - Math.log10(to - from));
  return Number((from + (to - from) * share).toFixed(Math.min(Math.max(digits, 0), 12)));
}

/** Where a value lies on an axis, 0 to 1; beyond where it cannot. @param {Axis} axis @param {number} value */
function placeOn(axis, value) {
  const share = shareOf(axis, value);
  return Number.isFinite(share) ? share : -1;
}

/** @param {string[]} values */
const pointText = (values) => `operating point: ${values.join(", ")}`;
const within = (/** @type {number} */ share) => Math.min(Math.max(share, 0), 1);

/** A curve; a halo parts it from the colours of cells. @param {string} d @param {CurveInfo} info */
function curveLine(d, info) {
  const under = { ...info, colour: info.halo, width: info.width + 1.7, dash: [] };
  const halo = info.halo ? [curve(d, under, { "stroke-opacity": 0.8 })] : [];
  return [...halo, curve(d, info, { "data-curve": info.name })];
}

/** @typedef {(patch: Record<string, string>, isFinished: boolean) => void} Move */
export class MapView {
  // value gives a number of the operating point; move is called while a hand moves it.
  /** @param {any} data @param {{value: (name: string) => number, move: Move}} page */
  constructor(data, { value, move }) {
    this.data = data;
    this.value = value;
    this.move = move;
    this.pool = new Pool(data, solverWorkers(data));
    this.state = /** @type {Shown | null} */ (null);
    this.solving = Promise.resolve(false); // whether all cells are there, once that is known
    this.cells = /** @type {import("./jobs.js").MapCells | null} */ (null);
    this.drawn = /** @type {DrawnMap | null} */ (null);
    this.faces = /** @type {Cells | null} */ (null);
    this.keys = { asked: "", solved: "", drawn: "" }; // what decides the cells asked for, those there, and the picture
    this.stage = place("stage");
    this.canvas = /** @type {HTMLCanvasElement} */ (place("cells"));
    this.svg = shape("map");
    this.surface = shape("surface");
    this.point = shape("point");
    this.at = [0, 0]; // the operating point: shares of the axes, perhaps outside of them
    this.box = { left: 58, top: 30, width: 1, height: 1 };
    this.sign = /** @type {Element | null} */ (null); // the operating point's values as a text
    this.dragging = false;
    this.pointer = /** @type {PointerEvent | null} */ (null); // the last event of one that is over the map
    this.wide = 0; // [px] of the stage as it was drawn: the map itself decides on its height
    new ResizeObserver(() => this.stage.clientWidth !== this.wide && this.draw()).observe(this.stage);
    this.listen();
  }

  /** Show the map of a state: solve it, unless its cells are there, and draw what has changed. @param {Shown} state */
  show(state) {
    const before = this.state;
    this.state = state;
    const asked = JSON.stringify(jobOf(state, MAP_WIDTH, MAP_HEIGHT));
    if (asked !== this.keys.asked) {
      this.keys.asked = asked;
      this.stage.classList.add("waiting");
      const axesOf = (/** @type {Shown | null} */ of) => JSON.stringify(of && [of.scene, of.drive, of.x, of.y]);
      if (axesOf(before) !== axesOf(state)) this.clear();
      this.solving = solveMap(this.pool, state, (cells) => {
        [this.cells, this.keys.solved, this.keys.drawn] = [cells, asked, ""];
        this.picture();
      });
    }
    this.picture();
    this.put();
  }

  /** Take away a map of other axes, on which a hand would move this scene's point. */
  clear() {
    this.drawn = this.faces = null;
    this.canvas.getContext("2d")?.clearRect(0, 0, this.canvas.width, this.canvas.height);
    shape("frame").replaceChildren(svg("text", { x: this.box.left, y: 18, fill: "currentColor" }, "solving the map …"));
    place("notes").replaceChildren();
    set(this.point, { transform: "translate(-99 -99)" });
    this.hover();
  }

  /** Give up what is being solved. */
  cancel() {
    this.pool.cancel();
    this.keys.asked = this.keys.solved;
  }

  /** Draw the cells that are there as the state wants to see them, unless they are drawn so. */
  picture() {
    const { cells, data, keys, state } = this;
    if (!cells || !state || keys.solved !== keys.asked) return;
    const { view, target, values: { trough_length: length }, bands } = state;
    const drawn = JSON.stringify([view, target, length, bands]);
    if (drawn === keys.drawn) return;
    keys.drawn = drawn;
    this.stage.classList.remove("waiting");
    const { looks } = data, map = drawnMap(data, state, cells);
    const palette = [looks.palettes.plain, ...(map.scale ? [looks.palettes[map.scale.palette]] : [])].map(colours);
    this.drawn = map;
    this.faces = {
      palette: Uint32Array.from(palette.flatMap((part) => [...part])), hatches: looks.stripes, pale: looks.marks.misses,
      faces: map.faces, others: map.others, marks: map.marks, nx: map.nx, ny: map.ny, pieces: piecesOf(map),
    };
    this.draw();
    place("notes").replaceChildren(...map.notes.map((note) => html("p", {}, note)));
  }

  draw() {
    if (!this.drawn || !this.faces || !this.stage.clientWidth) return; // drawn once the page is laid out
    const { box, faces, drawn: { title, caption, label, progress, x, y, scale } } = this;
    const wide = this.wide = this.stage.clientWidth;
    const room = window.innerHeight * (wide < 600 ? 0.4 : 0.64);
    const texts = [...caption.split(", "), progress].filter(Boolean);
    const facts = legend(texts.map((text) => ({ text, sample: [] })), box.left, 25, wide - box.left);
    box.top = 30 + facts.height;
    box.width = wide - box.left - (scale?.ticks ? 84 : 16);
    box.height = Math.round(Math.max(Math.min(0.75 * box.width, room), 180));
    const under = box.top + box.height + 50;
    const names = legend(this.samples(faces), 12, under, wide - 24);
    this.sign = names.group.querySelector(":scope > :last-child > text");
    const name = title[0].toUpperCase() + title.slice(1);
    shape("frame").replaceChildren(
      svg("text", { x: box.left, y: 18, "font-size": 14, "font-weight": 600, fill: "currentColor" }, name),
      facts.group, axis(box, "below", x.ticks, x.title), axis(box, "left", y.ticks, y.title),
      ...(scale?.ticks ? this.bar(scale, label, faces) : []),
      plot(box, { class: "curves" }, ...this.curves()), names.group);
    const height = under + names.height;
    set(this.svg, { width: wide, height, viewBox: `0 0 ${wide} ${height}` });
    set(this.svg, { "aria-label": `${name}, over ${x.title} and ${y.title}` });
    set(this.surface, { x: box.left, y: box.top, width: box.width, height: box.height });
    for (const [side, length] of Object.entries(box)) this.canvas.style.setProperty(side, `${length}px`);
    const zoom = window.devicePixelRatio;
    [this.canvas.width, this.canvas.height] = [Math.round(box.width * zoom), Math.round(box.height * zoom)];
    paint(this.canvas, zoom, faces);
    this.put();
    this.hover();
  }

  /** The colour bar. @param {Scale} scale @param {string} label @param {Cells} faces */
  bar({ ticks }, label, faces) {
    const box = { ...this.box, left: this.box.left + this.box.width + 14, width: 12 };
    const [first, count] = this.data.looks.scale;
    const href = picture(faces, Array.from({ length: count }, (_, n) => first + n), 1, 128);
    const image = svg("image", { href, width: 1000, height: 1000, preserveAspectRatio: "none" });
    return [plot(box, {}, image), axis(box, "right", ticks ?? [], label)];
  }

  curves() {
    return (this.drawn?.curves ?? []).flatMap((info) =>
      curveLine(info.lines.map((line) => way(line.length, (n) => line[n])).join(""), info));
  }

  /** What the legend shows. @param {Cells} faces */
  samples(faces) {
    const { legend: kinds, curves, x, y } = /** @type {DrawnMap} */ (this.drawn);
    const edge = { x: 0.5, y: 0.5, width: 23, height: 13, fill: "none", stroke: "#777777" };
    const areas = kinds.map(({ text, faces: own, marks }) => {
      const plain = this.data.regimes.find((/** @type {any} */ { code }) => code === own[0]);
      if (!marks) return { text, sample: [svg("rect", { ...edge, fill: plain.colour })] };
      const href = picture(faces, own, 24, 14, marks);
      return { text, sample: [svg("image", { href, width: 24, height: 14 }), svg("rect", edge)] };
    });
    const lines = curves.map((info) => ({ text: info.label, sample: curveLine("M0 7H24", info) }));
    const ring = svg("circle", { cx: 12, cy: 7, r: 4.5, fill: "#FFFFFF", stroke: "#000000", "stroke-width": 2.5 });
    const widest = [x, y].map((axis) => valueText(axis, 0.12345));
    return [...areas, ...lines, { text: pointText(widest), sample: [ring] }];
  }

  /** Put the operating point where the state has it. */
  put() {
    if (!this.drawn) return;
    const { x, y } = this.drawn;
    const { left, top, width, height } = this.box;
    const numbers = [x, y].map((axis) => this.value(axis.name));
    // While the state has no such number, the point stays where it was.
    this.at = [x, y].map((axis, n) => (Number.isNaN(numbers[n]) ? this.at[n] : placeOn(axis, numbers[n])));
    const [u, v] = this.at.map(within);
    const isOutside = this.at.some((share) => Math.abs(share - 0.5) > 0.5 + 1e-6);
    const values = [x, y].map((axis, n) => valueText(axis, numbers[n]));
    this.sign?.replaceChildren(pointText(values));
    set(this.point, {
      transform: `translate(${left + width * u} ${top + height * (1 - v)})`,
      "stroke-dasharray": isOutside ? "3 2.5" : "none",
      "aria-valuenow": Math.round(100 * u), "aria-valuetext": `${x.label} ${values[0]}, ${y.label} ${values[1]}`,
    });
    place("outside").hidden = !isOutside;
  }

  listen() {
    this.svg.addEventListener("pointerdown", (event) => {
      if (event.button) return;
      this.svg.setPointerCapture(event.pointerId);
      this.dragging = true;
      if (event.target === this.surface) this.moveTo(this.sharesOf(event));
      this.hover(event);
    });
    this.svg.addEventListener("pointermove", (event) => {
      if (this.dragging) this.moveTo(this.sharesOf(event));
      this.hover(event);
    });
    this.svg.addEventListener("lostpointercapture", () => {
      this.dragging = false;
      this.move({}, true);
      this.hover();
    });
    this.svg.addEventListener("pointerleave", () => this.hover(null));
    document.addEventListener("keydown", ({ key }) => key === "Escape" && this.hover(null));
    this.point.addEventListener("keydown", (event) => {
      if (!(event.key in KEYS) || event.ctrlKey || event.altKey || event.metaKey) return;
      event.preventDefault();
      const far = event.shiftKey ? LEAP : STEP;
      this.moveTo(KEYS[event.key].map((way, n) => this.at[n] + way * far));
    });
    this.point.addEventListener("keyup", ({ key }) => key in KEYS && this.move({}, true));
  }

  /** Where a pointer is: shares of the axes, perhaps outside of them. @param {PointerEvent} event */
  sharesOf({ clientX, clientY }) {
    const area = this.canvas.getBoundingClientRect();
    return [(clientX - area.left) / area.width, 1 - (clientY - area.top) / area.height];
  }

  /** Move the point to shares of the axes; NaN leaves a coordinate as it is. @param {number[]} shares */
  moveTo(shares) {
    if (!this.drawn) return;
    const { x, y } = this.drawn;
    const moved = [x, y].map((axis, n) => [axis.column, String(valueAt(axis, within(shares[n])))]);
    this.move(Object.fromEntries(moved.filter((_, n) => !Number.isNaN(shares[n]))), false);
  }

  // Show the numbers of the cell under a pointer that is over the map and does not move the point.
  /** @param {PointerEvent | null} pointer */
  hover(pointer = this.pointer) {
    this.pointer = pointer;
    const tip = place("tip");
    const [u, v] = pointer && !this.dragging ? this.sharesOf(pointer) : [NaN, NaN];
    tip.hidden = !(within(u) === u && within(v) === v);
    if (!this.drawn || !pointer || tip.hidden) return;
    const { nx, ny } = this.drawn;
    const rows = tipRows(this.data, this.drawn, Math.round(u * (nx - 1)), Math.round(v * (ny - 1)));
    tip.replaceChildren(...rows.map(([name, text]) => html("div", {}, html("span", {}, name), html("b", {}, text))));
    const area = this.stage.getBoundingClientRect();
    tip.style.left = `min(${pointer.clientX - area.left + 16}px, 100% - ${tip.offsetWidth}px)`;
    tip.style.top = `min(${pointer.clientY - area.top + 12}px, 100% - ${tip.offsetHeight}px)`;
  }
}
