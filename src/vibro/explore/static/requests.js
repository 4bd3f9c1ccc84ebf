// @ts-check
/** Questions to the server: one under way a kind, the newest waits, the last is never lost. */

const RETRY = 1200; // [ms] after the server did not answer
const PATIENCE = 30000; // [ms] for an answer

/** @template Answer */
export class Lane {
  /**
   * @param {string} kind the route
   * @param {(answer: Response) => Promise<Answer>} read
   * @param {(answer: Answer, query: string) => void} show
   * @param {(refusal: Refusal, query: string) => void} refuse input that the server refuses, unless newer waits
   * @param {(kind: string, trouble: string) => void} report that there is no answer, or "" that there is one
   */
  constructor(kind, read, show, refuse, report) {
    this.kind = kind, this.read = read, this.show = show, this.refuse = refuse, this.report = report;
    /** @type {string | null} */
    this.waiting = null;
    this.busy = false;
  }

  /** @param {string} query */
  ask(query) {
    this.waiting = query;
    if (!this.busy) void this.run();
  }

  async run() {
    this.busy = true;
    while (this.waiting !== null) {
      const query = this.waiting;
      this.waiting = null;
      const answer = await this.fetch(query);
      if (answer === null) {
        this.waiting ??= query;
        await new Promise((resume) => setTimeout(resume, RETRY));
      } else answer();
    }
    this.busy = false;
  }

  /** Ask once: what to do with the answer; null without one. @param {string} query */
  async fetch(query) {
    try {
      const response = await fetch(`/${this.kind}?${query}`, { signal: AbortSignal.timeout(PATIENCE) });
      if (!response.ok && response.status !== 400) {
        const refusal = /** @type {Refusal} */ (await response.json().catch(() => ({ problems: [] })));
        this.report(this.kind, refusal.problems.map((p) => p.text).join("; ") || `answer ${response.status}`);
        return null;
      }
      if (response.ok) {
        const answer = await this.read(response);
        this.report(this.kind, "");
        return () => this.show(answer, query);
      }
      const refusal = /** @type {Refusal} */ (await response.json());
      this.report(this.kind, "");
      return () => this.waiting === null && this.refuse(refusal, query);
    } catch {
      this.report(this.kind, "no answer");
      return null;
    }
  }
}

/** @param {Response} response @returns {Promise<any>} */
export async function unpack(response) {
  const buffer = await response.arrayBuffer();
  const length = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const types = { f4: Float32Array, i1: Int8Array, u1: Uint8Array };
  /** @type {Record<string, Numbers>} */
  const arrays = {};
  for (const { name, type, shape, offset } of header.arrays) {
    const count = shape.reduce((/** @type {number} */ a, /** @type {number} */ b) => a * b, 1);
    arrays[name] = new types[/** @type {"f4" | "i1" | "u1"} */ (type)](buffer, 4 + length + offset, count);
  }
  return { header, arrays };
}
