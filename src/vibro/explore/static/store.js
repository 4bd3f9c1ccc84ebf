/** What changes the state: controls, tabs, and the fragment of the page's address that holds it. */

import { BANDED, filledTexts, idleKeys, initialTexts, stateOf } from "./state.js";
import { cutText, generalText, numberIn, typedText } from "./typed.js";

/** @typedef {import("./state.js").PageData} PageData
 * @typedef {import("./state.js").Texts} Texts
 * @typedef {import("./state.js").Shown} Shown */

const PAUSE = 1000; // [ms] after which a further change by the same control gets an entry of its own
const REWRITE = 300; // [ms] between the addresses of a drag: browsers refuse too many of them
const FEW = 4; // digits of what follows from a hand's move

/** The address of a state: all that it has, so that a link shows the same from another page of the same scene.
 * @param {PageData} data @param {number} scene @param {Texts} texts */
export function addressOf(data, scene, texts) {
  const initial = initialTexts(data, scene);
  const idle = idleKeys(data, scene, texts.drive);
  const kept = Object.entries(texts).filter(([key, text]) => (text || initial[key]) && !idle.includes(key));
  const entries = scene ? [["scene", String(scene + 1)], ...kept] : kept;
  return `#${new URLSearchParams(entries).toString().replaceAll("%3A", ":")}`;
}

/** The scene and the state of an address. @param {PageData} data @param {string} fragment */
export function readAddress(data, fragment) {
  const problems = /** @type {Problem[]} */ ([]);
  const wrong = (/** @type {string} */ text) => void problems.push({ field: "", text });
  const given = /** @type {Map<string, string>} */ (new Map());
  for (const part of fragment.slice(1).split("&")) for (const [key, text] of new URLSearchParams(part)) {
    if (given.has(key)) wrong(`'${cutText(key)}' is given twice (leave one out)`);
    if (part.includes("=")) given.set(key, text);
    else wrong(`'${cutText(key)}' has no value (write ${cutText(key)}=...)`);
  }
  const { scene: number = "1", ...texts } = Object.fromEntries(given);
  const scene = Number(number) - 1;
  if (Object.hasOwn(data.scenes, String(scene))) return { scene, texts, problems };
  wrong(`scene = '${cutText(number)}': must be a whole number from 1 to ${data.scenes.length}`);
  return { scene: 0, texts, problems };
}

/** Bands of a state that had none, a tenth to either side; and those that it has, where kinetic friction comes to
 * follow static friction, or no longer does: then it may be all that it was.
 * @param {Shown} state @param {boolean} follows @returns {Texts} */
export function bandsIf({ values: { static_friction: value, friction_ratio: share }, bands }, follows) {
  const isNew = !Object.keys(bands).length;
  const { kinetic_friction: own, friction_ratio: ratio, ...others } = bands;
  const wanted = /** @type {Record<string, number[]>} */ (
    isNew ? { static_friction: [0.9 * value, 1.1 * value] } : others);
  const { static_friction: ends = ratio && [value, value] } = wanted;
  const shares = ratio ?? (own && value ? own.map((end) => Math.min(end / value, 1)) : null);
  const kinetic = own ?? ends?.map((end, n) => end * (ratio?.[n] ?? share));
  if (follows && shares) wanted.friction_ratio = shares;
  if (!follows && kinetic) wanted.kinetic_friction = kinetic;
  return Object.fromEntries(Object.entries(wanted).map(([name, ends]) =>
    [`${name}_band`, ends.map((end) => generalText(end, FEW)).join(":")]));
}

/** The states of all scenes of the page, of which one is shown. @typedef {ReturnType<typeof createStore>} Store */
export function createStore(/** @type {PageData} */ data) {
  const tabs = data.scenes.map((_, scene) => {
    const { state, problems } = stateOf(data, scene, {});
    return {
      texts: state?.texts ?? initialTexts(data, scene), // as they were typed
      state, // the last one that was valid
      problems, // of the texts
      ratio: NaN, // of kinetic to static friction, as it was last set by hand
      bands: /** @type {Record<string, Texts>} */ ({}), // that kinetic friction had when it did not follow, or did
    };
  });
  let scene = 0;
  let changer = ""; // the control that changed the state last
  let until = 0; // what it does is the same change [ms]
  let written = 0; // [ms] when the address was

  /** Show a state. @param {number} number @param {Texts} texts */
  function settle(number, texts) {
    const tab = tabs[(scene = number)];
    const { state, problems } = stateOf(data, scene, texts);
    Object.assign(tab, { texts: state?.texts ?? texts, problems });
    if (state) tab.state = state;
    if (!(tab.ratio >= 0)) keepRatio();
  }

  function keepRatio() {
    tabs[scene].ratio = Math.min(tabs[scene].state?.values.friction_ratio ?? NaN, 1);
  }

  /** A number among texts, NaN where that is none. @param {Texts} texts @param {string} name */
  function numberOf(texts, name) {
    try {
      return numberIn(data.quantities[name], texts[name]);
    } catch {
      return NaN;
    }
  }

  /** Write the address; browsers refuse that in some frames and after too many. @param {boolean} isNew */
  function write(isNew) {
    const address = addressOf(data, scene, tabs[scene].texts);
    try {
      if (isNew && address !== location.hash) history.pushState(null, "", address);
      else history.replaceState(null, "", address);
    } catch { /* the page works without it */ }
  }

  return {
    tabs,
    get scene() { return scene; },
    get state() { return tabs[scene].state; },
    get texts() { return tabs[scene].texts; },
    get problems() { return tabs[scene].problems; },

    /** A number of the operating point. @param {string} name @returns {number} */
    value: (name) => tabs[scene].state?.values[name] ?? NaN,

    /** Take over an address; of one that cannot be read the problems are returned, and the start is shown.
     * @param {string} fragment @returns {Problem[]} */
    read(fragment) {
      const { scene: number, texts, problems } = readAddress(data, fragment);
      const wrong = [...problems, ...stateOf(data, number, texts).problems];
      [changer, tabs[number].ratio] = ["", NaN];
      settle(number, wrong.length ? initialTexts(data, number) : filledTexts(data, number, texts));
      if (fragment.length > 1 && !wrong.length) write(false); // in canonical spelling: 0.8 for 800um
      return wrong;
    },

    /** Bands where kinetic friction comes to follow static friction, or no longer does: those that it had then, if
     * they can still be. @param {boolean} follows @returns {Texts} */
    bandsIf(follows) {
      const { texts, state, bands } = tabs[scene];
      const follow = follows ? "1" : "0";
      const found = state ? bandsIf(state, follows) : {};
      const again = { ...found, ...bands[follow] };
      return stateOf(data, scene, { ...texts, follow, ...again }).state ? again : found;
    },

    /** Show another scene. @param {number} number */
    open(number) {
      [scene, changer] = [number, ""];
      write(true);
    },

    /** Change some keys, and the address with them.
     * @param {Texts} patch @param {string} control @param {boolean} isFinished */
    change({ friction_ratio: wanted, ...patch }, control, isFinished) {
      const tab = tabs[scene];
      const texts = { ...tab.texts, ...patch };
      const { follow, kinetic_friction_band, friction_ratio_band } = tab.texts;
      if (!BANDED.some((name) => texts[`${name}_band`])) tab.bands = {};
      else if (texts.follow !== follow) tab.bands[follow] = { kinetic_friction_band, friction_ratio_band };
      const most = numberOf(texts, "static_friction");
      const atMost = (/** @type {number} */ kinetic) => typedText(Math.min(Number(kinetic.toPrecision(FEW)), most));
      if (wanted !== undefined) texts.kinetic_friction = atMost(Number(wanted) * most);
      else if ("static_friction" in patch && !("kinetic_friction" in patch) && most >= 0) {
        if (texts.follow === "1" && tab.ratio >= 0) texts.kinetic_friction = atMost(tab.ratio * most);
        else if (numberOf(texts, "kinetic_friction") > most) texts.kinetic_friction = typedText(most);
      }
      const isSet = wanted !== undefined || "kinetic_friction" in patch || tab.texts.follow !== texts.follow;
      settle(scene, texts);
      if (isSet) keepRatio();

      const now = performance.now();
      const goesOn = control === changer && now < until;
      if (goesOn && !isFinished && now < written + REWRITE) return;
      write(!goesOn);
      [written, changer, until] = [now, control, isFinished ? now + PAUSE : Infinity];
    },
  };
}
