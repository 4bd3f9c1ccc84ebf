/** What follows on what: changes go to the address and to the server, its answers to the page. */

import { bindControls, showRefused } from "./controls.js";
import { html, place, set } from "./draw.js";
import { offerFiles } from "./files.js";
import { drawHistory } from "./history.js";
import { MapView } from "./map.js";
import { Lane, pause, unpack } from "./requests.js";
import { Store } from "./state.js";

const HEAD_START = 150; // [ms] that the question for a new map has at most before the others
const COPIED = 2000; // [ms] that a button says so
const CALM = 150; // [ms] without a change after which a map is refined

const json = (/** @type {Response} */ response) => response.json();
function say(/** @type {string} */ text, where = "says") {
  if (place(where).textContent !== text) place(where).textContent = text;
}
const warn = (/** @type {string} */ trouble) => say(trouble, "gone");

let pressed = /** @type {HTMLElement | null} */ (null); // the last button for texts to take along
place("take").addEventListener("click", ({ target }) => (pressed = /** @type {HTMLElement} */ (target)));
/** Say what became of a text, for a while on its button too. @param {string} text */
function sayCopied(text) {
  say(text);
  const button = pressed;
  if (!button || text !== "copied") return;
  button.textContent = "Copied";
  setTimeout(() => (button.textContent = "Copy"), COPIED);
}

/** A table, unless it is empty. @param {string} caption @param {TableInfo} content @returns {Node[]} */
function table(caption, { head, rows }) {
  if (!rows.length) return [];
  const heads = head.map((text) => html("th", { scope: "col" }, text));
  const cells = rows.map(([name, ...texts]) =>
    html("tr", {}, html("th", { scope: "row" }, name), ...texts.map((text) => html("td", {}, text))));
  const top = head.length ? [html("thead", {}, html("tr", {}, ...heads))] : [];
  const kind = head.length ? "numeric" : "facts";
  return [html("table", { class: kind }, html("caption", {}, caption), ...top, html("tbody", {}, ...cells))];
}

function start(/** @type {Schema} */ schema) {
  const store = new Store(schema);
  const numberOf = (/** @type {string} */ column) => store.value(column);
  const view = new MapView(schema, numberOf, (patch, isFinished) => change(patch, "map", isFinished));
  const renderControls = bindControls(store, change);
  const asked = { map: "", history: "" }; // what the last questions depended on
  let isLinked = true; // the state comes from the address
  let badLink = ""; // what is said of an address that tells no state
  let isTold = true; // how the last finished change ended has been said
  let changed = 0; // [ms] when the state last did
  let refining = 0; // the timer of the next refinement
  let motion = /** @type {HistoryAnswer | null} */ (null);

  const map = new Lane("map", unpack, (/** @type {MapAnswer} */ answer) => (view.show(answer), refine()), tell);
  const past = new Lane("history", unpack, (answer) => drawHistory((motion = answer)), tell);
  const point = new Lane("point", json, showPoint, tell);

  /** @param {State} patch @param {string} control @param {boolean} isFinished */
  function change(patch, control, isFinished) {
    store.change(patch, control, isFinished);
    isTold = !isFinished;
    leave();
    update();
  }

  /** Leave what a bad link said. */
  function leave() {
    isLinked = false;
    if (badLink) showRefused([], (badLink = ""));
  }

  /** Ask for what the state changed: first a map, then the rest, lest they compete. */
  async function update() {
    changed = performance.now();
    renderControls();
    view.put();
    set(place("csv"), { href: `/table.csv?${store.query()}` });
    refine();
    if (isDue("map", store.mapKey())) await Promise.race([map.ask(store.query()), pause(HEAD_START)]);
    if (isDue("history", store.historyKey())) past.ask(store.query());
    point.ask(store.query());
  }

  /** Whether a route is to be asked, as what its answer depends on has changed, or was refused.
   * @param {"map" | "history"} kind @param {string} key */
  function isDue(kind, key) {
    const isNew = key !== asked[kind] || !key;
    asked[kind] = key;
    return isNew;
  }

  /** Ask for more of a map that is not done, once changes pause. */
  function refine() {
    clearTimeout(refining);
    if (!view.map || view.map.header.progress.done) return;
    const ask = () => void (map.waiting ?? (map.problems.length || map.ask(`${store.query()}&advance=1`)));
    refining = setTimeout(ask, Math.max(changed + CALM - performance.now(), 0));
  }

  /** Tell what is wrong. @param {boolean} isRefused */
  function tell(isRefused) {
    const lanes = [map, past, point];
    warn(lanes.find((lane) => lane.trouble)?.trouble ?? "");
    if (map.problems.length) asked.map = ""; // to be asked again once the state is mended
    if (past.problems.length) asked.history = "";
    const all = lanes.flatMap((lane) => lane.problems);
    const problems = all.filter((p, n) => all.findIndex((q) => q.text === p.text) === n);
    if (isRefused && isLinked && location.hash.length > 1) {
      badLink = `This link could not be read: ${problems.map((p) => p.text).join("; ")}. The initial state is shown.`;
      isLinked = false;
      store.read("");
      update();
    }
    showRefused(badLink ? [] : problems, badLink);
  }

  /** @param {PointAnswer} answer @param {string} query */
  function showPoint(answer, query) {
    for (const id of /** @type {const} */ (["regime", "speed", "guaranteed", "command", "apart", "toml"])) say(answer[id], id);
    place("chip").style.backgroundColor = answer.colour;
    document.title = `${answer.title} – vibro`;
    place("tables").replaceChildren(...table("What the body does", { head: [], rows: answer.facts }),
      ...table("What begins when", answer.begins), ...table("Phases of a steady cycle", answer.phases));
    if (query !== store.query()) return;
    store.adopt(answer.state);
    if (asked.map) asked.map = store.mapKey();
    if (asked.history) asked.history = store.historyKey();
    renderControls();
    view.put();
    if (!isTold && !view.dragging) say([answer.title, answer.guaranteed].filter(Boolean).join(", "));
    isTold = true;
  }

  /** Go to what the address tells. */
  function follow() {
    leave();
    isLinked = true;
    store.read(location.hash);
    update();
  }
  window.addEventListener("popstate", follow);
  new ResizeObserver(() => motion && drawHistory(motion)).observe(place("history"));
  offerFiles(view, sayCopied);
  follow();
}
const schema = new Lane("schema", json, start, () => warn(schema.trouble));
schema.ask("");
