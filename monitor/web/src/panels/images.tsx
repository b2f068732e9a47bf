// A topic of pictures, live: the newest one with what detectors say about it drawn over it, and how old it is.

import { useEffect, useRef, useState } from "preact/hooks";
import { clock, duration } from "../format";
import { followsRule, marksOf, type Mark } from "../overlay";
import type { PanelProps } from "../panels";
import type { Robot } from "../robot";
import { decode, type Message } from "../ros2msg";
import { Button, Choice, colour, NoMessages, Tools, useSize, useWatch } from "../ui";

interface Shown {
  bitmap: ImageBitmap;
  stamp_ns: number;
  bytes: number;
}

const kJpeg = "/jpeg";
const kMarkColours = ["#4fe3c8", "#ffb454", "#8ab8ff", "#ff8fb5"]; // bright: pictures are dark or light as they like
const kMarksLiveNs = 0.500e9; // a detector that fell silent: its marks go

export function ImagesPanel({ robot, tile, set }: PanelProps) {
  useWatch(robot, "topics", 10_000);
  const channels = robot.socket.channels.value;
  const topics = [...channels.keys()].filter((t) => t.endsWith(kJpeg)).map((t) => t.slice(1, -kJpeg.length)).sort();
  const wished = typeof tile.state.topic === "string" ? tile.state.topic : "";
  const topic = topics.includes(wished) ? wished : (topics[0] ?? "");
  const marks = tile.state.marks !== false;
  useEffect(() => robot.socket.connect(), [robot]);
  return (
    <>
      <Tools>
        {topics.length > 1 && <Choice label="Topic of pictures" value={topic} options={topics.map((t) => [t, t] as const)} onChange={(t) => set({ topic: t })} />}
        {topics.length === 1 && <span class="muted">{topic}</span>}
        {topic && <Button label="Marks" pressed={marks} title="What detectors say, drawn over the picture" onClick={() => set({ marks: !marks })} />}
      </Tools>
      {topic ? <Picture key={topic} robot={robot} topic={topic} withMarks={marks} /> : <NoPicture robot={robot} />}
    </>
  );
}

function NoPicture({ robot }: { robot: Robot }) {
  const some = robot.topics.value?.some((t) => t.bulk_bytes > 0);
  return <NoMessages robot={robot}>{some ? "The monitor sends no pictures of this robot: it may have been built without a JPEG library." : "This robot has no topic of pictures."}</NoMessages>;
}

function Picture({ robot, topic, withMarks }: { robot: Robot; topic: string; withMarks: boolean }) {
  const [box, size] = useSize<HTMLDivElement>();
  const canvas = useRef<HTMLCanvasElement>(null);
  const note = useRef<HTMLSpanElement>(null);
  const whole = useWholeWidth(robot, topic);
  const state = useRef({ shown: null as Shown | null, marks: new Map<string, { marks: Mark[]; stamp_ns: number }>(), frames: 0, hz: 0, since: performance.now(), busy: false });
  const drawNow = useRef(() => {});
  const [problem, setProblem] = useState("");

  useEffect(() => robot.subscribe(`/${topic}${kJpeg}`, (payload) => {
    const struct = robot.struct(`/${topic}${kJpeg}`);
    if (!struct || typeof struct === "string") return setProblem(struct ?? "");
    const s = state.current;
    if (s.busy) return; // the browser still decodes: the newest that comes then is shown
    const message = decode(struct, payload) as { header?: Message; data?: Uint8Array };
    const stamp = message.header?.stamp as { sec: number; nanosec: number } | undefined;
    if (!message.data) return setProblem("The message has no data.");
    s.busy = true;
    const bytes = message.data.byteLength;
    createImageBitmap(new Blob([message.data.slice()], { type: "image/jpeg" }))
      .then((bitmap) => {
        s.shown?.bitmap.close();
        s.shown = { bitmap, stamp_ns: stamp ? Number(BigInt(stamp.sec) * 1_000_000_000n + BigInt(stamp.nanosec) - robot.socket.unix_ns) : NaN, bytes };
        ++s.frames;
        drawNow.current();
      }, () => setProblem("A picture came that this browser cannot read."))
      .finally(() => (s.busy = false));
  }), [robot, topic]);

  useEffect(() => {
    if (!withMarks) return state.current.marks.clear();
    const ends = [...robot.socket.channels.peek().keys()].flatMap((name) => {
      const struct = robot.struct(name);
      if (!struct || typeof struct === "string" || !followsRule(struct)) return [];
      return [robot.subscribe(name, (payload) => {
        const message = decode(struct, payload);
        const stamp = typeof message.stamp === "number" ? message.stamp : NaN;
        state.current.marks.set(name, { marks: marksOf(message, name.slice(1)), stamp_ns: stamp });
      })];
    });
    return () => ends.forEach((end) => end());
  }, [robot, withMarks, robot.socket.channels.value]);

  const draw = () => {
    const c = canvas.current, s = state.current, shown = s.shown;
    if (!c || !shown || size.width === 0) return;
    const ratio = devicePixelRatio || 1;
    const scale = Math.min(size.width / shown.bitmap.width, size.height / shown.bitmap.height);
    const w = Math.round(shown.bitmap.width * scale), h = Math.round(shown.bitmap.height * scale);
    if (c.width !== Math.round(w * ratio) || c.height !== Math.round(h * ratio)) {
      c.width = Math.round(w * ratio), c.height = Math.round(h * ratio);
      c.style.width = `${w}px`, c.style.height = `${h}px`;
    }
    const context = c.getContext("2d")!;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.imageSmoothingEnabled = scale < 3;
    context.drawImage(shown.bitmap, 0, 0, w, h);
    if (withMarks) drawMarks(context, w, h, w / (whole ?? shown.bitmap.width), s.marks, shown.stamp_ns);
  };
  drawNow.current = draw; // the listener outlives this size and these marks
  useEffect(draw);

  useEffect(() => {
    const timer = setInterval(() => {
      const s = state.current, now = performance.now();
      if (now - s.since >= 1000) (s.hz = (s.frames * 1000) / (now - s.since)), (s.frames = 0), (s.since = now);
      if (!note.current) return;
      note.current.textContent = s.shown ? words(robot, s.shown, s.hz, whole) : "waiting for a picture";
    }, 200);
    return () => clearInterval(timer);
  }, [robot, whole]);

  return (
    <div class="picture">
      <div ref={box} class="picture-box"><canvas ref={canvas} role="img" aria-label={`Newest picture of ${topic}`} /></div>
      {problem && <p class="warn-text">{problem}</p>}
      <p class="picture-note num"><span ref={note} /></p>
    </div>
  );
}

function words(robot: Robot, shown: Shown, hz: number, whole: number | null): string {
  const now = robot.now_ns();
  const age = robot.ended.peek() !== null ? "of a robot that ended"
    : robot.info.peek().virtual_time || robot.isPlayback.peek() || now === null || !Number.isFinite(shown.stamp_ns) ? `at ${clock(shown.stamp_ns)}`
    : `age ${duration(Math.max(0, now - shown.stamp_ns))}`;
  const small = whole && whole !== shown.bitmap.width ? ` of ${whole}` : "";
  return `${age} · ${shown.bitmap.width}${small} × ${shown.bitmap.height} px · ${hz.toFixed(1)} Hz · ${(shown.bytes / 1000).toFixed(1)} kB`;
}

/** Marks are in pixels of the whole picture; the monitor sends what the connection takes, which may be smaller. */
function useWholeWidth(robot: Robot, topic: string): number | null {
  const [width, setWidth] = useState<number | null>(null);
  useEffect(() => {
    let over = false;
    fetch(robot.picture(topic, { quality: 1 }))
      .then(async (r) => (r.ok ? createImageBitmap(await r.blob()) : null))
      .then((bitmap) => {
        if (bitmap && !over) setWidth(bitmap.width);
        bitmap?.close();
      }, () => undefined); // without it marks stand right only on whole pictures
    return () => void (over = true);
  }, [robot, topic, robot.info.value.pid]);
  return width;
}

function drawMarks(c: CanvasRenderingContext2D, w: number, h: number, scale: number, all: Map<string, { marks: Mark[]; stamp_ns: number }>, picture_ns: number) {
  c.lineWidth = 2;
  c.font = `600 12px ${colour("font")}`;
  c.textBaseline = "bottom";
  let index = 0;
  for (const { marks, stamp_ns } of all.values()) {
    const hue = kMarkColours[index++ % kMarkColours.length]!;
    if (Math.abs(picture_ns - stamp_ns) > kMarksLiveNs) continue;
    for (const m of marks) {
      const x = m.u * scale, y = m.v * scale;
      c.strokeStyle = hue;
      c.beginPath();
      if (m.width !== undefined && m.height !== undefined) c.rect(x - (m.width * scale) / 2, y - (m.height * scale) / 2, m.width * scale, m.height * scale);
      else if (m.radius !== undefined) c.arc(x, y, m.radius * scale, 0, 7);
      c.moveTo(x - 7, y), c.lineTo(x + 7, y), c.moveTo(x, y - 7), c.lineTo(x, y + 7);
      c.stroke();
      const wide = c.measureText(m.label).width;
      const off = (m.radius ?? (m.width ?? 0) / 2) * scale + 6;
      const left = Math.min(Math.max(2, x - wide / 2), w - wide - 8), top = y + off + 18 < h ? y + off + 16 : y - off;
      c.fillStyle = "rgba(8,12,16,0.72)";
      c.fillRect(left - 4, top - 15, wide + 8, 17);
      c.fillStyle = hue;
      c.fillText(m.label, left, top);
    }
  }
}
