import { describe, expect, it } from "vitest";
import { brief, heldBy, History, kNodeHeight, momentOf, planFor, planOf, ranksOf, stateDrawingOf, type Plan } from "../src/behaviour";
import type { Message } from "../src/ros2msg";

const kNone = 0xffffffff;
const name = (text: string) => {
  const bytes = new Uint8Array(24);
  bytes.set(new TextEncoder().encode(text));
  return bytes;
};
/** As the robot sends it: arrays of a fixed length, of which so many are in use. */
const filled = (used: Message[], empty: Message, length: number) => [...used, ...Array.from({ length: length - used.length }, () => empty)];

function message(states: [name: string, option: number, calls?: number][], decisions: [name: string, option: number, from: number | null, to: number][], options = ["play", "go_to"]): Message {
  return {
    stamp: 1, options: options.length, states: states.length, decisions: decisions.length, reserved: 0, force: name("force"),
    option: filled(options.map((o, i) => ({ name: name(o), parameter: filled(i === 1 ? [{ name: name("near_m") }] : [], { name: name("") }, 4) })), { name: name(""), parameter: [] }, 16),
    state: filled(states.map(([n, option, calls]) => ({ name: name(n), option, calls: calls ?? kNone, is_final: n === "there" ? 1 : 0, reserved: 0 })), { name: name(""), option: 0, calls: kNone, is_final: 0 }, 64),
    decision: filled(decisions.map(([n, option, from, to]) => ({ name: name(n), option, from: from ?? kNone, to, reserved: 0 })), { name: name(""), option: 0, from: kNone, to: 0 }, 128),
  };
}
// search -> approach (runs go_to) -> kick -> search; a lost ball leads back to search from everywhere.
const example = () => planOf(message([["search", 0], ["approach", 0, 1], ["kick", 0], ["walk", 1], ["there", 1]], [["lost", 0, null, 0], ["found", 0, 0, 1], ["arrived", 0, 1, 2], ["kicked", 0, 2, 0], ["near", 1, 3, 4]]));

type Now = [option: string, state: string, entered: number, state_entered: number, by?: number];
const moment = (stamp: number, active: Now[], reads: [depth: number, decision: number, name: string, value: number][] = [], forced = 0) => momentOf({
  stamp, depth: active.length, reads: reads.length, reads_dropped: 0, forced, changes: 0, done: 0,
  active: filled(active.map(([option, state, entered, state_entered, by]) => ({ entered, state_entered, parameter: [0.2, 0, 0, 0], option: name(option), state: name(state), decision: name(by === undefined ? "" : `d${by}`), decision_place: by ?? kNone, reserved: 0 })), {}, 8),
  read: filled(reads.map(([depth, decision, n, value]) => ({ value, depth, decision, name: name(n) })), {}, 24),
});

describe("the plan of a behaviour", () => {
  it("is what the robot sends, without what is not in use", () => {
    const plan = example();
    expect(plan.force).toBe("force");
    expect(plan.options).toEqual([{ name: "play", parameters: [], states: [0, 1, 2], decisions: [0, 1, 2, 3] }, { name: "go_to", parameters: ["near_m"], states: [3, 4], decisions: [4] }]);
    expect(plan.states[1]).toEqual({ name: "approach", option: 0, calls: 1, final: false });
    expect(plan.states[4]!.final).toBe(true);
    expect(plan.decisions[0]).toEqual({ name: "lost", option: 0, from: null, to: 0 });
  });
  it("numbers its states from 1, and 0 holds none", () => {
    const plan = example();
    expect([heldBy(plan, 3), heldBy(plan, 5), heldBy(plan, 0), heldBy(plan, 6), heldBy(plan, undefined)]).toEqual([{ option: "play", state: "kick" }, { option: "go_to", state: "there" }, null, null, null]);
  });
  it("is found by the root that is active", () => {
    const head = planOf(message([["rest", 0]], [], ["head"]));
    expect(planFor([head, example()], moment(5, [["play", "search", 0, 0]]))!.options[0]!.name).toBe("play");
    expect(planFor([head], moment(5, [["play", "search", 0, 0]]))).toBe(null);
  });
});

describe("the last seconds of a behaviour", () => {
  it("are spans from the instant of the change, with the decision, the state that it left and what it read", () => {
    const h = new History();
    h.take(moment(10, [["play", "search", 2, 2]], [[0, 0, "seen", 1], [0, 1, "ball_m", 3]]));
    h.take(moment(20, [["play", "approach", 2, 20, 1], ["go_to", "walk", 20, 20]], [[0, 0, "seen", 1], [0, 1, "ball_m", 0.5], [1, 4, "ball_m", 0.5]]));
    h.take(moment(30, [["play", "approach", 2, 20, 1], ["go_to", "walk", 20, 20]], [[1, 4, "ball_m", 0.4]]));
    expect(h.rows[0]!.map((s) => [s.state, s.begin_ns, s.end_ns, s.left])).toEqual([["search", 2, 20, ""], ["approach", 20, 30, "search"]]);
    expect(h.last(0)!.reads).toEqual([{ name: "ball_m", value: 0.5, decision: 1 }]);
    expect(h.rows[1]!.map((s) => [s.state, s.begin_ns, s.end_ns])).toEqual([["walk", 20, 30]]);
  });
  it("do not say what was left or read where the page missed the step", () => {
    const h = new History();
    h.take(moment(30, [["play", "kick", 2, 25, 2]], [[0, 3, "in_state_s", 0.1]]));
    expect(h.last(0)).toMatchObject({ decision: "d2", by: 2, left: "", reads: [], begin_ns: 25 });
  });
  it("tell two runs of the same state apart", () => {
    const h = new History();
    h.take(moment(10, [["play", "search", 2, 2]]));
    h.take(moment(20, [["play", "search", 2, 20, 3]]));
    expect(h.rows[0]!.map((s) => [s.begin_ns, s.end_ns])).toEqual([[2, 20], [20, 20]]);
  });
  it("forget what comes later when a recorded run is put back, and what is long ago", () => {
    const h = new History();
    h.take(moment(10e9, [["play", "search", 0, 0]]));
    h.take(moment(20e9, [["play", "kick", 0, 20e9, 1]]));
    h.take(moment(15e9, [["play", "search", 0, 0]]));
    expect(h.rows[0]!.map((s) => [s.state, s.end_ns])).toEqual([["search", 15e9]]);
    h.take(moment(20e9, [["play", "kick", 0, 20e9, 1]]));
    h.take(moment(400e9, [["play", "kick", 0, 20e9, 1]]));
    expect(h.rows[0]!.map((s) => s.state)).toEqual(["kick"]);
  });
  it("say what was held", () => {
    const h = new History();
    h.take(moment(10, [["play", "search", 0, 0]]));
    h.take(moment(20, [["play", "kick", 0, 20]], [], 1));
    expect(h.rows[0]!.map((s) => s.forced)).toEqual([false, true]);
    expect(h.newest!.active[0]!.forced).toBe(true);
  });
});

describe("the drawing of an option", () => {
  const long = (): Plan => planOf(message(
    [["search", 0], ["approach", 0], ["align", 0], ["kick", 0], ["follow", 0], ["halt", 0], ["walk", 1]],
    [["fell", 0, null, 5], ["sees_ball", 0, 0, 1], ["lost_ball", 0, 1, 0], ["behind_ball", 0, 1, 2], ["lost_ball", 0, 2, 0], ["at_place", 0, 2, 3], ["moved", 0, 2, 1], ["done", 0, 3, 4], ["too_long", 0, 3, 4], ["calm", 0, 4, 0], ["up", 0, 5, 0]]));
  it("stands in lines by the number of decisions from the first state; what every state leads to stands beside it", () => {
    const plan = long();
    expect([...ranksOf(plan, plan.options[0]!)].sort((a, b) => a[0] - b[0])).toEqual([[0, 0], [1, 1], [2, 2], [3, 3], [4, 4], [5, 0]]);
  });
  it("has each state once, none over another, and one arrow for all decisions of a pair", () => {
    const plan = long();
    const d = stateDrawingOf(plan, plan.options[0]!);
    expect(d.nodes.map((n) => n.place).sort()).toEqual([0, 1, 2, 3, 4, 5]);
    for (const a of d.nodes) for (const b of d.nodes) if (a !== b) expect(a.x + a.width <= b.x || b.x + b.width <= a.x || a.y + kNodeHeight <= b.y || b.y + kNodeHeight <= a.y).toBe(true);
    expect(d.arrows.length).toBe(10);
    expect(d.arrows.find((a) => a.from === 3)!.label).toBe("done, too_long");
    expect(d.arrows.find((a) => a.from === null)!.label).toBe("any: fell");
  });
  it("has room for all of it", () => {
    const plan = long();
    for (const option of plan.options) {
      const d = stateDrawingOf(plan, option);
      for (const n of d.nodes) expect(n.x >= d.left && n.x + n.width <= d.left + d.width && n.y + kNodeHeight <= d.height).toBe(true);
      for (const a of d.arrows) {
        const long = a.label.length * 6.3, end = d.left + d.width;
        const from = a.at.x - (a.at.anchor === "start" ? 0 : a.at.anchor === "end" ? long : long / 2);
        expect([a.label, from >= d.left - 1e-9, from + long <= end + 1e-9]).toEqual([a.label, true, true]);
        const xs = [...a.path.matchAll(/(-?[0-9.]+) (-?[0-9.]+)/g)].map((m) => Number(m[1]));
        expect([a.label, Math.min(...xs) >= d.left, Math.max(...xs) <= end]).toEqual([a.label, true, true]);
      }
    }
  });
  it("writes values short", () => {
    expect([brief(0.34567), brief(1), brief(12.34), brief(12345.6), brief(0.0042), brief(0), brief(1e-7), brief(Infinity), brief(NaN)]).toEqual(["0.346", "1", "12.3", "12346", "0.004", "0", "1.0e-7", "∞", "NaN"]);
  });
});
