/** What the page shows, as texts, and the fragment of the page's address that holds them. */

const PAUSE = 1000; // [ms] after which a further change by the same control gets an entry of its own
const REWRITE = 300; // [ms] between the addresses of a drag: browsers refuse too many of them

export class Store {
  /** @param {Schema} schema */
  constructor(schema) {
    this.schema = schema;
    /** @type {State} */
    this.state = {}; // keys that it lacks are the server's to fill
    this.ratio = NaN; // of kinetic to static friction, as it was last set by hand
    this.control = ""; // that changed the state last
    this.until = 0; // what it does is the same change [ms]
    this.written = 0; // [ms] when the address was
  }

  get drive() {
    return this.state.drive ?? this.schema.initial.drive ?? "";
  }

  /** The state as a query. @param {(key: string) => boolean} [keep] */
  query(keep = () => true) {
    const idle = this.schema.idle[this.drive] ?? [];
    const says = (/** @type {[string, string]} */ [key, text]) => text !== "" || this.schema.initial[key];
    const kept = Object.entries(this.state).filter((pair) => says(pair) && !idle.includes(pair[0]) && keep(pair[0]));
    return new URLSearchParams(kept).toString().replaceAll("%3A", ":");
  }

  /** All that the map depends on: where the operating point lies within its axes does not matter. */
  mapKey() {
    const { x, y, follow } = this.state;
    const idle = [x, y, "cycles"];
    if (idle.includes("friction_ratio")) idle.push("kinetic_friction");
    const coupled = follow === "1" && idle.includes("static_friction") && !idle.includes("kinetic_friction");
    if (coupled) idle.push("kinetic_friction");
    return this.query((key) => !idle.includes(key)) + (coupled ? `&ratio=${this.ratio.toPrecision(4)}` : "");
  }

  /** All that the history depends on. */
  historyKey() {
    const keys = [...this.schema.columns, "drive", "cycles"];
    return this.query((key) => keys.includes(key));
  }

  /** A number of the operating point. @param {string} column @returns {number} */
  value(column) {
    if (column === "friction_ratio") return this.value("kinetic_friction") / this.value("static_friction");
    return Number(this.state[column]);
  }

  /** @param {string} fragment */
  read(fragment) {
    const given = Object.fromEntries(new URLSearchParams(fragment.slice(1)));
    this.state = fragment.length > 1 ? given : { ...this.schema.initial };
    [this.control, this.ratio] = ["", NaN];
  }

  keepRatio() {
    const ratio = this.value("friction_ratio");
    if (ratio >= 0) this.ratio = Math.min(ratio, 1);
  }

  /** Take the server's spelling of this state: 0.8 for 800um. @param {State} state */
  adopt(state) {
    this.state = { ...this.state, ...state };
    if (Number.isNaN(this.ratio)) this.keepRatio();
    const address = `#${this.query()}`;
    if (location.hash.length > 1 && location.hash !== address) history.replaceState(null, "", address);
  }

  /** Change some keys. @param {State} patch @param {string} control @param {boolean} finished */
  change({ friction_ratio: ratio, ...patch }, control, finished) {
    const { follow } = this.state;
    this.state = { ...this.state, ...patch };
    const most = this.value("static_friction");
    const least = (/** @type {number} */ wanted) => String(Math.min(Number(wanted.toPrecision(4)), most));
    if (ratio !== undefined) this.state.kinetic_friction = least(Number(ratio) * most);
    else if ("static_friction" in patch && !("kinetic_friction" in patch) && most >= 0) {
      if (this.state.follow === "1" && this.ratio >= 0) this.state.kinetic_friction = least(this.ratio * most);
      else if (this.value("kinetic_friction") > most) this.state.kinetic_friction = String(most);
    }
    if (ratio !== undefined || "kinetic_friction" in patch || follow !== this.state.follow) this.keepRatio();
    const [now, address] = [performance.now(), `#${this.query()}`];
    const goesOn = control === this.control && now < this.until;
    if (goesOn && !finished && now < this.written + REWRITE) return;
    if (goesOn || address === location.hash) history.replaceState(null, "", address);
    else history.pushState(null, "", address);
    [this.written, this.control, this.until] = [now, control, finished ? now + PAUSE : Infinity];
  }
}
