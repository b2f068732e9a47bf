// Recording: start, stop, the last seconds to a file; and the recorded runs of the machine's folder.

import { useState } from "preact/hooks";
import { bytes, clock, count } from "../format";
import type { PanelProps } from "../panels";
import type { Robot } from "../robot";
import { CommandButton, Empty, useWatch } from "../ui";
import { Runs } from "./runs";

interface Ended {
  path?: string;
  bytes?: number;
  not_replayable?: Record<string, unknown>;
}

export function RecordPanel({ robot }: PanelProps) {
  return (
    <div class="record">
      {robot.isPlayback.value ? <p class="muted">This is a recorded run: {robot.info.value.recording}</p> : <Recorder robot={robot} />}
      <Runs machine={robot.machine} />
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
