import { describe, expect, it } from "vitest";
import { bars, isDense, line } from "../src/trace";

/** Columns of a value that goes `by` up and down in each of them. */
function columns(count: number, by: number): number[] {
  return Array.from({ length: count * 2 }, (_, i) => (i % 2 ? by : 0));
}

describe("a plotted field", () => {
  const place = { left: 10, step: 1, zero: 100, perUnit: -10, top: 0, bottom: 200 };
  const barsOf = (list: (number | null)[], thickness = 2) => {
    const drawn: number[][] = [];
    bars(list, place, thickness, (...bar) => drawn.push(bar));
    return drawn;
  };

  it("is a line through what there is, across what is missing", () => {
    const drawn: [number, number][] = [];
    const path = { moveTo: (x: number, y: number) => drawn.push([x, y]), lineTo: (x: number, y: number) => drawn.push([x, y]) };
    line([1, 2, null, null, 4, 3], place, path);
    expect(drawn).toEqual([[10.5, 90], [11.5, 80], [14.5, 60], [15.5, 70]]);
  });

  it("is a slope and no stairs where it only rises or falls", () => {
    const drawn: number[] = [];
    line([0, 1, 1, 2, 2, 3, 4, 2], place, { moveTo: (_, y) => drawn.push(y), lineTo: (_, y) => drawn.push(y) });
    expect(drawn).toEqual([100, 90, 80, 70, 60, 80]); // and the peak stays
  });

  it("is bars where it goes up and down in each column, and a line where it is smooth or rare", () => {
    expect(isDense(columns(100, 1), -10)).toBe(true);
    expect(isDense(columns(100, 0.1), -10)).toBe(false);
    expect(isDense(columns(100, 0.4), -10, 2)).toBe(false); // the same on a screen with twice the pixels
    expect(isDense(columns(10, 1), -10)).toBe(false);
    const rare = Array.from({ length: 600 }, (_, i) => (i % 6 < 2 ? i % 2 : null));
    expect(isDense(rare, -10)).toBe(false);
    const steep = Array.from({ length: 200 }, (_, i) => i);
    expect(isDense(steep, -10)).toBe(false);
  });

  it("as bars holds every peak, leaves no gap, and is nowhere thinner than a line", () => {
    expect(barsOf([1, 3, 3, 2])).toEqual([[10, 70, 2, 20], [12, 70, 2, 10]]);
    expect(barsOf([1, 1])).toEqual([[10, 89, 2, 2]]);
    expect(barsOf([1, 2, 5, 6])).toEqual([[10, 80, 2, 10], [12, 40, 2, 40]]); // down to the one before
    expect(barsOf([1, 2, null, null, 1, 2])).toEqual([[10, 80, 2, 10], [12, 80, 4, 10]]);
  });

  it("as bars stays inside of the plot", () => {
    expect(barsOf([-100, 100])).toEqual([[10, 0, 2, 200]]);
    expect(barsOf([100, 101])).toEqual([]);
  });
});
