// @ts-check
/** What can be taken along: pictures of the map, and texts. */

import { INK, byId, svg } from "./draw.js";

/** The map as it is seen, on its own: on white, with the canvas as an image inside. @param {import("./map.js").MapView} view */
function wholeFigure({ svg: seen, canvas, box }) {
  const figure = /** @type {SVGElement} */ (seen.cloneNode(true));
  const { left: x, top: y, width, height } = box;
  figure.querySelectorAll(".surface, .reach, .focus").forEach((part) => part.remove());
  figure.setAttribute("xmlns", "http://www.w3.org/2000/svg");
  figure.setAttribute("color", INK);
  figure.prepend(
    svg("rect", { width: "100%", height: "100%", fill: "#FFFFFF" }),
    svg("image", { href: canvas.toDataURL(), x, y, width, height, preserveAspectRatio: "none" }));
  return new XMLSerializer().serializeToString(figure);
}

/** @param {BlobPart} content @param {string} type @param {string} name */
function save(content, type, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([content], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

/** @param {import("./map.js").MapView} view */
async function savePng(view) {
  const image = new Image();
  const address = URL.createObjectURL(new Blob([wholeFigure(view)], { type: "image/svg+xml" }));
  image.src = address;
  await image.decode();
  URL.revokeObjectURL(address);
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [2 * image.width, 2 * image.height];
  canvas.getContext("2d")?.drawImage(image, 0, 0, canvas.width, canvas.height);
  canvas.toBlob((blob) => blob && save(blob, "image/png", `${name(view)}.png`));
}

/** @param {import("./map.js").MapView} view */
const name = (view) => `vibro-${view.map?.header.view ?? "map"}`;

/** @param {import("./map.js").MapView} view @param {(text: string) => void} say */
export function offerFiles(view, say) {
  const on = (/** @type {string} */ id, /** @type {() => unknown} */ act) => byId(id, HTMLButtonElement).addEventListener("click", act);
  on("png", () => savePng(view));
  on("svg", () => save(wholeFigure(view), "image/svg+xml", `${name(view)}.svg`));
  on("save-toml", () => save(byId("toml", HTMLElement).textContent ?? "", "application/toml", "scene.toml"));
  for (const id of ["command", "toml"]) {
    on(`copy-${id}`, async () => {
      const text = byId(id, HTMLElement);
      const done = await navigator.clipboard.writeText(text.textContent ?? "").then(() => true, () => false);
      getSelection()?.selectAllChildren(text);
      say(done ? "copied" : "selected: copy it by Ctrl+C");
    });
  }
}
