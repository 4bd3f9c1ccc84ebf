/** The cells of a map as pixels: their colours, and hatches at the resolution of the screen. */

/** @typedef {{right: number, down: number, period: number, from: number, to: number}} Stripe right: 1, or 0
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

// Lay stripes over cells that have another colour there, else 0; they are seen where all of them overlap. At most one
// crosses the rows of pixels: of the others a row is all in or all out.
/** @param {Stripe[]} stripes @param {number} zoom @param {Uint32Array} over @param {Int32Array} shown cells of pixels
 * @param {Uint32Array} pixels @param {number} width */
function lay(stripes, zoom, over, shown, pixels, width) {
  const height = pixels.length / width;
  const isIn = stripes.map(({ period, from, to }) => Uint8Array.from({ length: width + 2 * height }, (_, n) => {
    const place = ((n - height) / zoom) % period, inside = place < 0 ? place + period : place;
    return Number(inside >= from && inside < to);
  }));
  const k = stripes.findIndex(({ right }) => right);
  for (let py = 0; py < height; py++) {
    if (stripes.some(({ right, down }, n) => !right && !isIn[n][height + down * py])) continue;
    const row = k < 0 ? null : isIn[k].subarray(height + stripes[k].down * py);
    for (let px = 0, at = py * width; px < width; px++, at++) {
      if (over[shown[at]] && (!row || row[px])) pixels[at] = over[shown[at]];
    }
  }
}

// Paint cells, rows from the lowest up, over a whole canvas; curves divide the squares between cells exactly.
/** @param {HTMLCanvasElement} canvas @param {number} zoom device pixels a CSS pixel @param {Cells} cells */
export function paint(canvas, zoom, cells) {
  const { faces, others, marks, nx, ny, pieces } = cells;
  const { width, height } = canvas;
  const image = new ImageData(width, height);
  const pixels = new Uint32Array(image.data.buffer), shown = new Int32Array(width * height); // the cells of pixels
  const plain = new Uint32Array(faces.length);
  let present = 0;
  for (let cell = 0; cell < faces.length; cell++) {
    plain[cell] = colourOf(cells, faces[cell], marks[cell]);
    present |= marks[cell];
  }
  const across = Float64Array.from({ length: width }, (_, px) => ((px + 0.5) / width) * (nx - 1));
  const up = Float64Array.from({ length: height }, (_, py) => (1 - (py + 0.5) / height) * (ny - 1));
  for (let py = 0, at = 0, before = -1; py < height; py++, at += width) {
    const row = Math.round(up[py]);
    if (row === before) {
      for (const all of [shown, pixels]) all.copyWithin(at, at - width, at);
      continue;
    }
    before = row;
    for (let px = 0; px < width; px++) pixels[at + px] = plain[(shown[at + px] = nx * row + Math.round(across[px]))];
  }
  for (const [square, crossing] of pieces) {
    const i = square % nx, j = Math.floor(square / nx);
    const [left, right] = [i, i + 1].map((x) => Math.ceil((x * width) / (nx - 1) - 0.5));
    const [top, bottom] = [j + 1, j].map((y) => Math.ceil(height - (y * height) / (ny - 1) - 0.5));
    for (let py = Math.max(top, 0); py < Math.min(bottom, height); py++) {
      for (let px = left, at = py * width + left; px < Math.min(right, width); px++, at++) {
        pixels[at] = plain[(shown[at] = ownCell(crossing, nx, across[px], up[py]))];
      }
    }
  }
  for (const { marks: own, face, stripes } of cells.hatches.filter((hatch) => hatch.marks & present)) {
    const over = plain.map((_, cell) => (marks[cell] & own ? colourOf(cells, face ?? others[cell], marks[cell]) : 0));
    lay(stripes, zoom, over, shown, pixels, width);
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
