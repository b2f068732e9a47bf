// Threads, modules and topics: as a tree with what can be changed, and as the graph along which data flows.

import { useMemo, useState } from "preact/hooks";
import type { Status, ThreadStatus, Topic } from "../api";
import { count, duration, percent, rate } from "../format";
import { drawingOf, kHead, kNodeWidth, kRow, type GraphModule } from "../graph";
import type { PanelProps } from "../panels";
import type { Robot } from "../robot";
import { Asked, Badge, CommandButton, cx, Segments, Switch, Tools, useSize, useWatch } from "../ui";

export function LayoutPanel({ robot, tile, set }: PanelProps) {
  useWatch(robot, "status", 250);
  useWatch(robot, "topics", 10_000);
  const mode = tile.state.mode === "graph" ? "graph" : "tree";
  return (
    <>
      <Tools>
        <Segments label="As" value={mode} options={[["tree", "Tree"], ["graph", "Graph"]]} onChange={(m) => set({ mode: m })} />
      </Tools>
      <Asked robot={robot} request="status" there={robot.status.value !== null}>
        {mode === "tree" ? <Tree robot={robot} status={robot.status.value!} /> : <Asked robot={robot} request="topics" there={robot.topics.value !== null}><Graph robot={robot} status={robot.status.value!} topics={robot.topics.value ?? []} /></Asked>}
      </Asked>
    </>
  );
}

function Tree({ robot, status }: { robot: Robot; status: Status }) {
  const rates = robot.rates.value;
  const topics = robot.topics.value ?? [];
  const counters = new Map(status.topics.map((t) => [t.name, t]));
  return (
    <table class="table tree">
      <thead>
        <tr><th>Thread, module, topic</th><th class="r">Rate</th><th class="r">Planned</th><th class="r">Processor</th><th class="r">Lost</th><th>Change</th></tr>
      </thead>
      {status.threads.map((t) => (
        <tbody key={t.name}>
          <tr class="level-0">
            <td><strong>{t.name}</strong> <span class="muted type">priority {t.priority}, {t.trigger === "period" ? "by its period" : t.trigger === "topics" ? "by topics" : "by its device"}</span></td>
            <td class="r num">{rate(rates?.hz.get(`thread:${t.name}`))}</td>
            <td class="r num muted">{t.period_ns > 0 ? rate(1e9 / t.period_ns) : ""}</td>
            <td class="r num">{percent(rates?.share.get(`thread:${t.name}`))}</td>
            <td class="r num">{t.overruns + t.skips > 0 ? <span class="warn-text">{count(t.overruns + t.skips)}</span> : ""}</td>
            <td>{t.trigger === "period" && <Period robot={robot} thread={t} />}</td>
          </tr>
          {t.modules.map((name) => {
            const m = status.modules.find((x) => x.name === name);
            if (!m) return null;
            return [
              <tr key={name} class="level-1">
                <td>{name} <span class="muted type">{m.type}</span> {m.fault > 0 && <Badge tone="bad">{count(m.fault)} faults</Badge>}{!m.running && <Badge tone="warn">off</Badge>}</td>
                <td class="r num">{rate(rates?.hz.get(`module:${name}`))}</td>
                <td />
                <td class="r num">{percent(rates?.share.get(`module:${name}`))}</td>
                <td />
                <td>{!robot.isPlayback.value && <Switch on={m.running} label={`Module ${name}`} onChange={(on) => void robot.command(on ? "module.enable" : "module.disable", { module: name })} />}</td>
              </tr>,
              ...topics.filter((x) => x.writer === name).map((topic) => {
                const c = counters.get(topic.name);
                return (
                  <tr key={topic.name} class="level-2">
                    <td>{topic.name} <span class="muted type">{topic.type}{topic.bulk_bytes > 0 ? " with pixels" : ""}</span></td>
                    <td class="r num">{rate(rates?.hz.get(`topic:${topic.name}`))}</td>
                    <td class="r num muted">{topic.rate_hz > 0 ? rate(topic.rate_hz) : ""}</td>
                    <td />
                    <td class="r num">{c && c.drops > 0 ? <span class="warn-text">{count(c.drops)}</span> : ""}</td>
                    <td class="muted num">{c && c.age.count > 0 ? `age ${duration(c.age.p50_ns)}` : ""}</td>
                  </tr>
                );
              }),
            ];
          })}
        </tbody>
      ))}
    </table>
  );
}

function Period({ robot, thread }: { robot: Robot; thread: ThreadStatus }) {
  const [text, setText] = useState<string | null>(null);
  const now = String(thread.period_ns / 1000);
  if (robot.isPlayback.value) return null;
  const send = async () => {
    const period_us = Number(text);
    if (text === null || text === now) return setText(null);
    await robot.command("thread.period", { thread: thread.name, period_us: Number.isInteger(period_us) ? period_us : text });
    setText(null);
  };
  return (
    <form class="inline" onSubmit={(e) => (e.preventDefault(), void send())}>
      <input class="number" inputMode="numeric" aria-label={`Period of ${thread.name} in µs`} value={text ?? now} size={7} onInput={(e) => setText(e.currentTarget.value)} onKeyDown={(e) => e.key === "Escape" && setText(null)} onBlur={() => text === now && setText(null)} />
      <span class="muted">µs</span>
      {text !== null && text !== now && <CommandButton label="Set" kind="strong" onClick={() => void send()} />}
    </form>
  );
}

function Graph({ robot, status, topics }: { robot: Robot; status: Status; topics: Topic[] }) {
  const [box, size] = useSize<HTMLDivElement>();
  const [marked, setMarked] = useState<string | null>(null);
  const rates = robot.rates.value;
  const key = `${status.modules.map((m) => `${m.name}/${m.thread}`).join()}|${topics.map((t) => t.name).join()}`;
  const drawing = useMemo(() => {
    const inputs = new Map<string, string[]>();
    for (const t of topics) for (const reader of t.readers ?? []) inputs.set(reader, [...(inputs.get(reader) ?? []), t.name]);
    const order = status.threads.flatMap((t) => t.modules);
    const modules: GraphModule[] = [...status.modules].sort((a, b) => order.indexOf(a.name) - order.indexOf(b.name)).map((m) => ({
      name: m.name, thread: m.thread, last: m.type === "rt::Guardian", outputs: topics.filter((t) => t.writer === m.name).map((t) => t.name), inputs: inputs.get(m.name) ?? [],
    }));
    return drawingOf(modules, status.threads.map((t) => t.name));
  }, [key]);
  // As large as it fits, but legible.
  const scale = Math.max(0.78, Math.min(1, size.width / drawing.width));
  const running = new Map(status.modules.map((m) => [m.name, m]));
  const near = (e: { from: string; to: string; topic: string }) => marked !== null && (e.from === marked || e.to === marked);
  return (
    <div ref={box} class="graph" tabIndex={0} aria-label="Graph of modules and topics; scrolls">
      <svg width={drawing.width * scale} height={drawing.height * scale} viewBox={`0 0 ${drawing.width} ${drawing.height}`} role="img" aria-label={`${drawing.places.size} modules in ${drawing.lanes.length} threads`}>
        {drawing.lanes.map((lane, i) => {
          const t = status.threads.find((x) => x.name === lane.thread);
          return (
            <g key={lane.thread}>
              <rect x={0} y={lane.y} width="100%" height={lane.height} class={i % 2 ? "lane odd" : "lane"} />
              <text x={12} y={lane.y + 26} class="lane-name">{lane.thread}</text>
              <text x={12} y={lane.y + 42} class="lane-note">{rate(rates?.hz.get(`thread:${lane.thread}`))}</text>
              <text x={12} y={lane.y + 57} class="lane-note">{t ? `priority ${t.priority}` : ""}</text>
            </g>
          );
        })}
        {drawing.edges.map((e) => {
          const back = e.x2 <= e.x1;
          const bend = back ? 70 : Math.max(24, (e.x2 - e.x1) / 2);
          return <path key={`${e.topic}>${e.to}`} class={cx("edge", near(e) && "near", drawing.places.get(e.to)?.module.last && "watched", marked !== null && !near(e) && "far", back && "back")} d={`M${e.x1} ${e.y1}C${e.x1 + bend} ${e.y1} ${e.x2 - bend} ${e.y2} ${e.x2} ${e.y2}`} />;
        })}
        {[...drawing.places.values()].map((p) => {
          const m = running.get(p.module.name);
          return (
            <g key={p.module.name} class={cx("node", marked === p.module.name && "marked", m && !m.running && "off", (m?.fault ?? 0) > 0 && "faulty")} transform={`translate(${p.x} ${p.y})`} onMouseEnter={() => setMarked(p.module.name)} onMouseLeave={() => setMarked(null)}>
              <title>{`${p.module.name}: ${m?.type ?? ""}${m && !m.running ? ", off" : ""}`}</title>
              <rect width={kNodeWidth} height={p.height} rx={5} />
              <text x={10} y={kHead / 2 + 5} class="node-name">{p.module.name}</text>
              <text x={kNodeWidth - 10} y={kHead / 2 + 5} class="node-share">{m && !m.running ? "off" : percent(rates?.share.get(`module:${p.module.name}`))}</text>
              {p.module.outputs.map((topic, i) => (
                <g key={topic} transform={`translate(0 ${kHead + i * kRow})`}>
                  <text x={10} y={kRow - 5} class="port">{topic.startsWith(`${p.module.name}.`) ? topic.slice(p.module.name.length + 1) : topic}</text>
                  <text x={kNodeWidth - 10} y={kRow - 5} class="port-rate">{rate(rates?.hz.get(`topic:${topic}`))}</text>
                  <circle cx={kNodeWidth} cy={kRow / 2} r={3} class="plug" />
                </g>
              ))}
            </g>
          );
        })}
      </svg>
    </div>
  );
}
