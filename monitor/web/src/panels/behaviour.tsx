// What a robot's behaviour does, and why: the active options from the root on with their last seconds, the states of each
// as a drawing, the decisions with the values that they read; and, with the token, a state to be held.

import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { brief, heldBy, History, kNodeHeight, momentOf, planFor, planOf, stateDrawingOf, type Active, type Moment, type Plan, type Span } from "../behaviour";
import type { PanelProps } from "../panels";
import type { Robot } from "../robot";
import { decode } from "../ros2msg";
import { Badge, Button, Choice, CommandButton, cx, Empty, NoMessages, Segments, Tools, useSize, useWatch } from "../ui";

const kRedraw_ms = 100;
const kSeries = 8;

const ofType = (robot: Robot, type: string) => [...robot.socket.channels.value].filter(([, c]) => c.schemaName.split("/").pop() === type).map(([topic]) => topic).sort();

export function BehaviourPanel({ robot, tile, set }: PanelProps) {
  useEffect(() => robot.socket.connect(), [robot]);
  useWatch(robot, "topics", 10_000);
  const [frozen, setFrozen] = useState(false);
  const topics = ofType(robot, "BehaviourState");
  const topic = topics.find((t) => t === tile.state.topic) ?? topics[0];
  const writer = robot.topics.value?.find((t) => `/${t.name}` === topic)?.writer ?? "";
  const all = tile.state.shows === "all";
  const seconds = tile.state.seconds === "30" || tile.state.seconds === "120" ? tile.state.seconds : "10";
  return (
    <>
      <Tools>
        {topics.length > 1 && <Choice label="Behaviour" value={topic!} options={topics.map((t) => [t, t.slice(1)] as const)} onChange={(t) => set({ topic: t })} />}
        {topic && <Segments label="Options" value={all ? "all" : "active"} options={[["active", "Active"], ["all", "All"]]} onChange={(shows) => set({ shows })} />}
        {topic && <Choice label="Seconds of the strip" value={seconds} options={[["10", "10 s"], ["30", "30 s"], ["120", "2 min"]] as const} onChange={(s) => set({ seconds: s })} />}
        {topic && <Button icon={frozen ? "play" : "pause"} label={frozen ? "Go on" : "Freeze"} pressed={frozen} onClick={() => setFrozen(!frozen)} />}
      </Tools>
      {topic ? <Behaviour key={topic} robot={robot} topic={topic} writer={writer} all={all} seconds={Number(seconds)} frozen={frozen} /> : <NoMessages robot={robot}>This robot has no behaviour: none of its topics is a BehaviourState.</NoMessages>}
    </>
  );
}

function useMoments(robot: Robot, topic: string, writer: string, frozen: boolean): { history: History; plan: Plan | null; why: string } {
  const history = useRef(new History());
  const plans = useRef(new Map<string, Plan>());
  const why = useRef("");
  const [, redraw] = useState(0);
  const struct = robot.struct(topic);
  const written = robot.topics.value?.filter((t) => t.type === "BehaviourPlan" && t.writer === writer).map((t) => `/${t.name}`) ?? [];
  const planTopics = written.filter((t) => robot.socket.channels.value.has(t)).join();
  useEffect(() => {
    const ends = planTopics.split(",").filter(Boolean).map((t) => robot.subscribe(t, (payload) => {
      const layout = robot.struct(t);
      if (layout && typeof layout === "object") plans.current.set(t, planOf(decode(layout, payload)));
    }));
    return () => ends.forEach((end) => end());
  }, [robot, planTopics]);
  useEffect(() => {
    if (frozen) return;
    let news = true;
    const end = robot.subscribe(topic, (payload) => {
      news = true;
      try {
        if (struct && typeof struct === "object") history.current.take(momentOf(decode(struct, payload)));
        why.current = typeof struct === "string" ? struct : "";
      } catch (e) {
        why.current = (e as Error).message;
      }
    });
    const timer = setInterval(() => {
      if (news) redraw((n) => n + 1);
      news = false;
    }, kRedraw_ms);
    return () => {
      end();
      clearInterval(timer);
    };
  }, [robot, topic, struct, frozen]);
  const newest = history.current.newest;
  const plan = newest ? planFor(plans.current.values(), newest) : null;
  return { history: history.current, plan, why: why.current };
}

function Behaviour({ robot, topic, writer, all, seconds, frozen }: { robot: Robot; topic: string; writer: string; all: boolean; seconds: number; frozen: boolean }) {
  useWatch(robot, "params", 1000);
  const { history, plan, why } = useMoments(robot, topic, writer, frozen);
  const [picked, setPicked] = useState<number | null>(null); // a state's place in the plan
  const moment = history.newest;
  if (why) return <Empty title="This message cannot be shown">{why}</Empty>;
  if (!moment || moment.active.length === 0) return <Empty>No message of {topic.slice(1)} yet.</Empty>;
  const param = plan?.force ? robot.params.value?.find((p) => p.module === writer && p.param === plan.force) : undefined;
  const held = plan && param ? heldBy(plan, param.value) : null;
  const mayHold = Boolean(param) && !robot.isPlayback.value && robot.ended.value === null;
  const hold = async (number: number) => {
    if (!param) return;
    const reply = await robot.command("param.set", { module: writer, param: param.param, value: number });
    if (!reply) return;
    setPicked(null);
    robot.params.value = (robot.params.peek() ?? []).map((q) => (q.module === writer && q.param === param.param ? { ...q, value: number } : q));
  };
  const options = plan ? (all ? plan.options.map((o) => o.name) : moment.active.map((a) => a.option)) : [];
  const place = picked !== null && plan ? plan.states[picked] : undefined;
  return (
    <div class="behaviour">
      {held && (
        <p class="behaviour-held" role="status">
          <span><Badge tone="warn">held</Badge> <strong>{held.option} / {held.state}</strong> <span class="muted">by {writer}.{param!.param}{moment.active.some((a) => a.forced) ? ": its decisions are not asked" : ": as soon as this option is active"}</span></span>
          {mayHold && <CommandButton label="Release" kind="strong" onClick={() => void hold(0)} />}
        </p>
      )}
      <Path history={history} moment={moment} plan={plan} seconds={seconds} />
      {!plan && <p class="muted behaviour-note">The robot does not publish the plan of this behaviour (BehaviourPlan), so that its states cannot be drawn.</p>}
      <div class="behaviour-options">
        {plan && options.map((name, i) => {
          const depth = moment.active.findIndex((a) => a.option === name);
          return <OptionCard key={`${name}${all ? "" : i}`} plan={plan} name={name} active={depth < 0 ? null : moment.active[depth]!} span={depth < 0 ? null : history.last(depth)} now_ns={moment.stamp_ns} held={held} picked={picked} onPick={mayHold ? setPicked : null} />;
        })}
        {!plan && moment.active.map((a) => <section key={a.option} class="behaviour-option active"><h3>{a.option}</h3><p class="behaviour-reads">{a.reads.map((r, i) => <ReadChip key={i} name={r.name} value={r.value} />)}</p></section>)}
      </div>
      {mayHold && (
        <p class="behaviour-pick">
          {place ? (
            <>
              <span>Hold <strong>{plan!.options[place.option]!.name} / {place.name}</strong>: its decisions are not asked until it is released.</span>
              <CommandButton label="Hold" kind="strong" onClick={() => void hold(picked! + 1)} />
              <Button label="Cancel" kind="quiet" onClick={() => setPicked(null)} />
            </>
          ) : <span class="muted">To test a situation, choose a state in a drawing: it can be held.</span>}
        </p>
      )}
    </div>
  );
}

const sec = (ns: number) => {
  const s = Math.max(0, ns / 1e9);
  return s < 9.95 ? `${s.toFixed(1)} s` : s < 60 ? `${s.toFixed(0)} s` : `${Math.floor(s / 60)}:${String(Math.floor(s % 60)).padStart(2, "0")}`;
};

function ReadChip({ name, value }: { name: string; value: number }) {
  return <span class="behaviour-read num"><span class="muted">{name}</span> {brief(value)}</span>;
}

/** The active options, each below the one that runs it, with its last seconds beside it. */
function Path({ history, moment, plan, seconds }: { history: History; moment: Moment; plan: Plan | null; seconds: number }) {
  const [box, size] = useSize<HTMLDivElement>();
  const depths = Math.max(moment.active.length, ...history.rows.map((row, d) => (row.some((s) => s.end_ns > moment.stamp_ns - seconds * 1e9) ? d + 1 : 0)));
  return (
    <div class="behaviour-path" role="table" aria-label="Active options">
      {Array.from({ length: depths }, (_, depth) => {
        const a = moment.active[depth];
        const option = plan?.options.find((o) => o.name === a?.option);
        return (
          <div key={depth} class={cx("behaviour-row", !a && "idle")} role="row">
            <div class="behaviour-who" role="cell" style={{ paddingInlineStart: `${8 + depth * 16}px` }}>
              {depth > 0 && <span class="behaviour-branch" aria-hidden="true" />}
              {a ? (
                <>
                  <strong>{a.option}</strong>
                  {option?.parameters.map((name, i) => <ReadChip key={name} name={name} value={a.parameters[i]!} />)}
                  <Badge tone={a.forced ? "warn" : "accent"}>{a.state}</Badge>
                  <span class="muted num">{sec(moment.stamp_ns - a.state_entered_ns)}</span>
                  {a.state_entered_ns !== a.entered_ns && <span class="muted num behaviour-since" title="how long the option is active">of {sec(moment.stamp_ns - a.entered_ns)}</span>}
                </>
              ) : <span class="muted">–</span>}
            </div>
            <div class="behaviour-strip" role="cell" ref={depth === 0 ? box : undefined}>
              <Strip row={history.rows[depth] ?? []} plan={plan} now_ns={moment.stamp_ns} seconds={seconds} width={size.width} />
            </div>
          </div>
        );
      })}
      <div class="behaviour-row axis" aria-hidden="true">
        <div class="behaviour-who" />
        <div class="behaviour-strip"><Axis seconds={seconds} width={size.width} /></div>
      </div>
    </div>
  );
}

function colourOf(plan: Plan | null, span: Span): string {
  const option = plan?.options.find((o) => o.name === span.option);
  const at = option ? option.states.findIndex((s) => plan!.states[s]!.name === span.state) : 0;
  return `var(--series-${(Math.max(at, 0) % kSeries) + 1})`;
}

const kStrip = 20;

function Strip({ row, plan, now_ns, seconds, width }: { row: Span[]; plan: Plan | null; now_ns: number; seconds: number; width: number }) {
  const begin_ns = now_ns - seconds * 1e9;
  const x = (ns: number) => ((Math.max(ns, begin_ns) - begin_ns) / (seconds * 1e9)) * width;
  return (
    <svg width={width} height={kStrip} role="img" aria-label="the last seconds">
      {row.filter((s) => s.end_ns > begin_ns).map((s) => {
        const left = x(s.begin_ns), wide = Math.max(1.5, x(s.end_ns) - left - 1);
        const room = Math.floor((wide - 8) / 6.4);
        return (
          <g key={s.begin_ns}>
            <title>{`${s.option} / ${s.state}, ${sec(s.end_ns - s.begin_ns)}${s.decision ? `\nby ${s.decision}${s.left ? ` from ${s.left}` : ""}${s.reads.length ? `: ${s.reads.map((r) => `${r.name} ${brief(r.value)}`).join(", ")}` : ""}` : ""}`}</title>
            <rect x={left} y={1} width={wide} height={kStrip - 2} rx={Math.min(3, wide / 2)} style={{ fill: colourOf(plan, s) }} class={cx(s.forced && "forced")} />
            {room >= Math.min(s.state.length, 4) && <text x={left + 5} y={kStrip / 2 + 4}>{s.state.length <= room ? s.state : `${s.state.slice(0, room - 1)}…`}</text>}
          </g>
        );
      })}
    </svg>
  );
}

function Axis({ seconds, width }: { seconds: number; width: number }) {
  const step = seconds <= 10 ? 2 : seconds <= 30 ? 5 : 20;
  const marks = Array.from({ length: Math.floor(seconds / step) }, (_, i) => i * step);
  return (
    <svg width={width} height={14}>
      {marks.map((s) => <text key={s} x={width - (s / seconds) * width - (s === 0 ? 2 : 0)} y={11} class="behaviour-tick" style={{ textAnchor: s === 0 ? "end" : "middle" }}>{s === 0 ? "now" : `−${s} s`}</text>)}
    </svg>
  );
}

/** One option: its states as a drawing, and the decisions of the active one with what they read. */
function OptionCard({ plan, name, active, span, now_ns, held, picked, onPick }: {
  plan: Plan; name: string; active: Active | null; span: Span | null; now_ns: number; held: { option: string; state: string } | null; picked: number | null; onPick: ((place: number) => void) | null;
}) {
  const at = plan.options.findIndex((o) => o.name === name);
  const option = plan.options[at]!;
  const drawing = useMemo(() => stateDrawingOf(plan, option), [JSON.stringify(option), plan.states.length]);
  const isAt = (place: number | null) => active !== null && place !== null && plan.states[place]!.name === active.state;
  const here = option.states.find((s) => isAt(s)) ?? null;
  const isLast = (a: { from: number | null; decisions: number[] }) => active !== null && span !== null && span.by !== null && a.decisions.includes(span.by);
  const decisions = here === null ? [] : option.decisions.map((d) => ({ place: d, ...plan.decisions[d]! })).filter((d) => d.from === here || (d.from === null && d.to !== here));
  return (
    <section class={cx("behaviour-option", active && "active", active?.forced && "forced")} aria-label={`Option ${name}`}>
      <h3>
        {name}
        {active?.forced && <Badge tone="warn">held</Badge>}
        {active?.done && <Badge tone="ok">done</Badge>}
        {!active && <span class="muted">not active</span>}
      </h3>
      <svg class="behaviour-graph" viewBox={`${drawing.left} 0 ${drawing.width} ${drawing.height}`} style={{ maxWidth: `${drawing.width}px` }} role="group" aria-label={`States of ${name}`}>
        <defs>
          {["arrow", "arrow-out", "arrow-last"].map((id) => (
            <marker key={id} id={`behaviour-${id}`} viewBox="0 0 8 8" refX={7} refY={4} markerWidth={7} markerHeight={7} markerUnits="userSpaceOnUse" orient="auto-start-reverse"><path d="M0 0.500L8 4L0 7.500z" class={id} /></marker>
          ))}
        </defs>
        {[false, true].map((front) => drawing.arrows.map((a) => {
          const last = isLast(a), out = isAt(a.from) || (a.from === null && active !== null && !isAt(a.to));
          if (front !== (last || out)) return null;
          return (
            <g key={`${a.from}>${a.to}`} class={cx("behaviour-arrow", a.crowded && "crowded", last ? "last" : out && "out")}>
              <title>{a.label}</title>
              <path d={a.path} marker-end={`url(#behaviour-arrow${last ? "-last" : out ? "-out" : ""})`} class={cx(a.from === null && "any")} />
              <text x={a.at.x} y={a.at.y} text-anchor={a.at.anchor}>{a.label}</text>
            </g>
          );
        }))}
        {drawing.nodes.map((n) => {
          const state = plan.states[n.place]!;
          const isHeld = held?.option === name && held.state === state.name;
          const pick = onPick ? () => onPick(n.place) : undefined;
          return (
            <g key={n.place} class={cx("behaviour-state", isAt(n.place) && "active", isHeld && "held", picked === n.place && "picked", pick && "may")} transform={`translate(${n.x} ${n.y})`} onClick={pick}
              role={pick ? "button" : undefined} tabIndex={pick ? 0 : undefined} aria-label={pick ? `Hold ${name} / ${state.name}` : undefined} aria-current={isAt(n.place) ? "step" : undefined}
              onKeyDown={(e) => pick && (e.key === "Enter" || e.key === " ") && (e.preventDefault(), pick())}>
              <title>{`${state.name}${state.calls === null ? "" : `, runs ${plan.options[state.calls]!.name}`}${state.final ? ", final" : ""}${isHeld ? ", held" : ""}`}</title>
              <rect width={n.width} height={kNodeHeight} rx={7} />
              {state.final && <rect x={3} y={3} width={n.width - 6} height={kNodeHeight - 6} rx={5} class="inside" />}
              <text x={n.width / 2 - (state.calls === null ? 0 : 5)} y={kNodeHeight / 2 + 4}>{state.name}</text>
              {state.calls !== null && <path d={`M${n.width - 14} ${kNodeHeight / 2 - 4}l4 4l-4 4`} class="runs" />}
            </g>
          );
        })}
      </svg>
      {active && (
        <table class="behaviour-decisions">
          <tbody>
            {active.forced && <tr><td colSpan={2} class="warn-text">Held: its decisions are not asked.</td></tr>}
            {!active.forced && decisions.map((d) => {
              const reads = active.reads.filter((r) => r.decision === d.place);
              return (
                <tr key={d.place}>
                  <td><strong>{d.name}</strong> <span class="muted">→ {plan.states[d.to]!.name}</span></td>
                  <td class="behaviour-reads">{reads.map((r, i) => <ReadChip key={i} name={r.name} value={r.value} />)}</td>
                </tr>
              );
            })}
            {!active.forced && decisions.length === 0 && <tr><td colSpan={2} class="muted">No decision leads out of {active.state}.</td></tr>}
          </tbody>
        </table>
      )}
      {active && span?.decision && (
        <p class="behaviour-came num"><span class="muted">{sec(now_ns - span.begin_ns)} ago by</span> <strong>{span.decision}</strong>{span.left && <span class="muted"> from {span.left}</span>} {span.reads.map((r, i) => <ReadChip key={i} name={r.name} value={r.value} />)}</p>
      )}
    </section>
  );
}
