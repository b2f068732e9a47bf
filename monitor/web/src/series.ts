// The samples of plotted fields, and what a plot draws of them: per column of pixels the least and the greatest value,
// so that a plot costs the same at 10 and at 1000 messages a second, and no peak is lost.

const kFirstRoom = 1024;
const kBlock = 8; // samples whose least and greatest value are kept, so that long plots do not look at each sample

/** Times and values, oldest dropped first beyond `most`. Times rise; one that does not begins anew. */
export class Samples {
  private times = new Float64Array(kFirstRoom);
  private values = new Float64Array(kFirstRoom);
  private low = new Float64Array(kFirstRoom / kBlock); // by block of the room
  private high = new Float64Array(kFirstRoom / kBlock);
  private start = 0;
  size = 0;
  /** `most`: a power of two times 1024. */
  constructor(readonly most = 1 << 17) {}

  push(time: number, value: number) {
    if (this.size > 0 && time < this.time(this.size - 1)) this.clear(); // a recorded run went back
    const room = this.times.length;
    if (this.size === room && room < this.most) this.grow();
    const at = (this.start + this.size) % this.times.length;
    this.put(at, time, value);
    if (this.size < this.times.length) ++this.size;
    else this.start = (this.start + 1) % this.times.length;
  }

  time(i: number): number {
    return this.times[(this.start + i) % this.times.length]!;
  }

  value(i: number): number {
    return this.values[(this.start + i) % this.times.length]!;
  }

  clear() {
    this.start = this.size = 0;
  }

  /** The first sample at or behind that time. */
  firstFrom(time: number): number {
    let low = 0, high = this.size;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.time(middle) < time) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  /** The newest value at or before that time; NaN: there is none. */
  at(time: number): number {
    const behind = this.firstFrom(time + 1e-9);
    return behind === 0 ? NaN : this.value(behind - 1);
  }

  /** Writes into `out`, two a column, the least and the greatest value of each column of gridOf(), in the order in which
   *  they came as far as it is known; null where there is none. */
  columns(from: number, to: number, columns: number, out: (number | null)[]) {
    out.length = columns * 2;
    out.fill(null);
    const { times, values, low, high, start, size } = this;
    const room = times.length, perSecond = columns / (to - from), last = columns - 1;
    // One sample before and behind, so that a line enters and leaves the plot.
    let i = Math.max(0, this.firstFrom(from) - 1);
    while (i < size) {
      const at = (start + i) % room;
      const time = times[at]!;
      const column = Math.min(last, Math.max(0, Math.floor((time - from) * perSecond)));
      if (at % kBlock === 0 && i + kBlock <= size) {
        const end = times[at + kBlock - 1]!;
        if (end <= to && Math.floor((end - from) * perSecond) === column) {
          const block = at / kBlock;
          if (low[block]! <= high[block]!) widen(out, column, low[block]!), widen(out, column, high[block]!);
          i += kBlock;
          continue;
        }
      }
      const value = values[at]!;
      if (Number.isFinite(value)) widen(out, column, value);
      if (time > to) return;
      ++i;
    }
  }

  private put(at: number, time: number, value: number) {
    this.times[at] = time;
    this.values[at] = value;
    const block = Math.floor(at / kBlock);
    if (at % kBlock === 0) (this.low[block] = Infinity), (this.high[block] = -Infinity);
    if (!Number.isFinite(value)) return;
    if (value < this.low[block]!) this.low[block] = value;
    if (value > this.high[block]!) this.high[block] = value;
  }

  private grow() {
    const size = Math.min(this.times.length * 2, this.most);
    const { times, values, start } = this;
    this.times = new Float64Array(size);
    this.values = new Float64Array(size);
    this.low = new Float64Array(size / kBlock);
    this.high = new Float64Array(size / kBlock);
    for (let i = 0; i < this.size; ++i) this.put(i, times[(start + i) % times.length]!, values[(start + i) % times.length]!);
    this.start = 0;
  }
}

function widen(out: (number | null)[], column: number, value: number) {
  const a = out[column * 2] as number | null;
  if (a === null) {
    out[column * 2] = out[column * 2 + 1] = value;
    return;
  }
  const b = out[column * 2 + 1] as number;
  const low = a < b ? a : b, high = a < b ? b : a;
  // The newer end of the range stands second.
  if (value < low) (out[column * 2] = high), (out[column * 2 + 1] = value);
  else if (value > high) (out[column * 2] = low), (out[column * 2 + 1] = value);
}

/** Times of `columns` columns from `from` to `to`, two each. */
export function gridOf(from: number, to: number, columns: number): Float64Array {
  const grid = new Float64Array(columns * 2);
  const step = (to - from) / (columns * 2);
  for (let i = 0; i < grid.length; ++i) grid[i] = from + (i + 0.5) * step;
  return grid;
}

export interface Named {
  name: string;
  unit: string;
  samples: Samples;
}

/** As CSV: one line for each time that any field has, empty where a field has no sample then. */
export function csvOf(fields: Named[], from: number, to: number): string {
  const times = new Set<number>();
  for (const f of fields)
    for (let i = f.samples.firstFrom(from); i < f.samples.size && f.samples.time(i) <= to; ++i) times.add(f.samples.time(i));
  const quoted = (text: string) => (/[",\n]/.test(text) ? `"${text.replace(/"/g, '""')}"` : text);
  const lines = [["time [s]", ...fields.map((f) => `${f.name}${f.unit ? ` [${f.unit}]` : ""}`)].map(quoted).join(",")];
  for (const time of [...times].sort((a, b) => a - b)) {
    const cells = fields.map(({ samples }) => {
      const i = samples.firstFrom(time);
      return i < samples.size && samples.time(i) === time ? String(samples.value(i)) : "";
    });
    lines.push([time.toFixed(6), ...cells].join(","));
  }
  return `${lines.join("\n")}\n`;
}
