/** The settings: the server wrote them into the page, and every box has a key of the state as its name. */

import { html, input, place, set } from "./draw.js";

/** @typedef {HTMLInputElement | HTMLSelectElement} Box */
/** @typedef {import("./state.js").Store} Store */
const BANDS = ["static_friction_band", "kinetic_friction_band", "friction_ratio_band"];
const NO_BANDS = Object.fromEntries(BANDS.map((key) => [key, ""]));
const form = /** @type {HTMLFormElement} */ (place("controls"));
const boxes = /** @type {Box[]} */ ([...form.elements]).filter((box) => box.name);
const ofDrives = /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll("[data-drives]"));

/** What a box changes. @param {Box} box @param {Store} store @returns {State} */
function patchOf(box, store) {
  const { name, type } = box;
  const text = box.value.trim();
  const patch = box instanceof HTMLSelectElement && box.selectedOptions[0]?.dataset.patch;
  if (typeof patch === "string") return Object.fromEntries(new URLSearchParams(patch));
  if (name === "x" || name === "y") return axisPatch(name, name === "x" ? "y" : "x", text, store.state);
  if (name === "follow" || name === "bands") return frictionPatch(store);
  if (name.endsWith("_range")) {
    const parts = boxes.filter((other) => other.name === name).map((other) => other.value);
    return { [name]: parts.slice(0, input(`${name[0]}-log`).checked ? 3 : 2).join(":") };
  }
  if (name.endsWith("_band")) return { [name]: bandText(box, text, store.state[name]) };
  const isTooLarge = name === "kinetic_friction" && type === "range" && Number(text) > store.value("static_friction");
  return { [name]: isTooLarge ? `${store.value("static_friction")}` : text };
}

/** A band with a new end: of its handles none passes the other; without an end there is none.
 * @param {Box} box @param {string} text @param {string} [band] */
function bandText({ type, dataset }, text, band) {
  if (!text) return "";
  const ends = band ? band.split(":") : [text, text];
  ends[Number(dataset.part)] = text;
  if (type === "range" && Number(ends[0]) > Number(ends[1])) ends.fill(text);
  return ends.join(":");
}

/** Choose an axis; the other's quantity swaps them.
 * @param {string} axis @param {string} other @param {string} column @param {State} state @returns {State} */
function axisPatch(axis, other, column, state) {
  const bands = column.includes("friction") ? NO_BANDS : {};
  if (column !== state[other]) return { [axis]: column, [`${axis}_range`]: "", ...bands };
  const ranges = { [`${axis}_range`]: state[`${other}_range`], [`${other}_range`]: state[`${axis}_range`] };
  return { [axis]: column, [other]: state[axis], ...ranges };
}

/** Bands of a tenth to either side where there are none yet; where kinetic friction follows, one of its ratio
 * stands for its own. @param {Store} store @returns {State} */
function frictionPatch(store) {
  /** @type {State} */
  const patch = { ...NO_BANDS, follow: input("follow").checked ? "1" : "0" };
  if (!input("bands").checked) return patch;
  const [ofStatic, ofKinetic, ofRatio] = BANDS.map((key) => store.state[key] ?? "");
  const most = store.value("static_friction");
  const times = (/** @type {string} */ band, /** @type {number} */ factor, limit = Infinity) =>
    band.split(":").map((end) => Number(Math.min(Number(end) * factor, limit).toPrecision(4))).join(":");
  const isNew = !(ofStatic || ofKinetic || ofRatio);
  patch.static_friction_band = isNew ? times("0.9:1.1", most) : ofStatic;
  if (patch.follow === "1") patch.friction_ratio_band = ofKinetic ? times(ofKinetic, 1 / most, 1) : ofRatio;
  else if (ofRatio) patch.kinetic_friction_band = times(ofRatio, most);
  else patch.kinetic_friction_band = ofKinetic || times("0.9:1.1", store.value("kinetic_friction"));
  return patch;
}

/** @param {Store} store @param {(patch: State, control: string, isFinished: boolean) => void} change */
export function bindControls(store, change) {
  let edited = /** @type {EventTarget | null} */ (null); // the box that somebody types in
  form.addEventListener("submit", (event) => event.preventDefault());
  for (const type of ["input", "change"]) document.addEventListener(type, ({ target }) => {
    const box = /** @type {Box} */ (target);
    const isFinished = type === "change";
    if (isFinished || box.type === "range") change(patchOf(box, store), box.name, isFinished);
    edited = isFinished ? null : box; // and not overwritten meanwhile
  });
  document.addEventListener("focusout", () => (edited = null));

  /** What a box shows; handles of a band that is not there stand at the number itself. @param {Box} box */
  function textOf({ name, type, dataset: { part } }) {
    const text = store.state[name] ?? "";
    if (!text && type === "range" && BANDS.includes(name)) return `${store.value(name.replace("_band", ""))}`;
    return part ? text.split(":")[Number(part)] ?? "" : text;
  }

  return function render() {
    const { state, drive } = store;
    for (const part of ofDrives) {
      part.hidden = !part.dataset.drives?.split(" ").includes(drive);
      if (part instanceof HTMLOptionElement) part.disabled = part.hidden;
    }
    for (const box of boxes) {
      const text = textOf(box);
      if (box.type === "checkbox") /** @type {HTMLInputElement} */ (box).checked = text === "1" || text === "log";
      else if (box !== edited && box.value !== text) box.value = text;
      if (box.dataset.unit !== undefined) set(box, { "aria-valuetext": `${text} ${box.dataset.unit}`.trim() });
    }
    const bands = input("bands");
    bands.checked = BANDS.some((key) => state[key]);
    bands.disabled = drive !== "line" || `${state.x} ${state.y}`.includes("friction");
    place("no-bands").hidden = !bands.disabled;
    const other = BANDS[state.follow === "0" ? 2 : 1]; // the kinetic friction's, or its ratio's
    for (const key of BANDS) place(`row-${key}`).hidden = !state[key] && (!bands.checked || key === other);
  };
}

/** What is wrong, as a button that leads to its box. @param {Problem} problem */
function leading({ field, text }) {
  const box = boxes.find(({ name }) => name === field);
  if (!box || box.closest("[hidden]")) return text;
  const button = html("button", { type: "button" }, text);
  button.addEventListener("click", () => box.focus());
  return button;
}

/** Show what the server refused, in the header and beside its field.
 * @param {Problem[]} problems @param {string} badLink what to say instead */
export function showRefused(problems, badLink) {
  for (const box of boxes) {
    const text = problems.find((p) => p.field === box.name)?.text ?? "";
    set(box, { "aria-invalid": String(text !== "") });
    const note = document.getElementById(`note-${box.name}`);
    note?.replaceChildren(text);
    note?.classList.toggle("error", text !== "");
  }
  const line = problems.flatMap((problem, n) => [n ? "; " : "not updated: ", leading(problem)]);
  const shown = badLink ? [badLink] : line;
  const text = shown.map((part) => (typeof part === "string" ? part : part.textContent)).join("");
  if (place("refused").textContent !== text) place("refused").replaceChildren(...shown);
}
