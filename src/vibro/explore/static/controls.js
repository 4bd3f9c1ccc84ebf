/** The settings: boxes bear the names of keys of the state; those of quantities are made from the server's schema. */

import { html, input, place, select, set } from "./draw.js";

/** @typedef {HTMLInputElement | HTMLSelectElement} Box */
const FRICTIONS = ["static_friction", "kinetic_friction"];
const BANDS = FRICTIONS.map((column) => `${column}_band`);
const NO_BANDS = Object.fromEntries(BANDS.map((key) => [key, ""]));
const CHOICES = /** @type {const} */ (["view", "drive", "preset"]);
const form = /** @type {HTMLFormElement} */ (place("controls"));

export class Controls {
  /**
   * @param {import("./state.js").Store} store
   * @param {(patch: State, control: string, isFinished: boolean) => void} change
   */
  constructor(store, change) {
    this.store = store;
    this.drive = /** @type {string | undefined} */ (""); // of which the quantities of the axes are
    this.edited = /** @type {EventTarget | null} */ (null); // the box that somebody types in
    const { schema } = store;
    this.quantities = schema.quantities.filter((q) => q.point);
    for (const quantity of this.quantities) this.addQuantity(quantity);
    for (const quantity of this.quantities.filter((q) => FRICTIONS.includes(q.column))) this.addBand(quantity);
    for (const id of CHOICES) select(id).append(...schema[`${id}s`].map((known) => new Option(known.label, known.name)));
    this.boxes = /** @type {Box[]} */ ([...form.elements]).filter((box) => box.name);
    const noted = this.boxes.filter((box) => document.getElementById(`note-${box.name}`));
    for (const box of noted) set(box, { "aria-describedby": `note-${box.name}` });
    form.addEventListener("submit", (event) => event.preventDefault());
    for (const type of ["input", "change"]) document.addEventListener(type, ({ target }) => {
      const box = /** @type {Box} */ (target);
      const isFinished = type === "change";
      if (isFinished || box.type === "range") change(this.patch(box), box.name, isFinished);
      this.edited = isFinished ? null : box; // and not overwritten meanwhile
    });
    document.addEventListener("focusout", () => (this.edited = null));
  }

  /** A text with a unit, and a slider. @param {Quantity} quantity */
  addQuantity({ column, label, symbol, unit, meaning, low, high, step, drives }) {
    const [name, slider] = [column, { type: "range", min: low, max: high, step, "aria-label": `${label}, slider` }];
    const row = html("div", { class: "quantity", id: `row-${name}` },
      html("label", { for: name, title: meaning }, `${label} `, html("i", {}, symbol)),
      html("span", { class: "measure" }, html("input", { id: name, name, spellcheck: "false" }), html("i", {}, unit)),
      html("input", { name, ...slider, "data-unit": unit }), html("p", { id: `note-${name}`, class: "note" }));
    const isOfDrive = column === "frequency_hz" || drives.length < this.store.schema.drives.length;
    if (FRICTIONS.includes(column)) place("follow-row").before(row);
    else place(isOfDrive ? "of-drive" : "of-trough").append(row);
  }

  /** Two handles. @param {Quantity} quantity */
  addBand({ column, label, low, high, step }) {
    const name = `${column}_band`;
    const ends = ["least", "largest"].map((end, part) => html("input",
      { name, type: "range", min: low, max: high, step, "aria-label": `${end} ${label}`, "data-part": part }));
    place("of-friction").append(html("div", { class: "quantity", id: `row-${name}` }, html("span", {}, label),
      html("output", { for: column }), ...ends, html("p", { id: `note-${name}`, class: "note" })));
  }

  /** What a box changes. @param {Box} box @returns {State} */
  patch({ name, type, value }) {
    const text = value.trim();
    const parts = this.boxes.filter((box) => box.name === name).map((box) => box.value);
    const choice = CHOICES.find((id) => id === name);
    if (choice) return this.store.schema[`${choice}s`].find((known) => known.name === text)?.state ?? {};
    if (name === "x" || name === "y") return this.axisPatch(name, name === "x" ? "y" : "x", text);
    if (name === "follow" || name === "bands") return this.frictionPatch();
    if (name.endsWith("_range")) return { [name]: parts.slice(0, input(`${name[0]}-log`).checked ? 3 : 2).join(":") };
    if (name.endsWith("_band")) { // of its handles none passes the other
      const [least, most] = parts.map(Number);
      return { [name]: least <= most ? parts.join(":") : `${text}:${text}` };
    }
    const isTooLarge = name === FRICTIONS[1] && type === "range" && Number(text) > this.store.value(FRICTIONS[0]);
    return { [name]: isTooLarge ? `${this.store.value(FRICTIONS[0])}` : text };
  }

  /** Choose an axis; the other's quantity swaps them.
   * @param {string} axis @param {string} other @param {string} column @returns {State} */
  axisPatch(axis, other, column) {
    const { state } = this.store;
    const bands = column.includes("friction") ? NO_BANDS : {};
    if (column !== state[other]) return { [axis]: column, [`${axis}_range`]: "", ...bands };
    const ranges = { [`${axis}_range`]: state[`${other}_range`], [`${other}_range`]: state[`${axis}_range`] };
    return { [axis]: column, [other]: state[axis], ...ranges };
  }

  /** Bands of a tenth to either side, where there are none yet. @returns {State} */
  frictionPatch() {
    const [bands, follow] = [input("bands").checked, input("follow").checked];
    const band = (/** @type {string} */ column, /** @type {number} */ n) => {
      const ends = [0.9, 1.1].map((share) => Number((share * this.store.value(column)).toPrecision(3)));
      return bands && !(n && follow) ? this.store.state[BANDS[n]] || ends.join(":") : "";
    };
    const both = FRICTIONS.map((column, n) => [BANDS[n], band(column, n)]);
    return { follow: follow ? "1" : "0", ...Object.fromEntries(both) };
  }

  render() {
    const { state, schema } = this.store;
    const swept = schema.quantities.filter((q) => q.swept && this.store.isOfDrive(q));
    const options = () => swept.map((q) => new Option(q.unit ? `${q.label} [${q.unit}]` : q.label, q.column));
    if (state.drive !== this.drive) for (const axis of ["x", "y"]) select(axis).replaceChildren(...options());
    this.drive = state.drive;
    for (const box of this.boxes) {
      const { part, unit } = box.dataset;
      const text = (part ? state[box.name]?.split(":")[Number(part)] : state[box.name]) ?? "";
      if (box.type === "checkbox") /** @type {HTMLInputElement} */ (box).checked = text === "1" || text === "log";
      else if (box !== this.edited && box.value !== text) box.value = text;
      if (unit !== undefined) set(box, { "aria-valuetext": `${text} ${unit}` });
    }
    for (const quantity of this.quantities) place(`row-${quantity.column}`).hidden = !this.store.isOfDrive(quantity);
    for (const key of BANDS) {
      place(`row-${key}`).hidden = !state[key];
      place(`row-${key}`).getElementsByTagName("output")[0].value = (state[key] ?? "").replace(":", " to ");
    }
    input("bands").checked = Boolean(state[BANDS[0]]);
    input("bands").disabled = state.drive !== "line" || `${state.x} ${state.y}`.includes("friction");
  }

  /** Show what the server refused beside its field. @param {Problem[]} problems */
  renderNotes(problems) {
    for (const box of this.boxes) {
      const text = problems.find((p) => p.field === box.name)?.text ?? "";
      set(box, { "aria-invalid": String(text !== "") });
      const note = document.getElementById(`note-${box.name}`);
      note?.replaceChildren(text);
      note?.classList.toggle("error", text !== "");
    }
    const names = this.boxes.map((box) => box.name);
    place("problems").textContent = problems.filter((p) => !names.includes(p.field)).map((p) => p.text).join(" ");
  }
}
