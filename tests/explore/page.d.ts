// What the modules of the page hand to each other, and what its classic script has for all of them.

declare const exports: Record<string, any>; // the solver's doors
declare const engineOf: typeof import("../../src/vibro/explore/static/engine.js").engineOf;
declare const driveOf: typeof import("../../src/vibro/explore/static/scenes.js").driveOf;
declare const operatingOf: typeof import("../../src/vibro/explore/static/scenes.js").operatingOf;

type Problem = { field: string; text: string };
type Tick = [share: number, text: string];
type AxisInfo = {
  column: string; label: string; title: string; unit: string; from: number; to: number; log: boolean; count: number;
  ticks: Tick[];
};
type ScaleInfo = { colours: [first: number, count: number]; ticks: Tick[] };
type Stripe = { right: number; down: number; period: number; from: number; to: number };
type Hatch = { marks: number; face: number | null; stripes: Stripe[] }; // no face: the other colour of the cell
type CurveInfo = { name: string; label: string; dash: number[]; width: number; colour: string; halo: string; count: number };
type MapHeader = {
  view: string; label: string; title: string; caption: string; x: AxisInfo; y: AxisInfo; palette: string; hatches: Hatch[]; scale: ScaleInfo | null;
  legend: { text: string; faces: number[]; marks: number }[]; curves: CurveInfo[]; bands: boolean;
  progress: { done: boolean; share: number; text: string }; notes: string[];
};
type Numbers = Float32Array | Int8Array | Uint8Array | Uint16Array;
type Packed<Header> = { header: Header; arrays: Record<string, Numbers> };
type MapAnswer = Packed<MapHeader>;

type PanelCurve = { label: string; colour: string; dash: number[]; width: number; array: string };
type Panel = { title: string; height: number; low: number; high: number; ticks: Tick[]; curves: PanelCurve[] };
type HistoryHeader = {
  title: string; duration_ms: number; ticks: Tick[]; note: string; panels: Panel[];
  phases: { name: string; colour: string; start: number; end: number }[];
};
type HistoryAnswer = Packed<HistoryHeader>;

type ArrayInfo = { name: string; type: "f4" | "i1" | "u1" | "u2"; shape: number[]; offset: number };
type Box = { left: number; top: number; width: number; height: number };
type Sample = { sample: SVGElement[]; text: string };
type Cells = {
  palette: Uint32Array; hatches: Hatch[]; pale: number; faces: ArrayLike<number>; others: ArrayLike<number>; marks: ArrayLike<number>;
  nx: number; ny: number;
  pieces: number[][][]; // of curves, [ax, ay, bx, by] in cells, by the square that they cross
};
