/** Downloads and copies: pictures of the map, its cells, and texts. */

import { FONT, INK, place, set, svg } from "./draw.js";
import { ask } from "./session.js";

const COPIED = 2000; // [ms] that a button says so

/** @typedef {import("./map.js").MapView} MapView @typedef {(text: string, where?: string) => void} Say */
const nameOf = (/** @type {MapView} */ { map }) => `vibro-${map?.header.view}`;

/** The map as it is seen, dark on white, with its canvas as an image inside. @param {MapView} view */
function figure({ svg: seen, canvas, box: { left, top, width, height } }) {
  const whole = /** @type {SVGElement} */ (seen.cloneNode(true));
  whole.querySelectorAll("#surface, .reach, .focus").forEach((part) => part.remove());
  const image = svg("image", { x: left, y: top, width, height, href: canvas.toDataURL(), preserveAspectRatio: "none" });
  whole.prepend(svg("rect", { width: "100%", height: "100%", fill: "#FFFFFF" }), image);
  set(whole, { color: INK, "font-family": FONT });
  return new Blob([new XMLSerializer().serializeToString(whole)], { type: "image/svg+xml" });
}

/** @param {Blob | null} blob @param {string} name */
function save(blob, name) {
  if (!blob) return;
  const link = document.createElement("a");
  [link.href, link.download] = [URL.createObjectURL(blob), name];
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
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
  canvas.toBlob((blob) => save(blob, `${nameOf(view)}.png`));
}

/** Save the cells of the map, which may take long to compute, and say so. @param {string} query @param {Say} say */
async function saveCsv(query, say) {
  say("computing the CSV …", "saving");
  const response = await ask(`/table.csv?${query}`).catch(() => null);
  const table = response?.ok ? await response.blob().catch(() => null) : null; // null if it is cut short
  save(table, "vibro-map.csv");
  say(table ? "" : "There is no CSV: mend what is refused above, or ask again.", "saving");
}

/** Copy a text, and say so, on its button too for a while. @param {string} id @param {Say} say */
async function copy(id, say) {
  getSelection()?.selectAllChildren(place(id)); // to be copied by hand where that is refused
  await navigator.clipboard.writeText(place(id).textContent ?? "").then(() => {
    say("copied");
    say("Copied", `copy-${id}`);
    setTimeout(say, COPIED, "Copy", `copy-${id}`);
  }, () => say("selected"));
}

/** @param {MapView} view @param {() => string} query @param {Say} say */
export function offerFiles(view, query, say) {
  const acts = {
    csv: () => saveCsv(query(), say), "csv-comma": () => saveCsv(`${query()}&decimal_comma=1`, say),
    png: () => savePng(view), svg: () => save(figure(view), `${nameOf(view)}.svg`),
    "save-toml": () => save(new Blob([place("toml").textContent ?? ""]), "scene.toml"),
    "copy-command": () => copy("command", say), "copy-toml": () => copy("toml", say),
  };
  for (const [id, act] of Object.entries(acts)) place(id).addEventListener("click", act);
}
