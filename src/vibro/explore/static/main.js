/** What follows on what: changes go to the address and to the server, its answers to the page. */

import { Controls } from "./controls.js";
import { html, place, set } from "./draw.js";
import { offerFiles } from "./files.js";
import { drawHistory } from "./history.js";
import { MapView } from "./map.js";
import { Lane, unpack } from "./requests.js";
import { Store } from "./state.js";

const json = (/** @type {Response} */ response) => response.json();
const say = (/** @type {string} */ text) => void (place("says").textContent = text);

const troubles = /** @type {Map<string, string>} */ (new Map());
function report(/** @type {string} */ kind, /** @type {string} */ trouble) {
  if (trouble) troubles.set(kind, trouble);
  else troubles.delete(kind);
  const [text] = troubles.values();
  const words = text ? `vibro does not answer (${text}). This page keeps its state and tries again by itself.` : "";
  if (place("gone").textContent !== words) place("gone").textContent = words;
}

/** @param {string} caption @param {string[]} head @param {string[][]} rows */
function table(caption, head, rows) {
  const heads = head.map((text) => html("th", { scope: "col" }, text));
  const body = rows.map(([name, ...texts]) => html("tr", {}, html("th", { scope: "row" }, name), ...texts.map((text) => html("td", {}, text))));
  const parts = [html("caption", {}, caption), ...(head.length ? [html("thead", {}, html("tr", {}, ...heads))] : [])];
  return html("table", { class: head.length ? "numeric" : "facts" }, ...parts, html("tbody", {}, ...body));
}

function start(/** @type {Schema} */ schema) {
  const store = new Store(schema);
  const view = new MapView(schema, (column) => store.value(column), (patch, finished) => change(patch, "map", finished));
  const controls = new Controls(store, change);
  const problems = /** @type {Record<string, Problem[]>} */ ({}); // by the route that found them
  const asked = { map: "", history: "" }; // what the last questions depended on
  let isLinked = true; // the state comes from the address
  let isFinished = false; // the last change is, and is yet to be told
  let motion = /** @type {HistoryAnswer | null} */ (null);

  /** @template A @param {string} kind @param {(response: Response) => Promise<A>} read @param {(answer: A, query: string) => void} show */
  function lane(kind, read, show) {
    return new Lane(kind, read, (answer, query) => {
      if (delete problems[kind] && controls.problems.length) showProblems();
      show(answer, query);
    }, (refusal) => refuse(kind, refusal), report);
  }
  const map = lane("map", unpack, (/** @type {MapAnswer} */ answer, query) => {
    view.show(answer, Boolean(new URLSearchParams(query).get("target")));
    if (!answer.header.progress.done && map.waiting === null) map.ask(`${store.query()}&advance=1`);
  });
  const past = lane("history", unpack, (/** @type {HistoryAnswer} */ answer) => drawHistory(place("history"), (motion = answer)));
  const point = lane("point", json, showPoint);

  /** @param {State} patch @param {string} control @param {boolean} finished */
  function change(patch, control, finished) {
    store.change(patch, control, finished);
    [isLinked, isFinished] = [false, finished];
    delete problems.address;
    update();
  }

  function update() {
    controls.render();
    view.put();
    const query = store.query();
    const keys = { map: store.mapKey(), history: store.historyKey() };
    if (keys.map !== asked.map || !keys.map) map.ask(query);
    if (keys.history !== asked.history || !keys.history) past.ask(query);
    point.ask(query);
    Object.assign(asked, keys);
    set(place("csv"), { href: `/table.csv?${query}` });
  }

  /** @param {string} kind @param {Refusal} refusal */
  function refuse(kind, refusal) {
    Object.assign(asked, { [kind]: "" }); // to be asked again once the state is mended
    const hint = refusal.hint ? ` (${refusal.hint})` : "";
    problems[kind] = refusal.problems.map(({ field, text }) => ({ field, text: text + hint }));
    if (isLinked && location.hash.length > 1) {
      const texts = refusal.problems.map((p) => p.text).join("; ");
      problems.address = [{ field: "", text: `The address tells no state: ${texts}. This is the initial one.` }];
      follow("");
    }
    showProblems();
    say(controls.problems.map((p) => p.text).join(" "));
  }

  function showProblems() {
    const all = problems.address ?? Object.values(problems).flat();
    controls.problems = all.filter((p, n) => all.findIndex((q) => q.text === p.text) === n);
    controls.renderNotes();
  }

  /** @param {PointAnswer} answer @param {string} query */
  function showPoint(answer, query) {
    const told = [answer.regime, Object.fromEntries(answer.facts)["mean speed"] ?? "", answer.guaranteed];
    ["regime", "speed", "guaranteed"].forEach((id, n) => (place(id).textContent = told[n]));
    place("chip").style.backgroundColor = schema.regimes.find((r) => r.label === answer.regime)?.colour ?? "transparent";
    document.title = `${told.slice(0, 2).filter(Boolean).join(", ")} – vibro`;
    for (const id of /** @type {const} */ (["command", "toml"])) place(id).textContent = answer[id];
    place("tables").replaceChildren(table("What the body does", [], answer.facts),
      ...(answer.begins.rows.length ? [table("What begins when", answer.begins.head, answer.begins.rows)] : []),
      ...(answer.phases.rows.length ? [table("Phases of a steady cycle", answer.phases.head, answer.phases.rows)] : []));
    if (query !== store.query()) return;
    store.adopt(answer.state);
    if (asked.map) asked.map = store.mapKey();
    if (asked.history) asked.history = store.historyKey();
    controls.render();
    view.put();
    if (isFinished && !view.dragging) say(told.filter(Boolean).join(", "));
    isFinished = false;
  }

  /** @param {string} fragment */
  function follow(fragment) {
    isLinked = fragment !== "";
    store.read(fragment);
    update();
  }
  window.addEventListener("popstate", () => follow(location.hash));
  new ResizeObserver(() => motion && drawHistory(place("history"), motion)).observe(place("history"));
  offerFiles(view, say);
  follow(location.hash);
}
new Lane("schema", json, start, () => {}, report).ask("");
