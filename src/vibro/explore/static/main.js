/** Order of updates: a change goes to the state, that to the map, the numbers, the motion and the address. */

import { html, place, set, tableOf, valueText } from "./draw.js";
import { commandOf, offerFiles, otherSprings, tomlOf } from "./files.js";
import { createForm } from "./form.js";
import { MapView } from "./map.js";
import { drawMotion } from "./motion.js";
import { answerOf, showAnswer } from "./numbers.js";
import { data, drivesOf, quantitiesOf, spansOf } from "./state.js";
import { createStore } from "./store.js";

/** @typedef {import("./state.js").Shown} Shown
 * @typedef {import("./state.js").Texts} Texts
 * @typedef {import("./numbers.js").Answer} Answer */

const APART = "For the operating point's own values: these commands and scene files have no bands.";
const NOT_OF_BANDS = "numbers and motion are those of the operating point, not of the bands";
const MAP_TIME = 60; // [ms] in which a map without flights is seen
/** What the command of a drive reads from the scene file. @type {Record<string, string>} */
const READ = { given: "motion", machine: "machine" };

function say(/** @type {string} */ text, where = "says") {
  if (place(where).textContent !== text) place(where).textContent = text;
}

/** How texts to take along differ from what is shown, or what they need. @param {Shown} state */
function apartText(state) {
  const { drive, bands } = state;
  const file = drive in READ ? [`The command reads the ${READ[drive]} from the scene file, saved as scene.toml.`] : [];
  const solve = otherSprings(state);
  const springs = solve ? [`For these numbers with other springs: ${solve}.`] : [];
  return [...file, ...springs, ...(Object.keys(bands).length ? [APART] : [])].join(" ");
}

/** What is asked, for paper: the scene and its quantities; and of which of its bodies the numbers are.
 * @param {Shown} state */
function questionText(state) {
  const { scene, drive, values: { friction_ratio: _, ...values }, bands, target } = state;
  const kind = drivesOf(data, scene)[drive];
  const told = (/** @type {Record<string, number[]>} */ spans) =>
    quantitiesOf(data, kind).filter((name) => name in spans).map((name) => {
      const ends = new Set(spans[name].map((end) => valueText(data.quantities[name], end)));
      return `${data.quantities[name].label} ${[...ends].join(" to ")}`;
    }).join(", ");
  const spans = spansOf(values, state);
  const asked = [`${data.scenes[scene].name || "Scene"}, trough moved ${kind.label}: ${told(spans)}`];
  if (target !== null) asked.push(`target speed ${valueText(data.quantities.speed, target)}`);
  const own = Object.entries(values).filter(([name]) => name in bands || !(name in spans));
  const point = Object.fromEntries(own.map(([name, value]) => [name, [value]]));
  if (own.length) asked.push(`${NOT_OF_BANDS}: ${told(point)}`);
  return asked.join("; ");
}

function start() {
  const view = new MapView(data, { // first: its workers begin meanwhile
    value: (name) => store.value(name),
    move: (patch, isFinished) => change(patch, "map", isFinished),
  });
  const engine = engineOf(exports, data.known);
  const store = createStore(data);
  const form = createForm(data, store, change);
  const answers = /** @type {(Answer | null)[]} */ (data.scenes.map(() => null));
  let badLink = ""; // message on an address without a valid state
  let failed = /** @type {{field: string, text: string}[]} */ ([]); // parts of the page that cannot show this state
  let wide = 0; // [px] of the motion as it was drawn
  let awaited = 0; // timer of a motion that is to be drawn: that takes as long as a map, which a hand sees before

  /** @param {Texts} patch @param {string} control @param {boolean} isFinished */
  function change(patch, control, isFinished) {
    badLink = "";
    store.change(patch, control, isFinished);
    update();
    if (isFinished && !store.problems.length) say(answers[store.scene]?.title ?? "");
  }

  /** Do something that may fail for a scene that nobody has tried; the rest of the page goes on.
   * @param {string} what @param {() => void} act */
  function attempt(what, act) {
    try {
      act();
    } catch (error) {
      console.error(error);
      tellFailed(what, error);
    }
  }

  /** @param {string} what @param {unknown} error */
  function tellFailed(what, error) {
    failed.push({ field: "", text: `${what}: ${error instanceof Error ? error.message : error}` });
    form.refuse(failed, "");
  }

  /** Show the state. While what somebody typed is refused, all but the form shows the last valid one. */
  function update() {
    const { problems, scene, state } = store;
    failed = [];
    const isShown = state && !problems.length;
    if (isShown) attempt("map", () => view.show(state)); // first: workers solve it meanwhile
    form.render();
    form.refuse(badLink ? [] : [...problems, ...failed], badLink);
    if (!isShown) return;
    attempt("numbers", () => showNumbers((answers[scene] = answerOf(data, engine, state))));
    attempt("files", () => takeAlong(state));
    showScenes();
    awaited ||= setTimeout(showMotion, MAP_TIME);
  }

  /** Draw the motion, as wide as there is room. */
  function showMotion() {
    clearTimeout(awaited);
    awaited = 0;
    wide = place("history").clientWidth;
    const { state } = store;
    if (state) attempt("motion", () => drawMotion(data, engine, state));
  }

  /** @param {Answer} answer */
  function showNumbers(answer) {
    say(answer.regime, "regime");
    say(answer.speedText, "speed");
    place("chip").style.backgroundColor = answer.colour || "transparent";
    document.title = `${answer.title} – vibro`;
    showAnswer(answer, place("tables"));
  }

  /** @param {Shown} state */
  function takeAlong(state) {
    say(commandOf(data, state), "command");
    say(tomlOf(data, state), "toml");
    say(apartText(state), "apart");
    say(questionText(state), "print-question"); // on paper alone, where there are no sliders
  }

  /** Tabs of several scenes, and a table that compares them. */
  function showScenes() {
    if (data.scenes.length < 2) return;
    place("tabs").hidden = place("compare").hidden = false;
    const tabs = [...place("tabs").children];
    tabs.forEach((tab, scene) => set(tab, { "aria-current": String(scene === store.scene) }));
    const rows = data.scenes.map((_, scene) => {
      const { regime, speedText } = answerFor(scene) ?? { regime: "unknown", speedText: "unknown" };
      return [nameOf(scene), regime, speedText];
    });
    const title = "Scenes compared; a link holds the open one alone";
    place("compare").replaceChildren(tableOf(title, ["scene", "regime", "mean speed"], rows));
  }

  /** The name of a scene, with its number where another has the same. @param {number} scene */
  function nameOf(scene) {
    const { name } = data.scenes[scene];
    const others = data.scenes.filter((other) => other.name === name);
    return name && others.length === 1 ? name : `${name || "scene"} ${scene + 1}`;
  }

  /** The answer of a scene, also of one that was not shown yet. @param {number} scene */
  function answerFor(scene) {
    const { state } = store.tabs[scene];
    if (!answers[scene] && state) attempt(nameOf(scene), () => void (answers[scene] = answerOf(data, engine, state)));
    return answers[scene];
  }

  /** Show another scene. @param {number} scene */
  function open(scene) {
    badLink = "";
    store.open(scene);
    update();
  }

  /** Take over the state of the address. */
  function follow() {
    const wrong = store.read(location.hash);
    const reasons = wrong.map(({ text }) => text).join("; ");
    badLink = wrong.length ? `This link could not be read: ${reasons}. The initial state is shown.` : "";
    update();
  }

  place("tabs").replaceChildren(...data.scenes.map((_, scene) => {
    const tab = html("button", { type: "button" }, nameOf(scene));
    tab.addEventListener("click", () => open(scene));
    return tab;
  }));
  window.addEventListener("popstate", follow);
  window.addEventListener("unhandledrejection", ({ reason }) => tellFailed("map", reason)); // drawn when it is solved
  new ResizeObserver(() => {
    if (!awaited && place("history").clientWidth !== wide) showMotion();
  }).observe(place("history"));
  // Browsers tell no observer of the width of paper: the window gets it meanwhile.
  for (const event of ["beforeprint", "afterprint"]) window.addEventListener(event, () => {
    document.body.classList.toggle("printed", event === "beforeprint");
    view.draw();
    showMotion();
  });
  offerFiles(view);
  follow();
}

start();
