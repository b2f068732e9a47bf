import { describe, expect, it } from "vitest";
import { csvOf, gridOf, Samples } from "../src/series";

function ramp(count: number, step = 0.001): Samples {
  const samples = new Samples();
  for (let i = 0; i < count; ++i) samples.push(i * step, i);
  return samples;
}

function columnsOf(samples: Samples, from: number, to: number, columns: number): (number | null)[] {
  const out: (number | null)[] = [];
  samples.columns(from, to, columns, out);
  return out;
}

describe("samples", () => {
  it("keep the newest and drop the oldest", () => {
    const samples = new Samples(2048);
    for (let i = 0; i < 5000; ++i) samples.push(i, i * 2);
    expect(samples.size).toBe(2048);
    expect([samples.time(0), samples.value(2047)]).toEqual([5000 - 2048, 9998]);
  });

  it("answer what was true at a time", () => {
    const samples = ramp(100);
    expect(samples.at(0.0505)).toBe(50);
    expect(samples.at(-1)).toBeNaN();
    expect(samples.at(9)).toBe(99);
  });

  it("begin anew where time goes back", () => {
    const samples = ramp(100);
    samples.push(0.01, 7);
    expect([samples.size, samples.value(0)]).toEqual([1, 7]);
  });
});

describe("columns of a plot", () => {
  it("lose no peak, however many samples share a column", () => {
    const samples = new Samples();
    for (let i = 0; i < 100_000; ++i) samples.push(i / 1000, i === 54_321 ? 9 : i === 70_000 ? -9 : Math.sin(i / 50));
    const columns = columnsOf(samples, 0, 100, 200);
    expect(columns.length).toBe(gridOf(0, 100, 200).length);
    expect(Math.max(...columns.map((c) => c ?? 0))).toBe(9);
    expect(Math.min(...columns.map((c) => c ?? 0))).toBe(-9);
  });

  it("are the same whether samples are looked at one by one or in blocks, also after the oldest were dropped", () => {
    const samples = new Samples(8192);
    const kept: [number, number][] = [];
    for (let i = 0; i < 20_000; ++i) {
      const value = i % 997 === 0 ? NaN : Math.sin(i * i);
      samples.push(i / 100, value);
      kept.push([i / 100, value]);
    }
    const newest = kept.slice(-samples.size);
    const [from, to, columns] = [newest[0]![0], newest.at(-1)![0] + 0.005, 23];
    const want = Array.from({ length: columns }, () => [Infinity, -Infinity]);
    for (const [t, v] of newest) {
      if (Number.isNaN(v)) continue;
      const range = want[Math.min(columns - 1, Math.floor(((t - from) * columns) / (to - from)))]!;
      range[0] = Math.min(range[0]!, v);
      range[1] = Math.max(range[1]!, v);
    }
    const got = columnsOf(samples, from, to, columns);
    expect(want.map((_, i) => [got[2 * i]!, got[2 * i + 1]!].sort((a, b) => a - b))).toEqual(want);
  });

  it("are empty where nothing came", () => {
    const samples = new Samples();
    samples.push(1, 5);
    samples.push(9, 6);
    const columns = columnsOf(samples, 0, 10, 10);
    expect(columns.slice(2, 4)).toEqual([5, 5]);
    expect(columns.slice(4, 18).every((c) => c === null)).toBe(true);
  });

  it("leave out what is not finite", () => {
    const samples = new Samples();
    samples.push(1, NaN);
    samples.push(1.1, 2);
    expect(columnsOf(samples, 0, 2, 2).slice(2)).toEqual([2, 2]);
  });
});

describe("CSV", () => {
  it("has a line for each time, with units, and quotes what needs it", () => {
    const a = new Samples(), b = new Samples();
    a.push(1, 10), a.push(2, 20), b.push(2, 0.5), b.push(3, 7);
    const text = csvOf([{ name: "imu gyro.x", unit: "rad/s", samples: a }, { name: 'odd,"name"', unit: "", samples: b }], 0, 2.5);
    expect(text).toBe('time [s],imu gyro.x [rad/s],"odd,""name"""\n1.000000,10,\n2.000000,20,0.5\n');
  });
});
