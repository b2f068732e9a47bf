// Where modules stand in the drawing of a robot's graph: a lane for each thread, and in it from left to right in the
// order in which data flows.

export interface GraphModule {
  name: string;
  thread: string;
  outputs: string[]; // topics
  inputs: string[];
  /** What it publishes is about what others did already: it stands last, as the guardian. */
  last?: boolean;
}

export interface Place {
  module: GraphModule;
  x: number;
  y: number;
  width: number;
  height: number;
}

export interface Drawing {
  width: number;
  height: number;
  lanes: { thread: string; y: number; height: number }[];
  places: Map<string, Place>;
  /** from a topic's row in its writer to the reader */
  edges: { topic: string; from: string; to: string; x1: number; y1: number; x2: number; y2: number }[];
}

export const kNodeWidth = 158, kHead = 24, kRow = 18, kGapX = 38, kGapY = 14, kLanePad = 12, kLeft = 116;

/** The column of each module: behind all whose topics it reads. A module that reads what a later one of its thread
 *  publishes has that from the cycle before, and what the guardian says is about commands that went out: both count as
 *  feedback. Other loops are cut where they are met first. `modules`: those of a thread in its order. */
export function columnsOfModules(modules: GraphModule[]): Map<string, number> {
  const rank = new Map(modules.map((m, i) => [m.name, i]));
  const writer = new Map<string, string>();
  for (const m of modules) for (const t of m.outputs) writer.set(t, m.name);
  const byName = new Map(modules.map((m) => [m.name, m]));
  const column = new Map<string, number>();
  const open = new Set<string>();
  const visit = (name: string): number => {
    const known = column.get(name);
    if (known !== undefined) return known;
    if (open.has(name)) return -1; // feedback
    open.add(name);
    let at = 0;
    for (const topic of byName.get(name)!.inputs) {
      const from = writer.get(topic);
      const source = from === undefined ? undefined : byName.get(from);
      if (!from || !source || from === name) continue;
      const back = source.last || (source.thread === byName.get(name)!.thread && rank.get(from)! > rank.get(name)!);
      if (!back) at = Math.max(at, visit(from) + 1);
    }
    open.delete(name);
    column.set(name, at);
    return at;
  };
  for (const m of modules) visit(m.name);
  return column;
}

export function drawingOf(modules: GraphModule[], threads: string[]): Drawing {
  const columns = columnsOfModules(modules);
  const places = new Map<string, Place>();
  const lanes: Drawing["lanes"] = [];
  let y = 0, widest = 0;
  for (const thread of threads) {
    const inLane = modules.filter((m) => m.thread === thread);
    if (inLane.length === 0) continue;
    const below = new Map<number, number>();
    let height = 0;
    for (const m of inLane) {
      const column = columns.get(m.name) ?? 0;
      const top = below.get(column) ?? kLanePad;
      const own = kHead + Math.max(1, m.outputs.length) * kRow + 6;
      const x = kLeft + column * (kNodeWidth + kGapX);
      places.set(m.name, { module: m, x, y: y + top, width: kNodeWidth, height: own });
      below.set(column, top + own + kGapY);
      height = Math.max(height, top + own + kLanePad);
      widest = Math.max(widest, x + kNodeWidth + 24);
    }
    lanes.push({ thread, y, height });
    y += height;
  }
  const edges: Drawing["edges"] = [];
  for (const to of modules)
    for (const topic of to.inputs) {
      const from = modules.find((m) => m.outputs.includes(topic));
      const a = from && places.get(from.name), b = places.get(to.name);
      if (!from || !a || !b || from === to) continue;
      const row = from.outputs.indexOf(topic);
      edges.push({ topic, from: from.name, to: to.name, x1: a.x + a.width, y1: a.y + kHead + row * kRow + kRow / 2, x2: b.x, y2: b.y + kHead / 2 });
    }
  return { width: widest, height: y, lanes, places, edges };
}
