// The recorded runs of a machine's folder: downloaded, shown as robots, executed again, compared with each other.

import { useEffect, useRef, useState } from "preact/hooks";
import { get, post, Refusal, type ComparedRuns, type Job, type JobState, type Replayed, type Run } from "../api";
import { hidden } from "../browser";
import { bytes, clock, count, value } from "../format";
import type { Machine } from "../machine";
import * as page from "../page";
import { Badge, Button, CommandButton, cx, Icon, MachineContext } from "../ui";

const kListEachMs = 10_000;
const kJobEachMs = 500;
const kOpensForMs = 30_000; // a long file takes its time to stand up

/** What the list of runs is about just now, below the run that it is of. */
type Shown = { run: string; with?: string };

export function Runs({ machine }: { machine: Machine }) {
  const there = machine.info.value?.runs === true;
  const [runs, setRuns] = useState<Run[] | null>(null);
  const [why, setWhy] = useState("");
  const [shown, setShown] = useState<Shown | null>(null);
  const [chosen, setChosen] = useState<string[]>([]); // for a comparison, at most two
  const [opening, setOpening] = useState("");
  const say = (e: unknown) => setWhy(e instanceof Refusal ? e.message : "The monitor does not answer.");
  const ask = () => get<{ runs: Run[] }>(`${machine.base}/api/runs`, kOpensForMs).then((r) => setRuns(r.runs), say);
  useEffect(() => {
    if (!there) return;
    void ask();
    const timer = setInterval(() => !hidden.peek() && void ask(), kListEachMs);
    return () => clearInterval(timer);
  }, [machine, there]);

  /** False: refused, and `why` says so. */
  const command = async <T,>(run: string, request: string, body: object = {}, patience_ms?: number): Promise<T | null> => {
    setWhy("");
    if (!machine.token.peek()) return say(new Refusal(401, "denied", `This page only looks: this needs the token of the monitor of ${machine.name} (key symbol, top right).`)), null;
    try {
      return await post<T>(`${machine.base}/api/runs/${encodeURIComponent(run)}/${request}`, body, { token: machine.token.peek() }, patience_ms);
    } catch (e) {
      return say(e), null;
    }
  };
  const replay = async (r: Run) => {
    if (!(await command(r.name, "replay"))) return;
    setShown({ run: r.name });
    void ask();
  };
  const open = async (r: Run) => {
    setOpening(r.name);
    const robot = await command<{ robot: string }>(r.name, "open", {}, kOpensForMs);
    setOpening("");
    if (!robot) return;
    await machine.look();
    const id = machine.robots.peek().find((x) => x.name === robot.robot)?.id;
    if (id) page.show(id);
    void ask();
  };
  const close = async (r: Run) => {
    if (await command(r.name, "close")) void ask();
  };
  const compare = async () => {
    const [a, b] = chosen as [string, string];
    if (await command(a, "compare", { with: b })) setShown({ run: a, with: b });
  };
  const choose = (name: string) => setChosen(chosen.includes(name) ? chosen.filter((n) => n !== name) : [...chosen.slice(-1), name]);

  return (
    <MachineContext.Provider value={machine}>
      <section>
        <div class="section-head">
          <h3>Recorded runs{machine.address && ` of ${machine.address}`}</h3>
          <span class="space" />
          {there && <CommandButton label="Compare" disabled={chosen.length !== 2} title={chosen.length === 2 ? `A: ${chosen[0]}, B: ${chosen[1]}` : "Choose two runs"} onClick={() => void compare()} />}
          {there && <Button icon="reset" label="Look again" kind="quiet" hideLabel onClick={() => void ask()} />}
        </div>
        {why && <p class="warn-text" role="alert">{why}</p>}
        {!there ? <p class="muted">This monitor was started without a folder of runs.</p> : !runs ? <p class="muted">Asking …</p> : runs.length === 0 ? <p class="muted">None yet.</p> : (
          <table class="table runs">
            <thead><tr><th /><th>Run</th><th class="robot-cell">Robot</th><th class="r">Length</th><th class="r wide-cell">Size</th><th>Result</th><th /></tr></thead>
            <tbody>
              {runs.flatMap((r) => [
                <tr key={r.name}>
                  <td><input type="checkbox" aria-label={`Compare ${r.name}`} title="Choose two to compare them" checked={chosen.includes(r.name)} onChange={() => choose(r.name)} />{chosen.includes(r.name) && <b class="which">{"AB"[chosen.indexOf(r.name)]}</b>}</td>
                  <td class="num run-name">{r.name}</td>
                  <td class="robot-cell">{r.robot}</td>
                  <td class="r num">{clock(r.duration_s * 1e9)}</td>
                  <td class="r num wide-cell">{bytes(r.bytes)}</td>
                  <td class="results">
                    {r.verdict ? <Badge tone={/not|fail|crash|FAIL|lost|interrupted/.test(r.verdict) ? "warn" : "ok"}>{r.verdict}</Badge> : r.replay === "none" && <span class="muted">none said</span>}
                    {r.replay !== "none" && <button type="button" class="as-link" title="Of its replay; shows more" onClick={() => setShown(shown?.run === r.name && !shown.with ? null : { run: r.name })}><State state={r.replay} /></button>}
                  </td>
                  <td class="r run-buttons">
                    <CommandButton label="Replay" kind="quiet" title="Executes every recorded step again, and compares what comes out byte for byte" onClick={() => void replay(r)} />
                    {r.open ? <CommandButton label="Close" kind="quiet" title="The robot that shows this file ends" onClick={() => void close(r)} />
                      : <CommandButton label={opening === r.name ? "Opens …" : "Open"} kind="quiet" title="Stands up as a robot, which plays the file" disabled={opening !== ""} onClick={() => void open(r)} />}
                    <a class="button quiet only-icon" title={`Download ${r.name}.mcap`} aria-label={`Download ${r.name}`} href={`${machine.base}/api/runs/${encodeURIComponent(r.name)}/run.mcap`} download={`${r.name}.mcap`}><Icon name="save" /></a>
                  </td>
                </tr>,
                shown?.run === r.name && <tr key={`${r.name} result`} class="run-result"><td colSpan={7}>{shown.with ? <JobOf<ComparedRuns> key={`${r.name} ${shown.with}`} machine={machine} run={r.name} with={shown.with} what={`Comparison of A, ${r.name}, with B, ${shown.with}`} command={command} close={() => setShown(null)} done={ask}>{(c) => <Comparison c={c} />}</JobOf>
                  : <JobOf<Replayed> key={`${r.name} ${r.replay === "running"}`} machine={machine} run={r.name} what={`Replay of ${r.name}`} command={command} close={() => setShown(null)} done={ask}>{(x) => <Replay x={x} />}</JobOf>}</td></tr>,
              ])}
            </tbody>
          </table>
        )}
      </section>
    </MachineContext.Provider>
  );
}

function State({ state }: { state: JobState }) {
  if (state === "identical") return <Badge tone="ok">same bytes</Badge>;
  if (state === "differs") return <Badge tone="warn">differs</Badge>;
  if (state === "failed") return <Badge tone="bad">failed</Badge>;
  return <Badge tone="accent">{state === "running" ? "runs …" : state}</Badge>;
}

/** A job until it is over, and then what came of it. */
function JobOf<Result>({ machine, run, with: other, what, command, close, done, children }: {
  machine: Machine;
  run: string;
  with?: string;
  what: string;
  command: (run: string, request: string, body?: object) => Promise<unknown>;
  close: () => void;
  done: () => void;
  children: (result: Result) => preact.JSX.Element;
}) {
  const [job, setJob] = useState<Job<Result> | null>(null);
  const [why, setWhy] = useState("");
  const over = useRef(false);
  const url = `${machine.base}/api/runs/${encodeURIComponent(run)}/${other ? `compare?with=${encodeURIComponent(other)}` : "replay"}`;
  useEffect(() => {
    over.current = false;
    let timer: ReturnType<typeof setTimeout> | undefined;
    let ran = false;
    const ask = async () => {
      try {
        const now = await get<Job<Result>>(url);
        if (over.current) return;
        setJob(now);
        setWhy("");
        if (now.state === "running") ran = true;
        else return void (ran && done());
      } catch (e) {
        setWhy(e instanceof Refusal ? e.message : "The monitor does not answer.");
      }
      if (!over.current) timer = setTimeout(ask, kJobEachMs);
    };
    void ask();
    return () => {
      over.current = true;
      clearTimeout(timer);
    };
  }, [url]);
  return (
    <div class="job" role="status">
      <div class="section-head">
        <h4>{what}</h4>
        {job && job.state !== "done" && <State state={job.state} />}
        {job?.seconds !== undefined && <span class="muted num">{job.seconds.toFixed(1)} s</span>}
        <span class="space" />
        {job?.state === "running" && <CommandButton label="End it" onClick={() => void command(run, "stop", other ? { with: other } : {})} />}
        <Button icon="close" label="Close this result" hideLabel kind="quiet" onClick={close} />
      </div>
      {why && <p class="warn-text">{why}</p>}
      {job?.why && <p class="warn-text">{job.why}</p>}
      {job?.result && children(job.result)}
    </div>
  );
}

function at(seconds: number | undefined): string {
  return seconds === undefined ? "–" : `${seconds.toFixed(3)} s`;
}

function Replay({ x }: { x: Replayed }) {
  const d = x.first_difference;
  const apart = (x.compared ?? []).filter((q) => q.max > 0 || q.one_sided > 0).slice(0, 20);
  const stopped = Object.entries(x.modules).filter(([, m]) => m.stopped);
  return (
    <>
      <p>
        {x.identical ? <>All <b class="num">{count(x.messages)}</b> messages of <b class="num">{count(x.steps)}</b> steps are the same bytes.</> : <><b class="num">{count(x.steps)}</b> steps were executed again; they do not give the same bytes.</>}
        {x.robot_s !== undefined && x.wall_s ? <span class="muted"> {(x.robot_s / x.wall_s).toFixed(1)} times real time.</span> : null}
      </p>
      {d && <p class="warn-text">First difference: module {d.module}, step {count(d.step)}, at {at(d.time_s)}: {d.what}{d.recorded !== undefined && <span class="num"> (recorded {String(d.recorded)}, now {String(d.now)})</span>}</p>}
      {stopped.length > 0 && <ul class="remarks">{stopped.map(([name, m]) => <li key={name}>{name}: {m.stopped}</li>)}</ul>}
      {apart.length > 0 && <Apart rows={apart} />}
    </>
  );
}

function Comparison({ c }: { c: ComparedRuns }) {
  return (
    <>
      <dl class="compared">
        <dt>A</dt><dd>{c.a.result || "no result"}</dd>
        <dt>B</dt><dd>{c.b.result || "no result"}</dd>
      </dl>
      <p class="muted">Times are from "{c.from_event}".</p>
      {c.events.length > 0 && (
        <table class="table">
          <thead><tr><th>Event</th><th class="r">A</th><th class="r">B</th><th class="r">B − A</th></tr></thead>
          <tbody>
            {c.events.map((e, i) => <tr key={i}><td>{e.text}</td><td class="r num">{at(e.a_s ?? undefined)}</td><td class="r num">{at(e.b_s ?? undefined)}</td><td class="r num">{e.a_s !== null && e.b_s !== null ? at(e.b_s - e.a_s) : ""}</td></tr>)}
          </tbody>
        </table>
      )}
      {c.fields.length > 0 && <Apart rows={c.fields} />}
    </>
  );
}

function Apart({ rows }: { rows: { name: string; unit: string; messages: number; rms: number; max: number; max_at_s?: number }[] }) {
  return (
    <table class="table">
      <thead><tr><th>Field</th><th class="r">RMS apart</th><th class="r">Most</th><th>Unit</th><th class="r">At</th><th class="r wide-cell">Messages</th></tr></thead>
      <tbody>
        {rows.map((q) => (
          <tr key={q.name}>
            <td>{q.name}</td>
            <td class="r num">{value(q.rms)}</td>
            <td class={cx("r num", q.max > 0 && "strong-text")}>{value(q.max)}</td>
            <td class="unit">{q.unit}</td>
            <td class="r num">{at(q.max_at_s)}</td>
            <td class="r num wide-cell">{count(q.messages)}</td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}
