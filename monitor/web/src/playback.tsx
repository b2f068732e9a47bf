// The bar of a recorded run: where it is, play, pause, step, speed.

import { useState } from "preact/hooks";
import { clock } from "./format";
import type { Robot } from "./robot";
import { Button, Choice, useWatch } from "./ui";

const kSpeeds = [["0.1", "0.1 ×"], ["0.25", "0.25 ×"], ["0.5", "0.5 ×"], ["1", "1 ×"], ["2", "2 ×"], ["5", "5 ×"], ["10", "10 ×"]] as const;

export function Playback({ robot }: { robot: Robot }) {
  useWatch(robot, "playback", 200);
  const [dragged, setDragged] = useState<number | null>(null);
  const p = robot.playback.value;
  if (!p) return <div class="playback muted">{robot.failures.value.get("playback") ?? "Asking where the recorded run is …"}</div>;
  const length = Math.max(1, p.end_ns - p.begin_ns);
  const at = dragged ?? p.time_ns;
  const ask = async (request: string, body: object = {}) => {
    const reply = await robot.command<Partial<typeof p>>(`playback.${request}`, body);
    if (reply && robot.playback.peek()) robot.playback.value = { ...robot.playback.peek()!, ...reply };
  };
  const seek = (time_ns: number) => {
    setDragged(null);
    void ask("seek", { time_ns: Math.round(time_ns) });
  };
  const plays = p.state === "playing";
  return (
    <div class="playback" role="group" aria-label="Recorded run">
      <Button icon={plays ? "pause" : "play"} label={plays ? "Pause" : "Play"} hideLabel kind="strong" onClick={() => void ask(plays ? "pause" : "play")} />
      <Button icon="step" label="Step: one message" hideLabel onClick={() => void ask("step", { messages: 1 })} />
      <span class="num">{clock(at - p.begin_ns)}</span>
      <input
        type="range" aria-label="Time in the recorded run" min={0} max={1000} step={1} value={((at - p.begin_ns) / length) * 1000}
        aria-valuetext={clock(at - p.begin_ns)}
        onInput={(e) => setDragged(p.begin_ns + (Number(e.currentTarget.value) / 1000) * length)}
        onChange={(e) => seek(p.begin_ns + (Number(e.currentTarget.value) / 1000) * length)}
      />
      <span class="num muted">{clock(length)}</span>
      <Choice label="Speed" value={String(p.speed)} options={kSpeeds.some(([s]) => Number(s) === p.speed) ? kSpeeds : [...kSpeeds, [String(p.speed), `${p.speed} ×`] as const]} onChange={(s) => void ask("speed", { speed: Number(s) })} />
      {p.state === "ended" && <span class="muted">at its end</span>}
    </div>
  );
}
