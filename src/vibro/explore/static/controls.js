/** The settings, built from the server's schema. */

import { html, input, place, select, set, symbolText, unitText } from "./draw.js";

const FRICTIONS = ["static_friction", "kinetic_friction"];
const BANDS = FRICTIONS.map((column) => `${column}_band`);
const NO_BANDS = Object.fromEntries(BANDS.map((key) => [key, ""]));

export class Controls {
  /** @param {import("./state.js").Store} store @param {(patch: State, control: string, finished: boolean) => void} change */
  constructor(store, change) {
    this.store = store;
    this.change = change;
    const { schema } = store;
    this.problems = /** @type {Problem[]} */ ([]);
    this.inputs = /** @type {Record<string, HTMLInputElement[]>} */ ({
      x_range: ["x-from", "x-to", "x-log"].map(input), y_range: ["y-from", "y-to", "y-log"].map(input),
      target: [input("target")], cycles: [input("cycles")],
    });
    this.quantities = schema.quantities.filter((q) => q.point);
    for (const quantity of this.quantities) this.addQuantity(quantity);
    for (const key of BANDS) this.addBand(key);
    for (const axis of ["x", "y"]) {
      const [from, to, log] = this.inputs[`${axis}_range`];
      const range = () => [from.value, to.value, ...(log.checked ? ["log"] : [])].join(":");
      for (const part of [from, to, log]) this.onText(part, () => ({ [`${axis}_range`]: range() }), axis);
    }
    for (const key of ["target", "cycles"]) this.onText(input(key), (text) => ({ [key]: text }), key);
    const presets = schema.presets.map((p) => [p.name, p.state]);
    this.onSelect("view", schema.views, (view) => ({ view }));
    this.onSelect("drive", schema.drives, (drive) => ({ drive, x: "", y: "", x_range: "", y_range: "", ...NO_BANDS }));
    this.onSelect("preset", schema.presets, (name) => ({ ...NO_BANDS, ...Object.fromEntries(presets)[name] }));
    this.onSelect("x", [], (column) => this.axisPatch("x", "y", column));
    this.onSelect("y", [], (column) => this.axisPatch("y", "x", column));
    const [follow, bands] = [input("follow"), input("bands")];
    const frictions = () => ({ follow: follow.checked ? "1" : "0", ...this.bandPatch(bands.checked, follow.checked) });
    for (const box of [follow, bands]) box.addEventListener("change", () => change(frictions(), box.id, true));
    place("controls").addEventListener("submit", (event) => event.preventDefault());
  }

  /** A text with a unit, and a slider. @param {Quantity} quantity */
  addQuantity({ column, label, symbol, unit, meaning, low, high, step, drives }) {
    const text = html("input", { id: column, spellcheck: "false" });
    const slider = html("input", { type: "range", min: low, max: high, step, "aria-label": `${label}, slider` });
    const row = html("div", { class: "quantity", id: `row-${column}` },
      html("label", { for: column, title: meaning }, `${label} `, html("i", {}, symbolText(symbol))),
      html("span", { class: "measure" }, text, html("i", {}, unitText(unit))), slider, html("p", { id: `note-${column}`, class: "note" }));
    const isOfDrive = column === "frequency_hz" || drives.length < this.store.schema.drives.length;
    if (FRICTIONS.includes(column)) place("follow-row").before(row);
    else place(isOfDrive ? "of-drive" : "of-trough").append(row);
    this.inputs[column] = [text, slider];
    this.onText(text, (value) => ({ [column]: value }), column);
    const most = () => (column === FRICTIONS[1] ? this.store.value(FRICTIONS[0]) : Infinity);
    this.onSlider(slider, () => ({ [column]: slider.valueAsNumber > most() ? `${most()}` : slider.value }), column);
  }

  /** Two handles, of which none passes the other. @param {string} key */
  addBand(key) {
    const { column, label, low, high, step } = /** @type {Quantity} */ (this.quantities.find((q) => key.startsWith(q.column)));
    const look = { type: "range", min: low, max: high, step };
    const ends = ["least", "largest"].map((end) => html("input", { ...look, "aria-label": `${end} ${label}` }));
    const row = html("div", { class: "quantity", id: `row-${key}` }, html("span", {}, label), html("output", { for: column }),
      ...ends, html("p", { id: `note-${key}`, class: "note" }));
    place("of-friction").append(row);
    this.inputs[key] = ends;
    ends.forEach((end, n) => this.onSlider(end, () => {
      const pair = ends.map((e) => e.valueAsNumber);
      if (pair[0] > pair[1]) pair[1 - n] = pair[n];
      return { [key]: pair.join(":") };
    }, key));
  }

  /** @param {HTMLInputElement} box @param {(text: string) => State} patch @param {string} control */
  onText(box, patch, control) {
    box.addEventListener("input", () => box.classList.add("edited")); // and not overwritten until it is done
    box.addEventListener("blur", () => box.classList.remove("edited"));
    box.addEventListener("change", () => {
      box.classList.remove("edited");
      this.change(patch(box.value.trim()), control, true);
    });
  }

  /** @param {HTMLInputElement} slider @param {() => State} patch @param {string} control */
  onSlider(slider, patch, control) {
    slider.addEventListener("input", () => this.change(patch(), control, false));
    slider.addEventListener("change", () => this.change(patch(), control, true));
  }

  /** @param {string} id @param {Choice[]} choices @param {(name: string) => State} patch */
  onSelect(id, choices, patch) {
    select(id).append(...choices.map(({ name, label }) => new Option(label, name)));
    select(id).addEventListener("change", () => this.change(patch(select(id).value), id, true));
  }

  /** Choose an axis; the other's quantity swaps them. @param {string} axis @param {string} other @param {string} column */
  axisPatch(axis, other, column) {
    const { state } = this.store;
    const bands = column.includes("friction") ? NO_BANDS : {};
    if (column !== state[other]) return { [axis]: column, [`${axis}_range`]: "", ...bands };
    return { [axis]: column, [other]: state[axis], [`${axis}_range`]: state[`${other}_range`], [`${other}_range`]: state[`${axis}_range`] };
  }

  /** Bands of a tenth to either side, where there are none yet. @param {boolean} on @param {boolean} follow @returns {State} */
  bandPatch(on, follow) {
    return Object.fromEntries(FRICTIONS.map((column, n) => {
      const ends = [0.9, 1.1].map((share) => Number((share * this.store.value(column)).toPrecision(3)));
      return [BANDS[n], on && !(n && follow) ? this.store.state[BANDS[n]] || ends.join(":") : ""];
    }));
  }

  render() {
    const { state, schema } = this.store;
    const swept = schema.quantities.filter((q) => q.swept && this.store.isOfDrive(q));
    for (const axis of ["x", "y"]) {
      if (swept.map((q) => q.column).join() !== [...select(axis).options].map((o) => o.value).join()) {
        select(axis).replaceChildren(...swept.map((q) => new Option(q.unit ? `${q.label} [${unitText(q.unit)}]` : q.label, q.column)));
      }
      const [from = "", to = "", log] = (state[`${axis}_range`] ?? "").split(":");
      this.fill(`${axis}_range`, [from, to]);
      input(`${axis}-log`).checked = log === "log";
    }
    for (const id of ["view", "drive", "x", "y"]) select(id).value = state[id] ?? "";
    select("preset").value = "";
    for (const quantity of this.quantities) {
      const { column, unit } = quantity;
      place(`row-${column}`).hidden = !this.store.isOfDrive(quantity);
      this.fill(column, [state[column], state[column]]);
      set(this.inputs[column][1], { "aria-valuetext": `${state[column]} ${unitText(unit)}` });
    }
    for (const key of ["target", "cycles"]) this.fill(key, [state[key]]);
    for (const key of BANDS) {
      place(`row-${key}`).hidden = !state[key];
      place(`row-${key}`).getElementsByTagName("output")[0].value = (state[key] ?? "").replace(":", " to ");
      if (state[key]) this.fill(key, state[key].split(":"));
    }
    input("follow").checked = state.follow === "1";
    input("bands").checked = Boolean(state[BANDS[0]]);
    input("bands").disabled = state.drive !== "line" || `${state.x} ${state.y}`.includes("friction");
    this.renderNotes();
  }

  /** @param {string} key @param {(string | undefined)[]} texts */
  fill(key, texts) {
    this.inputs[key].slice(0, texts.length).forEach((box, n) => {
      if (!box.classList.contains("edited") && box.value !== (texts[n] ?? "")) box.value = texts[n] ?? "";
    });
  }

  /** Show what the server refused beside its field. */
  renderNotes() {
    for (const [key, boxes] of Object.entries(this.inputs)) {
      const wrong = this.problems.find((p) => p.field === key);
      place(`note-${key}`).textContent = wrong?.text ?? "";
      place(`note-${key}`).classList.toggle("error", Boolean(wrong));
      for (const box of boxes) set(box, { "aria-invalid": String(Boolean(wrong)), "aria-describedby": `note-${key}` });
    }
    const others = this.problems.filter((p) => !(p.field in this.inputs)).map((p) => p.text);
    place("problems").textContent = others.join(" ");
  }
}
