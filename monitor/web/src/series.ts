// The samples of plotted fields, and what a plot draws of them: per column of pixels the least and the greatest value,
// so that a plot costs the same at 10 and at 1000 messages a second, and no peak is lost.

const kFirstRoom = 1024;

/** Times and values, oldest dropped first beyond `most`. Times rise; one that does not begins anew. */
export class Samples {
  private times = new Float64Array(kFirstRoom);
  private values = new Float64Array(kFirstRoom);
  private start = 0;
  size = 0;
  constructor(readonly most = 1 << 17) {}

  push(time: number, value: number) {
    if (this.size > 0 && time < this.time(this.size - 1)) this.clear(); // a recorded run went back
    const room = this.times.length;
    if (this.size === room && room < this.most) this.grow();
    const at = (this.start + this.size) % this.times.length;
    this.times[at] = time;
    this.values[at] = value;
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

  private grow() {
    const size = Math.min(this.times.length * 2, this.most);
    const times = new Float64Array(size), values = new Float64Array(size);
    for (let i = 0; i < this.size; ++i) {
      times[i] = this.time(i);
      values[i] = this.value(i);
    }
    this.times = times;
    this.values = values;
    this.start = 0;
  }
}

/** Times of `columns` columns from `from` to `to`, two each. */
export function gridOf(from: number, to: number, columns: number): Float64Array {
  const grid = new Float64Array(columns * 2);
  const step = (to - from) / (columns * 2);
  for (let i = 0; i < grid.length; ++i) grid[i] = from + (i + 0.5) * step;
  return grid;
}

/** Values for gridOf(): in each column that has samples the least and the greatest in their order, else null. */
export function columnsOf(samples: Samples, from: number, to: number, columns: number): (number | null)[] {
  const out = new Array<number | null>(columns * 2).fill(null);
  const width = (to - from) / columns;
  // One sample before and behind, so that a line enters and leaves the plot.
  let i = Math.max(0, samples.firstFrom(from) - 1);
  for (; i < samples.size; ++i) {
    const time = samples.time(i);
    const value = samples.value(i);
    if (!Number.isFinite(value)) continue;
    const column = Math.min(columns - 1, Math.max(0, Math.floor((time - from) / width)));
    const a = out[column * 2] as number | null, b = out[column * 2 + 1] as number | null;
    if (a === null) out[column * 2] = out[column * 2 + 1] = value;
    else {
      // Of the two kept values the order in time stays: the newer end of the range stands second.
      const low = Math.min(a, b!), high = Math.max(a, b!);
      if (value < low) [out[column * 2], out[column * 2 + 1]] = [high, value];
      else if (value > high) [out[column * 2], out[column * 2 + 1]] = [low, value];
    }
    if (time > to) break;
  }
  return out;
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
