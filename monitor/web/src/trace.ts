// The shape of a plotted field on the screen: a line, or bars from the least to the greatest value of each column where it
// goes up and down in all of them. A line that fills an area costs a browser a hundred times as much as the bars.

/** What it needs of a Path2D; tests give one of their own. */
export interface PathLike {
  moveTo(x: number, y: number): void;
  lineTo(x: number, y: number): void;
}

/** From times and values to the canvas: entry `i` of the columns stands at x = left + (i + 0.5) * step, a value at
 *  y = zero + value * perUnit, between top and bottom. */
export interface Place {
  left: number;
  step: number;
  zero: number;
  perUnit: number;
  top: number;
  bottom: number;
}

const kDense_px = 3; // up and down in each column, on average

/** A steep line goes up or down in each column, too, but not the way back that the next column goes.
 *  `columns`: as Samples.columns() gives them, two entries a column. `pixel`: of the canvas, in its units. */
export function isDense(columns: ArrayLike<number | null>, perUnit: number, pixel = 1): boolean {
  let filled = 0, first = -1, last = -1, way = 0, again = 0, beforeLow = NaN, beforeHigh = NaN;
  for (let i = 0; i < columns.length; i += 2) {
    const a = columns[i] as number | null;
    if (a === null) continue;
    if (first < 0) first = i;
    last = i;
    ++filled;
    const b = columns[i + 1] as number, low = a < b ? a : b, high = a < b ? b : a;
    way += high - low;
    const both = (high < beforeHigh ? high : beforeHigh) - (low > beforeLow ? low : beforeLow);
    if (both > 0) again += both;
    beforeLow = low, beforeHigh = high;
  }
  return filled > 16 && filled * 2 > (last - first) / 2 && again > way / 2 && way * Math.abs(perUnit) > kDense_px * pixel * filled;
}

export function line(columns: ArrayLike<number | null>, { left, step, zero, perUnit }: Place, path: PathLike) {
  let before = NaN;
  for (let i = 0; i < columns.length; i += 2) {
    const a = columns[i] as number | null;
    if (a === null) continue;
    const b = columns[i + 1] as number, x = left + (i + 0.5) * step;
    // On its way to b the line passes a: it would be a step.
    const passes = (before <= a && a <= b) || (before >= a && a >= b);
    if (Number.isNaN(before)) path.moveTo(x, zero + a * perUnit);
    else if (!passes) path.lineTo(x, zero + a * perUnit);
    path.lineTo(x + step, zero + b * perUnit);
    before = b;
  }
}

/** Whole pixels, each at least `thickness` high and touching the one before it. */
export function bars(columns: ArrayLike<number | null>, { left, step, zero, perUnit, top, bottom }: Place, thickness: number, bar: (x: number, y: number, width: number, height: number) => void) {
  let beforeHigh = NaN, beforeLow = NaN, right = NaN; // of the column before
  for (let i = 0; i < columns.length; i += 2) {
    const a = columns[i] as number | null;
    if (a === null) continue;
    const p = zero + a * perUnit, q = zero + (columns[i + 1] as number) * perUnit;
    let high = Math.min(p, q), low = Math.max(p, q); // y grows downwards
    const least = (thickness - (low - high)) / 2;
    if (least > 0) (high -= least), (low += least);
    const from = beforeLow < high ? beforeLow : high, to = beforeHigh > low ? beforeHigh : low;
    beforeHigh = high, beforeLow = low;
    const x = Math.round(left + i * step), end = Math.round(left + (i + 2) * step);
    const begin = right < x ? right : x; // across columns that have nothing
    right = end;
    const y = Math.round(from < top ? top : from), height = Math.round(to > bottom ? bottom : to) - y;
    if (height > 0) bar(begin, y, end - begin, height);
  }
}
