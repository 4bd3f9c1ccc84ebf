// @ts-check
/** The settings, built from the server's schema. */

import { byId, html } from "./draw.js";

const INPUT = HTMLInputElement;
const BANDED = ["static_friction", "kinetic_friction"];
const WIDTH = 0.1; // of a new band, to either side

/** @typedef {(patch: State, control: string, finished: boolean) => void} Change */

export class Controls {
  /** @param {import("./state.js").Store} store @param {Change} change */
  constructor(store, change) {
    this.store = store;
    this.change = change;
    /** @type {Record<string, string>} */
    this.ranges = {}; // that an axis had, by column
    /** @type {Record<string, string>} */
    this.hints = {};
    /** @type {Problem[]} */
    this.problems = [];
    /** @type {Record<string, HTMLInputElement[]>} */
    this.inputs = { x_range: ["x-from", "x-to", "x-log"].map((id) => byId(id, INPUT)), y_range: ["y-from", "y-to", "y-log"].map((id) => byId(id, INPUT)) };
    const { schema } = store;
    for (const { name, label } of schema.views) byId("view", HTMLSelectElement).append(new Option(label, name));
    for (const { name, label } of schema.drives) byId("drive", HTMLSelectElement).append(new Option(label, name));
    for (const { name, label } of schema.presets) byId("preset", HTMLSelectElement).append(new Option(label, name));
    for (const quantity of schema.quantities) this.addQuantity(quantity);
    for (const column of BANDED) this.addBand(column);
    this.listen();
  }

  /** A text with a unit, and a slider. @param {Quantity} quantity */
  addQuantity(quantity) {
    const { column, label, symbol, unit, meaning, low, high, step, drives } = quantity;
    const text = html("input", { id: column, inputmode: "decimal", spellcheck: "false", "aria-describedby": `note-${column}` });
    const slider = html("input", { type: "range", min: `${low}`, max: `${high}`, step: `${step}`, "aria-label": `${label}, slider` });
    const name = html("label", { for: column, title: meaning }, `${label} `, html("i", {}, symbol));
    const row = html("div", { class: "quantity", id: `row-${column}` }, name, html("span", { class: "measure" }, text, html("i", {}, unit)), slider,
      html("p", { id: `note-${column}`, class: "note" }));
    const place = BANDED.includes(column) ? "of-friction" : column === "frequency_hz" || drives.length < this.store.schema.drives.length ? "of-drive" : "of-trough";
    const group = byId(place, HTMLElement);
    group.insertBefore(row, place === "of-friction" ? group.querySelector(".tick") : null);
    this.inputs[column] = [text, slider];
    this.bindText(text, (value) => ({ [column]: value }), column);
    this.bindSlider(slider, () => {
      const most = column === "kinetic_friction" ? Number(this.store.state.static_friction) : NaN;
      return { [column]: slider.valueAsNumber > most ? String(most) : slider.value };
    }, column);
  }

  /** Two handles; neither passes the other. @param {string} column */
  addBand(column) {
    const key = `${column}_band`;
    const quantity = /** @type {Quantity} */ (this.store.schema.quantities.find((q) => q.column === column));
    const ends = ["least", "most"].map((end) => html("input", { type: "range", min: `${quantity.low}`, max: `${quantity.high}`, step: `${quantity.step}`, "aria-label": `${end} ${quantity.label}` }));
    const row = html("div", { class: "quantity band", id: `row-${key}` }, html("span", {}, `${quantity.label} `), html("output"), ...ends, html("p", { id: `note-${key}`, class: "note" }));
    byId("band-rows", HTMLElement).append(row);
    this.inputs[key] = ends;
    ends.forEach((end, n) => this.bindSlider(end, () => {
      const pair = ends.map((e) => e.valueAsNumber);
      const held = n ? Math.min(pair[0], pair[1]) : Math.max(pair[0], pair[1]);
      return { [key]: n ? `${held}:${pair[1]}` : `${pair[0]}:${held}` };
    }, key));
  }

  /** @param {HTMLInputElement} input @param {(value: string) => State} patch @param {string} control */
  bindText(input, patch, control) {
    input.addEventListener("input", () => input.classList.add("edited"));
    input.addEventListener("change", () => {
      input.classList.remove("edited");
      this.change(patch(input.value.trim()), control, true);
    });
    input.addEventListener("blur", () => input.classList.remove("edited"));
  }

  /** @param {HTMLInputElement} slider @param {() => State} patch @param {string} control */
  bindSlider(slider, patch, control) {
    slider.addEventListener("input", () => this.change(patch(), control, false));
    slider.addEventListener("change", () => this.change(patch(), control, true));
  }

  listen() {
    const { schema } = this.store;
    byId("controls", HTMLFormElement).addEventListener("submit", (event) => event.preventDefault());
    for (const key of ["target", "cycles"]) {
      this.inputs[key] = [byId(key, INPUT)];
      this.bindText(this.inputs[key][0], (value) => ({ [key]: value || (schema.initial[key] ?? "") }), key);
    }
    for (const axis of ["x", "y"]) {
      const [from, to, log] = this.inputs[`${axis}_range`];
      const range = () => ({ [`${axis}_range`]: [from.value.trim(), to.value.trim(), ...(log.checked ? ["log"] : [])].join(":") });
      for (const input of [from, to, log]) this.bindText(input, range, `${axis}_range`);
      const select = byId(axis, HTMLSelectElement);
      select.addEventListener("change", () => this.change(this.axisPatch(axis, select.value), axis, true));
    }
    const onChange = (/** @type {string} */ id, /** @type {(value: string) => State} */ patch) => {
      const select = byId(id, HTMLSelectElement);
      select.addEventListener("change", () => this.change(patch(select.value), id, true));
    };
    onChange("view", (view) => ({ view }));
    onChange("drive", (drive) => this.drivePatch(drive));
    onChange("preset", (name) => {
      const state = schema.presets.find((p) => p.name === name)?.state ?? {};
      return { ...(state.drive ? this.drivePatch(state.drive) : {}), ...state };
    });
    const [follow, bands] = [byId("follow", INPUT), byId("bands", INPUT)];
    follow.addEventListener("change", () => this.change({ follow: follow.checked ? "1" : "0", ...this.bandPatch(bands.checked, follow.checked) }, "follow", true));
    bands.addEventListener("change", () => this.change(this.bandPatch(bands.checked, follow.checked), "bands", true));
  }

  /** Choose an axis; the other's quantity swaps them. @param {string} axis @param {string} column @returns {State} */
  axisPatch(axis, column) {
    const { x, y, x_range, y_range, [axis]: before } = this.store.state;
    if (column === (axis === "x" ? y : x)) return { x: y, y: x, x_range: y_range, y_range: x_range };
    this.ranges[before] = this.store.state[`${axis}_range`];
    const quantity = this.store.schema.quantities.find((q) => q.column === column);
    const range = this.ranges[column] ?? `${quantity?.low}:${quantity?.high}`;
    return { [axis]: column, [`${axis}_range`]: range, ...(BANDED.includes(column) ? this.bandPatch(false, true) : {}) };
  }

  /** Choose a drive; axes that it lacks give way to others. @param {string} drive @returns {State} */
  drivePatch(drive) {
    const able = this.store.schema.quantities.filter((q) => q.swept && q.drives.includes(drive)).map((q) => q.column);
    const { x, y } = this.store.state;
    /** @type {State} */
    let patch = { drive, ...(drive === "line" ? {} : this.bandPatch(false, true)) };
    for (const [axis, column] of [["x", x], ["y", y]]) {
      const taken = axis === "x" ? y : (patch.x ?? x);
      if (!able.includes(column)) patch = { ...patch, ...this.axisPatch(axis, able.find((c) => c !== taken) ?? "") };
    }
    return patch;
  }

  /** Bands about the frictions as they are, or none. @param {boolean} on @param {boolean} follow @returns {State} */
  bandPatch(on, follow) {
    return Object.fromEntries(BANDED.map((column, n) => {
      const [key, about] = [`${column}_band`, Number(this.store.state[column])];
      const ends = [1 - WIDTH, 1 + WIDTH].map((share) => Number((share * about).toPrecision(2)));
      return [key, on && !(n && follow) ? (this.store.state[key] ?? ends.join(":")) : ""];
    }));
  }

  /** Show the state, the server's hints, and what it refused; what is being typed stays. */
  render() {
    const { state, schema } = this.store;
    for (const id of ["view", "drive"]) byId(id, HTMLSelectElement).value = state[id];
    byId("preset", HTMLSelectElement).value = "";
    const swept = schema.quantities.filter((q) => q.swept && this.store.counts(q));
    for (const axis of ["x", "y"]) {
      const select = byId(axis, HTMLSelectElement);
      if (swept.map((q) => q.column).join() !== [...select.options].map((o) => o.value).join()) {
        select.replaceChildren(...swept.map((q) => new Option(q.unit ? `${q.label} [${q.unit}]` : q.label, q.column)));
      }
      select.value = state[axis];
      const [from, to, log] = state[`${axis}_range`].split(":");
      this.fill(`${axis}_range`, [from ?? "", to ?? ""]);
      this.inputs[`${axis}_range`][2].checked = log === "log";
    }
    for (const quantity of schema.quantities) {
      const { column, unit } = quantity;
      byId(`row-${column}`, HTMLElement).hidden = !this.store.counts(quantity);
      this.fill(column, [state[column], state[column]]);
      this.inputs[column][1].setAttribute("aria-valuetext", `${state[column]} ${unit}`);
    }
    for (const key of ["target", "cycles"]) this.fill(key, [state[key] ?? ""]);
    const [follow, bands] = [byId("follow", INPUT), byId("bands", INPUT)];
    follow.checked = state.follow === "1";
    bands.checked = "static_friction_band" in state;
    bands.disabled = state.drive !== "line" || BANDED.some((c) => c === state.x || c === state.y);
    for (const key of BANDED.map((column) => `${column}_band`)) {
      const row = byId(`row-${key}`, HTMLElement);
      row.hidden = !(key in state);
      const ends = (state[key] ?? "").split(":");
      this.fill(key, ends);
      row.getElementsByTagName("output")[0].textContent = ends.join(" to ");
    }
    this.renderNotes();
  }

  /** @param {string} key @param {string[]} texts */
  fill(key, texts) {
    texts.forEach((text, n) => {
      const input = this.inputs[key][n];
      if (!input.classList.contains("edited") && input.value !== text) input.value = text;
    });
  }

  renderNotes() {
    const beside = Object.keys(this.inputs);
    for (const key of beside) {
      const problem = this.problems.find((p) => p.field === key);
      const note = byId(`note-${key}`, HTMLElement);
      note.textContent = problem?.text ?? this.hints[key] ?? "";
      note.classList.toggle("error", Boolean(problem));
      for (const input of this.inputs[key]) {
        input.setAttribute("aria-describedby", note.id);
        if (problem) input.setAttribute("aria-invalid", "true");
        else input.removeAttribute("aria-invalid");
      }
    }
    const others = this.problems.filter((p) => !beside.includes(p.field)).map((p) => p.text);
    const place = byId("problems", HTMLElement);
    place.textContent = others.join(" ");
    place.hidden = !others.length;
  }
}
