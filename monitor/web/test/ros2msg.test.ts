import { describe, expect, it } from "vitest";
import { decode, getterOf, nameOfValue, numbersOf, parseSchema, valueAt } from "../src/ros2msg";

const kState = `# Attitude and mode.
int64 stamp  # [ns]
sinew_msgs/Quat q_world_base  # [1]
sinew_msgs/Vec3 p_world_m  # [m] world
uint32 mode  # 0 idle, 1 follow, 2 coast; what it does
uint32 faults  # bits: 1 over-current, 2 over-voltage
float32[3] x  # [1]
================================================================================
MSG: sinew_msgs/Quat
# Unit quaternion (Hamilton).
float64 w  # [1]
float64 x  # [1]
float64 y  # [1]
float64 z  # [1]
================================================================================
MSG: sinew_msgs/Vec3
float64 x
float64 y
float64 z
`;

/** Bytes as msg/cdr.hpp writes them, by hand. */
function bytesOfState(): DataView {
  const view = new DataView(new ArrayBuffer(4 + 8 + 32 + 24 + 4 + 4 + 12));
  view.setUint8(1, 1);
  let at = 4;
  view.setBigInt64(at, 1_500_000_000n, true), (at += 8);
  for (const v of [1, 0.5, -0.5, 0.25, 10, 20, 30]) view.setFloat64(at, v, true), (at += 8);
  view.setUint32(at, 1, true), (at += 4);
  view.setUint32(at, 3, true), (at += 4);
  for (const v of [0.5, 1.5, 2.5]) view.setFloat32(at, v, true), (at += 4);
  return view;
}

describe("a schema of ours", () => {
  const struct = parseSchema("sinew_msgs/msg/State", kState);

  it("gives each field its unit, words and names of values", () => {
    expect(struct.doc).toBe("Attitude and mode.");
    const [stamp, , position, mode, faults] = struct.fields;
    expect(stamp).toMatchObject({ name: "stamp", type: "int64", unit: "ns" });
    expect(position).toMatchObject({ unit: "m", doc: "world" });
    expect(mode!.doc).toBe("what it does");
    expect(nameOfValue(mode!, 2)).toBe("coast");
    expect(nameOfValue(mode!, 9)).toBe("");
    expect(nameOfValue(faults!, 3)).toBe("over-current, over-voltage");
  });

  it("decodes what a robot sends", () => {
    const message = decode(struct, bytesOfState());
    expect(message).toMatchObject({ stamp: 1.5e9, q_world_base: { w: 1, z: 0.25 }, p_world_m: { x: 10, y: 20, z: 30 }, mode: 1, faults: 3 });
    expect(message.x).toEqual([0.5, 1.5, 2.5]);
  });

  it("finds every number, with the unit of the field that holds it", () => {
    const leaves = numbersOf(struct);
    expect(leaves.map((l) => l.path)).toContain("p_world_m.y");
    expect(leaves.find((l) => l.path === "p_world_m.y")!.unit).toBe("m");
    expect(leaves.find((l) => l.path === "x[2]")!.integer).toBe(false);
    expect(leaves.find((l) => l.path === "mode")!.integer).toBe(true);
  });

  it("reads one number without the rest, the same as the whole message has", () => {
    const view = bytesOfState();
    const whole = decode(struct, view);
    for (const { path } of numbersOf(struct)) expect([path, getterOf(struct, path)!(view)]).toEqual([path, valueAt(whole, path)]);
  });

  it("has no getter for what is no number", () => {
    for (const path of ["nothing", "p_world_m", "p_world_m.w", "x", "x[3]", "stamp.x", "mode[0]"]) expect([path, getterOf(struct, path)]).toEqual([path, null]);
  });
});

describe("schemas of ROS", () => {
  const kCompressed = `std_msgs/Header header
string format
uint8[] data
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
`;

  function compressed(frame: string, format: string, data: number[]): DataView {
    const bytes: number[] = [];
    const align = (n: number) => { while (bytes.length % n) bytes.push(0); };
    const u32 = (v: number) => { align(4); bytes.push(v & 255, (v >> 8) & 255, (v >> 16) & 255, (v >> 24) & 255); };
    const text = (t: string) => { u32(t.length + 1); bytes.push(...new TextEncoder().encode(t), 0); };
    u32(12), u32(500), text(frame), text(format), u32(data.length), bytes.push(...data);
    return new DataView(Uint8Array.from([0, 1, 0, 0, ...bytes]).buffer);
  }

  it("decode texts, sequences and what stands behind them", () => {
    const struct = parseSchema("sensor_msgs/msg/CompressedImage", kCompressed);
    const message = decode(struct, compressed("camera", "jpeg", [255, 216, 1]));
    expect(message).toMatchObject({ header: { stamp: { sec: 12, nanosec: 500 }, frame_id: "camera" }, format: "jpeg" });
    expect([...(message.data as Uint8Array)]).toEqual([255, 216, 1]);
  });

  it("reads numbers behind a text by decoding", () => {
    const struct = parseSchema("p/msg/A", "string name\nfloat64 x\n");
    const view = new DataView(new ArrayBuffer(4 + 4 + 2 + 2 + 8));
    view.setUint8(1, 1);
    view.setUint32(4, 2, true);
    view.setUint8(8, 65);
    view.setFloat64(12, 7.5, true);
    expect(decode(struct, view)).toEqual({ name: "A", x: 7.5 });
    expect(getterOf(struct, "x")!(view)).toBe(7.5);
  });

  it("know time without its definition, and skip constants", () => {
    const struct = parseSchema("p/msg/A", "uint8 DEBUG=10\nbuiltin_interfaces/Time stamp\nuint8 level\n");
    expect(struct.fields.map((f) => f.name)).toEqual(["stamp", "level"]);
    expect(numbersOf(struct).map((l) => l.path)).toEqual(["stamp.sec", "stamp.nanosec", "level"]);
  });
});

describe("what is damaged", () => {
  it("throws and never reads beyond the message", () => {
    const struct = parseSchema("p/msg/A", "float64[] x\nuint8[] data\n");
    const view = new DataView(new ArrayBuffer(12));
    view.setUint8(1, 1);
    view.setUint32(4, 0xffffffff, true);
    expect(() => decode(struct, view)).toThrow();
    expect(() => decode(struct, new DataView(new ArrayBuffer(2)))).toThrow("header");
    const schema = parseSchema("sinew_msgs/msg/State", kState);
    const whole = bytesOfState();
    for (let length = 4; length < whole.byteLength; length += 3) expect(() => decode(schema, new DataView(whole.buffer, 0, length))).toThrow();
    expect(getterOf(schema, "x[2]")!(new DataView(whole.buffer, 0, 20))).toBeNaN();
  });

  it("names the line of a schema that it cannot read", () => {
    expect(() => parseSchema("p/msg/A", "float64\n")).toThrow("'float64'");
    expect(() => parseSchema("p/msg/A", "other/Thing x\n")).toThrow("no definition of other/Thing");
  });
});
