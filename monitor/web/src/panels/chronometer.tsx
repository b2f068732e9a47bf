// Where the time goes: rates, lateness and execution times of threads and modules, the distribution of one of them, and
// the time line of the last second.

import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import type { Histogram, Status, Timeline } from "../api";
import { count, duration, percent, rate } from "../format";
import type { PanelProps } from "../panels";
import type { Robot } from "../robot";
import { binsOf, lengthsOf, newestOf } from "../timeline";
import { Asked, Button, Canvas, colour, cx, Empty, Segments, seriesColour, Tools, useScheme, useWatch } from "../ui";

const kKept = 20_000; // lengths of one thread or module, for its distribution

export function ChronometerPanel({ robot, tile, set }: PanelProps) {
  useWatch(robot, "status", 250);
  const timeline = useTimeline(robot);
  const [held, setHeld] = useState<Timeline | null>(null);
  const seen = useDistribution(timeline);
  const chosen = typeof tile.state.chosen === "string" ? tile.state.chosen : "";
  const span = typeof tile.state.span_ms === "number" ? tile.state.span_ms : 100;
  const shown = held ?? timeline;
  return (
    <>
      <Tools>
        <Segments label="Length of the time line" value={span} options={[[1000, "1 s"], [100, "100 ms"], [20, "20 ms"], [5, "5 ms"]]} onChange={(s) => set({ span_ms: s })} />
        <Button icon={held ? "play" : "pause"} label={held ? "Go on" : "Hold"} pressed={held !== null} onClick={() => setHeld(held ? null : timeline)} />
      </Tools>
      <Asked robot={robot} request="status" there={robot.status.value !== null}>
        <div class="chronometer">
          <Times robot={robot} status={robot.status.value!} chosen={chosen} choose={(c) => set({ chosen: c })} />
          <Distribution of={chosen || `thread:${robot.status.value?.threads[0]?.name}`} seen={seen.current} stamp={timeline} />
          {shown ? <TimeLine timeline={shown} span_ms={span} robot={robot} hold={() => setHeld((h) => (h ? null : timeline))} held={held !== null} /> : <Empty>{robot.failures.value.get("timeline") ?? "Asking for the time line …"}</Empty>}
        </div>
      </Asked>
    </>
  );
}

/** From /sinew/timeline, which switches the modules' zones on while somebody looks. */
function useTimeline(robot: Robot): Timeline | null {
  useEffect(() => robot.subscribe("/sinew/timeline", (payload) => {
    robot.timeline.value = JSON.parse(new TextDecoder().decode(payload)) as Timeline;
  }), [robot]);
  return robot.timeline.value;
}

function useDistribution(timeline: Timeline | null) {
  const seen = useRef({ lengths: new Map<string, number[]>(), until: -Infinity, taken: null as Timeline | null });
  if (timeline && seen.current.taken !== timeline) {
    const s = seen.current;
    s.taken = timeline;
    const newest = newestOf(timeline);
    if (newest < s.until) (s.lengths = new Map()), (s.until = -Infinity); // the robot began anew
    for (const [key, list] of lengthsOf(timeline, s.until)) s.lengths.set(key, [...(s.lengths.get(key) ?? []), ...list].slice(-kKept));
    s.until = Math.max(s.until, newest);
  }
  return { current: seen.current.lengths };
}

function Cells({ h }: { h: Histogram }) {
  const none = h.count === 0;
  return (
    <>
      <td class="r num">{none ? "" : duration(h.p50_ns)}</td>
      <td class="r num">{none ? "" : duration(h.p99_ns)}</td>
      <td class="r num">{none ? "" : duration(h.max_ns)}</td>
    </>
  );
}

function Times({ robot, status, chosen, choose }: { robot: Robot; status: Status; chosen: string; choose: (key: string) => void }) {
  const rates = robot.rates.value;
  const row = (key: string) => ({
    class: cx("choosable", chosen === key && "chosen"),
    tabIndex: 0,
    "aria-current": chosen === key ? ("true" as const) : undefined,
    onClick: () => choose(key),
    onKeyDown: (e: KeyboardEvent) => e.key === "Enter" && choose(key),
  });
  return (
    <div class="scroll">
      <table class="table times">
        <thead>
          <tr><th rowSpan={2}>Thread, module</th><th rowSpan={2} class="r">Rate</th><th colSpan={3} class="group">Begins late</th><th colSpan={3} class="group">Takes</th><th rowSpan={2} class="r">Processor</th><th rowSpan={2} class="r">Overruns</th><th rowSpan={2} class="r" title="Times that a thread of higher priority interrupted it">Preempted</th></tr>
          <tr><th class="r">p50</th><th class="r">p99</th><th class="r">max</th><th class="r">p50</th><th class="r">p99</th><th class="r">max</th></tr>
        </thead>
        {status.threads.map((t) => (
          <tbody key={t.name}>
            <tr {...row(`thread:${t.name}`)}>
              <td><strong>{t.name}</strong></td>
              <td class="r num">{rate(rates?.hz.get(`thread:${t.name}`))}</td>
              <Cells h={t.lateness} />
              <Cells h={t.exec} />
              <td class="r num">{percent(rates?.share.get(`thread:${t.name}`))}</td>
              <td class={cx("r num", t.overruns + t.skips > 0 && "warn-text")}>{count(t.overruns + t.skips)}</td>
              <td class="r num">{count(t.preemptions)}</td>
            </tr>
            {t.modules.map((name) => {
              const m = status.modules.find((x) => x.name === name);
              return m && (
                <tr key={name} {...row(`module:${name}`)}>
                  <td class="indent">{name}{!m.running && <span class="muted"> off</span>}</td>
                  <td class="r num">{rate(rates?.hz.get(`module:${name}`))}</td>
                  <td colSpan={3} />
                  <Cells h={m.exec} />
                  <td class="r num">{percent(rates?.share.get(`module:${name}`))}</td>
                  <td class={cx("r num", m.fault > 0 && "bad-text")}>{m.fault > 0 ? `${count(m.fault)} faults` : ""}</td>
                  <td />
                </tr>
              );
            })}
          </tbody>
        ))}
      </table>
    </div>
  );
}

function Distribution({ of: key, seen, stamp }: { of: string; seen: Map<string, number[]>; stamp: unknown }) {
  const scheme = useScheme();
  const [kind, name] = key.split(/:(.*)/s) as [string, string];
  const parts = useMemo(() => {
    const exec = binsOf(seen.get(key) ?? []);
    const late = kind === "thread" ? binsOf(seen.get(`late:${name}`) ?? []) : null;
    return [["takes", exec, "series-1"], ...(late && late.total ? [["begins late", late, "series-2"]] : [])] as [string, ReturnType<typeof binsOf>, string][];
  }, [key, stamp, scheme]);
  return (
    <div class="distribution">
      {parts.map(([what, bins, hue]) => (
        <figure key={what}>
          <figcaption><strong>{name}</strong> {what} <span class="muted num">{count(bins.total)} times</span></figcaption>
          {bins.total === 0 ? <p class="muted">nothing seen yet</p> : (
            <Canvas label={`${name} ${what}: from ${duration(bins.borders[0])} to ${duration(bins.borders.at(-1))}`} draw={(c, w, h) => {
              const most = Math.max(...bins.counts), foot = 16, n = bins.counts.length;
              c.fillStyle = colour(hue);
              bins.counts.forEach((v, i) => {
                if (v === 0) return;
                const high = Math.max(1.5, (Math.log1p(v) / Math.log1p(most)) * (h - foot - 4));
                c.fillRect((i * w) / n + 0.5, h - foot - high, Math.max(1, w / n - 1), high);
              });
              c.fillStyle = colour("line");
              c.fillRect(0, h - foot, w, 1);
              c.fillStyle = colour("muted");
              c.font = `11px ${colour("font")}`;
              c.textBaseline = "bottom";
              c.textAlign = "left";
              c.fillText(duration(bins.borders[0]), 0, h);
              c.textAlign = "right";
              c.fillText(duration(bins.borders.at(-1)), w, h);
            }} />
          )}
        </figure>
      ))}
    </div>
  );
}

const kLane = 34, kName = 112, kFoot = 20;

function TimeLine({ timeline, span_ms, robot, hold, held }: { timeline: Timeline; span_ms: number; robot: Robot; hold: () => void; held: boolean }) {
  useScheme();
  const [view, setView] = useState<{ end_ns: number; span_ns: number } | null>(null); // null: the newest
  const [at, setAt] = useState<{ x: number; y: number } | null>(null);
  const newest = useMemo(() => newestOf(timeline), [timeline]);
  useEffect(() => setView(null), [span_ms]);
  useEffect(() => { if (!held) setView(null); }, [timeline, held]);
  const span = view?.span_ns ?? span_ms * 1e6;
  const end = view?.end_ns ?? newest;
  const begin = end - span;
  const drag = useRef<number | null>(null);
  const widthRef = useRef(1);
  const under = at ? eventAt(timeline, at.x, at.y, begin, span, widthRef.current) : null;
  return (
    <div class="timeline" tabIndex={0} aria-label="Time line; space holds it" onKeyDown={(e) => {
      if (e.key === " ") hold();
      else if (e.key === "ArrowLeft" || e.key === "ArrowRight") setView({ span_ns: span, end_ns: end + (e.key === "ArrowLeft" ? -0.2 : 0.2) * span });
      else if (e.key === "+" || e.key === "-") setView({ span_ns: span * (e.key === "+" ? 0.5 : 2), end_ns: end });
      else return;
      e.preventDefault();
    }}>
      <Canvas
        label={`What ${timeline.threads.length} threads did in the last ${duration(span)}`}
        class="timeline-canvas"
        draw={(c, w, h) => {
          widthRef.current = w;
          drawTimeLine(c, w, h, timeline, begin, span);
        }}
        onWheel={(e) => {
          e.preventDefault();
          const x = Math.min(1, Math.max(0, (e.offsetX - kName) / (widthRef.current - kName)));
          const factor = e.deltaY > 0 ? 1.25 : 0.8;
          const now = Math.min(1e9, Math.max(5e4, span * factor));
          const centre = begin + x * span;
          if (!held) hold();
          setView({ span_ns: now, end_ns: centre + (1 - x) * now });
        }}
        onPointerDown={(e) => (drag.current = e.offsetX)}
        onPointerMove={(e) => {
          setAt({ x: e.offsetX, y: e.offsetY });
          if (drag.current === null || e.buttons === 0) return void (drag.current = null);
          const moved = ((e.offsetX - drag.current) / (widthRef.current - kName)) * span;
          drag.current = e.offsetX;
          if (!held) hold();
          setView({ span_ns: span, end_ns: end - moved });
        }}
        onPointerUp={() => (drag.current = null)}
        onPointerLeave={() => setAt(null)}
      />
      <p class="timeline-note muted num">
        {under ?? `${duration(span)} until ${(end / 1e9).toFixed(4)} s${timeline.left_out > 0 ? `; ${count(timeline.left_out)} older events left out` : ""}${robot.info.value.virtual_time ? "; virtual time: exact" : ""}`}
      </p>
    </div>
  );
}

function laneHeight(h: number, lanes: number): number {
  return Math.max(18, Math.min(kLane, (h - kFoot) / Math.max(1, lanes)));
}

function drawTimeLine(c: CanvasRenderingContext2D, w: number, h: number, timeline: Timeline, begin: number, span: number) {
  const lane = laneHeight(h, timeline.threads.length);
  const x = (ns: number) => kName + ((ns - begin) / span) * (w - kName);
  const font = colour("font");
  const [line, muted, text, warn, bad] = ["line", "muted", "text", "warn", "bad"].map(colour) as [string, string, string, string, string];
  c.font = `11.500px ${font}`;
  c.textBaseline = "middle";
  // grid
  const step = [1, 2, 5].flatMap((f) => [1e3, 1e4, 1e5, 1e6, 1e7, 1e8].map((t) => f * t)).sort((a, b) => a - b).find((s) => (s / span) * (w - kName) >= 90) ?? 2e8;
  c.fillStyle = muted;
  c.textAlign = "center";
  for (let t = begin + span - step; t > begin; t -= step) {
    c.globalAlpha = 0.35;
    c.fillStyle = line;
    c.fillRect(Math.round(x(t)), 0, 1, h - kFoot + 3);
    c.globalAlpha = 1;
    c.fillStyle = muted;
    const back = (begin + span - t) / 1e6;
    if (x(t) > kName + 30 && x(t) < w - 20) c.fillText(`−${back.toFixed(step < 1e5 ? 2 : step < 1e6 ? 1 : 0)} ms`, x(t), h - 7);
  }
  c.textAlign = "left";
  timeline.threads.forEach((name, i) => {
    c.fillStyle = line;
    c.fillRect(0, Math.round((i + 1) * lane) - 0.5, w, 1);
    c.fillStyle = text;
    c.fillText(name, 4, i * lane + lane / 2, kName - 10);
  });
  c.save();
  c.beginPath();
  c.rect(kName, 0, w - kName, h);
  c.clip();
  const colours = timeline.modules.map((_, i) => seriesColour(i));
  const box = (thread: number, at: number, length: number, top: number, height: number, least = 1) => {
    const left = x(at);
    c.fillRect(left, thread * lane + lane * top, Math.max(least, (length / span) * (w - kName)), lane * height);
  };
  const end = begin + span;
  for (const pass of ["cycle", "step", "zone", "off_processor", "preempted", "release", "overrun", "skip"]) {
    for (const [kind, thread, module, at, length] of timeline.events) {
      if (kind !== pass || at > end || at + length < begin) continue;
      switch (kind) {
        case "cycle":
          c.fillStyle = line;
          box(thread, at, length, 0.18, 0.64);
          break;
        case "step":
          c.fillStyle = module === null ? muted : colours[module]!;
          box(thread, at, length, 0.22, 0.56);
          break;
        case "zone":
          c.fillStyle = text;
          c.globalAlpha = 0.55;
          box(thread, at, length, 0.68, 0.1);
          c.globalAlpha = 1;
          break;
        case "preempted":
          hatch(c, x(at), thread * lane + lane * 0.22, Math.max(1, (length / span) * (w - kName)), lane * 0.56, colour("surface"));
          break;
        case "off_processor":
          c.fillStyle = bad;
          c.globalAlpha = 0.35;
          box(thread, at, length, 0.1, 0.8);
          c.globalAlpha = 1;
          break;
        case "release":
          c.fillStyle = text;
          c.fillRect(x(at), thread * lane + lane * 0.06, 1, lane * 0.14);
          break;
        default:
          c.fillStyle = kind === "overrun" ? bad : warn;
          c.beginPath();
          c.arc(x(at), thread * lane + lane * 0.13, 3, 0, 7);
          c.fill();
      }
    }
  }
  // Names of steps where there is room.
  c.textAlign = "left";
  c.fillStyle = colour("on-series");
  for (const [kind, thread, module, at, length, zone] of timeline.events) {
    if ((kind !== "step" && kind !== "zone") || at > end || at + length < begin) continue;
    const wide = (length / span) * (w - kName);
    const label = kind === "zone" ? zone ?? "" : module === null ? "" : timeline.modules[module]!;
    if (kind === "step" && wide > 26 + label.length * 5) c.fillText(label, Math.max(x(at), kName) + 5, thread * lane + lane * 0.47, wide - 8);
  }
  c.restore();
}

function hatch(c: CanvasRenderingContext2D, x: number, y: number, w: number, h: number, hue: string) {
  c.save();
  c.beginPath();
  c.rect(x, y, w, h);
  c.clip();
  c.strokeStyle = hue;
  c.lineWidth = 1.5;
  c.beginPath();
  for (let i = -h; i < w; i += 4) {
    c.moveTo(x + i, y + h);
    c.lineTo(x + i + h, y);
  }
  c.stroke();
  c.restore();
}

function eventAt(timeline: Timeline, px: number, py: number, begin: number, span: number, w: number): string | null {
  if (px < kName) return null;
  const at = begin + ((px - kName) / (w - kName)) * span;
  const slack = (2 / (w - kName)) * span;
  const height = document.querySelector<HTMLElement>(".timeline-canvas")?.clientHeight ?? 0;
  const thread = Math.floor(py / laneHeight(height, timeline.threads.length));
  const order = ["zone", "preempted", "step", "off_processor", "overrun", "skip", "cycle"];
  let best: Timeline["events"][number] | null = null;
  for (const e of timeline.events) {
    if (e[1] !== thread || e[3] - slack > at || e[3] + e[4] + slack < at || !order.includes(e[0])) continue;
    if (!best || order.indexOf(e[0]) < order.indexOf(best[0])) best = e;
  }
  if (!best) return null;
  const [kind, t, module, from, length, zone] = best;
  const what = kind === "step" ? `step of ${timeline.modules[module ?? 0]}` : kind === "zone" ? `zone ${zone}` : kind.replace("_", " ");
  return `${timeline.threads[t]}: ${what}, ${duration(length)}, from ${(from / 1e9).toFixed(6)} s`;
}
