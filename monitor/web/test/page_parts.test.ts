import { describe, expect, it } from "vitest";
import type { Param, Status, Timeline } from "../src/api";
import { bytes, clock, duration, rate, unit, value } from "../src/format";
import { columnsOfModules, drawingOf, type GraphModule } from "../src/graph";
import { marksOf } from "../src/overlay";
import { ratesBetween } from "../src/robot";
import { angles, projector, rotate } from "../src/space";
import { binsOf, lengthsOf } from "../src/timeline";
import { changed, tomlOf } from "../src/toml";

describe("numbers for people", () => {
  it("keep three digits and their unit", () => {
    expect([duration(0), duration(831), duration(9730), duration(47_100), duration(2.11e6), duration(1.5e9), duration(null)]).toEqual(["0 µs", "831 ns", "9.73 µs", "47.1 µs", "2.11 ms", "1.50 s", "–"]);
    expect([duration(999.6e3), duration(99_960)]).toEqual(["1.00 ms", "100 µs"]);
    expect([rate(998.4), rate(29.97), rate(0)]).toEqual(["998 Hz", "30.0 Hz", "0 Hz"]);
    expect([bytes(999), bytes(41_100_000), bytes(1500)]).toEqual(["999 B", "41.1 MB", "1.50 kB"]);
    expect([clock(7.25e9), clock(75e9), clock(7923e9)]).toEqual(["7.25 s", "1:15.0", "2:12:03"]);
  });

  it("show what is no number as it is", () => {
    expect([value(NaN), value(Infinity), value(1e-9), value(12.34567), value(3, true), value(true)]).toEqual(["NaN", "∞", "1.000e-9", "12.346", "3", "true"]);
    expect([unit("m/s^2"), unit("1"), unit("degC"), unit("N m")]).toEqual(["m/s²", "", "°C", "N·m"]);
  });
});

describe("the graph", () => {
  const modules: GraphModule[] = [
    { name: "guardian", thread: "guardian", outputs: ["guardian.state"], inputs: ["mixer.motors"] },
    { name: "imu", thread: "fast", outputs: ["imu.raw"], inputs: [] },
    { name: "filter", thread: "fast", outputs: ["filter.state"], inputs: ["imu.raw", "mixer.motors"] },
    { name: "mixer", thread: "fast", outputs: ["mixer.motors"], inputs: ["filter.state", "guardian.state"] },
    { name: "camera", thread: "slow", outputs: ["camera.raw"], inputs: [] },
  ];

  it("puts readers behind writers and ends at loops", () => {
    const columns = columnsOfModules(modules.slice(1));
    expect([columns.get("imu"), columns.get("mixer")! > columns.get("filter")! || columns.get("filter")! > columns.get("mixer")!]).toEqual([0, true]);
  });

  it("draws each module in the lane of its thread, without overlap, and each connection once", () => {
    const drawing = drawingOf(modules, ["guardian", "fast", "slow"]);
    expect(drawing.places.size).toBe(5);
    for (const place of drawing.places.values()) {
      const lane = drawing.lanes.find((l) => l.thread === place.module.thread)!;
      expect(place.y >= lane.y && place.y + place.height <= lane.y + lane.height).toBe(true);
    }
    const all = [...drawing.places.values()];
    for (const a of all) for (const b of all) if (a !== b) expect(a.x + a.width <= b.x || b.x + b.width <= a.x || a.y + a.height <= b.y || b.y + b.height <= a.y).toBe(true);
    expect(drawing.edges.length).toBe(5);
  });
});

describe("overlays", () => {
  it("follow the rule: a point with what else the detector tells", () => {
    expect(marksOf({ found: 1, u_px: 10, v_px: 20, radius_px: 5, confidence: 0.873 }, "pad.sighting")).toEqual([{ u: 10, v: 20, radius: 5, label: "pad.sighting 87 %" }]);
    expect(marksOf({ found: 0, u_px: 10, v_px: 20 }, "pad")).toEqual([]);
    expect(marksOf({ u_px: NaN, v_px: 20 }, "pad")).toEqual([]);
    expect(marksOf({ count: 2, u_px: [1, 2, 3], v_px: [4, 5, 6], width_px: [7, 8, 9], height_px: [1, 1, 1] }, "faces").map((m) => [m.u, m.v, m.width])).toEqual([[1, 4, 7], [2, 5, 8]]);
  });
});

describe("the time line", () => {
  const timeline: Timeline = {
    threads: ["fast"], modules: ["imu"], columns: [], left_out: 0,
    events: [["release", 0, null, 100, 7, null], ["cycle", 0, null, 107, 50, null], ["step", 0, 0, 110, 30, null], ["step", 0, 0, 1110, 40, null]],
  };
  it("gives lengths of cycles and steps, and lateness, only of what is new", () => {
    expect([...lengthsOf(timeline)]).toEqual([["late:fast", [7]], ["thread:fast", [50]], ["module:imu", [30, 40]]]);
    expect([...lengthsOf(timeline, 500)]).toEqual([["module:imu", [40]]]);
  });
  it("counts every value in bins with round borders", () => {
    const bins = binsOf([1, 2, 3, 50, 99, 100]);
    expect(bins.counts.reduce((a, b) => a + b)).toBe(6);
    expect(bins.borders[0]! <= 1 && bins.borders.at(-1)! >= 100).toBe(true);
    expect(binsOf([5, 5, 5]).total).toBe(3);
    expect(binsOf([]).total).toBe(0);
  });
});

describe("rates", () => {
  it("are those of the robot's clock", () => {
    const status = (now_ns: number, steps: number, busy_ns: number): Status => ({
      now_ns, threads: [], topics: [], chains: [],
      modules: [{ name: "imu", type: "", thread: "", running: true, steps, ok: 0, stale: 0, fault: 0, stops: 0, exec: { count: steps, mean_ns: busy_ns / steps, min_ns: 0, p50_ns: 0, p99_ns: 0, p999_ns: 0, max_ns: 0 } }],
    });
    const rates = ratesBetween(status(0, 100, 1e6), status(5e8, 600, 51e6));
    expect(rates.hz.get("module:imu")).toBe(1000);
    expect(rates.share.get("module:imu")).toBeCloseTo(0.1);
    expect(ratesBetween(status(5, 1, 1), status(5, 2, 1)).hz.size).toBe(0);
  });
});

describe("parameters", () => {
  const p = (over: Partial<Param>): Param => ({ module: "attitude", param: "kp", type: "number", value: 8, default: 1, start: 8, unit: "1", min: 0, max: 20, doc: "", allowed: "", ...over });
  it("differ from what the run began with, not from the default", () => {
    expect([changed(p({})), changed(p({ value: 9 })), changed(p({ start: undefined as never }))]).toEqual([false, true, true]);
  });
  it("are saved as sinew param save does", () => {
    const text = tomlOf([p({ value: 9 }), p({ param: "same" }), p({ param: "on", type: "bool", value: false, start: true }), p({ module: "imu", param: "device", type: "text", value: 'a"b', start: "imu" }), p({ module: "imu", param: "n", type: "integer", value: 3, start: 2 })], "quad");
    expect(text).toBe('# Parameters of robot quad that differ from its robot file: sinew run ROBOT --params THIS\n\n[attitude]\nkp = 9.0\non = false\n\n[imu]\ndevice = "a\\"b"\nn = 3\n');
  });
});

describe("space", () => {
  it("turns by quaternions as REP-103 has it", () => {
    const half = Math.SQRT1_2;
    const yaw90 = { w: half, x: 0, y: 0, z: half };
    const [x, y, z] = rotate(yaw90, [1, 0, 0]);
    expect([x, y, z].map((v) => Math.round(v * 1e9) / 1e9 + 0)).toEqual([0, 1, 0]);
    expect(angles(yaw90).yaw).toBeCloseTo(Math.PI / 2);
    expect(angles({ w: Math.cos(0.1), x: 0, y: Math.sin(0.1), z: 0 }).pitch).toBeCloseTo(0.2);
  });
  it("shows what the camera looks at in the middle, up upwards, and nothing behind it", () => {
    const project = projector({ azimuth: 0.3, elevation: 0.4, distance: 5, target: [1, 2, 3] }, 400, 300);
    expect(project([1, 2, 3])).toMatchObject({ x: 200, y: 150 });
    expect(project([1, 2, 4])!.y).toBeLessThan(150);
    expect(project([1 + 10 * Math.cos(0.3), 2 + 10 * Math.sin(0.3), 7])).toBeNull();
  });
});
