/** What can be taken along: pictures of the map, its cells, a scene file, a command line. */

import { INK, fontFamily, place, set, svg } from "./draw.js";
import { MAP_HEIGHT, MAP_WIDTH, OF_FLIGHT, jobOf } from "./jobs.js";
import { KNOBS_OF_MACHINES, csvOf } from "./tables.js";
import { typedText } from "./typed.js";

const COPIED = 2000; // [ms] that a button says so
const SAVED = "scene.toml"; // as the page calls it

/** @typedef {import("./map.js").MapView} MapView
 * @typedef {import("./state.js").Shown} Shown */

// ------------------------------------------------------------------------------
// The same map by vibro itself.

/** Quantities of the map without their usual values, as they are typed: ranges with counts.
 * @param {any} data @param {Shown} state @returns {Record<string, string>} */
function givenTexts({ quantities }, state) {
  const { values: fixed } = jobOf(state, 2, 2);
  const { trough_length: length } = state.values;
  const given = /** @type {Record<string, string>} */ ({});
  for (const [name, value] of Object.entries(fixed)) {
    const isUsual = !quantities[name]?.control || value === quantities[name].default;
    if (value !== undefined && !isUsual) given[name] = typedText(value);
  }
  for (const [axis, count] of /** @type {[Shown["x"], number][]} */ ([[state.x, MAP_WIDTH], [state.y, MAP_HEIGHT]])) {
    given[axis.name] = `${typedText(axis.from)}:${typedText(axis.to)}:${count}${axis.log ? ":log" : ""}`;
  }
  if (length !== undefined) given.trough_length = typedText(length);
  return Object.fromEntries(Object.keys(quantities).filter((name) => name in given).map((name) => [name, given[name]]));
}

/** A word of a command line as a shell takes it, as Python's shlex quotes. @param {string} word */
function shellWord(word) {
  return /^[\w@%+=:,./-]+$/.test(word) ? word : `'${word.replaceAll("'", `'"'"'`)}'`;
}

/** The command line that makes the same map, of the same cells. @param {any} data @param {Shown} state */
export function commandOf(data, state) {
  const isGiven = Boolean(state.given || state.machine);
  const options = isGiven ? [] : Object.entries(givenTexts(data, state)).flatMap(([name, text]) => {
    const option = data.quantities[name].options;
    return option.startsWith("-") ? [option, text] : [`${option}=${text}`];
  });
  const name = data.scenes[state.scene].name || "map";
  return [
    "vibro", "map", ...(isGiven ? [SAVED] : options), "--x", state.x.name, "--y", state.y.name,
    ...(OF_FLIGHT.includes(state.view) ? ["--show", state.view] : []),
    ...(state.target === null ? [] : ["--speed", typedText(state.target)]), "-o", `out/${name}`,
  ].map(shellWord).join(" ");
}

/** Lists of amplitudes and phases in place of single harmonics, where a direction has more than an ellipse has;
 * and the other quantities. @param {any} data @param {Record<string, number>} values
 * @returns {[Record<string, number[]>, Record<string, number>]} */
function harmonicLists({ quantities }, values) {
  const others = { ...values }, lists = /** @type {Record<string, number[]>} */ ({});
  for (const way of ["along", "normal"]) {
    if (!Object.keys(values).some((name) => name.startsWith(way) && /(^along_phase|_\d+)$/.test(name))) continue;
    for (const first of [`${way}_amplitude`, `${way}_phase`]) {
      const own = Object.keys(values).filter((name) => name.startsWith(first));
      const orders = own.map((name) => Number(/\d+$/.exec(name) ?? 1));
      const names = Array.from({ length: Math.max(1, ...orders) }, (_, n) => (n ? `${first}_${n + 1}` : first));
      lists[quantities[first].column.replace(first, `${first}s`)] = names.map((name) => others[name] ?? 0.0);
      for (const name of names) delete others[name];
    }
  }
  return [lists, others];
}

/** The command that solves the scene file with the shown springs, where they are not the machine's own, which the
 * file keeps, as it may have been calibrated with them; else empty. @param {Shown} state */
export function otherSprings({ machine, values: { natural } }) {
  const isOther = machine && natural !== undefined && natural !== machine.fields.natural_frequency;
  return isOther ? `vibro solve ${SAVED} natural=${typedText(natural)}` : "";
}

/** The scene file that makes the same map, of the same cells. @param {any} data @param {Shown} state */
export function tomlOf(data, state) {
  const { quantities } = data, { given, machine } = state;
  const { friction_ratio: _, ...point } = state.values;
  for (const name of given?.table.length ? Object.keys(given.values) : []) delete point[name]; // [motion] gives them
  const column = (/** @type {string} */ name) => quantities[name].column;
  const [lists, others] = given ? harmonicLists(data, point) : [{}, point];
  const names = Object.keys(quantities).filter((name) => name in others && !KNOBS_OF_MACHINES.includes(name));
  const moved = KNOBS_OF_MACHINES.filter((name) => machine && name in point && point[name] !== machine.own[name]);
  // Another spring pack stands with the axes: a machine's own may be the one that it was calibrated with.
  const swept = Object.entries(givenTexts(data, state)).filter(([name, text]) =>
    text.includes(":") || name === "friction_ratio" || (name === "natural" && moved.includes(name)));
  const knobs = moved.filter((name) => name !== "natural").map((name) => [column(name), typedText(point[name])]);
  const ofMachine = Object.entries({ ...machine?.table, ...Object.fromEntries(knobs) });
  const table = (/** @type {string} */ name, /** @type {string[]} */ lines) =>
    lines.length ? [`[${name}]`, ...lines, ""] : [];
  const springs = otherSprings(state);
  return [
    ...(springs ? [`# with the springs that were shown: ${springs}`] : []), "[scene]",
    ...Object.entries(lists).map(([key, values]) => `${key} = [${values.map(typedText).join(", ")}]`),
    ...names.map((name) => `${column(name)} = ${typedText(others[name])}`), "",
    ...table("motion", given?.table ?? []),
    ...table("machine", ofMachine.map(([key, text]) => `${key} = ${text}`)),
    "[map]", ...swept.map(([name, text]) => `${column(name)} = ${text.includes(":") ? `"${text}"` : text}`), "",
  ].join("\n");
}

// ------------------------------------------------------------------------------
// Downloads and copies.

/** The name of a file of the shown scene. @param {MapView} view @param {string} what it holds */
const nameOf = ({ data, state }, what) => `${data.scenes[state?.scene ?? 0].file}-${what}`;

/** @param {string} text @param {string} [where] */
function tell(text, where = "says") {
  place(where).textContent = text;
}

/** The map as it is seen, dark on white, with its canvas as an image inside. @param {MapView} view */
function figure({ svg: seen, canvas, box: { left, top, width, height } }) {
  const whole = /** @type {SVGElement} */ (seen.cloneNode(true));
  whole.querySelectorAll("#surface, .reach, .focus").forEach((part) => part.remove());
  const image = svg("image", { x: left, y: top, width, height, href: canvas.toDataURL(), preserveAspectRatio: "none" });
  whole.prepend(svg("rect", { width: "100%", height: "100%", fill: "#FFFFFF" }), image);
  set(whole, { color: INK, "font-family": fontFamily() });
  return new Blob([new XMLSerializer().serializeToString(whole)], { type: "image/svg+xml" });
}

/** @param {Blob | null} blob @param {string} name */
function save(blob, name) {
  if (!blob) return;
  const link = document.createElement("a");
  [link.href, link.download] = [URL.createObjectURL(blob), name];
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  tell(`${name} was handed to the browser.`, "saving"); // which does not say whether it keeps it
}

/** @param {MapView} view */
async function savePng(view) {
  const image = new Image();
  image.src = URL.createObjectURL(figure(view));
  await image.decode();
  URL.revokeObjectURL(image.src);
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [2 * image.width, 2 * image.height];
  canvas.getContext("2d")?.drawImage(image, 0, 0, canvas.width, canvas.height);
  canvas.toBlob((blob) => save(blob, nameOf(view, `${view.drawn?.view}.png`)));
}

/** Save the cells of the map, which may take long to be solved, and say so.
 * @param {MapView} view @param {boolean} hasComma */
async function saveCsv(view, hasComma) {
  tell("computing the CSV …", "saving");
  const isDone = await view.solving;
  const { cells, data, state } = view;
  if (!isDone || !cells || !state) return tell("There is no CSV, for the map was changed: ask again.", "saving");
  const table = csvOf(data, engineOf(exports, data.known), state, cells, hasComma);
  save(new Blob([table], { type: "text/csv" }), nameOf(view, hasComma ? "map-comma.csv" : "map.csv"));
}

/** Copy a text, and say so, on its button too for a while. @param {string} id */
async function copy(id) {
  getSelection()?.selectAllChildren(place(id)); // to be copied by hand where that is refused
  const label = place(`copy-${id}`);
  try {
    await navigator.clipboard.writeText(place(id).textContent ?? "");
    tell("copied");
    label.textContent = "Copied";
    setTimeout(() => (label.textContent = "Copy"), COPIED);
  } catch {
    tell("selected");
  }
}

/** @param {MapView} view */
export function offerFiles(view) {
  const acts = {
    csv: () => saveCsv(view, false), "csv-comma": () => saveCsv(view, true),
    png: () => savePng(view), svg: () => save(figure(view), nameOf(view, `${view.drawn?.view}.svg`)),
    "save-toml": () => save(new Blob([place("toml").textContent ?? ""]), SAVED),
    "copy-command": () => copy("command"), "copy-toml": () => copy("toml"),
  };
  for (const [id, act] of Object.entries(acts)) place(id).addEventListener("click", () => void act());
}
