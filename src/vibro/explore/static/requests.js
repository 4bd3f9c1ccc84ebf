/** Questions to the server: one under way a kind, the newest waits, the last is never lost. */

import { ask as send } from "./session.js";

const RETRY = 1200; // [ms] after the server gave no answer
const PATIENCE = 30000; // [ms] for an answer
const GONE = "vibro does not answer: is it still running? This page keeps its state and tries again.";
const ANEW = "vibro was started anew, or answers another browser: open the address that it printed; this page then goes on.";

export const pause = (/** @type {number} */ time) => new Promise((resume) => setTimeout(resume, time));

/**
 * A queue of requests; its `problems` are those of the input, its `trouble` is why there is no answer.
 * @template Answer
 * @param {string} kind the route
 * @param {(response: Response) => Promise<Answer>} read
 * @param {(answer: Answer, query: string) => void} show
 * @param {(refused: boolean) => void} tell called when problems appear or disappear
 */
export function createLane(kind, read, show, tell) {
  const lane = {
    problems: /** @type {Problem[]} */ ([]), refused: "", // query that has them
    trouble: "", waiting: /** @type {string?} */ (null), ask,
  };
  let work = /** @type {Promise<void> | null} */ (null);

  /** Ask, now or after what is under way; resolves once nothing waits. @param {string} query */
  function ask(query) {
    lane.waiting = query;
    work ??= answerAll().finally(() => (work = null));
    return work;
  }

  async function answerAll() {
    while (lane.waiting !== null) {
      const query = lane.waiting;
      lane.waiting = null;
      const act = await askOnce(query).catch(() => GONE);
      if (typeof act === "string") {
        lane.trouble = act;
        tell(false);
        lane.waiting ??= query;
        await pause(RETRY);
      } else act();
    }
  }

  /** Ask, and return what to do with the answer, or why there is none.
   * @param {string} query @returns {Promise<string | (() => void)>} */
  async function askOnce(query) {
    const response = await send(`/${kind}?${query}`, AbortSignal.timeout(PATIENCE));
    if (response.status === 403) return ANEW;
    const answer = response.ok ? await read(response) : null;
    const { problems, hint } = answer ? { problems: [] } : /** @type {Refusal} */ (await response.json());
    const told = problems.map(({ field, text }) => ({ field, text: hint ? `${text} (${hint})` : text }));
    if (!answer && response.status !== 400) return `vibro says: ${told[0]?.text}. This page tries again.`;
    const isNews = lane.trouble || told.length || lane.problems.length;
    lane.trouble = "";
    if (!answer && lane.waiting !== null) return () => tell(false);
    lane.problems = told;
    lane.refused = answer ? "" : query;
    return () => {
      if (isNews) tell(!answer);
      if (answer) show(answer, query);
    };
  }

  return lane;
}

/** @param {Response} response @returns {Promise<any>} */
export async function unpack(response) {
  const buffer = await response.arrayBuffer();
  const length = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const types = { f4: Float32Array, i1: Int8Array, u1: Uint8Array, u2: Uint16Array };
  const arrays = /** @type {ArrayInfo[]} */ (header.arrays).map(({ name, type, shape, offset }) =>
    [name, new types[type](buffer, 4 + length + offset, shape.reduce((a, b) => a * b, 1))]);
  return { header, arrays: Object.fromEntries(arrays) };
}
