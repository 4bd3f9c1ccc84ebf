/** What the page shows, as texts, and the fragment of the page's address that holds them. */

const PAUSE = 1000; // [ms] after which a further change by the same control gets an entry of its own
const REWRITE = 300; // [ms] between the addresses of a drag: browsers refuse too many of them

/** @typedef {ReturnType<typeof createStore>} Store */
export function createStore(/** @type {Schema} */ { initial, ...schema }) {
  const idle = new Map(Object.entries(schema.idle)); // an address may name anything: objects have constructor and more
  const store = {
    state: /** @type {State} */ ({}), // keys that it lacks are the server's to fill
    bands: /** @type {State[]} */ ([]), // by whether kinetic friction follows, as the server would have them
    drive: () => store.state.drive ?? initial.drive ?? "",
    query, mapKey, value, read, adopt, change,
  };
  let ratio = NaN; // of kinetic to static friction, as it was last set by hand
  let changer = ""; // the control that changed the state last
  let until = 0; // what it does is the same change [ms]
  let written = 0; // [ms] when the address was

  /** The state as a query. @param {string[]} without keys that it leaves out @returns {string} */
  function query(without = []) {
    const unsaid = [...without, ...(idle.get(store.drive()) ?? [])];
    const kept = Object.entries(store.state).filter(([key, text]) =>
      (text || (Object.hasOwn(initial, key) && initial[key])) && !unsaid.includes(key));
    return new URLSearchParams(kept).toString().replaceAll("%3A", ":");
  }

  /** All that the map depends on: where the operating point lies within its axes does not matter.
   * @returns {string} */
  function mapKey() {
    const without = [store.state.x ?? "", store.state.y ?? "", "cycles"];
    const isCoupled = store.state.follow === "1" && without.includes("static_friction");
    if (without.includes("friction_ratio")) without.push("kinetic_friction");
    if (!isCoupled || without.includes("kinetic_friction")) return query(without);
    return `${query([...without, "kinetic_friction"])}&ratio=${ratio.toPrecision(4)}`;
  }

  /** A number of the operating point. @param {string} column @returns {number} */
  function value(column) {
    if (column === "friction_ratio") return value("kinetic_friction") / value("static_friction");
    return Number(store.state[column]);
  }

  function keepRatio() {
    if (value("friction_ratio") >= 0) ratio = Math.min(value("friction_ratio"), 1);
  }

  function read(/** @type {string} */ fragment) {
    store.state = fragment.length > 1 ? Object.fromEntries(new URLSearchParams(fragment.slice(1))) : { ...initial };
    [changer, ratio] = ["", NaN];
  }

  /** Take the server's spelling of this state: 0.8 for 800um. @param {PointAnswer} answer */
  function adopt(answer) {
    Object.assign(store, { state: { ...store.state, ...answer.state }, bands: answer.bands });
    if (Number.isNaN(ratio)) keepRatio();
    const address = `#${query()}`;
    if (location.hash.length > 1 && location.hash !== address) history.replaceState(null, "", address);
  }

  /** Change some keys, and the address with them.
   * @param {State} patch @param {string} control @param {boolean} isFinished */
  function change({ friction_ratio: wanted, ...patch }, control, isFinished) {
    const { follow } = store.state;
    store.state = { ...store.state, ...patch };
    const most = value("static_friction");
    const atMost = (/** @type {number} */ kinetic) => String(Math.min(Number(kinetic.toPrecision(4)), most));
    if (wanted !== undefined) store.state.kinetic_friction = atMost(Number(wanted) * most);
    else if ("static_friction" in patch && !("kinetic_friction" in patch) && most >= 0) {
      if (store.state.follow === "1" && ratio >= 0) store.state.kinetic_friction = atMost(ratio * most);
      else if (value("kinetic_friction") > most) store.state.kinetic_friction = String(most);
    }
    if (wanted !== undefined || "kinetic_friction" in patch || follow !== store.state.follow) keepRatio();

    const [now, address] = [performance.now(), `#${query()}`];
    const goesOn = control === changer && now < until;
    if (goesOn && !isFinished && now < written + REWRITE) return;
    if (goesOn || address === location.hash) history.replaceState(null, "", address);
    else history.pushState(null, "", address);
    [written, changer, until] = [now, control, isFinished ? now + PAUSE : Infinity];
  }

  return store;
}
