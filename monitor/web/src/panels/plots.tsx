// Numbers of messages over the robot's time.

import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import uPlot from "uplot";
import { unit, value } from "../format";
import { plotRequests } from "../page";
import type { PanelProps } from "../panels";
import type { Robot } from "../robot";
import { getterOf, numbersOf, type Leaf } from "../ros2msg";
import { csvOf, gridOf, Samples } from "../series";
import { bars, isDense, line, type Place } from "../trace";
import { Button, Choice, colour, cx, Dialog, download, Empty, seriesColour, Tools, useScheme, useSize } from "../ui";

export interface FieldOfPlot {
  topic: string; // without the slash
  path: string;
}

const kWindows = [["5", "5 s"], ["10", "10 s"], ["30", "30 s"], ["120", "2 min"]] as const;
export const kMostFields = 24;

function fieldsOf(state: Record<string, unknown>): FieldOfPlot[] {
  if (!Array.isArray(state.fields)) return [];
  return state.fields.filter((f): f is FieldOfPlot => typeof f?.topic === "string" && typeof f?.path === "string").slice(0, kMostFields);
}

/** What a plot shows before anybody chose: joints, else where the body is, else the first numbers that there are. */
function usualFields(robot: Robot): FieldOfPlot[] {
  const found = new Map<string, FieldOfPlot[]>();
  for (const name of [...robot.socket.channels.value.keys()].sort()) {
    const struct = robot.struct(name);
    if (!struct || typeof struct === "string" || name.startsWith("/sinew/")) continue;
    const topic = name.slice(1);
    const paths = (pattern: RegExp) => numbersOf(struct).filter((l) => pattern.test(l.path)).map((l) => ({ topic, path: l.path }));
    const keep = (rule: string, fields: FieldOfPlot[]) => fields.length > 0 && !found.has(rule) && found.set(rule, fields.slice(0, 3));
    if (/world_base/.test(struct.fields.map((f) => f.name).join()) && topic !== "ground_truth") keep("position", paths(/^p_world_m/));
    keep("joints", paths(/^position_rad\[[01]\]/));
    keep("numbers", numbersOf(struct).filter((l) => !l.integer).map((l) => ({ topic, path: l.path })));
  }
  return found.get("joints") ?? found.get("position") ?? found.get("numbers") ?? [];
}

export function PlotsPanel({ robot, tile, set }: PanelProps) {
  const untouched = !Array.isArray(tile.state.fields);
  const channels = robot.socket.channels.value;
  const fields = useMemo(() => (untouched ? usualFields(robot) : fieldsOf(tile.state)), [untouched, tile.state.fields, channels]);
  const window_s = Number(tile.state.window_s ?? 10) || 10;
  const [choosing, setChoosing] = useState(false);
  const [held, setHeld] = useState(false);
  const plot = useRef<PlotHandle | null>(null);
  useEffect(() => robot.socket.connect(), [robot]);
  const add = (f: FieldOfPlot) => {
    const now = fields;
    if (!now.some((x) => x.topic === f.topic && x.path === f.path)) set({ fields: [...now, f] });
  };
  const asked = plotRequests.value;
  useEffect(() => {
    if (!asked || asked.tile !== tile.id) return;
    plotRequests.value = null;
    add(asked);
  }, [asked]);
  return (
    <>
      <Tools>
        <Button icon="plus" label="Field" onClick={() => setChoosing(true)} />
        <Choice label="Length of the plot" value={String(window_s)} options={kWindows} onChange={(w) => set({ window_s: Number(w) })} />
        <Button icon={held ? "play" : "pause"} label={held ? "Go on" : "Hold"} pressed={held} onClick={() => setHeld(!held)} />
        <Button label="CSV" disabled={fields.length === 0} title="What the plot shows, as a table" onClick={() => plot.current && download(`${robot.name}.csv`, plot.current.csv(), "text/csv")} />
        <Button label="PNG" disabled={fields.length === 0} title="The plot as a picture" onClick={() => plot.current?.png((blob) => download(`${robot.name}.png`, blob))} />
      </Tools>
      {fields.length === 0 ? (
        <Empty title="No field chosen">
          <Button icon="plus" label="Choose a field" kind="strong" onClick={() => setChoosing(true)} />
        </Empty>
      ) : (
        <Plot robot={robot} fields={fields} window_s={window_s} held={held} hold={setHeld} handle={plot} remove={(f) => set({ fields: fields.filter((x) => x !== f) })} />
      )}
      {choosing && <FieldDialog robot={robot} chosen={fields} onAdd={add} onRemove={(f) => set({ fields: fields.filter((x) => x.topic !== f.topic || x.path !== f.path) })} onClose={() => setChoosing(false)} />}
    </>
  );
}

interface PlotHandle {
  csv(): string;
  png(done: (blob: Blob) => void): void;
}

interface Line {
  field: FieldOfPlot;
  leaf: Leaf | null;
  samples: Samples;
  columns: (number | null)[]; // what is drawn
}

function keyOf(f: FieldOfPlot): string {
  return `${f.topic} ${f.path}`;
}

/** Subscribes each topic once, however many of its fields are shown. */
function useLines(robot: Robot, fields: FieldOfPlot[]): { lines: Line[]; newest: () => number } {
  const kept = useRef(new Map<string, Samples>());
  const newest = useRef(-Infinity);
  const key = fields.map(keyOf).join("|");
  const channels = robot.socket.channels.value;
  const pid = robot.info.value.pid;
  useEffect(() => {
    for (const s of kept.current.values()) s.clear();
    newest.current = -Infinity;
  }, [robot, pid]);
  const lines = useMemo(() => fields.map((field): Line => {
    const id = keyOf(field);
    let samples = kept.current.get(id);
    if (!samples) kept.current.set(id, (samples = new Samples()));
    const struct = robot.struct(`/${field.topic}`);
    const leaf = struct && typeof struct === "object" ? (numbersOf(struct).find((l) => l.path === field.path) ?? null) : null;
    return { field, leaf, samples, columns: [] };
  }), [key, channels]);
  useEffect(() => {
    const byTopic = new Map<string, Line[]>();
    for (const line of lines) if (line.leaf) byTopic.set(line.field.topic, [...(byTopic.get(line.field.topic) ?? []), line]);
    const ends = [...byTopic].map(([topic, list]) => {
      const struct = robot.struct(`/${topic}`);
      if (!struct || typeof struct === "string") return () => undefined;
      const getters = list.map((l) => getterOf(struct, l.field.path)!);
      return robot.subscribe(`/${topic}`, (payload, time_ns) => {
        const time = time_ns / 1e9;
        if (time < newest.current - 1) newest.current = time; // a recorded run went back
        else if (time > newest.current) newest.current = time;
        list.forEach((line, i) => line.samples.push(time, getters[i]!(payload)));
      });
    });
    return () => ends.forEach((end) => end());
  }, [lines]);
  return { lines, newest: () => newest.current };
}

const kColumn_px = 2; // the least and the greatest value of each are drawn
const kFrameMs = 1000 / 60 - 2;
const kLegendMs = 100; // nobody reads digits that change faster, and each change has the browser lay out and paint text

function Plot({ robot, fields, window_s, held, hold, handle, remove }: {
  robot: Robot;
  fields: FieldOfPlot[];
  window_s: number;
  held: boolean;
  hold: (held: boolean) => void;
  handle: { current: PlotHandle | null };
  remove: (f: FieldOfPlot) => void;
}) {
  const [box, size] = useSize<HTMLDivElement>();
  const { lines, newest } = useLines(robot, fields);
  const scheme = useScheme();
  const plot = useRef<uPlot | null>(null);
  const legend = useRef<HTMLUListElement>(null);
  const range = useRef<{ from: number; to: number }>({ from: 0, to: window_s });
  const zoomed = useRef(false);
  const cursor = useRef<number | null>(null);
  const isHeld = useRef(held);
  isHeld.current = held;
  if (!held) zoomed.current = false;
  const shape = lines.map((l) => `${keyOf(l.field)} ${l.leaf?.unit}`).join("|");

  const update = (force = false) => {
    const u = plot.current;
    if (!u || u.width <= 0) return;
    if (!isHeld.current) {
      const end = newest();
      if (!Number.isFinite(end)) return;
      range.current = { from: end - window_s, to: end };
    } else if (!force) return;
    const { from, to } = range.current;
    const columns = Math.max(16, Math.min(1200, Math.round(u.bbox.width / devicePixelRatio / kColumn_px)));
    u.batch(() => {
      for (const l of lines) l.samples.columns(from, to, columns, l.columns);
      u.setData([gridOf(from, to, columns), ...lines.map((l) => l.columns)] as unknown as uPlot.AlignedData, false);
      u.setScale("x", { min: from, max: to });
      for (const scale of new Set(lines.map(scaleOf))) u.setScale(scale, spanOf(u, lines, scale));
    });
  };

  useEffect(() => {
    const element = box.current;
    if (!element || size.width < 40 || size.height < 40) return;
    const scales = [...new Set(lines.map(scaleOf))];
    const axis = { stroke: colour("muted"), grid: { stroke: colour("grid"), width: 1 }, ticks: { show: false }, font: `11px ${colour("font")}`, labelFont: `11px ${colour("font")}`, labelSize: 16, labelGap: 0 };
    const options: uPlot.Options = {
      width: size.width,
      height: size.height,
      pxAlign: 0,
      legend: { show: false },
      cursor: {
        drag: { x: true, y: false, setScale: false },
        points: { size: 6 },
        focus: { prox: 24 },
      },
      scales: { x: { time: false, auto: false }, ...Object.fromEntries(scales.map((s) => [s, { auto: false }])) },
      axes: [
        { ...axis, size: 26, values: (_, ticks) => ticks.map((t) => timeText(t)) },
        ...scales.slice(0, 2).map((s, i): uPlot.Axis => ({ ...axis, scale: s, side: i === 0 ? 3 : 1, size: 52, label: unit(s.slice(2)) || "1", grid: { ...axis.grid, show: i === 0 }, values: (_, ticks) => ticks.map((t) => tickText(t)) })),
      ],
      series: [
        {},
        ...lines.map((l, i): uPlot.Series => ({ scale: scaleOf(l), stroke: seriesColour(i), width: kLine_px, dash: i >= 8 ? (i >= 16 ? [2, 2] : [6, 3]) : [], paths: pathsOf, points: { show: false } })),
      ],
      hooks: {
        drawSeries: [barsOf],
        setCursor: [(u) => {
          cursor.current = u.cursor.left != null && u.cursor.left >= 0 ? u.posToVal(u.cursor.left, "x") : null;
        }],
        setSelect: [(u) => {
          if (u.select.width < 4) return;
          range.current = { from: u.posToVal(u.select.left, "x"), to: u.posToVal(u.select.left + u.select.width, "x") };
          zoomed.current = true;
          isHeld.current = true;
          hold(true);
          u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
          update(true);
        }],
      },
    };
    const u = new uPlot(options, [[0], ...lines.map(() => [null])] as unknown as uPlot.AlignedData, element);
    plot.current = u;
    update(true);
    return () => {
      u.destroy();
      plot.current = null;
    };
  }, [shape, size.width, size.height, scheme]);

  useEffect(() => {
    let frame = 0, last = 0, drawn = NaN, written = 0, at: number | null = NaN;
    const run = (now: number) => {
      frame = requestAnimationFrame(run);
      if (now - last < kFrameMs) return;
      last = now;
      if (newest() !== drawn) update(); // else the same picture
      drawn = newest();
      if (now - written >= kLegendMs || cursor.current !== at) {
        writeLegend(legend.current, lines, cursor.current ?? range.current.to);
        written = now;
        at = cursor.current;
      }
      (window as unknown as { sinewRedraws?: number }).sinewRedraws = ((window as unknown as { sinewRedraws?: number }).sinewRedraws ?? 0) + 1;
    };
    frame = requestAnimationFrame(run);
    return () => cancelAnimationFrame(frame);
  }, [lines, window_s, shape]);

  handle.current = {
    csv: () => csvOf(lines.map((l) => ({ name: keyOf(l.field), unit: unit(l.leaf?.unit ?? ""), samples: l.samples })), range.current.from, range.current.to),
    png: (done) => plot.current && pngOf(plot.current, lines, done),
  };

  const zoom = (factor: number, at: number) => {
    const { from, to } = range.current;
    const span = Math.min(120, Math.max(0.01, (to - from) * factor));
    const centre = from + at * (to - from);
    range.current = { from: centre - at * span, to: centre + (1 - at) * span };
    zoomed.current = true;
    isHeld.current = true;
    hold(true);
    update(true);
  };

  return (
    <div class="plot" tabIndex={0} aria-label={`Plot of ${lines.map((l) => keyOf(l.field)).join(", ")}; space holds it, + and - zoom`} onKeyDown={(e) => {
      if (e.target !== e.currentTarget) return;
      if (e.key === " ") hold(!held);
      else if (e.key === "+" || e.key === "-") zoom(e.key === "+" ? 0.5 : 2, 0.5);
      else if ((e.key === "ArrowLeft" || e.key === "ArrowRight") && held) {
        const by = (range.current.to - range.current.from) * (e.key === "ArrowLeft" ? -0.2 : 0.2);
        range.current = { from: range.current.from + by, to: range.current.to + by };
        update(true);
      } else return;
      e.preventDefault();
    }}>
      <ul ref={legend} class="legend">
        {lines.map((l, i) => (
          <li key={keyOf(l.field)} title={l.leaf?.doc || undefined}>
            <i style={{ background: seriesColour(i) }} />
            <span class="legend-name">{l.field.topic} <b>{l.field.path}</b></span>
            <output class="num" />
            <span class="unit">{unit(l.leaf?.unit ?? "")}</span>
            {!l.leaf && <span class="warn-text">{robot.socket.state.value === "open" ? "not there" : "connecting"}</span>}
            <Button icon="close" label={`Remove ${keyOf(l.field)}`} hideLabel kind="quiet" onClick={() => remove(l.field)} />
          </li>
        ))}
      </ul>
      <div ref={box} class="plot-box" onWheel={(e) => {
        e.preventDefault();
        const u = plot.current;
        if (u) zoom(e.deltaY > 0 ? 1.25 : 0.8, Math.min(1, Math.max(0, (u.cursor.left ?? 0) / (u.bbox.width / devicePixelRatio))));
      }} onDblClick={() => hold(false)} />
    </div>
  );
}

const kLine_px = 1.5;

function placeOf(u: uPlot, index: number): Place {
  const { min, max } = u.scales[u.series[index]!.scale!] as { min: number; max: number };
  const { left, top, width, height } = u.bbox;
  const perUnit = -height / (max - min);
  return { left, step: width / u.data[index]!.length, zero: top - max * perUnit, perUnit, top, bottom: top + height };
}

/** As uPlot asks for it. Where lines would fill an area, barsOf() draws. */
function pathsOf(u: uPlot, index: number): uPlot.Series.Paths {
  const columns = u.data[index] as (number | null)[], place = placeOf(u, index);
  const path = new Path2D();
  if (!isDense(columns, place.perUnit, devicePixelRatio)) line(columns, place, path);
  return { stroke: path, fill: null, clip: null, band: null, flags: 0 };
}

function barsOf(u: uPlot, index: number) {
  const columns = u.data[index] as (number | null)[], place = placeOf(u, index);
  if (index === 0 || !isDense(columns, place.perUnit, devicePixelRatio)) return;
  u.ctx.fillStyle = seriesColour(index - 1);
  bars(columns, place, kLine_px * devicePixelRatio, (x, y, width, height) => u.ctx.fillRect(x, y, width, height));
}

function scaleOf(l: Line): string {
  return `y:${l.leaf?.unit ?? ""}`;
}

/** Room above and below what is shown; a line that does not move gets some, too. */
function spanOf(u: uPlot, lines: Line[], scale: string): { min: number; max: number } {
  let low = Infinity, high = -Infinity;
  lines.forEach((l, i) => {
    if (scaleOf(l) !== scale) return;
    for (const v of u.data[i + 1] as (number | null)[]) {
      if (v === null) continue;
      if (v < low) low = v;
      if (v > high) high = v;
    }
  });
  if (low > high) return { min: -1, max: 1 };
  const room = Math.max((high - low) * 0.08, Math.abs(high) * 1e-3, 1e-9);
  return { min: low - room, max: high + room };
}

function timeText(t: number): string {
  if (t > 1e9) return new Date(t * 1e3).toISOString().slice(11, 21);
  return `${Number(t.toFixed(4))} s`;
}

function tickText(t: number): string {
  const size = Math.abs(t);
  return size !== 0 && (size >= 1e5 || size < 1e-3) ? t.toExponential(1) : String(Number(t.toPrecision(6)));
}

function writeLegend(list: HTMLUListElement | null, lines: Line[], at: number) {
  if (!list) return;
  const outputs = list.querySelectorAll("output");
  lines.forEach((l, i) => {
    const v = l.samples.at(at);
    const name = l.leaf?.names?.get(v);
    const text = Number.isNaN(v) ? "–" : name ?? value(v, l.leaf?.integer);
    const out = outputs[i];
    if (out && out.textContent !== text) out.textContent = text;
  });
}

function pngOf(u: uPlot, lines: Line[], done: (blob: Blob) => void) {
  const from = u.ctx.canvas, ratio = devicePixelRatio || 1, head = Math.ceil(lines.length / 2) * 18 * ratio + 8 * ratio;
  const c = document.createElement("canvas");
  c.width = from.width, c.height = from.height + head;
  const context = c.getContext("2d")!;
  context.fillStyle = colour("surface");
  context.fillRect(0, 0, c.width, c.height);
  context.font = `${12 * ratio}px ${colour("font")}`;
  lines.forEach((l, i) => {
    const x = (i % 2) * (c.width / 2) + 10 * ratio, y = Math.floor(i / 2) * 18 * ratio + 16 * ratio;
    context.fillStyle = seriesColour(i);
    context.fillRect(x, y - 8 * ratio, 12 * ratio, 3 * ratio);
    context.fillStyle = colour("text");
    context.fillText(`${keyOf(l.field)}${l.leaf?.unit ? ` [${unit(l.leaf.unit)}]` : ""}`, x + 18 * ratio, y);
  });
  context.drawImage(from, 0, head);
  c.toBlob((blob) => blob && done(blob), "image/png");
}

// ---- choosing fields

function FieldDialog({ robot, chosen, onAdd, onRemove, onClose }: {
  robot: Robot;
  chosen: FieldOfPlot[];
  onAdd: (f: FieldOfPlot) => void;
  onRemove: (f: FieldOfPlot) => void;
  onClose: () => void;
}) {
  const [filter, setFilter] = useState("");
  const channels = robot.socket.channels.value;
  const words = filter.toLowerCase().split(/\s+/).filter(Boolean);
  const all = useMemo(() => [...channels.keys()].sort().flatMap((name) => {
    const struct = robot.struct(name);
    return struct && typeof struct === "object" ? numbersOf(struct).map((leaf) => ({ topic: name.slice(1), leaf })) : [];
  }), [channels]);
  const some = all.filter(({ topic, leaf }) => words.every((w) => `${topic} ${leaf.path} ${leaf.doc}`.toLowerCase().includes(w)));
  const has = (topic: string, path: string) => chosen.some((f) => f.topic === topic && f.path === path);
  let before = "";
  return (
    <Dialog title="Fields to plot" onClose={onClose}>
      <input type="search" class="search wide" placeholder="Topic, field, words of its description" aria-label="Find a field" autofocus value={filter} onInput={(e) => setFilter(e.currentTarget.value)} />
      <ul class="fields">
        {some.slice(0, 400).map(({ topic, leaf }) => {
          const heading = topic !== before ? <li key={`${topic}:`} class="fields-topic">{topic}</li> : null;
          before = topic;
          const on = has(topic, leaf.path);
          const f = { topic, path: leaf.path };
          return [heading, (
            <li key={`${topic} ${leaf.path}`}>
              <label class={cx(on && "on")}>
                <input type="checkbox" checked={on} disabled={!on && chosen.length >= kMostFields} onChange={() => (on ? onRemove(f) : onAdd(f))} />
                <span>{leaf.path}</span><span class="unit">{unit(leaf.unit)}</span><span class="muted">{leaf.doc}</span>
              </label>
            </li>
          )];
        })}
      </ul>
      {all.length === 0 && <p class="muted">{robot.socket.state.value === "open" ? "This robot publishes no numbers." : "Connecting …"}</p>}
      {some.length > 400 && <p class="muted">{some.length - 400} more: type a word to find them.</p>}
      <p class="muted">{chosen.length} of at most {kMostFields}. Fields of one unit share a scale.</p>
    </Dialog>
  );
}
