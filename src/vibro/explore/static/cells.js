// @ts-check
/** The cells of a map as pixels: colours, and hatches drawn at the resolution of the screen. */

const NO_ANSWER = 0xffe9e9e9; // colours are AABBGGRR, as the bytes of an image lie in memory
const FAINT = 0xff8a8a8a;
const INK = 0xff222222;
const WHITE = 0xffffffff;

export const MARK = { backwards: 1, averaged: 2, coexists: 4, preview: 8, missing: 16, meets: 32 };

/** Bits of what lies over a cell's colour; those of a map's marks keep their places. */
export const OVER = { either: 64, "////": 128, "\\\\\\\\": 256, xxx: 512, "---": 1024, "+++": 2048, veil: 4096 };
const UNANSWERED = 128 + 256 + 512 + 1024 + 2048;

/** @param {string} colour #RRGGBB */
export function pixel(colour) {
  const n = parseInt(colour.slice(1), 16);
  return (0xff000000 | ((n & 255) << 16) | (n & 0xff00) | (n >> 16)) >>> 0;
}

/** Where a number lies on its scale, 0 to 1. @param {ScaleInfo} scale @param {number} value */
export function onScale({ kind, low, high, width = 1 }, value) {
  const of = kind === "log" ? Math.log : kind === "asinh" ? (/** @type {number} */ v) => Math.asinh(v / width) : Number;
  const share = (of(kind === "log" ? Math.max(value, low) : value) - of(low)) / (of(high) - of(low));
  return Math.min(Math.max(share, 0), 1);
}

/** 256 colours of a scale, the lowest first. @param {ScaleInfo} scale */
export function scaleColours(scale) {
  const bytes = Uint8Array.from(atob(scale.colours), (c) => c.charCodeAt(0));
  return Uint32Array.from({ length: 256 }, (_, n) => 0xff000000 + (bytes[3 * n + 2] << 16) + (bytes[3 * n + 1] << 8) + bytes[3 * n]);
}

/** The colour of every cell, a second one where the regime is uncertain, and what lies over them. @param {MapAnswer} map */
export function looks({ header, arrays }) {
  const { regime, status, marks, values, lowest, highest } = arrays;
  const faces = new Map(header.regimes.map((r) => [r.code, pixel(r.colour)]));
  const hatches = header.statuses.map((s) => (s.answered ? 0 : OVER[/** @type {keyof typeof OVER} */ (s.hatch)] ?? 0));
  const palette = header.scale && scaleColours(header.scale);
  const target = header.curves.some((c) => c.name === "target") || marks.some((m) => m & MARK.meets);
  const count = regime.length;
  const [first, second, over] = [new Uint32Array(count), new Uint32Array(count), new Uint16Array(count)];
  for (let i = 0; i < count; i++) {
    const mark = marks[i];
    let face = faces.get(regime[i]) ?? NO_ANSWER;
    let bits = mark & (MARK.backwards | MARK.coexists);
    if (header.scale && palette && regime[i] !== 0) {
      const value = values[i];
      if (!Number.isNaN(value)) {
        face = palette[Math.round(255 * onScale(header.scale, value))];
        bits |= mark & (MARK.averaged | MARK.preview);
      } else if (mark & MARK.missing) [face, bits] = [NO_ANSWER, MARK.missing];
      else if (hatches[status[i]] || regime[i] < 0) [face, bits] = [NO_ANSWER, hatches[status[i]]];
      else face = WHITE;
    } else if (regime[i] < 0) bits = hatches[status[i]];
    first[i] = second[i] = face;
    if (!header.scale && header.bands && lowest[i] !== highest[i] && lowest[i] >= 0) {
      first[i] = faces.get(lowest[i]) ?? NO_ANSWER;
      second[i] = faces.get(highest[i]) ?? NO_ANSWER;
      bits |= OVER.either;
    }
    over[i] = target && !(mark & MARK.meets) ? bits | OVER.veil : bits;
  }
  return { first, second, over };
}

/** One pixel where something lies over the colour; x, y [CSS px] downwards. */
function covered(/** @type {number} */ bits, first = 0, second = 0, x = 0, y = 0) {
  const [rising, falling] = [(x + y) % 14, (x - y + 1e5) % 9];
  let colour = bits & OVER.either && rising < 7 ? second : first;
  if (bits & UNANSWERED) {
    const lines =
      (bits & (OVER["////"] | OVER.xxx) && (x + y) % 9 < 1) || (bits & (OVER["\\\\\\\\"] | OVER.xxx) && falling < 1) ||
      (bits & (OVER["---"] | OVER["+++"]) && y % 8 < 1) || (bits & OVER["+++"] && x % 8 < 1);
    if (lines) colour = FAINT;
  }
  if (bits & MARK.backwards && x % 12 < 1) colour = INK;
  if (bits & MARK.averaged && rising < 3.6) colour = rising >= 1.2 && rising < 2.4 ? INK : WHITE;
  if (bits & MARK.coexists && x % 7 < 1.6 && y % 7 < 1.6) colour = FAINT;
  if (bits & MARK.preview && x % 5 < 1 && y % 5 < 1) colour = WHITE;
  if (bits & MARK.missing && x % 10 < 1 && y % 10 < 1) colour = FAINT;
  if (bits & OVER.veil) colour = 0xff000000 + ((colour >> 2) & 0x3f3f3f) + 0xbfbfbf; // three quarters white
  return colour;
}

/**
 * Paint cells over a whole canvas; rows lie from the lowest up.
 * @param {HTMLCanvasElement} canvas @param {number} zoom device pixels a CSS pixel
 * @param {{first: Uint32Array, second: Uint32Array, over: Uint16Array}} cells @param {number} nx @param {number} ny
 */
export function paint(canvas, zoom, { first, second, over }, nx, ny) {
  const { width, height } = canvas;
  const image = new ImageData(width, height);
  const pixels = new Uint32Array(image.data.buffer);
  const columns = Int32Array.from({ length: width }, (_, px) => Math.round(((px + 0.5) / width) * (nx - 1)));
  for (let py = 0, at = 0; py < height; py++) {
    const row = nx * Math.round((1 - (py + 0.5) / height) * (ny - 1));
    for (let px = 0; px < width; px++, at++) {
      const cell = row + columns[px];
      pixels[at] = over[cell] ? covered(over[cell], first[cell], second[cell], px / zoom, py / zoom) : first[cell];
    }
  }
  canvas.getContext("2d")?.putImageData(image, 0, 0);
}

/** @type {Map<string, string>} */
const painted = new Map();

/** Cells as the address of a picture, for samples and colour bars. @param {number[]} first @param {number} bits */
export function picture(first, bits, second = 0, width = 24, height = 14) {
  const key = [bits, second, width, height, ...first].join();
  if (!painted.has(key)) {
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [2 * width, 2 * height];
    const all = { first: Uint32Array.from(first), second: Uint32Array.from(first, () => second), over: new Uint16Array(first.length).fill(bits) };
    paint(canvas, 2, all, 1, first.length);
    painted.set(key, canvas.toDataURL());
  }
  return painted.get(key) ?? "";
}
