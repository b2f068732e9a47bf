// Recording: start, stop, the last seconds to a file; and the recorded runs of the monitor's folder.

import { useEffect, useState } from "preact/hooks";
import { get, Refusal, type Run } from "../api";
import { bytes, clock, count } from "../format";
import { info } from "../monitor";
import type { PanelProps } from "../panels";
import type { Robot } from "../robot";
import { Badge, Button, CommandButton, Empty, useWatch } from "../ui";

interface Ended {
  path?: string;
  bytes?: number;
  not_replayable?: Record<string, unknown>;
}

export function RecordPanel({ robot }: PanelProps) {
  return (
    <div class="record">
      {robot.isPlayback.value ? <p class="muted">This is a recorded run: {robot.info.value.recording}</p> : <Recorder robot={robot} />}
      <Runs />
    </div>
  );
}

function Recorder({ robot }: { robot: Robot }) {
  useWatch(robot, "record.status", 1000);
  const [last, setLast] = useState<string | null>(null);
  const state = robot.record.value;
  const why = robot.failures.value.get("record.status");
  if (!state) return <Empty title={why ? "No recorder" : undefined as never}>{why ?? "Asking for the recorder …"}</Empty>;
  const now = state.recording, ring = state.ring;
  const lost = now ? [sum(now.lost_messages), sum(now.lost_steps)] : [0, 0];
  return (
    <section>
      <div class="recorder">
        <span class={`lamp ${now ? "on" : ""}`} aria-hidden="true" />
        <div class="state">
          <strong>{now ? "Records" : "Does not record"}</strong>
          <span class="muted num">{now ? `${clock(now.seconds * 1e9)}, ${bytes(now.bytes)}${now.files > 1 ? ` in ${now.files} files` : ""}` : "the robot runs on without a file"}</span>
        </div>
        <span class="space" />
        {now ? (
          <CommandButton label="Stop" kind="strong" onClick={() => void robot.command<Ended>("record.stop").then((r) => r && setLast(verdictOf(r)))} />
        ) : (
          <CommandButton label="Record" kind="strong" onClick={() => void robot.command<Ended>("record.start").then((r) => r && setLast(`Records to ${r.path}`))} />
        )}
        <CommandButton label="Snapshot" disabled={!ring} title={ring ? "The last seconds of the flight ring to a file" : "This robot has no flight ring ([record] in its robot file)"} onClick={() => void robot.command<Ended>("record.snapshot").then((r) => r && setLast(`Snapshot: ${r.path}, ${bytes(r.bytes)}`))} />
      </div>
      {now && <p class="path">{now.path}</p>}
      {lost[0]! + lost[1]! > 0 && <p class="warn-text">Lost: {count(lost[0])} messages, {count(lost[1])} steps</p>}
      {last && <p role="status">{last}</p>}
      {ring && (
        <>
          <h3>Flight ring</h3>
          <p class="num">{clock(ring.seconds * 1e9)} in {bytes(ring.bytes)} of {bytes(ring.room_bytes)}</p>
          {ring.dumps.length > 0 && (
            <table class="table">
              <thead><tr><th>Why</th><th class="r">At</th><th class="r">Size</th><th>File</th></tr></thead>
              <tbody>{ring.dumps.map((d) => <tr key={d.path}><td>{d.reason}</td><td class="r num">{clock(d.at_s * 1e9)}</td><td class="r num">{bytes(d.bytes)}</td><td class="path">{d.error ?? d.path}</td></tr>)}</tbody>
            </table>
          )}
        </>
      )}
    </section>
  );
}

function sum(lost: unknown): number {
  if (typeof lost === "number") return lost;
  if (typeof lost !== "object" || lost === null) return 0;
  return Object.values(lost).reduce((a: number, b) => a + Number(b), 0);
}

function verdictOf(r: Ended): string {
  const not = Object.keys(r.not_replayable ?? {}).length;
  return `Recorded ${r.path}, ${bytes(r.bytes)}; ${not === 0 ? "every module can be replayed" : `${not} modules cannot be replayed`}`;
}

function Runs() {
  const [runs, setRuns] = useState<Run[] | null>(null);
  const [why, setWhy] = useState("");
  const there = info.value?.runs === true;
  const ask = () => {
    get<{ runs: Run[] }>("/api/runs").then((r) => (setRuns(r.runs), setWhy("")), (e: Error) => setWhy(e instanceof Refusal ? e.message : "The monitor does not answer."));
  };
  useEffect(() => {
    if (!there) return;
    ask();
    const timer = setInterval(() => document.visibilityState === "visible" && ask(), 10_000);
    return () => clearInterval(timer);
  }, [there]);
  return (
    <section>
      <div class="section-head"><h3>Recorded runs</h3><span class="space" />{there && <Button icon="reset" label="Look again" kind="quiet" hideLabel onClick={ask} />}</div>
      {!there ? <p class="muted">This monitor was started without a folder of runs.</p> : why ? <p class="muted">{why}</p> : !runs ? <p class="muted">Asking …</p> : runs.length === 0 ? <p class="muted">None yet.</p> : (
        <table class="table runs">
          <thead><tr><th>Run</th><th>Robot</th><th class="r">Length</th><th class="r">Size</th><th>Result</th><th /></tr></thead>
          <tbody>
            {runs.map((r) => (
              <tr key={r.name}>
                <td class="num">{r.name}</td>
                <td>{r.robot}</td>
                <td class="r num">{clock(r.duration_s * 1e9)}</td>
                <td class="r num">{bytes(r.bytes)}</td>
                <td>{r.verdict ? <Badge tone={/not|fail|crash|FAIL|lost|interrupted/.test(r.verdict) ? "warn" : "ok"}>{r.verdict}</Badge> : <span class="muted">none said</span>}</td>
                <td class="r"><a class="button quiet" href={`/api/runs/${encodeURIComponent(r.name)}/run.mcap`} download={`${r.name}.mcap`}>Download</a></td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
    </section>
  );
}
