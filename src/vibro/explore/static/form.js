/** The settings, built from the page's data; every box has a key of the state as its name. */

import { html, input, place, set } from "./draw.js";
import { BANDED, controlOf, drivesOf, quantitiesOf } from "./state.js";
import { KNOBS_OF_MACHINES } from "./tables.js";
import { printedText, typedText } from "./typed.js";

/** @typedef {HTMLInputElement | HTMLSelectElement} Setting
 * @typedef {import("./state.js").PageData} PageData
 * @typedef {import("./store.js").Store} Store
 * @typedef {import("./state.js").Texts} Texts
 * @typedef {Record<string, string | number>} Attributes */

const NO_BANDS = Object.fromEntries(BANDED.map((name) => [`${name}_band`, ""]));
const NO_AXES = { x: "", y: "", x_range: "", y_range: "" };

// ------------------------------------------------------------------------------
// Its parts

/** A box of a key, beside which its note stands. @param {string} key @param {Attributes} [more] */
const boxOf = (key, more) =>
  html("input", { name: key, "aria-describedby": `note-${key}`, spellcheck: "false", ...more });
const noteOf = (/** @type {string} */ key) => html("p", { id: `note-${key}`, class: "note error" });

/** A text with its unit. @param {string} key @param {string} sign @param {Attributes} [more] */
const measureOf = (key, sign, more) =>
  html("span", { class: "measure" }, boxOf(key, { id: key, ...more }), html("i", {}, sign));

/** A choice among values with labels.
 * @param {string} key @param {[string, string][]} choices @param {(value: string) => string} [drives] */
function selectOf(key, choices, drives) {
  const options = choices.map(([value, label]) =>
    html("option", { value, ...(drives && { "data-drives": drives(value) }) }, label));
  return html("select", { id: key, name: key, "aria-describedby": `note-${key}` }, ...options);
}

/** @param {string} key @param {string} label @param {HTMLElement} box */
const pairOf = (key, label, box) =>
  html("div", { class: "pair" }, html("label", { for: key }, label), box, noteOf(key));

/** @param {string} key @param {string} label @param {Attributes} [more] */
const tickOf = (key, label, more) =>
  html("label", { class: "tick" }, html("input", { type: "checkbox", id: key, name: key, ...more }), label);

/** @param {string} legend @param {Attributes} attributes @param {HTMLElement[]} rows */
const fieldsetOf = (legend, attributes, rows) => html("fieldset", attributes, html("legend", {}, legend), ...rows);

/** The fieldsets of a scene. @param {PageData} data @param {number} scene */
function fieldsetsOf(data, scene) {
  const { quantities, presets, views, scenes } = data;
  const drives = drivesOf(data, scene);
  const names = Object.entries(drives).map(([name, drive]) => /** @type {const} */ ([name, quantitiesOf(data, drive)]));
  /** Drives that have a quantity. @param {string} name */
  const drivesWith = (name) => names.filter(([, own]) => own.includes(name)).map(([drive]) => drive).join(" ");
  const all = Object.keys(quantities).filter((name) => drivesWith(name));

  /** A slider. @param {string} key @param {string} name @param {string} label @param {Attributes} more */
  function slider(key, name, label, more) {
    const { low, high, step } = controlOf(data, scene, name);
    return boxOf(key, { type: "range", min: low, max: high, step, "aria-label": `${label}, slider`, ...more });
  }

  /** A quantity: a text with its unit, and a slider. @param {string} name */
  function row(name) {
    const { column, label, symbol, sign, meaning } = quantities[name];
    const title = html("label", { for: column, title: meaning }, `${label} `, html("i", {}, symbol));
    return html("div", { class: "quantity", id: `row-${column}`, "data-drives": drivesWith(name) },
      title, measureOf(column, sign), slider(column, name, label, { "data-unit": sign }), noteOf(column));
  }

  /** The ends of a band: two texts and two sliders. @param {string} name */
  function band(name) {
    const [key, { label }] = [`${name}_band`, quantities[name]];
    const ends = ["least", "most"];
    const texts = ends.flatMap((end, part) => [html("label", { for: `${key}-${end}` }, end),
      boxOf(key, { id: `${key}-${end}`, "data-part": part, placeholder: "exact" })]);
    const sliders = ends.map((end, part) =>
      slider(key, name, `${end} ${label}`, { "data-part": part, "data-unit": "" }));
    return html("div", { class: "band", id: `row-${key}`, role: "group", "aria-label": `band of ${label}` },
      html("span", {}, label), ...texts, ...sliders, noteOf(key));
  }

  /** An axis of the map. @param {"x" | "y"} key @param {string} name @param {string} label */
  function axisRow(key, name, label) {
    const swept = all.filter((quantity) => quantities[quantity].control?.axis).map((quantity) => quantities[quantity]);
    const choices = swept.map(({ column, label, sign }) =>
      /** @type {[string, string]} */ ([column, sign ? `${label} [${sign}]` : label]));
    const named = new Map(all.map((quantity) => [quantities[quantity].column, quantity]));
    const ends = ["from", "to"].flatMap((end, part) => [html("label", { for: `${key}-${end}` }, end),
      boxOf(`${key}_range`, { id: `${key}-${end}`, "data-part": part })]);
    const log = boxOf(`${key}_range`, { type: "checkbox", id: `${key}-log`, "data-part": 2, value: "log" });
    return html("div", { class: "axis", role: "group", "aria-label": name }, html("label", { for: key }, label),
      selectOf(key, choices, (column) => drivesWith(named.get(column) ?? "")), ...ends,
      html("label", { class: "tick" }, log, "log"), noteOf(`${key}_range`), noteOf(key));
  }

  const labelled = (/** @type {Record<string, {label: string}>} */ kinds) =>
    Object.entries(kinds).map(([name, { label }]) => /** @type {[string, string]} */ ([name, label]));
  const packs = Object.keys(scenes[scene].machine?.packs ?? {})
    .map((name) => /** @type {[string, string]} */ ([name, name]));
  const pack = packs.length ? [pairOf("pack", "Spring pack", selectOf("pack", [...packs, ["", "another one"]]))] : [];
  const knobs = all.filter((name) => KNOBS_OF_MACHINES.includes(name));
  const frictions = all.filter((name) => ["static_friction", "kinetic_friction"].includes(name));
  const moves = new Set(["frequency", ...Object.values(drives).flatMap((drive) => drive.quantities)]);
  const rest = all.filter((name) => ![...knobs, ...frictions, "friction_ratio"].includes(name));
  return [
    fieldsetOf("Map", {}, [
      pairOf("view", "Show", selectOf("view", Object.entries(views))),
      axisRow("x", "Horizontal axis", "Across"),
      axisRow("y", "Vertical axis", "Up"),
      pairOf("target", "Target speed", measureOf("target", quantities.speed.sign, { placeholder: "none" })),
    ]),
    fieldsetOf("Drive", {}, [
      pairOf("preset", "Preset", selectOf("preset", [["", "choose one"], ...labelled(presets)])),
      pairOf("drive", "Motion", selectOf("drive", labelled(drives))),
      ...rest.filter((name) => moves.has(name)).map(row),
    ]),
    ...(knobs.length ? [fieldsetOf("Machine", { "data-drives": "machine" }, [...knobs.map(row), ...pack])] : []),
    fieldsetOf("Friction", {}, [
      ...frictions.map(row),
      tickOf("follow", "kinetic friction follows static friction"),
      tickOf("bands", "friction or restitution is not known exactly", { "aria-describedby": "no-bands" }),
      html("p", { id: "no-bands", class: "note" }, "only for frictions that are not an axis"),
      ...BANDED.map(band),
    ]),
    fieldsetOf("Trough and body", {}, rest.filter((name) => !moves.has(name)).map(row)),
  ];
}

// ------------------------------------------------------------------------------
// What it changes

/** A range or band with a new part: of its handles none passes the other; a range without an end is none, a band ends
 * at its point. @param {HTMLInputElement} box @param {string} text @param {string} whole @param {string} point */
function withPart({ type, checked, dataset: { part } }, text, whole, point) {
  const ends = whole ? whole.split(":") : [point || text, point || text];
  if (type === "checkbox") return [...ends.slice(0, 2), ...(checked ? [text] : [])].join(":");
  const end = text || point, here = Number(part);
  ends[here] = end;
  const isPassed = Number(ends[0]) > Number(ends[1]);
  if (isPassed && (type === "range" || !whole)) ends.fill(end);
  else if (isPassed && !text) ends.fill(ends[1 - here]);
  return end && ends.join(":");
}

/** Choose an axis; the other's quantity swaps them.
 * @param {"x" | "y"} axis @param {string} column @param {Texts} texts @returns {Texts} */
function axisPatch(axis, column, texts) {
  const other = axis === "x" ? "y" : "x";
  const bands = column.includes("friction") ? NO_BANDS : column === "restitution" ? { restitution_band: "" } : {};
  if (column !== texts[other]) return { [axis]: column, [`${axis}_range`]: "", ...bands };
  const ranges = { [`${axis}_range`]: texts[`${other}_range`], [`${other}_range`]: texts[`${axis}_range`] };
  return { [axis]: column, [other]: texts[axis], ...ranges };
}

/** What a box changes. @param {PageData} data @param {Store} store @param {Setting} box @returns {Texts} */
function patchOf(data, store, box) {
  const { name, type } = box;
  const text = box.value.trim();
  switch (name) {
    case "x": case "y":
      return axisPatch(name, text, store.texts);
    case "preset":
      return text ? { ...NO_BANDS, ...data.presets[text].state } : {};
    case "drive":
      return { ...NO_AXES, drive: text };
    case "pack": {
      const natural = data.scenes[store.scene].machine?.packs[text];
      return natural === undefined ? {} : { natural_hz: typedText(natural) };
    }
    case "follow": case "bands": {
      const follows = input("follow").checked;
      return { ...NO_BANDS, follow: follows ? "1" : "0", ...(input("bands").checked && store.bandsIf(follows)) };
    }
  }
  if (box.dataset.part) {
    const point = name in NO_BANDS ? typedText(store.value(name.replace("_band", ""))) : "";
    return { [name]: withPart(/** @type {HTMLInputElement} */ (box), text, store.texts[name], point) };
  }
  const most = name === "kinetic_friction" && type === "range" ? store.value("static_friction") : Infinity;
  return { [name]: Number(text) > most ? typedText(most) : text };
}

/** The form of the page. @param {PageData} data @param {Store} store
 * @param {(patch: Texts, control: string, isFinished: boolean) => void} change called for every input */
export function createForm(data, store, change) {
  const form = /** @type {HTMLFormElement} */ (place("controls"));
  let boxes = /** @type {Setting[]} */ ([]);
  let built = -1; // the scene whose settings they are
  let edited = /** @type {EventTarget | null} */ (null); // the box that somebody types in
  for (const type of ["input", "change"]) document.addEventListener(type, ({ target }) => {
    const box = /** @type {Setting} */ (target);
    if (!boxes.includes(box)) return;
    const isFinished = type === "change";
    edited = isFinished ? null : box; // and not overwritten meanwhile
    if (isFinished || box.type === "range") change(patchOf(data, store, box), box.name, isFinished);
  });
  document.addEventListener("focusout", () => (edited = null));
  form.addEventListener("submit", (event) => event.preventDefault());

  /** Build the settings of the shown scene. */
  function build() {
    built = store.scene;
    form.replaceChildren(...fieldsetsOf(data, store.scene));
    boxes = /** @type {Setting[]} */ ([...form.elements]).filter((box) => box.name);
  }

  /** What a box shows; handles of a band that is not there stand at the number itself. @param {Setting} box */
  function textOf({ name, type, dataset: { part } }) {
    if (name === "pack") {
      const packs = Object.entries(data.scenes[store.scene].machine?.packs ?? {});
      return packs.find(([, natural]) => typedText(natural) === store.texts.natural_hz)?.[0] ?? "";
    }
    const text = store.texts[name] ?? "";
    if (!text && type === "range" && name in NO_BANDS) return String(store.value(name.replace("_band", "")));
    return printedText(part ? text.split(":")[Number(part)] ?? "" : text);
  }

  /** Show the state. */
  function render() {
    const { texts } = store;
    if (built !== store.scene) build();
    for (const part of /** @type {NodeListOf<HTMLElement>} */ (form.querySelectorAll("[data-drives]"))) {
      part.hidden = !part.dataset.drives?.split(" ").includes(texts.drive);
      if (part instanceof HTMLOptionElement) part.disabled = part.hidden;
    }
    for (const box of boxes) {
      const text = textOf(box);
      if (box.type === "checkbox") /** @type {HTMLInputElement} */ (box).checked = text === "1" || text === "log";
      else if (box.type === "range" && Number.isNaN(Number(text))) continue; // its handle stays, as the map's point
      else if (box !== edited && box.value !== text) box.value = text;
      if (box.dataset.unit !== undefined) set(box, { "aria-valuetext": `${text} ${box.dataset.unit}`.trim() });
    }
    const bands = input("bands");
    bands.checked = Object.keys(NO_BANDS).some((key) => texts[key]);
    bands.disabled = `${texts.x} ${texts.y}`.includes("friction");
    const other = texts.follow === "0" ? "friction_ratio" : "kinetic_friction"; // the one that is not given
    for (const name of BANDED) {
      const mayHave = bands.checked && ![other, texts.x, texts.y].includes(name);
      place(`row-${name}_band`).hidden = !texts[`${name}_band`] && !mayHave;
    }
  }

  /** A problem as a button that leads to its box. @param {Problem} problem */
  function leading({ field, text }) {
    const box = boxes.find(({ name }) => name === field);
    const label = `not updated: ${text}`;
    if (!box || box.closest("[hidden]")) return label;
    const button = html("button", { type: "button" }, label);
    button.addEventListener("click", () => box.focus());
    return button;
  }

  /** Show what is refused, in the header and beside its field.
   * @param {Problem[]} problems @param {string} instead what the header says in place of them */
  function refuse(problems, instead) {
    for (const box of boxes) {
      const text = problems.find((problem) => problem.field === box.name)?.text ?? "";
      set(box, { "aria-invalid": String(text !== "") });
      document.getElementById(`note-${box.name}`)?.replaceChildren(text);
    }
    const line = html("div", {}, ...(instead ? [instead] : problems.map(leading)));
    if (place("refused").textContent !== line.textContent) place("refused").replaceChildren(...line.childNodes);
  }

  return { render, refuse };
}
