// What the modules of the page hand to each other, and what its classic script finds.

declare const exports: Record<string, any>; // the solver's doors
declare const importScripts: unknown; // of workers alone

type Problem = { field: string; text: string };
type Tick = [share: number, text: string];
type Box = { left: number; top: number; width: number; height: number };
type Sample = { sample: SVGElement[]; text: string };
