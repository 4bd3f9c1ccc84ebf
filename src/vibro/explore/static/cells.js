/** The cells of a map as pixels: their colours, and hatches at the resolution of the screen. */

/** The colours of a palette. @param {string} palette bytes of red, green and blue, in base64 */
export function colours(palette) {
  const bytes = Uint8Array.from(atob(palette), (c) => c.charCodeAt(0));
  const colour = (/** @type {number} */ n) => 0xff000000 + bytes[n] + 256 * bytes[n + 1] + 65536 * bytes[n + 2];
  return Uint32Array.from({ length: bytes.length / 3 }, (_, n) => colour(3 * n));
}

/** Whether a place lies in all stripes of a hatch. @param {Stripe[]} stripes @param {number} x @param {number} y */
const isIn = (stripes, x, y) => stripes.every(({ right, down, period, from, to }) => {
  const at = (((right * x + down * y) % period) + period) % period;
  return at >= from && at < to;
});

/** Pieces of curves by the square of four cells that each lies in. @param {MapAnswer} map */
export function piecesOf({ header: { x, y }, arrays: { points } }) {
  const pieces = /** @type {number[][][]} */ (Array(x.count * y.count));
  const cells = points.map((share, n) => share * ((n % 2 ? y : x).count - 1));
  for (let at = 0; at + 3 < cells.length; at += 2) {
    const [ax, ay, bx, by] = cells.subarray(at, at + 4);
    const square = Math.floor((ay + by) / 2) * x.count + Math.floor((ax + bx) / 2);
    if (square >= 0) (pieces[square] ??= []).push([ax, ay, bx, by]); // no square, where a curve is interrupted
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

// Paint cells, rows from the lowest up, over a whole canvas; curves divide the squares between cells exactly.
/** @param {HTMLCanvasElement} canvas @param {number} zoom device pixels a CSS pixel @param {Cells} cells */
export function paint(canvas, zoom, { palette, hatches, pale, faces, others, marks, nx, ny, pieces }) {
  const { width, height } = canvas;
  const image = new ImageData(width, height);
  const pixels = new Uint32Array(image.data.buffer);
  for (let py = 0, at = 0; py < height; py++) {
    const y = (1 - (py + 0.5) / height) * (ny - 1);
    const [row, near] = [nx * Math.floor(y), nx * Math.round(y)];
    for (let px = 0; px < width; px++, at++) {
      const x = ((px + 0.5) / width) * (nx - 1);
      const crossing = pieces[row + Math.floor(x)];
      let cell = near + Math.round(x);
      if (crossing) {
        const [i, j] = ownCell(crossing, [x, y]);
        cell = nx * j + i;
      }
      const over = marks[cell];
      let face = faces[cell];
      if (over) for (const hatch of hatches) {
        if (over & hatch.marks && isIn(hatch.stripes, px / zoom, py / zoom)) face = hatch.face ?? others[cell];
      }
      const colour = palette[face];
      pixels[at] = over & pale ? 0xff000000 + ((colour >> 1) & 0x7f7f7f) + 0x7f7f7f : colour; // half white
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
