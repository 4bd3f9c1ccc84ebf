/** Questions to the server: one under way a kind, the newest waits, the last is never lost. */

const RETRY = 1200; // [ms] after the server gave no answer
const PATIENCE = 30000; // [ms] for an answer

/** @template Answer */
export class Lane {
  /**
   * @param {string} kind the route
   * @param {(response: Response) => Promise<Answer>} read
   * @param {(answer: Answer, query: string) => void} show
   * @param {(refusal: Refusal) => void} refuse told of input that the server refuses, unless newer waits
   * @param {(kind: string, trouble: string) => void} report told why there is no answer, or "" once there is one
   */
  constructor(kind, read, show, refuse, report) {
    this.kind = kind;
    this.read = read;
    this.show = show;
    this.refuse = refuse;
    this.report = report;
    /** @type {string | null} */
    this.waiting = null;
    this.busy = false;
  }

  /** @param {string} query */
  async ask(query) {
    this.waiting = query;
    if (this.busy) return;
    this.busy = true;
    while (this.waiting !== null) {
      /** @type {string} */
      const asked = this.waiting;
      this.waiting = null;
      const act = await this.fetch(asked).catch((error) => this.report(this.kind, String(error.message)));
      if (act) act();
      else {
        this.waiting ??= asked;
        await new Promise((resume) => setTimeout(resume, RETRY));
      }
    }
    this.busy = false;
  }

  /** Ask once, and tell what to do with the answer. @param {string} query @returns {Promise<() => void>} */
  async fetch(query) {
    const response = await fetch(`/${this.kind}?${query}`, { signal: AbortSignal.timeout(PATIENCE) });
    const answer = response.ok ? await this.read(response) : null;
    const refusal = answer ? null : /** @type {Refusal} */ (await response.json());
    if (refusal && response.status !== 400) throw new Error(refusal.problems.map((p) => p.text).join("; "));
    this.report(this.kind, "");
    return () => (answer ? this.show(answer, query) : refusal && this.waiting === null && this.refuse(refusal));
  }
}

/** @param {Response} response @returns {Promise<any>} */
export async function unpack(response) {
  const buffer = await response.arrayBuffer();
  const length = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const types = { f4: Float32Array, i1: Int8Array, u1: Uint8Array };
  const arrays = /** @type {ArrayInfo[]} */ (header.arrays).map(({ name, type, shape, offset }) => {
    return [name, new types[type](buffer, 4 + length + offset, shape.reduce((a, b) => a * b, 1))];
  });
  return { header, arrays: Object.fromEntries(arrays) };
}
