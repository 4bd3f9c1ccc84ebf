/** Questions to the server: one under way a kind, the newest waits, the last is never lost. */

const RETRY = 1200; // [ms] after the server gave no answer
const PATIENCE = 30000; // [ms] for an answer
const GONE = "vibro does not answer: is it still running? This page keeps its state and tries again.";
const ANEW = "vibro was started anew: open the address that it printed, in another tab; this page then goes on.";

class Trouble extends Error {}

export const pause = (/** @type {number} */ time) => new Promise((resume) => setTimeout(resume, time));

/** @template Answer */
export class Lane {
  /**
   * @param {string} kind the route
   * @param {(response: Response) => Promise<Answer>} read
   * @param {(answer: Answer, query: string) => void} show
   * @param {(refused: boolean) => void} tell called where there are new problems, or none any more
   */
  constructor(kind, read, show, tell) {
    this.kind = kind;
    this.read = read;
    this.show = show;
    this.tell = tell;
    this.problems = /** @type {Problem[]} */ ([]); // of the input, that the server told last
    this.trouble = ""; // why there is no answer
    this.waiting = /** @type {string | null} */ (null);
    this.work = /** @type {Promise<void> | null} */ (null);
  }

  /** Ask, now or after what is under way; resolves once nothing waits. @param {string} query */
  ask(query) {
    this.waiting = query;
    this.work ??= this.answerAll().finally(() => (this.work = null));
    return this.work;
  }

  async answerAll() {
    while (this.waiting !== null) {
      const query = this.waiting;
      this.waiting = null;
      const act = await this.fetch(query).catch((error) => {
        this.trouble = error instanceof Trouble ? error.message : GONE;
      });
      if (act) act();
      else {
        this.tell(false);
        this.waiting ??= query;
        await pause(RETRY);
      }
    }
  }

  /** Ask once, and tell what to do with the answer. @param {string} query @returns {Promise<() => void>} */
  async fetch(query) {
    const response = await fetch(`/${this.kind}?${query}`, { signal: AbortSignal.timeout(PATIENCE) });
    const answer = response.ok ? await this.read(response) : null;
    if (response.status === 403) throw new Trouble(ANEW);
    const { problems, hint } = answer ? { problems: [] } : /** @type {Refusal} */ (await response.json());
    const texts = problems.map((p) => p.text).join("; ");
    if (!answer && response.status !== 400) throw new Trouble(`vibro says: ${texts}. This page tries again.`);
    const isNews = this.trouble || problems.length || this.problems.length;
    this.trouble = "";
    if (!answer && this.waiting !== null) return () => this.tell(false);
    this.problems = problems.map(({ field, text }) => ({ field, text: hint ? `${text} (${hint})` : text }));
    return () => {
      if (isNews) this.tell(!answer);
      if (answer) this.show(answer, query);
    };
  }
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
