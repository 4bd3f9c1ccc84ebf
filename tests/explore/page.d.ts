// What the modules of the page hand to each other, and what its classic script has for all of them.

declare const exports: Record<string, any>; // the solver's doors
declare const TURN: number;
declare const engineOf: typeof import("../../src/vibro/explore/static/engine.js").engineOf;
declare const driveOf: typeof import("../../src/vibro/explore/static/scenes.js").driveOf;
declare const cellsOf: typeof import("../../src/vibro/explore/static/scenes.js").cellsOf;
declare const reachOf: typeof import("../../src/vibro/explore/static/scenes.js").reachOf;
declare const spelledFriction: typeof import("../../src/vibro/explore/static/scenes.js").spelledFriction;
declare const solveRows: typeof import("../../src/vibro/explore/static/worker.js").solveRows;
declare const solveCells: typeof import("../../src/vibro/explore/static/worker.js").solveCells;
declare function withhold(cells: Record<string, Float64Array>, operating: Record<string, Float64Array>, known: any): void;
declare const importScripts: unknown; // of workers alone
declare const operatingOf: typeof import("../../src/vibro/explore/static/scenes.js").operatingOf;

type Problem = { field: string; text: string };
type Tick = [share: number, text: string];
type Box = { left: number; top: number; width: number; height: number };
type Sample = { sample: SVGElement[]; text: string };
