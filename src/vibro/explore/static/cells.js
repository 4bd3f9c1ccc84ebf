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
 * @property {(number[][] | null)[]} pieces of curves, [ax, ay, bx, by] in cells, by the square that they cross */

/** The colours of a palette. @param {string} palette bytes of red, green and blue, in base64 */
export function colours(palette) {
  const bytes = Uint8Array.from(atob(palette), (c) => c.charCodeAt(0));
  const colour = (/** @type {number} */ n) => 0xff000000 + bytes[n] + 256 * bytes[n + 1] + 65536 * bytes[n + 2];
  return Uint32Array.from({ length: bytes.length / 3 }, (_, n) => colour(3 * n));
}

const masks = /** @type {Map<string, Uint8Array>} */ (new Map()); // by stripes and the size of the canvas
const MOST_MASKS = 64;

// Which pixels of a canvas lie in all stripes: found once, as a hand that moves a slider draws many maps of one size.
/** @param {Stripe[]} stripes @param {number} width @param {number} height @param {number} zoom */
function maskOf(stripes, width, height, zoom) {
  const key = JSON.stringify([stripes, width, height, zoom]);
  const known = masks.get(key);
  if (known) return known;
  if (masks.size === MOST_MASKS) masks.clear();
  const mask = new Uint8Array(width * height).fill(1);
  for (const { right, down, period, from, to } of stripes) {
    for (let py = 0, at = 0; py < height; py++) {
      for (let px = 0; px < width; px++, at++) {
        const place = ((right * px + down * py) / zoom) % period;
        const inside = place < 0 ? place + period : place;
        if (inside < from || inside >= to) mask[at] = 0;
      }
    }
  }
  masks.set(key, mask);
  return mask;
}

/** Pieces of curves by the square of four cells that each lies in.
 * @param {{nx: number, ny: number, curves: {lines: number[][][]}[]}} map */
export function piecesOf({ nx, ny, curves }) {
  const pieces = /** @type {(number[][] | null)[]} */ (Array(nx * ny).fill(null));
  for (const line of curves.flatMap(({ lines }) => lines)) {
    for (let n = 1; n < line.length; n++) {
      const [ax, ay, bx, by] = [...line[n - 1], ...line[n]].map((share, k) => share * ((k % 2 ? ny : nx) - 1));
      (pieces[Math.floor((ay + by) / 2) * nx + Math.floor((ax + bx) / 2)] ??= []).push([ax, ay, bx, by]);
    }
  }
  return pieces;
}

// Whether a piece of a curve parts two places.
/** @param {number[]} piece @param {number[]} place @param {number[]} other */
function parts([ax, ay, bx, by], [x, y], [cx, cy]) {
  const side = (/** @type {number} */ px, /** @type {number} */ py) => (bx - ax) * (py - ay) - (by - ay) * (px - ax);
  const turn = (/** @type {number} */ px, /** @type {number} */ py) => (cx - x) * (py - y) - (cy - y) * (px - x);
  return side(x, y) * side(cx, cy) < 0 && turn(ax, ay) * turn(bx, by) < 0;
}

/** The nearest of four cells on a place's own side of curves. @param {number[][]} pieces @param {number[]} place */
function ownCell(pieces, place) {
  const [i, j] = place.map(Math.round);
  const [k, l] = [2 * Math.floor(place[0]) + 1 - i, 2 * Math.floor(place[1]) + 1 - j];
  const isOwn = (/** @type {number[]} */ cell) => !pieces.some((piece) => parts(piece, place, cell));
  return [[i, j], [k, j], [i, l], [k, l]].find(isOwn) ?? [i, j];
}

/** The colour of a cell with some face under its marks. @param {Cells} cells @param {number} face @param {number} over */
function colourOf({ palette, pale }, face, over) {
  return over & pale ? 0xff000000 + ((palette[face] >> 1) & 0x7f7f7f) + 0x7f7f7f : palette[face]; // half white
}

// Paint cells, rows from the lowest up, over a whole canvas; curves divide the squares between cells exactly.
/** @param {HTMLCanvasElement} canvas @param {number} zoom device pixels a CSS pixel @param {Cells} cells */
export function paint(canvas, zoom, cells) {
  const { faces, others, marks, nx, ny, pieces } = cells;
  const { width, height } = canvas;
  const image = new ImageData(width, height);
  const pixels = new Uint32Array(image.data.buffer);
  let present = 0;
  for (let cell = 0; cell < marks.length; cell++) present |= marks[cell];
  const hatches = cells.hatches.filter((hatch) => hatch.marks & present)
    .map((hatch) => ({ ...hatch, mask: maskOf(hatch.stripes, width, height, zoom) }));
  const plain = Uint32Array.from(faces, (face, cell) => colourOf(cells, face, marks[cell]));
  const across = Float64Array.from({ length: width }, (_, px) => ((px + 0.5) / width) * (nx - 1));
  const [columns, lefts] = [Int32Array.from(across, Math.round), Int32Array.from(across, Math.floor)];
  for (let py = 0, at = 0; py < height; py++) {
    const y = (1 - (py + 0.5) / height) * (ny - 1);
    const [row, near] = [nx * Math.floor(y), nx * Math.round(y)];
    for (let px = 0; px < width; px++, at++) {
      const crossing = pieces[row + lefts[px]];
      let cell = near + columns[px];
      if (crossing) {
        const [i, j] = ownCell(crossing, [across[px], y]);
        cell = nx * j + i;
      }
      pixels[at] = plain[cell];
      for (const hatch of hatches) {
        if (marks[cell] & hatch.marks && hatch.mask[at]) pixels[at] = colourOf(cells, hatch.face ?? others[cell], marks[cell]);
      }
    }
  }
  canvas.getContext("2d")?.putImageData(image, 0, 0);
}

// A column of faces, the lowest first, or marks over one of them, which may show the last: the address of a picture.
/** @param {Cells} cells @param {number[]} faces @param {number} width @param {number} height @param {number} [over] */
export function picture(cells, faces, width, height, over = 0) {
  const ny = over ? 1 : faces.length;
  const own = { faces, others: faces.slice(-1), marks: Array(ny).fill(over), nx: 1, ny, pieces: [] };
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [2 * width, 2 * height];
  paint(canvas, 2, { ...cells, ...own });
  return canvas.toDataURL();
}
