/** The cells of a map as pixels: their colours, and hatches at the resolution of the screen. */

/** @typedef {{right: number, down: number, period: number, from: number, to: number}} Stripe
 * @typedef {{marks: number, face: number | null, stripes: Stripe[]}} Hatch without a face: the other colour of the cell
 * @typedef {object} Cells
 * @property {Uint32Array} palette
 * @property {Hatch[]} hatches
 * @property {number} pale bits of marks under which colours are half white
 * @property {ArrayLike<number>} faces places in the palette
 * @property {ArrayLike<number>} others those of stripes
 * @property {ArrayLike<number>} marks bits
 * @property {number} nx
 * @property {number} ny
 * @property {Map<number, number[][]>} pieces of curves, [ax, ay, bx, by] in cells, by the square that they cross */

/** The colours of a palette. @param {string} palette bytes of red, green and blue, in base64 */
export function colours(palette) {
  const bytes = Uint8Array.from(atob(palette), (c) => c.charCodeAt(0));
  const colour = (/** @type {number} */ n) => 0xff000000 + bytes[n] + 256 * bytes[n + 1] + 65536 * bytes[n + 2];
  return Uint32Array.from({ length: bytes.length / 3 }, (_, n) => colour(3 * n));
}

// Which pixels of a canvas lie in all stripes, whose lines run down, across or diagonally: one number tells them apart.
/** @param {Stripe[]} stripes @param {number} width @param {number} height @param {number} zoom */
function maskOf(stripes, width, height, zoom) {
  const mask = new Uint8Array(width * height).fill(1);
  for (const { right, down, period, from, to } of stripes) {
    const first = Math.min(right, 0) * width + Math.min(down, 0) * height;
    const isIn = Uint8Array.from({ length: width + height }, (_, n) => {
      const place = ((first + n) / zoom) % period, inside = place < 0 ? place + period : place;
      return Number(inside >= from && inside < to);
    });
    for (let py = 0, at = 0; py < height; py++) {
      for (let px = 0, n = down * py - first; px < width; px++, at++, n += right) mask[at] &= isIn[n];
    }
  }
  return mask;
}

/** Pieces of curves by the square of four cells that each lies in.
 * @param {{nx: number, ny: number, curves: {lines: number[][][]}[]}} map */
export function piecesOf({ nx, ny, curves }) {
  const pieces = /** @type {Map<number, number[][]>} */ (new Map());
  for (const line of curves.flatMap(({ lines }) => lines)) {
    for (let n = 1; n < line.length; n++) {
      const [ax, ay, bx, by] = [...line[n - 1], ...line[n]].map((share, k) => share * ((k % 2 ? ny : nx) - 1));
      const square = Math.floor((ay + by) / 2) * nx + Math.floor((ax + bx) / 2);
      pieces.set(square, [...(pieces.get(square) ?? []), [ax, ay, bx, by]]);
    }
  }
  return pieces;
}

// Whether a piece of a curve parts two places.
/** @param {number[]} piece @param {number} x @param {number} y @param {number} u @param {number} v */
function parts([ax, ay, bx, by], x, y, u, v) {
  const side = (/** @type {number} */ px, /** @type {number} */ py) => (bx - ax) * (py - ay) - (by - ay) * (px - ax);
  const turn = (/** @type {number} */ px, /** @type {number} */ py) => (u - x) * (py - y) - (v - y) * (px - x);
  return side(x, y) * side(u, v) < 0 && turn(ax, ay) * turn(bx, by) < 0;
}

/** The nearest of four cells on a place's own side of curves. @param {number[][]} pieces @param {number} nx
 * @param {number} x @param {number} y */
function ownCell(pieces, nx, x, y) {
  const i = Math.round(x), j = Math.round(y), k = 2 * Math.floor(x) + 1 - i, l = 2 * Math.floor(y) + 1 - j;
  const isOwn = (/** @type {number} */ u, /** @type {number} */ v) => !pieces.some((piece) => parts(piece, x, y, u, v));
  if (isOwn(i, j)) return nx * j + i;
  if (isOwn(k, j)) return nx * j + k;
  if (isOwn(i, l)) return nx * l + i;
  return isOwn(k, l) ? nx * l + k : nx * j + i;
}

/** The colour of a cell with some face under its marks.
 * @param {Cells} cells @param {number} face @param {number} over */
function colourOf({ palette, pale }, face, over) {
  return over & pale ? 0xff000000 + ((palette[face] >> 1) & 0x7f7f7f) + 0x7f7f7f : palette[face]; // half white
}

// The cell that each pixel shows: the nearest one, in squares that curves cross the nearest on its side of them.
/** @param {number} width @param {number} height @param {Cells} cells */
function shownCells(width, height, { nx, ny, pieces }) {
  const shown = new Int32Array(width * height);
  const across = Float64Array.from({ length: width }, (_, px) => ((px + 0.5) / width) * (nx - 1));
  const up = Float64Array.from({ length: height }, (_, py) => (1 - (py + 0.5) / height) * (ny - 1));
  const columns = Int32Array.from(across, Math.round);
  for (let py = 0, at = 0; py < height; py++) {
    const first = nx * Math.round(up[py]);
    for (let px = 0; px < width; px++, at++) shown[at] = first + columns[px];
  }
  for (const [square, crossing] of pieces) {
    const i = square % nx, j = Math.floor(square / nx);
    const [left, right] = [i, i + 1].map((x) => Math.ceil((x * width) / (nx - 1) - 0.5));
    const [top, bottom] = [j + 1, j].map((y) => Math.ceil(height - (y * height) / (ny - 1) - 0.5));
    for (let py = Math.max(top, 0); py < Math.min(bottom, height); py++) {
      for (let px = left; px < Math.min(right, width); px++) {
        shown[py * width + px] = ownCell(crossing, nx, across[px], up[py]);
      }
    }
  }
  return shown;
}

// Paint cells, rows from the lowest up, over a whole canvas; curves divide the squares between cells exactly.
/** @param {HTMLCanvasElement} canvas @param {number} zoom device pixels a CSS pixel @param {Cells} cells */
export function paint(canvas, zoom, cells) {
  const { faces, others, marks } = cells;
  const { width, height } = canvas;
  const image = new ImageData(width, height);
  const pixels = new Uint32Array(image.data.buffer);
  const shown = shownCells(width, height, cells);
  const plain = new Uint32Array(faces.length);
  let present = 0;
  for (let cell = 0; cell < faces.length; cell++) {
    plain[cell] = colourOf(cells, faces[cell], marks[cell]);
    present |= marks[cell];
  }
  for (let at = 0; at < shown.length; at++) pixels[at] = plain[shown[at]];
  for (const { marks: own, face, stripes } of cells.hatches.filter((hatch) => hatch.marks & present)) {
    const over = plain.map((_, cell) => (marks[cell] & own ? colourOf(cells, face ?? others[cell], marks[cell]) : 0));
    const mask = maskOf(stripes, width, height, zoom);
    for (let at = 0; at < shown.length; at++) if (mask[at] && over[shown[at]]) pixels[at] = over[shown[at]];
  }
  canvas.getContext("2d")?.putImageData(image, 0, 0);
}

// A column of faces, the lowest first, or marks over one of them, which may show the last: the address of a picture.
/** @param {Cells} cells @param {number[]} faces @param {number} width @param {number} height @param {number} [over] */
export function picture(cells, faces, width, height, over = 0) {
  const ny = over ? 1 : faces.length;
  const own = { faces, others: faces.slice(-1), marks: Array(ny).fill(over), nx: 1, ny, pieces: new Map() };
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [2 * width, 2 * height];
  paint(canvas, 2, { ...cells, ...own });
  return canvas.toDataURL();
}
