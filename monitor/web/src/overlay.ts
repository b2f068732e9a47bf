// What is drawn over pictures, by one rule that a new detector can follow (docs/monitor.md, "Overlays"): a topic is
// drawn whose messages have the fields u_px and v_px, numbers or arrays of one length. Beside them, all optional:
//   found (0: nothing is drawn), count (of arrays: so many are meant), radius_px (a circle), width_px and height_px (a
//   rectangle about the point), confidence (0 to 1, written beside it).

import type { Message, Struct, Value } from "./ros2msg";

export interface Mark {
  u: number;
  v: number;
  radius?: number;
  width?: number;
  height?: number;
  label: string;
}

export function followsRule(struct: Struct): boolean {
  const has = (name: string) => struct.fields.some((f) => f.name === name && typeof f.type === "string" && f.type !== "string");
  return has("u_px") && has("v_px");
}

function numbers(value: Value | undefined): number[] {
  if (typeof value === "number") return [value];
  if (Array.isArray(value)) return value.map(Number);
  return [];
}

export function marksOf(message: Message, name: string): Mark[] {
  if (message.found === 0) return [];
  const u = numbers(message.u_px), v = numbers(message.v_px);
  const [radius, width, height, confidence] = [message.radius_px, message.width_px, message.height_px, message.confidence].map(numbers);
  const count = Array.isArray(message.u_px) && typeof message.count === "number" ? message.count : u.length;
  const marks: Mark[] = [];
  for (let i = 0; i < Math.min(count, u.length, v.length); ++i) {
    if (!Number.isFinite(u[i]) || !Number.isFinite(v[i])) continue;
    const sure = confidence![i];
    const mark: Mark = { u: u[i]!, v: v[i]!, label: sure === undefined ? name : `${name} ${Math.round(sure * 100)} %` };
    if (Number.isFinite(radius![i]) && radius![i]! > 0) mark.radius = radius![i]!;
    if (Number.isFinite(width![i]) && Number.isFinite(height![i])) (mark.width = width![i]!), (mark.height = height![i]!);
    marks.push(mark);
  }
  return marks;
}
