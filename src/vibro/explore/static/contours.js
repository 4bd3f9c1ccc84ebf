/** Fields over the cells of a map, row after row from the lowest up: filled, widened, and where they are zero. */

/** The value of a field between its cells, linear along both ways.
 * @param {ArrayLike<number>} field @param {number} nx @param {number} x @param {number} y */
export function sampleOf(field, nx, x, y) {
  const i = Math.min(Math.floor(x), nx - 2), j = Math.min(Math.floor(y), field.length / nx - 2);
  const s = x - i, t = y - j, n = j * nx + i, m = n + nx;
  const low = s === 0.0 ? field[n] : (1.0 - s) * field[n] + s * field[n + 1];
  if (t === 0.0) return low;
  const high = s === 0.0 ? field[m] : (1.0 - s) * field[m] + s * field[m + 1];
  return (1.0 - t) * low + t * high;
}

/** Give cells that are not known the value of the nearest one that is, along rows and columns; NaN if none is.
 * @template {Float64Array | Int8Array} T
 * @param {T} values @param {number} nx @param {(n: number) => boolean} isKnown @returns {T} */
export function fillUnknown(values, nx, isKnown) {
  const queue = new Int32Array(values.length), isThere = new Uint8Array(values.length);
  let last = 0;
  for (let n = 0; n < values.length; n++) if (isKnown(n)) isThere[queue[last++] = n] = 1;
  if (last === values.length) return values;
  const found = values.slice();
  if (!last) found.fill(NaN);
  for (let at = 0; last && last < values.length; at++) {
    const n = queue[at], i = n % nx;
    for (const other of [i > 0 ? n - 1 : -1, i < nx - 1 ? n + 1 : -1, n - nx, n + nx]) {
      if (other < 0 || other >= values.length || isThere[other]) continue;
      found[other] = found[n];
      isThere[queue[last++] = other] = 1;
    }
  }
  return /** @type {T} */ (found);
}

// The same, but that beside cells which are known values go on straight: a curve of them keeps its way up to their
// edge.
/** @param {Float64Array} values @param {number} nx @param {(n: number) => boolean} isKnown */
export function continued(values, nx, isKnown) {
  return fillUnknown(values, nx, isKnown).map((value, n) => {
    if (isKnown(n)) return value;
    let sum = 0.0, count = 0;
    for (const step of [n % nx > 1 ? -1 : 0, n % nx < nx - 2 ? 1 : 0, -nx, nx]) {
      if (!isKnown(n + step) || !isKnown(n + 2 * step)) continue;
      sum += 2.0 * values[n + step] - values[n + 2 * step];
      count++;
    }
    return count ? sum / count : value;
  });
}

/** Cells with one of a mask at most so many rows and columns away.
 * @param {Uint8Array} mask @param {number} nx @param {number} reach */
function widened(mask, nx, reach) {
  let found = mask;
  for (const step of [1, nx]) {
    const before = found;
    const length = step === 1 ? nx : mask.length / nx;
    found = new Uint8Array(mask.length);
    for (let n = 0; n < mask.length; n++) {
      if (!before[n]) continue;
      const at = step === 1 ? n % nx : Math.floor(n / nx);
      for (let k = Math.max(-reach, -at); k <= Math.min(reach, length - 1 - at); k++) found[n + k * step] = 1;
    }
  }
  return found;
}

/** Widen a mask to close its gaps, then narrow it again.
 * @param {Uint8Array} mask @param {number} nx @param {number} more @param {number} less */
export function closed(mask, nx, more, less) {
  const without = (/** @type {Uint8Array} */ cells) => cells.map((cell) => 1 - cell);
  return without(widened(without(widened(mask, nx, more)), nx, less));
}

// The lines on which a field is zero, as places in cells. Where two of them pass between the same four cells,
// the mean of these decides which corners they part.
/** @param {Float64Array} field @param {number} nx @returns {number[][][]} */
export function zeroLines(field, nx) {
  const next = /** @type {Map<number, number[]>} */ (new Map()); // sides between cells, and those that lines go on to
  const join = (/** @type {number} */ side, /** @type {number} */ other) => {
    for (const [from, to] of [[side, other], [other, side]]) next.set(from, [...(next.get(from) ?? []), to]);
  };
  for (let n = 0; n < field.length - nx; n++) {
    if (n % nx === nx - 1) continue;
    const a = field[n] > 0.0, b = field[n + 1] > 0.0, c = field[n + nx + 1] > 0.0, d = field[n + nx] > 0.0;
    if (a === b && b === c && c === d) continue;
    // sides by their first cell: even ones along a row, odd ones along a column
    const [below, right, above, left] = [2 * n, 2 * n + 3, 2 * (n + nx), 2 * n + 1];
    const cut = [a !== b && below, b !== c && right, c !== d && above, d !== a && left]
      .filter((side) => side !== false);
    const isMiddle = field[n] + field[n + 1] + field[n + nx + 1] + field[n + nx] > 0.0;
    if (cut.length === 2) join(cut[0], cut[1]);
    else if (isMiddle === a) {
      join(below, right);
      join(above, left);
    } else {
      join(left, below);
      join(right, above);
    }
  }
  const place = (/** @type {number} */ side) => {
    const [n, isUp] = [side >> 1, side & 1];
    const share = field[n] / (field[n] - field[n + (isUp ? nx : 1)]);
    return [(n % nx) + (isUp ? 0.0 : share), Math.floor(n / nx) + (isUp ? share : 0.0)];
  };
  const lines = [];
  const ends = [...next.keys()].filter((side) => next.get(side)?.length === 1);
  for (const first of [...ends, ...next.keys()]) {
    const line = /** @type {number[][]} */ ([]);
    const isClosed = next.get(first)?.length === 2;
    for (let side = /** @type {number | undefined} */ (first); side !== undefined;) {
      const others = next.get(side);
      next.delete(side);
      if (others) line.push(place(side));
      side = others?.find((other) => next.has(other));
    }
    if (isClosed && line.length > 2) line.push(line[0]);
    if (line.length > 1) lines.push(line);
  }
  return lines;
}

/** The parts of a line where a field is not positive, up to its zeros.
 * @param {number[][]} line @param {Float64Array} field @param {number} nx */
function clipLine(line, field, nx) {
  const parts = /** @type {number[][][]} */ ([]);
  let part = /** @type {number[][]} */ ([]), before = NaN;
  line.forEach(([x, y], k) => {
    const here = sampleOf(field, nx, x, y);
    if (k && here <= 0.0 !== before <= 0.0) {
      const share = before / (before - here);
      const [u, v] = line[k - 1];
      part.push([u + share * (x - u), v + share * (y - v)]);
      if (here > 0.0) {
        parts.push(part);
        part = [];
      }
    }
    if (here <= 0.0) part.push([x, y]);
    before = here;
  });
  return [...parts, part].filter((own) => own.length > 1);
}

/** The parts of lines that are seen.
 * @param {number[][][]} lines @param {Float64Array[]} hiding fields that are positive where they are not
 * @param {number} nx */
export function visibleLines(lines, hiding, nx) {
  return hiding.reduce((all, field) => all.flatMap((line) => clipLine(line, field, nx)), lines);
}
