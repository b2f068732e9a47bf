// What the time line tells: how long cycles and steps took, and how late they began.

import type { Timeline } from "./api";

/** Lengths in ns by "thread:NAME" (cycles), "module:NAME" (steps), "late:NAME" (release to beginning of the cycle). */
export function lengthsOf(timeline: Timeline, after_ns = -Infinity): Map<string, number[]> {
  const all = new Map<string, number[]>();
  const add = (key: string, value: number) => {
    const list = all.get(key);
    if (list) list.push(value);
    else all.set(key, [value]);
  };
  for (const [kind, thread, module, at, length] of timeline.events) {
    if (at <= after_ns) continue;
    if (kind === "cycle") add(`thread:${timeline.threads[thread]}`, length);
    else if (kind === "step" && module !== null) add(`module:${timeline.modules[module]}`, length);
    else if (kind === "release") add(`late:${timeline.threads[thread]}`, length);
  }
  return all;
}

export interface Bins {
  /** borders, one more than counts */
  borders: number[];
  counts: number[];
  total: number;
}

/** Bins of equal width over the values, about `most` of them, with round borders. */
export function binsOf(values: number[], most = 32): Bins {
  if (values.length === 0) return { borders: [0, 1], counts: [0], total: 0 };
  let low = Infinity, high = -Infinity;
  for (const v of values) {
    if (v < low) low = v;
    if (v > high) high = v;
  }
  if (high === low) high = low + Math.max(1, Math.abs(low) * 0.01);
  const rough = (high - low) / most;
  const ten = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((f) => f * ten).find((s) => s >= rough) ?? rough;
  const first = Math.floor(low / step), end = Math.floor(high / step) + 1;
  const counts = new Array<number>(end - first).fill(0);
  for (const v of values) {
    const at = Math.min(counts.length - 1, Math.floor(v / step) - first);
    counts[at] = counts[at]! + 1;
  }
  return { borders: Array.from({ length: counts.length + 1 }, (_, i) => (first + i) * step), counts, total: values.length };
}

export function newestOf(timeline: Timeline): number {
  let newest = -Infinity;
  for (const e of timeline.events) newest = Math.max(newest, e[3] + e[4]);
  return newest;
}
