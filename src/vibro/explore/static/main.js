/** Order of updates: changes go to the address and to the server, its answers to the page. */

import { bindControls, showRefused } from "./controls.js";
import { place } from "./draw.js";
import { offerFiles } from "./files.js";
import { drawHistory } from "./history.js";
import { MapView } from "./map.js";
import { createLane, pause, unpack } from "./requests.js";
import { begin, isInvited } from "./session.js";
import { createStore } from "./state.js";

const TEXTS = /** @type {const} */ (["regime", "speed", "guaranteed", "command", "apart", "toml"]); // of the point
const HEAD_START = 150; // [ms] that the question for a new map has at most before the others
const CALM = 150; // [ms] without a change after which a map is refined, and guarantees are searched for

function say(/** @type {string} */ text, where = "says") {
  if (place(where).textContent !== text) place(where).textContent = text;
}

function start(/** @type {Schema} */ schema) {
  const store = createStore(schema);
  const view = new MapView(schema, store.value, (patch, isFinished) => change(patch, "map", isFinished));
  const renderControls = bindControls(schema.form, store, change);
  let asked = /** @type {string | null} */ (null); // what the map depends on that was asked last
  let isLinked = true; // the state comes from the address
  let badLink = ""; // message on an address without a valid state
  let isTold = true; // how the last finished change ended has been said
  let changed = 0; // [ms] when the state last did
  let refining = 0; // the timer of the next refinement
  let searching = 0; // the timer of the next search
  let motion = /** @type {HistoryAnswer | null} */ (null);

  const map = createLane("map", unpack, (/** @type {MapAnswer} */ answer) => (view.show(answer), refine()), tell);
  const past = createLane("history", unpack, (answer) => drawHistory((motion = answer)), tell);
  const point = createLane("point", (response) => response.json(), showPoint, tell);
  const search = createLane("guarantee", (response) => response.json(), showSearched, tell);

  /** @param {State} patch @param {string} control @param {boolean} isFinished */
  function change(patch, control, isFinished) {
    store.change(patch, control, isFinished);
    isTold = !isFinished;
    leave(false);
    update();
  }

  /** Leave what a bad link said. @param {boolean} forLink */
  function leave(forLink) {
    isLinked = forLink;
    if (badLink) showRefused([], (badLink = ""));
  }

  /** Ask for what the state changed: first a map, then the rest, lest they compete. */
  async function update() {
    changed = performance.now();
    clearTimeout(searching); // for the state before: of one that is refused its problem would stay
    renderControls();
    view.put();
    refine();
    const isDue = asked !== store.mapKey();
    asked = store.mapKey();
    if (isDue) await Promise.race([map.ask(store.query()), pause(HEAD_START)]);
    past.ask(store.query());
    point.ask(store.query());
  }

  /** Ask for more of a map that is not done, once changes pause. */
  function refine() {
    clearTimeout(refining);
    if (!view.map || view.map.header.progress.done) return;
    const ask = () => void (map.waiting ?? (map.problems.length || map.ask(`${store.query()}&advance=1`)));
    refining = setTimeout(ask, Math.max(changed + CALM - performance.now(), 0));
  }

  /** Show all problems. @param {boolean} isRefused */
  function tell(isRefused) {
    const lanes = [map, past, point, search];
    say(lanes.find((lane) => lane.trouble)?.trouble ?? "", "gone");
    if (map.problems.length) asked = null; // to be asked again once the state is mended
    // Where it was mended while the refusal was under way, nothing else would ask.
    if (map.refused && map.refused.replace("&advance=1", "") !== store.query()) map.ask(store.query());
    const problems = new Map(lanes.flatMap((lane) => lane.problems).map((problem) => [problem.text, problem]));
    if (isRefused && isLinked && location.hash.length > 1) {
      badLink = `This link could not be read: ${[...problems.keys()].join("; ")}. The initial state is shown.`;
      isLinked = false;
      store.read("");
      update();
    }
    showRefused(badLink ? [] : [...problems.values()], badLink);
  }

  /** @param {PointAnswer} answer @param {string} query */
  function showPoint(answer, query) {
    for (const id of TEXTS) say(answer[id], id);
    place("chip").style.backgroundColor = answer.colour;
    document.title = `${answer.title} – vibro`;
    place("tables").innerHTML = answer.tables;
    clearTimeout(searching);
    if (query !== store.query()) return;
    if (answer.unproved) say(`${answer.guaranteed}: searching …`, "guaranteed");
    if (answer.unproved) searching = setTimeout(() => search.ask(store.query()), CALM);
    store.adopt(answer);
    if (asked !== null) asked = store.mapKey();
    renderControls();
    view.put();
    if (!isTold && !view.dragging) say([answer.title, answer.guaranteed].filter(Boolean).join(", "));
    isTold = true;
  }

  /** @param {{ text: string }} answer @param {string} query */
  function showSearched(answer, query) {
    if (query !== store.query()) return;
    say(answer.text, "guaranteed");
    say(answer.text);
  }

  /** Take over the state of the address. */
  function follow() {
    if (isInvited()) return; // the page is loaded anew
    leave(true);
    store.read(location.hash);
    update();
  }
  window.addEventListener("popstate", follow);
  new ResizeObserver(() => motion && drawHistory(motion)).observe(place("history"));
  offerFiles(view, store.query, say);
  follow();
}
const schema = createLane("schema", (response) => response.json(), start, () => say(schema.trouble, "gone"));
window.addEventListener("popstate", () => isInvited() && location.reload());
if (isInvited()) await begin();
schema.ask("");
