// The newest message of any topic, as a tree with units.

import { useEffect, useRef, useState } from "preact/hooks";
import { bytes, clock, duration, rate, unit, value } from "../format";
import { plotField } from "../page";
import type { PanelProps } from "../panels";
import type { Robot } from "../robot";
import { decode, nameOfValue, type Field, type Message, type Struct, type Value } from "../ros2msg";
import { Button, Choice, Empty, NoMessages, Tools } from "../ui";

const kRedrawMs = 100;

interface Newest {
  message: Message | null;
  time_ns: number;
  size: number;
  why: string;
}

export function MessagesPanel({ robot, tile, set }: PanelProps) {
  const [held, setHeld] = useState(false);
  useEffect(() => robot.socket.connect(), [robot]);
  const channels = robot.socket.channels.value;
  const topics = [...channels.keys()].map((t) => t.slice(1)).filter((t) => !t.endsWith("/jpeg")).sort();
  const wished = typeof tile.state.topic === "string" ? tile.state.topic : "";
  const usual = topics.find((t) => t === "filter.state") ?? topics.find((t) => !t.startsWith("sinew/")) ?? "";
  const topic = topics.includes(wished) ? wished : usual;
  return (
    <>
      <Tools>
        {topics.length > 0 && <Choice label="Topic" value={topic} options={topics.map((t) => [t, t] as const)} onChange={(t) => set({ topic: t })} />}
        {topics.length > 0 && <Button icon={held ? "play" : "pause"} label={held ? "Go on" : "Hold"} pressed={held} onClick={() => setHeld(!held)} />}
      </Tools>
      {topic ? <Newest_ key={topic} robot={robot} topic={topic} held={held} /> : <NoMessages robot={robot}>This robot has no topics.</NoMessages>}
    </>
  );
}

function Newest_({ robot, topic, held }: { robot: Robot; topic: string; held: boolean }) {
  const newest = useRef<Newest | null>(null);
  const times = useRef<number[]>([]);
  const [, redraw] = useState(0);
  const struct = robot.struct(`/${topic}`);
  const channel = robot.socket.channels.value.get(`/${topic}`);
  useEffect(() => {
    if (held) return;
    let payloadOf: (() => Newest) | null = null;
    const end = robot.subscribe(`/${topic}`, (payload, time_ns, c) => {
      times.current.push(time_ns);
      if (times.current.length > 400) times.current.splice(0, 200);
      payloadOf = () => {
        try {
          const message = c.encoding === "json" ? (JSON.parse(new TextDecoder().decode(payload)) as Message) : struct && typeof struct === "object" ? decode(struct, payload) : null;
          return { message, time_ns, size: payload.byteLength, why: typeof struct === "string" && c.encoding !== "json" ? struct : "" };
        } catch (e) {
          return { message: null, time_ns, size: payload.byteLength, why: (e as Error).message };
        }
      };
    });
    const timer = setInterval(() => {
      if (payloadOf) (newest.current = payloadOf()), (payloadOf = null);
      redraw((n) => n + 1);
    }, kRedrawMs);
    return () => {
      end();
      clearInterval(timer);
    };
  }, [robot, topic, held, struct]);
  const n = newest.current;
  const t = times.current;
  const span = t.length > 1 ? (t.at(-1)! - t[0]!) / 1e9 : 0;
  const now = robot.now_ns();
  const live = robot.ended.value === null && !robot.isPlayback.value && !robot.info.value.virtual_time;
  return (
    <div class="message">
      <p class="message-head num">
        <span>{channel?.schemaName.split("/").pop()}</span>
        {n && <span>at {clock(n.time_ns)}</span>}
        {n && live && now !== null && <span>age {duration(Math.max(0, now - n.time_ns))}</span>}
        {span > 0 && <span>{rate((t.length - 1) / span)}</span>}
        {n && <span>{bytes(n.size)}</span>}
      </p>
      {!n ? <Empty>No message yet.</Empty> : n.why ? <Empty title="This message cannot be shown">{n.why}</Empty> : n.message && (
        <table class="table message-tree"><tbody>
          {typeof struct === "object" && struct ? <Rows struct={struct} message={n.message} path="" depth={0} topic={topic} unitOf="" /> : <JsonRows value={n.message as unknown as Value} depth={0} />}
        </tbody></table>
      )}
    </div>
  );
}

const kShortArray = 6;

function Rows({ struct, message, path, depth, topic, unitOf }: { struct: Struct; message: Message; path: string; depth: number; topic: string; unitOf: string }) {
  return <>{struct.fields.map((f) => <FieldRows key={f.name} field={f} value={message[f.name]!} path={path + f.name} depth={depth} topic={topic} unitOf={f.unit || unitOf} />)}</>;
}

function FieldRows({ field, value: v, path, depth, topic, unitOf }: { field: Field; value: Value; path: string; depth: number; topic: string; unitOf: string }) {
  const [open, setOpen] = useState(depth < 2 && !(Array.isArray(v) && v.length > kShortArray));
  const pad = { paddingInlineStart: `${10 + depth * 16}px` };
  if (v instanceof Uint8Array)
    return <tr><td style={pad}>{field.name}</td><td class="num">{bytes(v.byteLength)}</td><td /><td class="muted doc">{field.doc}</td></tr>;
  const isList = Array.isArray(v);
  if (isList || (typeof v === "object" && v !== null)) {
    const summary = isList ? `${v.length} values` : "";
    return (
      <>
        <tr class="opens"><td style={pad}><button type="button" class="opener" aria-expanded={open} onClick={() => setOpen(!open)}>{field.name}</button></td><td class="muted num">{open ? "" : isList ? summary : short(v as Message)}</td><td class="unit">{unit(unitOf)}</td><td class="muted doc">{field.doc}</td></tr>
        {open && (isList
          ? v.slice(0, 256).map((x, i) => typeof field.type === "object"
            ? <FieldRows key={i} field={{ ...field, name: `[${i}]`, array: null, doc: "" }} value={x} path={`${path}[${i}]`} depth={depth + 1} topic={topic} unitOf={unitOf} />
            : <Leaf key={i} name={`[${i}]`} field={field} v={x} path={`${path}[${i}]`} pad={{ paddingInlineStart: `${10 + (depth + 1) * 16}px` }} topic={topic} u={unitOf} doc="" />)
          : typeof field.type === "object" && <Rows struct={field.type} message={v as Message} path={`${path}.`} depth={depth + 1} topic={topic} unitOf={unitOf} />)}
      </>
    );
  }
  return <Leaf name={field.name} field={field} v={v} path={path} pad={pad} topic={topic} u={unitOf} doc={field.doc} />;
}

function short(m: Message): string {
  const numbers = Object.values(m).filter((x) => typeof x === "number") as number[];
  return numbers.length && numbers.length <= 4 ? numbers.map((x) => value(x)).join("  ") : "";
}

function Leaf({ name, field, v, path, pad, topic, u, doc }: { name: string; field: Field; v: Value; path: string; pad: { paddingInlineStart: string }; topic: string; u: string; doc: string }) {
  const isNumber = typeof v === "number";
  const integer = typeof field.type === "string" && !field.type.startsWith("float");
  const named = isNumber ? nameOfValue(field, v) : "";
  const isTime = u === "ns" && isNumber && Math.abs(v) > 1e9;
  return (
    <tr>
      <td style={pad}>{name}</td>
      <td class="num r">{named ? <><b>{named}</b> <span class="muted">{value(v as number, true)}</span></> : isTime ? clock(v as number) : value(v as number | string | boolean, integer)}</td>
      <td class="unit">{isTime ? "" : unit(u)}</td>
      <td class="muted doc">{doc}{isNumber && <Button icon="plot" label={`Plot ${path}`} hideLabel kind="quiet" onClick={() => plotField(topic, path)} />}</td>
    </tr>
  );
}

function JsonRows({ value: v, depth, name }: { value: Value; depth: number; name?: string }) {
  const [open, setOpen] = useState(depth < 1);
  const pad = { paddingInlineStart: `${10 + Math.max(0, depth - 1) * 16}px` };
  const isTree = typeof v === "object" && v !== null;
  const entries: [string, Value][] = !isTree ? [] : Array.isArray(v) ? v.slice(0, 200).map((x, i) => [`[${i}]`, x]) : Object.entries(v as Message);
  return (
    <>
      {name !== undefined && (
        <tr class={isTree ? "opens" : ""}>
          <td style={pad}>{isTree ? <button type="button" class="opener" aria-expanded={open} onClick={() => setOpen(!open)}>{name}</button> : name}</td>
          <td class="num r">{isTree ? <span class="muted">{Array.isArray(v) ? `${v.length} values` : ""}</span> : value(v as number)}</td><td /><td />
        </tr>
      )}
      {open && entries.map(([k, x]) => <JsonRows key={k} name={k} value={x} depth={depth + 1} />)}
    </>
  );
}
