/** The cells of a map as pixels: their colours, and hatches at the resolution of the screen. */

const [NO_ANSWER, FAINT, INK, WHITE] = [0xffe9e9e9, 0xff8a8a8a, 0xff222222, 0xffffffff]; // AABBGGRR, as in memory

/** Bits of what lies over a cell's colour: those of the server's marks, then our own. */
export const OVER = {
  backwards: 1, averaged: 2, coexists: 4, preview: 8, missing: 16, meets: 32, covered: 64, unproved: 128,
  either: 256, veil: 512, "/": 1024, "\\": 2048, x: 4096, "-": 8192, "+": 16384,
};
const hatchBit = (/** @type {StatusStyle} */ { hatch }) => /** @type {Record<string, number>} */ (OVER)[hatch] ?? 0;

/** What the legend calls bits, and on which colour it shows them. */
const NAMES = /** @type {[number, string, number][]} */ ([
  [OVER.backwards, "moves backwards", WHITE], [OVER.averaged, "mean of motion without a short period", WHITE],
  [OVER.coexists, "another motion exists", WHITE], [OVER.preview, "preview, not exact yet", 0xff808080],
  [OVER.missing, "not computed yet", NO_ANSWER], [OVER.unproved, "no speed is guaranteed", NO_ANSWER],
  [OVER.either, "either regime, as friction may be", 0xffcc9966], [OVER.veil, "misses the target speed", 0xff808080],
]);

/** @param {string} colour #RRGGBB */
function pixel(colour) {
  const n = parseInt(colour.slice(1), 16);
  return (0xff000000 | ((n & 255) << 16) | (n & 0xff00) | (n >> 16)) >>> 0;
}

/** Where a number lies on its scale, 0 to 1. @param {ScaleInfo} scale @param {number} value */
export function onScale({ kind, low, high, width }, value) {
  const even = (/** @type {number} */ v) => (kind === "log" ? Math.log(v) : kind === "asinh" ? Math.asinh(v / width) : v);
  return Math.min(Math.max((even(Math.max(value, low)) - even(low)) / (even(high) - even(low)), 0), 1);
}

/** 256 colours of a scale, the lowest first. @param {ScaleInfo} scale */
export function scaleColours(scale) {
  const bytes = Uint8Array.from(atob(scale.colours), (c) => c.charCodeAt(0));
  return Array.from({ length: 256 }, (_, n) => 0xff000000 + bytes[3 * n] + 256 * bytes[3 * n + 1] + 65536 * bytes[3 * n + 2]);
}

/** How every cell looks, and what is seen there. @param {MapAnswer} map @param {Schema} schema @param {boolean} target whether there is one */
export function looks(map, { regimes, statuses }, target) {
  const { header: { scale, bands, x, y }, arrays } = map;
  const { regime, status, marks, values, lowest, highest } = arrays;
  const faces = new Map(regimes.map((r) => [r.code, pixel(r.colour)]));
  const hatches = new Map(statuses.map((s) => [s.code, hatchBit(s)]));
  const palette = scale ? scaleColours(scale) : [];
  const [first, second] = [new Uint32Array(regime.length).fill(NO_ANSWER), new Uint32Array(regime.length)];
  const over = new Uint16Array(regime.length);
  regime.forEach((code, i) => {
    const mark = marks[i];
    const hatch = hatches.get(status[i]) ?? 0;
    over[i] = mark & (OVER.backwards | OVER.coexists);
    if (!scale && bands && lowest[i] >= 0) {
      [first[i], second[i]] = [faces.get(lowest[i]) ?? WHITE, faces.get(highest[i]) ?? WHITE];
      if (lowest[i] !== highest[i]) over[i] |= OVER.either;
    } else if (!scale && code >= 0) first[i] = faces.get(code) ?? WHITE;
    else if (mark & OVER.covered) first[i] = WHITE;
    else if (scale && !Number.isNaN(values[i])) {
      first[i] = palette[Math.round(255 * onScale(scale, values[i]))];
      over[i] |= mark & (OVER.averaged | OVER.preview);
    } else over[i] = mark & (OVER.missing | OVER.unproved) || hatch;
    if (target && !(mark & OVER.meets)) over[i] |= OVER.veil;
  });
  const bits = over.reduce((all, some) => all | some, 0);
  const seen = new Set(bands && !scale ? [...lowest, ...highest] : regime);
  const rests = marks.some((mark) => mark & OVER.covered);
  const known = new Set(status);
  const names = [
    ...regimes.filter((r) => (scale ? rests && r.code === 0 && seen.has(0) : seen.has(r.code))).sort((a, b) => a.code - b.code)
      .map(({ label, colour }) => ({ text: label, face: pixel(colour), bit: 0 })),
    ...statuses.filter((s) => hatchBit(s) & bits && known.has(s.code))
      .map((s) => ({ text: s.label, face: NO_ANSWER, bit: hatchBit(s) })),
    ...NAMES.filter(([bit]) => bit & bits).map(([bit, text, face]) => ({ text, face, bit })),
  ];
  return { first, second, over, names, nx: x.count, ny: y.count, edges: cuts(map) };
}

/** A pixel where something lies over the colour; x and y [CSS px] run right and down. @type {Cover} */
function covered(bits, first, second, x, y) {
  const [rising, falling] = [(x + y) % 14, (x - y + 9e4) % 9];
  const steep = (bits & (OVER["/"] | OVER.x) && (x + y) % 9 < 1) || (bits & (OVER["\\"] | OVER.x) && falling < 1);
  const level = (bits & (OVER["-"] | OVER["+"]) && y % 8 < 1) || (bits & OVER["+"] && x % 8 < 1);
  const dots = (bits & OVER.coexists && x % 7 < 1.6 && y % 7 < 1.6) || (bits & (OVER.missing | OVER.unproved) && x % 10 < 1 && y % 10 < 1);
  let colour = bits & OVER.either && rising < 7 ? second : first;
  if (steep || level || dots) colour = FAINT;
  if (bits & OVER.backwards && x % 12 < 1) colour = INK;
  if (bits & OVER.averaged && rising < 3.6) colour = rising >= 1.2 && rising < 2.4 ? INK : WHITE;
  if (bits & OVER.preview && x % 5 < 1 && y % 5 < 1) colour = WHITE;
  return bits & OVER.veil ? 0xff000000 + ((colour >> 1) & 0x7f7f7f) + 0x7f7f7f : colour; // half white
}

/** Pieces of curves by the square of four cells that they cross. @param {MapAnswer} map @returns {Map<number, number[][]>} */
function cuts({ header: { curves, x, y }, arrays: { points } }) {
  const found = new Map();
  let at = 0;
  for (const count of curves.flatMap((c) => c.pieces)) {
    for (let n = 1; n < count; n++) {
      const [ax, ay, bx, by] = [...points.slice(at + 2 * n - 2, at + 2 * n + 2)].map((v, k) => v * ((k % 2 ? y : x).count - 1));
      for (let j = Math.floor(Math.min(ay, by)); j <= Math.max(ay, by); j++) {
        for (let i = Math.floor(Math.min(ax, bx)); i <= Math.max(ax, bx); i++) {
          found.set(j * x.count + i, [...(found.get(j * x.count + i) ?? []), [ax, ay, bx, by]]);
        }
      }
    }
    at += 2 * count;
  }
  return found;
}

/** The nearest of four cells on a place's own side of the curves. @param {number[][]} pieces @param {number} x @param {number} y */
function ownCell(pieces, x, y) {
  const [i, j] = [Math.round(x), Math.round(y)];
  const [k, l] = [2 * Math.floor(x) + 1 - i, 2 * Math.floor(y) + 1 - j];
  return [[i, j], [k, j], [i, l], [k, l]].find(([cx, cy]) => !pieces.some(([ax, ay, bx, by]) => {
    const side = (/** @type {number} */ px, /** @type {number} */ py) => (bx - ax) * (py - ay) - (by - ay) * (px - ax);
    const turn = (/** @type {number} */ px, /** @type {number} */ py) => (cx - x) * (py - y) - (cy - y) * (px - x);
    return side(x, y) * side(cx, cy) < 0 && turn(ax, ay) * turn(bx, by) < 0;
  })) ?? [i, j];
}

/** Paint cells, rows from the lowest up, over a whole canvas; curves divide the squares between cells exactly.
 * @param {HTMLCanvasElement} canvas @param {number} zoom device pixels a CSS pixel @param {Cells} cells */
export function paint(canvas, zoom, { first, second, over, nx, ny, edges }) {
  const { width, height } = canvas;
  const image = new ImageData(width, height);
  const pixels = new Uint32Array(image.data.buffer);
  const divided = new Uint8Array(nx * ny);
  for (const square of edges.keys()) divided[square] = 1;
  for (let py = 0, at = 0; py < height; py++) {
    const y = (1 - (py + 0.5) / height) * (ny - 1);
    for (let px = 0; px < width; px++, at++) {
      const x = ((px + 0.5) / width) * (nx - 1);
      const square = Math.floor(y) * nx + Math.floor(x);
      const [i, j] = divided[square] ? ownCell(edges.get(square) ?? [], x, y) : [Math.round(x), Math.round(y)];
      const cell = j * nx + i;
      pixels[at] = over[cell] ? covered(over[cell], first[cell], second[cell], px / zoom, py / zoom) : first[cell];
    }
  }
  canvas.getContext("2d")?.putImageData(image, 0, 0);
}

const drawn = /** @type {Map<string, string>} */ (new Map());

/** A column of cells as the address of a picture, for samples and colour bars. @param {number[]} column @param {number} bits */
export function picture(column, bits = 0, width = 24, height = 14) {
  const key = `${bits} ${width} ${height} ${column}`;
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [2 * width, 2 * height];
  const over = column.map(() => bits);
  const cells = { first: column, second: column.map(() => 0xff66ccee), over, nx: 1, ny: column.length, edges: new Map() };
  if (!drawn.has(key)) paint(canvas, 2, cells);
  if (!drawn.has(key)) drawn.set(key, canvas.toDataURL());
  return drawn.get(key) ?? "";
}
