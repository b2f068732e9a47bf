// Whether the robot may move, what its failsafes say, what its devices complain about; arm, disarm, stop.

import { useEffect, useState } from "preact/hooks";
import { get, Refusal, type DoctorSays, type Guardian, type Status } from "../api";
import { hidden } from "../browser";
import { clock, count, duration, value } from "../format";
import type { Machine } from "../machine";
import type { PanelProps } from "../panels";
import type { Robot } from "../robot";
import { Asked, Badge, Button, CommandButton, cx, useWatch } from "../ui";

export function HealthPanel({ robot }: PanelProps) {
  useWatch(robot, "status", 250);
  return (
    <Asked robot={robot} request="status" there={robot.status.value !== null}>
      <Health robot={robot} status={robot.status.value!} />
    </Asked>
  );
}

function complaintsOf(status: Status): string[] {
  const d = status.devices;
  const text = typeof d === "string" ? d : Array.isArray(d) ? d.join("\n") : (d?.complaints ?? "");
  return String(text).split("\n").filter((line) => line.trim());
}

function Health({ robot, status }: { robot: Robot; status: Status }) {
  const g = status.guardian;
  const complaints = complaintsOf(status);
  const stopped = status.modules.filter((m) => !m.running);
  const faulty = status.modules.filter((m) => m.running && m.fault > 0);
  return (
    <div class="health">
      {g ? <Permission robot={robot} g={g} /> : <p class="muted">This robot has no actuators, so nothing has to be permitted.</p>}
      {g && <Failsafes robot={robot} g={g} />}
      {(stopped.length > 0 || faulty.length > 0) && (
        <section>
          <h3>Modules</h3>
          <ul class="remarks">
            {stopped.map((m) => <li key={m.name} class="warn-text">{m.name} is off{m.fault > 0 ? ` after ${count(m.fault)} faults` : ""}</li>)}
            {faulty.map((m) => <li key={m.name}>{m.name}: {count(m.fault)} faults, runs</li>)}
          </ul>
        </section>
      )}
      <section>
        <h3>Devices</h3>
        {complaints.length ? <ul class="remarks">{complaints.map((c) => <li key={c} class="warn-text">{c}</li>)}</ul> : <p class="muted">{status.devices === undefined ? "No real devices, and no simulator that reports for them." : "No complaints."}</p>}
      </section>
      {status.chains.length > 0 && (
        <section>
          <h3>Ages, from measurement to actuator</h3>
          <table class="table chains">
            <thead><tr><th>Chain</th><th class="r">p50</th><th class="r">p99</th><th class="r">max</th><th class="r">Budget</th><th class="r">Missed</th></tr></thead>
            <tbody>
              {status.chains.map((c) => (
                <tr key={c.name}>
                  <td>{c.name}</td>
                  <td class="r num">{c.age.count ? duration(c.age.p50_ns) : "–"}</td>
                  <td class="r num">{c.age.count ? duration(c.age.p99_ns) : "–"}</td>
                  <td class="r num">{c.age.count ? duration(c.age.max_ns) : "–"}</td>
                  <td class="r num muted">{c.budget_ns ? duration(c.budget_ns) : "none"}</td>
                  <td class={cx("r num", c.budget_misses > 0 && "bad-text")}>{count(c.budget_misses)}</td>
                </tr>
              ))}
            </tbody>
          </table>
        </section>
      )}
      <section>
        <h3>What happened</h3>
        {robot.events.value.length === 0 ? <p class="muted">Nothing since this page looks.</p> : (
          <ol class="events">{robot.events.value.map((e, i) => <li key={`${e.at_ns}${e.text}${i}`} class={cx(e.grave && "warn-text")}><span class="num muted">{clock(e.at_ns)}</span> {e.text}</li>)}</ol>
        )}
      </section>
      <Outsiders status={status} />
      {!robot.isPlayback.value && <Doctor machine={robot.machine} />}
    </div>
  );
}

const kDoctorEachMs = 30_000;

/** What `sinew doctor` says of the robot's machine. */
function Doctor({ machine }: { machine: Machine }) {
  const [said, setSaid] = useState<DoctorSays | null>(null);
  const [why, setWhy] = useState("");
  useEffect(() => {
    let over = false;
    const ask = () => get<DoctorSays>(`${machine.base}/api/doctor`, 15_000).then((s) => !over && (setSaid(s), setWhy("")), (e: Error) => !over && setWhy(e instanceof Refusal ? e.message : "The monitor does not answer."));
    void ask();
    const timer = setInterval(() => !hidden.peek() && void ask(), kDoctorEachMs);
    return () => {
      over = true;
      clearInterval(timer);
    };
  }, [machine]);
  const rank = { problem: 0, warning: 1, unknown: 2, ok: 3 };
  const checks = [...(said?.checks ?? [])].sort((a, b) => rank[a.state] - rank[b.state]);
  const ailing = checks.filter((c) => c.state === "problem" || c.state === "warning");
  const rest = checks.filter((c) => !ailing.includes(c));
  return (
    <section class="doctor">
      <h3>The machine, as sinew doctor sees it</h3>
      {why && <p class="muted">{why}</p>}
      {!said && !why && <p class="muted">Asking …</p>}
      {said && ailing.length === 0 && <p><Badge tone="ok">good</Badge> {checks.length} checks found nothing that spoils its timing.</p>}
      {ailing.length > 0 && <Checks list={ailing} />}
      {rest.length > 0 && (
        <details>
          <summary>{rest.length} {rest.length === 1 ? "check" : "checks"} without a finding</summary>
          <Checks list={rest} />
        </details>
      )}
    </section>
  );
}

function Checks({ list }: { list: DoctorSays["checks"] }) {
  const tone = { problem: "bad", warning: "warn", unknown: "muted", ok: "ok" } as const;
  return (
    <ul class="checks">
      {list.map((c) => (
        <li key={c.id}>
          <Badge tone={tone[c.state]}>{c.state}</Badge>
          <div><b>{c.id}</b> {c.seen}{c.advice && <p class="muted">{c.advice}</p>}</div>
        </li>
      ))}
    </ul>
  );
}

export function modeOf(g: Guardian): string {
  return typeof g.mode === "number" ? (["standby", "armed", "active", "safe action"][g.mode] ?? String(g.mode)) : g.mode;
}

function Permission({ robot, g }: { robot: Robot; g: Guardian }) {
  const [asking, setAsking] = useState(false);
  const armed = g.permitted !== 0;
  const reasons = g.reasons ?? [];
  return (
    <section class={cx("permission", armed && "armed")}>
      <div class="state">
        <strong>{armed ? "Armed" : "Not armed"}</strong>
        <span class="muted">{armed ? `commands pass; guardian: ${modeOf(g)}` : g.ready ? "ready: arming would be granted" : "arming would be refused"}</span>
      </div>
      {!armed && reasons.length > 0 && <ul class="remarks">{reasons.map((r) => <li key={r}>{r}</li>)}</ul>}
      {!robot.isPlayback.value && robot.ended.value === null && (
        <>
          <div class="commands">
            <CommandButton label="Arm" disabled={armed} onClick={() => void robot.command("arm")} />
            <CommandButton label="Disarm" disabled={!armed} onClick={() => void robot.command("disarm")} />
            <CommandButton label="Emergency stop" kind="danger" title="Disarms: the guardian brings every actuator to its safe action at once" onClick={() => void robot.command("disarm")} />
            {asking ? (
              <>
                <CommandButton label={`End the run of ${robot.label}`} kind="danger" onClick={() => (setAsking(false), void robot.command("stop"))} />
                <Button label="No" onClick={() => setAsking(false)} />
              </>
            ) : <Button label="End the run …" kind="quiet" onClick={() => setAsking(true)} />}
          </div>
          <p class="muted small">Emergency stop disarms. It is a convenience and no safety function: it needs this browser, the network and the monitor. Keep a real emergency stop at hand.</p>
        </>
      )}
    </section>
  );
}

function Failsafes({ robot, g }: { robot: Robot; g: Guardian }) {
  const names = robot.info.value.failsafes ?? [];
  if (names.length === 0) return <section><h3>Failsafes</h3><p class="muted">The robot file has none.</p></section>;
  return (
    <section>
      <h3>Failsafes</h3>
      <table class="table">
        <thead><tr><th>Name</th><th>State</th><th class="r">Measured</th></tr></thead>
        <tbody>
          {names.map((name, i) => {
            const bit = 1 << i;
            const m = g.measured?.[i];
            const state = (g.latched & bit) !== 0 ? ["bad", "has acted"] as const : (g.conditions & bit) !== 0 ? ["warn", "condition holds"] as const : (g.acted & bit) !== 0 ? ["warn", "acted before"] as const : ["ok", "good"] as const;
            return (
              <tr key={name}>
                <td>{name}</td>
                <td><Badge tone={state[0]}>{state[1]}</Badge></td>
                <td class="r num" title="Seconds without a message or change, or the value that is watched">{m == null ? "–" : value(m)}</td>
              </tr>
            );
          })}
        </tbody>
      </table>
    </section>
  );
}

function Outsiders({ status }: { status: Status }) {
  const o = status.outsiders;
  if (!o) return null;
  const odd = Object.entries(o).filter(([k, v]) => v > 0 && !["clients", "accepted", "requests"].includes(k));
  return (
    <section>
      <h3>Other programs at this robot</h3>
      <p class="num">{count(o.clients)} connected, {count(o.requests)} requests since the start{odd.length > 0 && <span class="warn-text">; {odd.map(([k, v]) => `${k.replace(/_/g, " ")}: ${count(v)}`).join(", ")}</span>}</p>
    </section>
  );
}
