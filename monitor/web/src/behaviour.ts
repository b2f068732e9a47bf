// What a robot's behaviour is and does (docs/behaviour.md), out of the messages BehaviourPlan and BehaviourState; what it did
// in the last seconds; and where the states of an option stand in its drawing. No name is known here: all come from the robot.

import type { Message, Value } from "./ros2msg";

const kNone = 0xffffffff; // msg::kNoPlace

export interface PlanOption {
  name: string;
  parameters: string[];
  states: number[]; // places in Plan.states; it begins in the first
  decisions: number[]; // places in Plan.decisions, in the order in which they are asked
}

export interface PlanState {
  name: string;
  option: number;
  calls: number | null; // the option that runs below it
  final: boolean;
}

export interface PlanDecision {
  name: string;
  option: number;
  from: number | null; // null: every state of the option but `to`
  to: number;
}

export interface Plan {
  force: string; // parameter of the module that holds a state: the state's place plus 1; empty: none can be held
  options: PlanOption[];
  states: PlanState[];
  decisions: PlanDecision[];
}

/** A value that a decision read. */
export interface Read {
  name: string;
  value: number;
  decision: number;
}

/** An option that is active. */
export interface Active {
  option: string;
  state: string;
  decision: string; // that led into the state; empty: the option began there, or is held
  by: number | null; // its place in the plan
  entered_ns: number;
  state_entered_ns: number;
  parameters: number[];
  reads: Read[]; // in this step
  forced: boolean;
  done: boolean;
}

export interface Moment {
  stamp_ns: number;
  active: Active[]; // the root first
  dropped: number; // values read that the message had no room for
}

function text(bytes: Value | undefined): string {
  if (!(bytes instanceof Uint8Array)) return "";
  const end = bytes.indexOf(0);
  return new TextDecoder().decode(end < 0 ? bytes : bytes.subarray(0, end));
}

const placeOrNull = (place: Value | undefined) => (typeof place === "number" && place !== kNone ? place : null);
const list = (message: Message, field: string, used: string) => (message[field] as Message[]).slice(0, message[used] as number);

export function planOf(message: Message): Plan {
  const plan: Plan = {
    force: text(message.force),
    options: list(message, "option", "options").map((o) => ({ name: text(o.name), parameters: (o.parameter as Message[]).map((p) => text(p.name)).filter(Boolean), states: [], decisions: [] })),
    states: list(message, "state", "states").map((s) => ({ name: text(s.name), option: s.option as number, calls: placeOrNull(s.calls), final: s.is_final === 1 })),
    decisions: list(message, "decision", "decisions").map((d) => ({ name: text(d.name), option: d.option as number, from: placeOrNull(d.from), to: d.to as number })),
  };
  plan.states.forEach((s, place) => plan.options[s.option]?.states.push(place));
  plan.decisions.forEach((d, place) => plan.options[d.option]?.decisions.push(place));
  return plan;
}

export function momentOf(message: Message): Moment {
  const reads = list(message, "read", "reads");
  const bit = (field: string, depth: number) => (((message[field] as number) >>> depth) & 1) === 1;
  return {
    stamp_ns: message.stamp as number,
    dropped: message.reads_dropped as number,
    active: list(message, "active", "depth").map((a, depth) => ({
      option: text(a.option), state: text(a.state), decision: text(a.decision), by: placeOrNull(a.decision_place),
      entered_ns: a.entered as number, state_entered_ns: a.state_entered as number, parameters: a.parameter as number[],
      reads: reads.filter((r) => r.depth === depth).map((r) => ({ name: text(r.name), value: r.value as number, decision: r.decision as number })),
      forced: bit("forced", depth), done: bit("done", depth),
    })),
  };
}

/** "option/state" of the number that a parameter has; null: it holds nothing. */
export function heldBy(plan: Plan, number: unknown): { option: string; state: string } | null {
  const state = typeof number === "number" ? plan.states[number - 1] : undefined;
  return state ? { option: plan.options[state.option]!.name, state: state.name } : null;
}

/** The plan of a state: the one whose root is active; a robot may have several behaviours. */
export function planFor(plans: Iterable<Plan>, moment: Moment): Plan | null {
  const root = moment.active[0]?.option;
  for (const plan of plans) if (plan.options[0]?.name === root) return plan;
  return null;
}

// ---- the last seconds

export interface Span {
  option: string;
  state: string;
  entered_ns: number; // of the option
  begin_ns: number;
  end_ns: number;
  decision: string;
  by: number | null;
  /** The state that the decision left; empty: the option began here, or nobody looked. */
  left: string;
  /** What the decision read, where the page saw that step. */
  reads: Read[];
  forced: boolean;
}

const kKept_ns = 150e9;

export class History {
  /** By depth, the root first; in each row from old to new. */
  rows: Span[][] = [];
  newest: Moment | null = null;

  take(moment: Moment) {
    const now = moment.stamp_ns;
    if (this.newest && now < this.newest.stamp_ns) this.backTo(now);
    this.newest = moment;
    moment.active.forEach((a, depth) => {
      const row = (this.rows[depth] ??= []);
      const last = row.at(-1);
      if (last && last.option === a.option && last.state === a.state && last.begin_ns === a.state_entered_ns) {
        last.end_ns = now;
        last.forced ||= a.forced;
        return;
      }
      const goesOn = last && last.option === a.option && last.entered_ns === a.entered_ns;
      if (last && last.end_ns > a.state_entered_ns) last.end_ns = a.state_entered_ns;
      if (goesOn) last.end_ns = a.state_entered_ns;
      row.push({
        option: a.option, state: a.state, entered_ns: a.entered_ns, begin_ns: a.state_entered_ns, end_ns: now, decision: a.decision, by: a.by,
        left: goesOn && a.decision ? last.state : "", reads: a.state_entered_ns === now && a.by !== null ? a.reads.filter((r) => r.decision === a.by) : [], forced: a.forced,
      });
    });
    for (const row of this.rows) while (row.length && row[0]!.end_ns < now - kKept_ns) row.shift();
  }

  /** A recorded run was put back: what comes later is not known any more. */
  private backTo(now: number) {
    this.rows = this.rows.map((row) => row.filter((s) => s.begin_ns <= now).map((s) => ({ ...s, end_ns: Math.min(s.end_ns, now) })));
  }

  /** How the option at this depth came into its state. */
  last(depth: number): Span | null {
    return this.rows[depth]?.at(-1) ?? null;
  }
}

// ---- the drawing of an option

export const kNodeHeight = 28;
const kGapX = 34, kGapY = 46, kLetter = 6.7, kSmallLetter = 6.3;

export interface StateNode {
  place: number;
  x: number; // of the left edge
  y: number;
  width: number;
}

/** All decisions that lead from one state to another. `from` null: from every other state. */
export interface Arrow {
  from: number | null;
  to: number;
  decisions: number[];
  label: string;
  path: string;
  /** Others pass near it: its label would stand over theirs, were all shown. */
  crowded: boolean;
  at: { x: number; y: number; anchor: "start" | "end" | "middle" };
}

export interface StateDrawing {
  nodes: StateNode[];
  arrows: Arrow[];
  left: number; // the x of its left edge
  width: number;
  height: number;
}

/** How many decisions it takes from the first state of the option. */
export function ranksOf(plan: Plan, option: PlanOption): Map<number, number> {
  const ranks = new Map<number, number>();
  const own = option.decisions.map((d) => plan.decisions[d]!);
  // What decisions of every state lead to stands beside the first state, where nothing else leads to it.
  const begin = (place: number) => {
    if (ranks.has(place)) return;
    ranks.set(place, 0);
    const open = [place];
    for (let at = open.shift(); at !== undefined; at = open.shift())
      for (const d of own)
        if (d.from === at && !ranks.has(d.to)) {
          ranks.set(d.to, ranks.get(at)! + 1);
          open.push(d.to);
        }
  };
  if (option.states.length) begin(option.states[0]!);
  for (const d of own) if (d.from === null) begin(d.to);
  for (const s of option.states) begin(s);
  return ranks;
}

export function stateDrawingOf(plan: Plan, option: PlanOption): StateDrawing {
  const ranks = ranksOf(plan, option);
  const lines: number[][] = [];
  for (const place of option.states) (lines[ranks.get(place)!] ??= []).push(place);
  const widthOf = (place: number) => Math.max(64, Math.round(plan.states[place]!.name.length * kLetter + 26 + (plan.states[place]!.calls === null ? 0 : 12)));

  const bundles = new Map<string, { from: number | null; to: number; decisions: number[] }>();
  for (const d of option.decisions) {
    const { from, to } = plan.decisions[d]!;
    if (from === to) continue;
    const bundle = bundles.get(`${from}>${to}`) ?? { from, to, decisions: [] };
    bundle.decisions.push(d);
    bundles.set(`${from}>${to}`, bundle);
  }
  const labelOf = (b: { decisions: number[] }) => [...new Set(b.decisions.map((d) => plan.decisions[d]!.name))].join(", ");

  // Arrows that pass a line of states go round all of them, each in a lane of its own: back on the left, forward on the right.
  const lane = new Map<string, number>();
  const lanes = { left: 0, right: 0 };
  for (const [key, b] of bundles) {
    if (b.from === null) continue;
    const step = ranks.get(b.to)! - ranks.get(b.from)!;
    if (Math.abs(step) > 1) lane.set(key, lanes[step < 0 ? "left" : "right"]++);
  }
  const lineWidth = (line: number[]) => line.reduce((sum, p) => sum + widthOf(p), 0) + kGapX * (line.length - 1);
  const inner = Math.max(...lines.map(lineWidth));

  const top = option.decisions.some((d) => plan.decisions[d]!.from === null) ? 30 : 6;
  const nodes: StateNode[] = [];
  const at = new Map<number, StateNode>();
  lines.forEach((line, rank) => {
    let x = (inner - lineWidth(line)) / 2;
    for (const place of line) {
      const node = { place, x, y: top + rank * (kNodeHeight + kGapY), width: widthOf(place) };
      nodes.push(node);
      at.set(place, node);
      x += node.width + kGapX;
    }
  });

  const crowdedAt = (place: number) => lines[ranks.get(place)!]!.length > 1;
  const arrows = [...bundles].map(([key, bundle]): Arrow => {
    const b = { ...bundle, crowded: bundle.from !== null && (crowdedAt(bundle.from) || crowdedAt(bundle.to)) };
    const label = labelOf(b);
    const to = at.get(b.to)!, toX = to.x + to.width / 2;
    if (b.from === null) {
      const x = toX + Math.min(22, to.width / 2 - 8);
      return { ...b, label: `any: ${label}`, path: `M${x} ${to.y - 18}L${x} ${to.y}`, at: { x: x + 6, y: to.y - 12, anchor: "start" } };
    }
    const from = at.get(b.from)!, fromX = from.x + from.width / 2;
    const step = ranks.get(b.to)! - ranks.get(b.from)!;
    const middle = kNodeHeight / 2;
    if (step === 1 || step === -1) {
      const down = step === 1;
      const shift = down ? 7 : -7;
      const y1 = down ? from.y + kNodeHeight : from.y, y2 = down ? to.y : to.y + kNodeHeight, bend = down ? 20 : -20;
      const x1 = fromX + shift, x2 = toX + shift;
      const t = down ? 0.58 : 0.42; // near the state of the lower line: there arrows stand apart
      const s = t * t * (3 - 2 * t);
      return { ...b, label, path: `M${x1} ${y1}C${x1} ${y1 + bend} ${x2} ${y2 - bend} ${x2} ${y2}`, at: { x: x1 + (x2 - x1) * s + (down ? 5 : -5), y: y1 + (y2 - y1) * t + 4, anchor: down ? "start" : "end" } };
    }
    if (step === 0) {
      const forward = to.x > from.x;
      const lift = forward ? -6 : 6;
      const x1 = forward ? from.x + from.width : from.x, x2 = forward ? to.x : to.x + to.width;
      const y = from.y + middle + lift, near = Math.abs(x2 - x1) < kGapX + 1;
      const under = near ? 0 : forward ? -34 : 34;
      return { ...b, label, path: near ? `M${x1} ${y}L${x2} ${y}` : `M${fromX} ${from.y + (forward ? 0 : kNodeHeight)}C${fromX} ${y + under} ${toX} ${y + under} ${toX} ${to.y + (forward ? 0 : kNodeHeight)}`, at: { x: (x1 + x2) / 2, y: y + (forward ? -8 : 14) + 0.7 * under, anchor: "middle" } };
    }
    const onLeft = step < 0;
    const out = onLeft ? -(26 + 16 * lane.get(key)!) : 26 + 16 * lane.get(key)!;
    const edge = onLeft ? 0 : inner;
    const x1 = onLeft ? from.x : from.x + from.width, x2 = onLeft ? to.x : to.x + to.width;
    const y1 = from.y + middle, y2 = to.y + middle, x = edge + out;
    const turn = y2 > y1 ? 12 : -12;
    return { ...b, label, path: `M${x1} ${y1}L${x - Math.sign(out) * 10} ${y1}Q${x} ${y1} ${x} ${y1 + turn}L${x} ${y2 - turn}Q${x} ${y2} ${x - Math.sign(out) * 10} ${y2}L${x2} ${y2}`, at: { x: x + (onLeft ? -4 : 4), y: (y1 + y2) / 2 + 4 + (lane.get(key)! % 2 ? 14 : -8), anchor: onLeft ? "end" : "start" } };
  });
  let left = -4, right = inner + 4;
  const lowest = Math.max(0, ...arrows.map((a) => a.at.y + 8));
  for (const { label, at } of arrows) {
    const long = label.length * kSmallLetter, before = at.anchor === "start" ? 0 : at.anchor === "end" ? long : long / 2;
    left = Math.min(left, at.x - before - 4);
    right = Math.max(right, at.x - before + long + 4);
  }
  return { nodes, arrows, left, width: right - left, height: Math.max(lowest, top + lines.length * (kNodeHeight + kGapY) - kGapY + 6) };
}

/** Three digits, no zeros behind: "0.34", "1", "12.3". */
export function brief(x: number): string {
  if (!Number.isFinite(x)) return Number.isNaN(x) ? "NaN" : x > 0 ? "∞" : "−∞";
  const size = Math.abs(x);
  if (size !== 0 && (size < 1e-3 || size >= 1e6)) return x.toExponential(1);
  return String(Number(size >= 1000 ? x.toFixed(0) : size < 0.1 ? x.toFixed(3) : x.toPrecision(3)));
}
