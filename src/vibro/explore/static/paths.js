/**
 * The trough's path: its stroke and its largest acceleration. That of harmonics is sampled, and searched more finely
 * about the best place; those of steps and samples vibro has found, at a scale of 1 and at 1 Hz.
 *
 * @typedef {[number, number]} Point along the trough and normal to it
 */

const POINTS = 64; // of a path per harmonic
const LEAST_POINTS = 512;
const [FINER, SEARCHES] = [8, 10]; // places to each side, of each search; it is half as far as the one before

const around = (/** @type {number} */ middle, /** @type {number} */ far) =>
  Array.from({ length: 2 * FINER + 1 }, (_, n) => middle + far * (n / FINER - 1.0));

/** Points of a path of harmonics, and the distance between two phases. */
function sampledPath(/** @type {any} */ { path: [scale], harmonics }) {
  const number = Math.max(LEAST_POINTS, POINTS * harmonics[0].length);
  const phases = Array.from({ length: number }, (_, n) => (TURN * n) / number);
  const along = (/** @type {number[]} */ sizes, /** @type {number[]} */ leads, /** @type {number} */ phase) =>
    scale * sizes.reduce((sum, size, n) => sum + size * Math.sin((n + 1) * phase + leads[n]), 0.0);
  const path = (/** @type {number[]} */ at) => at.map((phase) => /** @type {Point} */ (
    [along(harmonics[0], harmonics[1], phase), along(harmonics[2], harmonics[3], phase)]));
  return { path, phases, points: path(phases), step: TURN / number };
}

/** Search the largest value of a function about a place.
 * @param {(places: number[]) => number[]} of @param {number} middle @param {number} far */
function largestAbout(of, middle, far) {
  let best = -Infinity;
  for (let n = 0; n < SEARCHES; n++, far /= 2.0) {
    const places = around(middle, far);
    const values = of(places);
    best = Math.max(...values);
    middle = places[values.indexOf(best)];
  }
  return best;
}

/** The two points, one of each list, that are farthest apart. @param {Point[]} first @param {Point[]} second */
function widestPair(first, second) {
  const found = { square: -1.0, i: 0, j: 0 };
  for (let i = 0; i < first.length; i++) {
    const [x, y] = first[i];
    for (let j = 0; j < second.length; j++) {
      const [dx, dy] = [x - second[j][0], y - second[j][1]];
      const square = dx * dx + dy * dy;
      if (square > found.square) Object.assign(found, { square, i, j });
    }
  }
  return found;
}

/** From one end of the trough's path to the other, the farther way [m]. @param {Drive} drive of plain numbers */
export function strokeOf(drive) {
  const { kind, path: own, frequency, motion } = /** @type {any} */ (drive);
  if (kind === "line") return 2.0 * own[0];
  if (kind === "ellipse") return 2.0 * reachOf(own);
  if (kind === "pieces") return motion.stroke * (own[0] / frequency ** 2);
  const { path, phases, points, step } = sampledPath(drive);
  let { square, i, j } = widestPair(points, points);
  let [p, q] = [phases[i], phases[j]];
  for (let n = 0, far = step; n < SEARCHES; n++, far /= 2.0) {
    const [first, second] = [around(p, far), around(q, far)];
    ({ square, i, j } = widestPair(path(first), path(second)));
    [p, q] = [first[i], second[j]];
  }
  return Math.sqrt(square);
}

/** Largest acceleration of the trough over gravity. @param {Drive} drive of plain numbers */
export function loadOf(drive) {
  const { kind, path: own, frequency, gravity, harmonics, motion } = /** @type {any} */ (drive);
  const rate = TURN * frequency;
  if (kind === "line") return (own[0] * rate ** 2) / gravity;
  if (kind === "ellipse") return (reachOf(own) * rate ** 2) / gravity;
  if (kind === "pieces") return (own[0] * motion.largest_acceleration) / gravity;
  const louder = harmonics.map((/** @type {number[]} */ column, /** @type {number} */ of) =>
    column.map((x, n) => (of % 2 ? x : x * (n + 1) ** 2)));
  const { path, phases, points, step } = sampledPath({ ...drive, harmonics: louder });
  const sizes = points.map(([x, y]) => Math.hypot(x, y));
  const place = phases[sizes.indexOf(Math.max(...sizes))];
  return (largestAbout((at) => path(at).map(([x, y]) => Math.hypot(x, y)), place, step) * rate ** 2) / gravity;
}
