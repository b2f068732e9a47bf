import { describe, expect, it } from "vitest";
import { columnsOf, csvOf, gridOf, Samples } from "../src/series";

function ramp(count: number, step = 0.001): Samples {
  const samples = new Samples();
  for (let i = 0; i < count; ++i) samples.push(i * step, i);
  return samples;
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
