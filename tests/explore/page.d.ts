// What the server answers, and what the modules of the page hand to each other.

type State = Record<string, string>;
type Problem = { field: string; text: string };
type Refusal = { problems: Problem[]; hint?: string };

type Quantity = {
  column: string; label: string; symbol: string; unit: string; meaning: string;
  low: number; high: number; step: number; drives: string[]; swept: boolean; point: boolean;
};
type Choice = { name: string; label: string };
type RegimeStyle = { code: number; label: string; colour: string };
type StatusStyle = { code: number; label: string; message: string; hatch: string; answered: boolean };
type Schema = {
  version: string; initial: State; quantities: Quantity[]; drives: Choice[]; views: Choice[];
  presets: (Choice & { state: State })[]; regimes: RegimeStyle[]; statuses: StatusStyle[];
};

type AxisInfo = {
  column: string; label: string; symbol: string; unit: string; from: number; to: number; log: boolean; count: number;
};
type ScaleInfo = {
  kind: "linear" | "log" | "asinh"; low: number; high: number; width: number; colours: string; ticks: number[];
};
type CurveInfo = { name: string; label: string; dash: number[]; width: number; colour: "ink" | "white"; pieces: number[] };
type MapHeader = {
  view: string; label: string; title: string; x: AxisInfo; y: AxisInfo; scale: ScaleInfo | null; curves: CurveInfo[];
  bands: boolean;
  progress: { done: boolean; share: number; text: string }; notes: string[];
};
type Numbers = Float32Array | Int8Array | Uint8Array;
type Packed<Header> = { header: Header; arrays: Record<string, Numbers> };
type MapAnswer = Packed<MapHeader>;

type PanelCurve = { label: string; colour: string; dash: number[]; width: number; array: string; mirrored: boolean };
type Panel = { name: string; label: string; unit: string; height: number; most: number | null; curves: PanelCurve[] };
type HistoryHeader = {
  title: string; duration_ms: number; note: string; panels: Panel[];
  phases: { kind: string; name: string; colour: string; start: number; end: number }[];
};
type HistoryAnswer = Packed<HistoryHeader>;

type TableInfo = { head: string[]; rows: string[][] };
type PointAnswer = {
  state: State; regime: string; facts: [string, string][]; begins: TableInfo; phases: TableInfo;
  command: string; toml: string; guaranteed: string;
};

type ArrayInfo = { name: string; type: "f4" | "i1" | "u1"; shape: number[]; offset: number };
type Span = { from: number; to: number; log: boolean };
type Box = { left: number; top: number; width: number; height: number };
type Sample = { sample: SVGElement; text: string };
type Cells = {
  first: ArrayLike<number>; second: ArrayLike<number>; over: ArrayLike<number>; nx: number; ny: number;
  edges: Map<number, number[][]>;
};
type Cover = (bits: number, first: number, second: number, x: number, y: number) => number;
type Marks = (box: Box, side: "below" | "left" | "right", values: number[], share: (value: number) => number) => SVGElement;
