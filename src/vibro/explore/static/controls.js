/** The settings: the server wrote them into the page, and every box has a key of the state as its name. */

import { html, input, place, set } from "./draw.js";

/** @typedef {HTMLInputElement | HTMLSelectElement} Box */
/** @typedef {import("./state.js").Store} Store */
const BANDS = ["static_friction_band", "kinetic_friction_band", "friction_ratio_band"];
const NO_BANDS = Object.fromEntries(BANDS.map((key) => [key, ""]));
let boxes = /** @type {Box[]} */ ([]);

/** A decimal comma as a point, which every box takes as each holds one number; 1,250 may be a thousand, and stays.
 * @param {string} text */
function withPoint(text) {
  if (/^[+-]?[1-9]\d{0,2},\d{3}(?!\d)/.test(text)) return text;
  return text.replace(/^([+-]?\d+),(\d+)(?![\d,.:])/, "$1.$2");
}

/** What a box changes. @param {Box} box @param {Store} store @returns {State} */
function patchOf(box, store) {
  const { name, type } = box;
  const text = withPoint(box.value.trim());
  const patch = box instanceof HTMLSelectElement && box.selectedOptions[0]?.dataset.patch;
  if (typeof patch === "string") return Object.fromEntries(new URLSearchParams(patch));
  if (name === "x" || name === "y") return axisPatch(name, name === "x" ? "y" : "x", text, store.state);
  if (name === "follow" || name === "bands") {
    const follow = Number(input("follow").checked);
    return { ...NO_BANDS, follow: `${follow}`, ...(input("bands").checked ? store.bands[follow] : {}) };
  }
  if (box.dataset.part) return { [name]: withPart(/** @type {HTMLInputElement} */ (box), text, store.state[name]) };
  const most = name === "kinetic_friction" && type === "range" ? store.value("static_friction") : Infinity;
  return { [name]: Number(text) > most ? `${most}` : text };
}

/** A range or band with a new part: of its handles none passes the other; without an end there is none.
 * @param {HTMLInputElement} box @param {string} text @param {string} [whole] */
function withPart({ type, checked, dataset: { part } }, text, whole) {
  const ends = whole ? whole.split(":") : [text, text];
  if (type === "checkbox") return [...ends.slice(0, 2), ...(checked ? [text] : [])].join(":");
  ends[Number(part)] = text;
  if (type === "range" && Number(ends[0]) > Number(ends[1])) ends.fill(text);
  return text && ends.join(":");
}

/** Choose an axis; the other's quantity swaps them.
 * @param {string} axis @param {string} other @param {string} column @param {State} state @returns {State} */
function axisPatch(axis, other, column, state) {
  const bands = column.includes("friction") ? NO_BANDS : {};
  if (column !== state[other]) return { [axis]: column, [`${axis}_range`]: "", ...bands };
  const ranges = { [`${axis}_range`]: state[`${other}_range`], [`${other}_range`]: state[`${axis}_range`] };
  return { [axis]: column, [other]: state[axis], ...ranges };
}

/** @param {string} form @param {Store} store @param {(patch: State, control: string, isFinished: boolean) => void} change */
export function bindControls(form, store, change) {
  place("controls").innerHTML = form;
  boxes = /** @type {Box[]} */ ([...document.forms[0].elements]).filter((box) => box.name);
  const ofDrives = /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll("[data-drives]"));
  let edited = /** @type {EventTarget | null} */ (null); // the box that somebody types in
  for (const type of ["input", "change"]) document.addEventListener(type, ({ target }) => {
    const box = /** @type {Box} */ (target);
    const isFinished = type === "change";
    if (isFinished || box.type === "range") change(patchOf(box, store), box.name, isFinished);
    edited = isFinished ? null : box; // and not overwritten meanwhile
  });
  document.addEventListener("focusout", () => (edited = null));

  /** The pack that has the natural frequency; of several the first. @param {Box} box */
  function packOf(box) {
    const has = (/** @type {HTMLElement} */ option) => option.dataset.patch === `natural_hz=${store.state.natural_hz}`;
    return [.../** @type {HTMLSelectElement} */ (box).options].find(has)?.value ?? "";
  }

  /** What a box shows; handles of a band that is not there stand at the number itself. @param {Box} box */
  function textOf(box) {
    const { name, type, dataset: { part } } = box;
    if (name === "pack") return packOf(box);
    const text = store.state[name] ?? "";
    if (!text && type === "range" && BANDS.includes(name)) return `${store.value(name.replace("_band", ""))}`;
    return part ? text.split(":")[Number(part)] ?? "" : text;
  }

  return function render() {
    const [state, drive] = [store.state, store.drive()];
    for (const part of ofDrives) {
      part.hidden = !part.dataset.drives?.split(" ").includes(drive);
      if (part instanceof HTMLOptionElement) part.disabled = part.hidden;
    }
    for (const box of boxes) {
      const text = textOf(box);
      if (box.type === "checkbox") /** @type {HTMLInputElement} */ (box).checked = text === "1" || text === "log";
      else if (box.type === "range" && Number.isNaN(Number(text))) continue; // its handle stays, as the point on the map
      else if (box !== edited && box.value !== text) box.value = text;
      if (box.dataset.unit !== undefined) set(box, { "aria-valuetext": `${text} ${box.dataset.unit}`.trim() });
    }
    const bands = input("bands");
    bands.checked = BANDS.some((key) => state[key]);
    bands.disabled = !["line", "machine"].includes(drive) || `${state.x} ${state.y}`.includes("friction");
    const other = BANDS[state.follow === "0" ? 2 : 1]; // the kinetic friction's, or its ratio's
    for (const key of BANDS) place(`row-${key}`).hidden = !state[key] && (!bands.checked || key === other);
  };
}

/** A problem as a button that leads to its box. @param {Problem} problem */
function leading({ field, text }) {
  const box = boxes.find(({ name }) => name === field);
  const said = `not updated: ${text}`;
  if (!box || box.closest("[hidden]")) return said;
  const button = html("button", { type: "button" }, said);
  button.addEventListener("click", () => box.focus());
  return button;
}

/** Show what the server refused, in the header and beside its field.
 * @param {Problem[]} problems @param {string} badLink what to say instead */
export function showRefused(problems, badLink) {
  for (const box of boxes) {
    const text = problems.find((p) => p.field === box.name)?.text ?? "";
    set(box, { "aria-invalid": String(text !== "") });
    document.getElementById(`note-${box.name}`)?.replaceChildren(text);
  }
  const line = html("div", {}, ...(badLink ? [badLink] : problems.map(leading)));
  if (place("refused").textContent !== line.textContent) place("refused").replaceChildren(...line.childNodes);
}
