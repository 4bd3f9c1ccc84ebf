// @ts-check
/** What happens when: changes go to the address and to the server, answers to the page. */

import { Controls } from "./controls.js";
import { byId, html } from "./draw.js";
import { offerFiles } from "./files.js";
import { drawHistory } from "./history.js";
import { MapView } from "./map.js";
import { Lane, unpack } from "./requests.js";
import { Store } from "./state.js";

const place = (/** @type {string} */ id) => byId(id, HTMLElement);
const say = (/** @type {string} */ text) => (place("says").textContent = text);

/** @type {Map<string, string>} */
const troubles = new Map();
/** @param {string} kind @param {string} trouble */
function report(kind, trouble) {
  if (trouble) troubles.set(kind, trouble);
  else troubles.delete(kind);
  const banner = place("gone");
  const [text] = troubles.values();
  const words = text ? `vibro does not answer (${text}). Nothing is lost: this page tries again by itself.` : "";
  if (banner.textContent !== words) banner.textContent = words;
  banner.hidden = !text;
}

const json = (/** @type {Response} */ response) => response.json();
new Lane("schema", json, start, () => {}, report).ask("");

/** @param {Schema} schema */
function start(schema) {
  const store = new Store(schema);
  const view = new MapView((patch, finished) => change(patch, "map", finished));
  const controls = new Controls(store, change);
  const asked = { map: "", history: "" };
  let fromLink = true; // the state was read from the address
  let finishing = false; // a change is finished, and not yet told
  /** @type {Record<string, Problem[]>} */
  const problems = {};
  /** @type {HistoryAnswer | null} */
  let motion = null;

  const map = new Lane("map", unpack, (/** @type {MapAnswer} */ answer) => {
    accept("map");
    view.show(answer);
    view.place(store.state);
    if (!answer.header.progress.done && map.waiting === null) map.ask(`${store.query()}&advance=1`);
  }, refuse("map"), report);
  const point = new Lane("point", json, showPoint, refuse("point"), report);
  const past = new Lane("history", unpack, (/** @type {HistoryAnswer} */ answer) => {
    accept("history");
    motion = answer;
    drawHistory(place("history"), answer);
  }, refuse("history"), report);

  /** @param {State} patch @param {string} control @param {boolean} finished */
  function change(patch, control, finished) {
    store.change(patch, control, finished);
    fromLink = false;
    finishing = finished;
    delete problems.link;
    update();
  }

  function update() {
    controls.render();
    view.place(store.state);
    const query = store.query();
    byId("csv", HTMLAnchorElement).href = `/table.csv?${query}`;
    point.ask(query);
    const keys = { map: store.mapKey(), history: store.historyKey() };
    if (keys.map !== asked.map) map.ask(query);
    if (keys.history !== asked.history) past.ask(query);
    Object.assign(asked, keys);
  }

  /** @param {string} kind */
  function accept(kind) {
    if (!(kind in problems)) return;
    delete problems[kind];
    showProblems();
  }

  /** @param {"map" | "point" | "history"} kind @returns {(refusal: Refusal) => void} */
  function refuse(kind) {
    return (refusal) => {
      if (kind !== "point") asked[kind] = ""; // to be asked again once the state is mended
      const hint = refusal.hint ? ` (${refusal.hint})` : "";
      problems[kind] = refusal.problems.map((p) => ({ ...p, text: p.text + hint }));
      if (fromLink && location.hash.length > 1) {
        const texts = problems[kind].map((p) => p.text).join("; ");
        problems.link = [{ field: "", text: `The address holds no state that can be shown: ${texts}. This is the initial state.` }];
        fromLink = false;
        store.readFragment("");
        update();
      }
      showProblems();
      say(controls.problems.map((p) => p.text).join(" "));
    };
  }

  function showProblems() {
    const all = problems.link ?? Object.values(problems).flat();
    controls.problems = all.filter((p, n) => all.findIndex((q) => q.text === p.text && q.field === p.field) === n);
    controls.renderNotes();
  }

  /** @param {PointAnswer} answer @param {string} query */
  function showPoint(answer, query) {
    accept("point");
    const facts = Object.fromEntries(answer.facts);
    const [regime] = (facts.regime ?? "").split(",");
    const speed = facts["mean speed"] ?? "";
    place("regime").textContent = regime;
    place("speed").textContent = speed;
    place("guaranteed").textContent = answer.guaranteed;
    const colour = schema.regimes.find((r) => r.label === regime)?.colour;
    place("chip").style.backgroundColor = colour ?? "transparent";
    document.title = `${[regime, speed].filter(Boolean).join(", ")} – vibro`;
    place("command").textContent = answer.command;
    place("command-note").textContent = answer.command_note;
    place("toml").textContent = answer.toml;
    const facing = answer.facts.map(([name, text]) => html("tr", {}, html("th", { scope: "row" }, name), html("td", {}, text)));
    place("tables").replaceChildren(
      html("table", {}, html("caption", {}, "What the body does"), html("tbody", {}, ...facing)),
      ...[table("What begins when", answer.begins), table("Phases of a steady cycle", answer.phases)].flat());
    controls.hints = answer.hints;
    if (query === store.query()) {
      store.adopt(answer.state);
      controls.render();
      if (finishing && !view.dragging) say([regime, speed, answer.guaranteed].filter(Boolean).join(", "));
      finishing = false;
    }
  }

  function follow() {
    fromLink = true;
    store.readFragment(location.hash);
    update();
  }

  window.addEventListener("popstate", follow);
  new ResizeObserver(() => motion && drawHistory(place("history"), motion)).observe(place("history"));
  offerFiles(view, say);
  follow();
}

/** @param {string} caption @param {TableInfo} info */
function table(caption, { head, rows }) {
  if (!rows.length) return [];
  const cells = rows.map(([first, ...rest]) => html("tr", {}, html("th", { scope: "row" }, first), ...rest.map((text) => html("td", {}, text))));
  const heads = html("tr", {}, ...head.map((text) => html("th", { scope: "col" }, text)));
  return [html("table", { class: "numeric" }, html("caption", {}, caption), html("thead", {}, heads), html("tbody", {}, ...cells))];
}
