/** The cells of a map as pixels: their colours, and hatches at the resolution of the screen. */

const [FAINT, INK, WHITE] = [0xff8a8a8a, 0xff222222, 0xffffffff]; // AABBGGRR, as in memory

/** The colours of a palette. @param {string} palette bytes of red, green and blue, in base64 */
export function colours(palette) {
  const bytes = Uint8Array.from(atob(palette), (c) => c.charCodeAt(0));
  const colour = (/** @type {number} */ n) => 0xff000000 + bytes[n] + 256 * bytes[n + 1] + 65536 * bytes[n + 2];
  return Uint32Array.from({ length: bytes.length / 3 }, (_, n) => colour(3 * n));
}

/** What tells a pixel's colour where marks lie over a cell; x and y [CSS px] run right and down.
 * @param {Record<string, number>} bits of marks, by name @returns {Cover} */
function coverOf(bits) {
  const { backwards, averaged, coexists, preview, unknown, unproved, either, misses } = bits;
  const [rising, falling, level] = [bits.rising | bits.crossed, bits.falling | bits.crossed, bits.level | bits.grid];
  return (marks, first, second, x, y) => {
    const stripe = (x + y) % 14;
    let colour = marks & either && stripe < 7 ? second : first;
    if (marks & rising && (x + y) % 9 < 1) colour = FAINT;
    if (marks & falling && (x - y + 9e4) % 9 < 1) colour = FAINT;
    if (marks & level && y % 8 < 1) colour = FAINT;
    if (marks & bits.grid && x % 8 < 1) colour = FAINT;
    if (marks & coexists && x % 7 < 1.6 && y % 7 < 1.6) colour = FAINT;
    if (marks & (unknown | unproved) && x % 10 < 1 && y % 10 < 1) colour = FAINT;
    if (marks & backwards && x % 12 < 1) colour = INK;
    if (marks & averaged && stripe < 3.6) colour = stripe >= 1.2 && stripe < 2.4 ? INK : WHITE;
    if (marks & preview && x % 5 < 1 && y % 5 < 1) colour = WHITE;
    return marks & misses ? 0xff000000 + ((colour >> 1) & 0x7f7f7f) + 0x7f7f7f : colour; // half white
  };
}

/** Pieces of curves by the square of four cells that they cross. @param {MapAnswer} map @returns {Pieces} */
export function piecesOf({ header: { x, y }, arrays: { points } }) {
  const found = /** @type {Pieces} */ (new Map());
  const cells = points.map((share, n) => share * ((n % 2 ? y : x).count - 1));
  for (let at = 0; at + 3 < cells.length; at += 2) {
    const [ax, ay, bx, by] = cells.subarray(at, at + 4);
    for (let j = Math.floor(Math.min(ay, by)); j <= Math.max(ay, by); j++) {
      for (let i = Math.floor(Math.min(ax, bx)); i <= Math.max(ax, bx); i++) {
        const square = j * x.count + i;
        if (!found.get(square)?.push([ax, ay, bx, by])) found.set(square, [[ax, ay, bx, by]]);
      }
    }
  }
  return found;
}

/** Whether a piece of a curve parts two places.
 * @param {number[]} piece @param {number[]} place @param {number[]} other */
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

export class Painter {
  /** @param {Record<string, number>} marks their bits, by name */
  constructor(marks) {
    this.cover = coverOf(marks);
    this.pictures = /** @type {Map<string, string>} */ (new Map());
  }

  /** Paint cells, rows from the lowest up, over a whole canvas; curves divide the squares between cells exactly.
   * @param {HTMLCanvasElement} canvas @param {number} zoom device pixels a CSS pixel @param {Cells} cells */
  paint(canvas, zoom, { palette, faces, others, marks, nx, ny, pieces }) {
    const { width, height } = canvas;
    const image = new ImageData(width, height);
    const pixels = new Uint32Array(image.data.buffer);
    const isDivided = new Uint8Array(nx * ny);
    for (const square of pieces.keys()) isDivided[square] = 1;
    for (let py = 0, at = 0; py < height; py++) {
      const y = (1 - (py + 0.5) / height) * (ny - 1);
      const [row, near] = [nx * Math.floor(y), nx * Math.round(y)];
      for (let px = 0; px < width; px++, at++) {
        const x = ((px + 0.5) / width) * (nx - 1);
        const square = row + Math.floor(x);
        let cell = near + Math.round(x);
        if (isDivided[square]) {
          const [i, j] = ownCell(pieces.get(square) ?? [], [x, y]);
          cell = nx * j + i;
        }
        const colour = palette[faces[cell]];
        const over = marks[cell];
        pixels[at] = over ? this.cover(over, colour, palette[others[cell]], px / zoom, py / zoom) : colour;
      }
    }
    canvas.getContext("2d")?.putImageData(image, 0, 0);
  }

  /** A column of cells, the lowest first, as the address of a picture. @param {Cells["palette"]} palette of the cells
   * @param {number} width @param {number} height @param {number} [marks] over them, which may show a last colour */
  picture(palette, width, height, marks = 0) {
    const key = [marks, width, height, ...palette].join(" ");
    const ny = marks ? 1 : palette.length;
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [2 * width, 2 * height];
    const faces = Array.from({ length: ny }, (_, n) => n);
    const cells = { palette, faces, others: [palette.length - 1], marks: Array(ny).fill(marks), nx: 1, ny };
    if (!this.pictures.has(key)) {
      this.paint(canvas, 2, { ...cells, pieces: new Map() });
      this.pictures.set(key, canvas.toDataURL());
    }
    return this.pictures.get(key) ?? "";
  }
}
