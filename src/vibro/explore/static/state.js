// @ts-check
/** What the page shows, as texts, and the fragment of its address that holds them. */

const PAUSE = 1000; // [ms] after which a further change by the same control is a change of its own
const REWRITE = 300; // [ms] between rewritten addresses of a drag: browsers refuse many of them

export class Store {
  /** @param {Schema} schema */
  constructor(schema) {
    this.schema = schema;
    /** @type {State} */
    this.state = { ...schema.initial };
    this.ratio = 1; // of kinetic to static friction, as it was last set by hand
    this.control = ""; // that changed the state last
    this.until = 0;
    this.written = 0;
    this.readFragment("");
  }

  /** Whether a quantity counts for the drive that is chosen. @param {Quantity} quantity */
  counts(quantity) {
    return quantity.drives.includes(this.state.drive);
  }

  /** The state as a query. @param {(key: string) => boolean} [keep] */
  query(keep = () => true) {
    const idle = new Set(this.schema.quantities.filter((q) => !this.counts(q)).map((q) => q.column));
    const kept = Object.entries(this.state).filter(([key]) => !idle.has(key) && keep(key));
    return new URLSearchParams(kept).toString().replaceAll("%3A", ":");
  }

  /** All that the map depends on: where the operating point lies within its axes does not matter. */
  mapKey() {
    const { x, y, follow } = this.state;
    const coupled = follow === "1" && [x, y].includes("static_friction");
    const idle = new Set([x, y, "cycles", ...(coupled ? ["kinetic_friction"] : [])]);
    return this.query((key) => !idle.has(key)) + (coupled ? `&ratio=${this.ratio.toPrecision(4)}` : "");
  }

  /** All that the history depends on. */
  historyKey() {
    const columns = new Set(this.schema.quantities.map((q) => q.column));
    return this.query((key) => columns.has(key) || key === "drive" || key === "cycles");
  }

  /** Take the state from a fragment; keys that it lacks have their initial values. @param {string} fragment */
  readFragment(fragment) {
    this.state = { ...this.schema.initial, ...Object.fromEntries(new URLSearchParams(fragment.replace(/^#/, ""))) };
    this.control = "";
    this.keepRatio();
  }

  keepRatio() {
    const ratio = Number(this.state.kinetic_friction) / Number(this.state.static_friction);
    if (ratio >= 0) this.ratio = Math.min(ratio, 1);
  }

  /**
   * Change some keys; an empty text removes its key.
   * @param {State} patch
   * @param {string} control one entry of the browser's history for all that it does without a pause
   * @param {boolean} finished
   */
  change(patch, control, finished) {
    const next = Object.fromEntries(Object.entries({ ...this.state, ...patch }).filter(([, text]) => text !== ""));
    const most = Number(next.static_friction);
    if ("static_friction" in patch && !("kinetic_friction" in patch) && Number.isFinite(most)) {
      const wanted = next.follow === "1" ? Number((this.ratio * most).toPrecision(4)) : Number(next.kinetic_friction);
      if (next.follow === "1" || wanted > most) next.kinetic_friction = String(Math.min(wanted, most));
    }
    this.state = next;
    if ("kinetic_friction" in patch || "follow" in patch) this.keepRatio();
    this.writeFragment(control, finished);
  }

  /** Take the server's spelling of this state: 0.8 for 800um. @param {State} state */
  adopt(state) {
    const keys = [...new URLSearchParams(this.query()).keys()];
    for (const key of keys) this.state[key] = state[key] ?? this.state[key];
    if (location.hash.length > 1) history.replaceState(null, "", `#${this.query()}`);
  }

  /** @param {string} control @param {boolean} finished */
  writeFragment(control, finished) {
    const now = performance.now();
    const address = `#${this.query()}`;
    const goesOn = control === this.control && now < this.until;
    if (!goesOn && address !== location.hash) history.pushState(null, "", address);
    else if (finished || now > this.written + REWRITE) history.replaceState(null, "", address);
    else return;
    this.written = now;
    this.control = control;
    this.until = finished ? now + PAUSE : Infinity;
  }
}
