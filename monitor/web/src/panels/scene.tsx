// The body in space: attitude, position, path, what is known of the world, and the joints.

import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { unit, value } from "../format";
import type { PanelProps } from "../panels";
import type { Robot } from "../robot";
import { decode, type Message, type Struct } from "../ros2msg";
import { angles, projector, rotate, type Camera, type Project, type Quat, type Vec } from "../space";
import { Button, Choice, colour, Empty, NoMessages, Segments, seriesColour, Tools, useScheme, useSize } from "../ui";

interface Pose {
  q: Quat;
  p: Vec;
}

const kMostPath = 4000;
const kPathStep_m = 0.02;
const kFrameMs = 1000 / 30 - 3;
const kTruth = "ground_truth"; // in the simulator's world, which begins elsewhere than the estimate's

const isVec = (s: unknown): s is Struct => typeof s === "object" && s !== null && (s as Struct).fields.map((f) => f.name).join() === "x,y,z";
const isQuat = (s: unknown): s is Struct => typeof s === "object" && s !== null && (s as Struct).fields.map((f) => f.name).join() === "w,x,y,z";

/** A topic tells a pose when it has a quaternion that takes base coordinates to the world's. */
function poseField(struct: Struct): { q: string; p: string | null } | null {
  const q = struct.fields.find((f) => isQuat(f.type) && f.array === null && /world_base$/.test(f.name));
  return q ? { q: q.name, p: struct.fields.find((f) => isVec(f.type) && f.name === "p_world_m")?.name ?? null } : null;
}

/** Points in the world: fields of three coordinates whose names end in _world_m. */
function pointFields(struct: Struct): string[] {
  return struct.fields.filter((f) => isVec(f.type) && f.array === null && /_world_m$/.test(f.name) && f.name !== "p_world_m").map((f) => f.name);
}

function structs(robot: Robot): [string, Struct][] {
  return [...robot.socket.channels.value.keys()].flatMap((name): [string, Struct][] => {
    const s = robot.struct(name);
    return s && typeof s === "object" ? [[name.slice(1), s]] : [];
  });
}

const vec = (v: unknown): Vec | null => {
  const { x, y, z } = (v ?? {}) as { x?: number; y?: number; z?: number };
  return Number.isFinite(x) && Number.isFinite(y) && Number.isFinite(z) ? [x!, y!, z!] : null;
};

interface Joint {
  name: string;
  position_rad: number;
  mode: number;
}

interface World {
  pose: Pose | null;
  path: Vec[];
  points: Map<string, Vec>;
  rotors: number[] | null;
  joints: Joint[];
  /** Takes the newest messages; false: none came since. */
  refresh: () => boolean;
}

export function ScenePanel({ robot, tile, set }: PanelProps) {
  useEffect(() => robot.socket.connect(), [robot]);
  const channels = robot.socket.channels.value;
  const all = useMemo(() => structs(robot), [channels]);
  const poses = all.filter(([name, s]) => poseField(s) && name !== kTruth);
  const wished = typeof tile.state.topic === "string" ? tile.state.topic : "";
  const withPosition = poses.find(([, s]) => poseField(s)?.p) ?? poses[0];
  const topic = poses.some(([n]) => n === wished) ? wished : (withPosition?.[0] ?? "");
  const follow = tile.state.follow !== false;
  const joints = all.filter(([, s]) => s.fields.some((f) => f.name === "position_rad" && f.array !== null));
  if (channels.size === 0) return <NoMessages robot={robot}>This robot has no topics.</NoMessages>;
  if (!topic && joints.length === 0) return <Empty title="Nothing to show in space">No topic of this robot has an attitude (a field q_..._world_base) or joints (position_rad).</Empty>;
  return (
    <>
      <Tools>
        {poses.length > 1 && <Choice label="Topic of the pose" value={topic} options={poses.map(([n]) => [n, n] as const)} onChange={(t) => set({ topic: t })} />}
        <Segments label="Camera" value={follow ? "follow" : "stay"} options={[["follow", "Follow"], ["stay", "Stay"]]} onChange={(v) => set({ follow: v === "follow" })} />
      </Tools>
      <Space key={topic} robot={robot} topic={topic} all={all} follow={follow} />
    </>
  );
}

function useWorld(robot: Robot, topic: string, all: [string, Struct][]): { current: World } {
  const world = useRef<World>({ pose: null, path: [], points: new Map(), rotors: null, joints: [], refresh: () => false });
  useEffect(() => {
    const w = world.current;
    // Of 1000 messages a second only those are decoded that a drawing shows.
    const newest = new Map<string, [payload: DataView, take: (payload: DataView) => void]>();
    w.refresh = () => {
      const any = newest.size > 0;
      for (const [payload, take] of newest.values()) take(payload);
      newest.clear();
      return any;
    };
    const poseOf = (m: Message, s: Struct): Pose | null => {
      const f = poseField(s)!;
      const q = m[f.q] as unknown as Quat;
      const p = f.p ? vec(m[f.p]) : [0, 0, 0] as Vec;
      return p && Number.isFinite(q.w) ? { q, p } : null;
    };
    const ends = all.flatMap(([name, s]) => {
      const own = name === topic;
      const points = own || !poseField(s) ? pointFields(s) : [];
      const target = !poseField(s) && s.fields.some((f) => f.name === "p_world_m" && isVec(f.type));
      const joints = s.fields.some((f) => f.name === "position_rad" && f.array !== null);
      const rotors = s.fields.some((f) => f.name === "fault_events"); // what the guardian passed on
      if (!own && points.length === 0 && !joints && !rotors && !target) return [];
      const take = (payload: DataView) => {
        const m = decode(s, payload);
        if (own) {
          w.pose = poseOf(m, s);
          const last = w.path.at(-1);
          if (w.pose && m.position_valid !== 0) {
            const d = last ? Math.hypot(...w.pose.p.map((x, i) => x - last[i]!)) : Infinity;
            if (d > 5 && last) w.path = []; // a robot that began anew
            if (d > kPathStep_m) w.path.push(w.pose.p);
            if (w.path.length > kMostPath) w.path.splice(0, kMostPath / 4);
          }
        }
        for (const f of points) {
          const known = m[f.replace(/_world_m$/, "_known")];
          const at = vec(m[f]);
          if (at && known !== 0) w.points.set(`${f.replace(/_world_m$/, "")}`, at);
          else if (own) w.points.delete(f.replace(/_world_m$/, ""));
        }
        if (target) {
          const at = vec(m.p_world_m);
          if (at && m.mode === 2) w.points.set("setpoint", at);
          else w.points.delete("setpoint");
        }
        if (joints) {
          const positions = m.position_rad as number[], modes = (m.mode ?? []) as number[];
          w.joints = positions.slice(0, Number(m.count ?? positions.length)).map((p, i) => ({ name: `joint ${i + 1}`, position_rad: p, mode: modes[i] ?? 0 }));
        }
        if (rotors) {
          const values = m.value as number[];
          w.rotors = m.count === 4 && values.slice(0, 4).every((v) => v >= 0 && v <= 1) ? values.slice(0, 4) : null;
        }
      };
      return [robot.subscribe(`/${name}`, (payload) => void newest.set(name, [payload, take]))];
    });
    return () => ends.forEach((end) => end());
  }, [robot, topic, all]);
  useEffect(() => {
    world.current.path = [];
  }, [robot.info.value.pid]);
  return world;
}

function Space({ robot, topic, all, follow }: { robot: Robot; topic: string; all: [string, Struct][]; follow: boolean }) {
  const [box, size] = useSize<HTMLDivElement>();
  const canvas = useRef<HTMLCanvasElement>(null);
  const note = useRef<HTMLParagraphElement>(null);
  const world = useWorld(robot, topic, all);
  const camera = useRef<Camera>({ azimuth: -2.2, elevation: 0.42, distance: 3.6, target: [0, 0, 0.6] });
  const scheme = useScheme();
  const [home, setHome] = useState(0);
  const drawn = useRef(""); // the camera of the last drawing
  drawn.current = "";

  useEffect(() => {
    let frame = 0, last = 0;
    const run = (now_ms: number) => {
      frame = requestAnimationFrame(run);
      const c = canvas.current;
      if (!c || size.width === 0 || now_ms - last < kFrameMs) return;
      last = now_ms;
      const turned = JSON.stringify(camera.current);
      if (!world.current.refresh() && drawn.current === turned) return; // the same picture
      drawn.current = turned;
      const ratio = devicePixelRatio || 1;
      const w = Math.round(size.width * ratio), h = Math.round(size.height * ratio);
      if (c.width !== w || c.height !== h) (c.width = w), (c.height = h);
      const context = c.getContext("2d")!;
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      context.clearRect(0, 0, size.width, size.height);
      const now = world.current;
      if (follow && now.pose) {
        const t = camera.current.target;
        for (let i = 0; i < 3; ++i) t[i] = t[i]! + (now.pose.p[i]! * (i === 2 ? 0.7 : 1) + (i === 2 ? 0.15 : 0) - t[i]!) * 0.08;
      }
      drawWorld(context, size.width, size.height, camera.current, now);
      if (note.current) note.current.textContent = now.pose ? poseText(now.pose) : topic ? "waiting for a pose" : "";
    };
    frame = requestAnimationFrame(run);
    return () => cancelAnimationFrame(frame);
  }, [size.width, size.height, scheme, follow, home, world]);

  const turn = (azimuth: number, elevation: number, zoom = 1) => {
    const c = camera.current;
    c.azimuth += azimuth;
    c.elevation = Math.max(-0.1, Math.min(1.55, c.elevation + elevation));
    c.distance = Math.max(0.4, Math.min(200, c.distance * zoom));
  };
  const drag = useRef<{ x: number; y: number } | null>(null);
  return (
    <div ref={box} class="space-view" tabIndex={0} aria-label="The body in space; arrow keys turn the camera, + and - zoom" onKeyDown={(e) => {
      const [a, b, z] = ({ ArrowLeft: [-0.1, 0, 1], ArrowRight: [0.1, 0, 1], ArrowUp: [0, 0.1, 1], ArrowDown: [0, -0.1, 1], "+": [0, 0, 0.8], "-": [0, 0, 1.25] } as Record<string, number[]>)[e.key] ?? [];
      if (a === undefined) return;
      turn(a, b!, z);
      e.preventDefault();
    }}>
      <canvas ref={canvas} role="img" aria-label="Drawing of the body, its path and the ground" onPointerDown={(e) => {
        drag.current = { x: e.clientX, y: e.clientY };
        e.currentTarget.setPointerCapture(e.pointerId);
      }} onPointerMove={(e) => {
        if (!drag.current) return;
        turn((drag.current.x - e.clientX) * 0.008, (e.clientY - drag.current.y) * 0.006);
        drag.current = { x: e.clientX, y: e.clientY };
      }} onPointerUp={() => (drag.current = null)} onPointerCancel={() => (drag.current = null)} onWheel={(e) => (e.preventDefault(), turn(0, 0, e.deltaY > 0 ? 1.1 : 0.9))} />
      <p ref={note} class="space-note num" />
      <Joints world={world} />
      <Button icon="reset" label="Camera as at first, path away" hideLabel kind="quiet" class="space-home" onClick={() => {
        camera.current = { azimuth: -2.2, elevation: 0.42, distance: 3.6, target: world.current.pose ? [...world.current.pose.p] : [0, 0, 0.6] };
        world.current.path = [];
        setHome(home + 1);
      }} />
    </div>
  );
}

const deg = (rad: number) => `${((rad * 180) / Math.PI).toFixed(1)}°`;

function poseText({ q, p }: Pose): string {
  const a = angles(q);
  const n = (x: number) => (x < 0 ? "−" : " ") + Math.abs(x).toFixed(2);
  return `x ${n(p[0])}  y ${n(p[1])}  z ${n(p[2])} m    roll ${deg(a.roll)}  pitch ${deg(a.pitch)}  yaw ${deg(a.yaw)}`;
}

function Joints({ world }: { world: { current: World } }) {
  const [, redraw] = useState(0);
  useEffect(() => {
    const timer = setInterval(() => redraw((n) => n + 1), 100);
    return () => clearInterval(timer);
  }, []);
  const joints = world.current.joints;
  if (joints.length === 0) return null;
  return (
    <ul class="joints" aria-label="Joints">
      {joints.map((j) => (
        <li key={j.name}>
          <svg viewBox="-20 -20 40 40" aria-hidden="true">
            <circle r="16" /><line x1="0" y1="0" x2={-15 * Math.sin(j.position_rad)} y2={-15 * Math.cos(j.position_rad)} />
          </svg>
          <span>{j.name}</span>
          <span class="num">{value(j.position_rad)} {unit("rad")}</span>
        </li>
      ))}
    </ul>
  );
}

// ---- drawing

function path(c: CanvasRenderingContext2D, project: Project, points: Vec[], close = false) {
  c.beginPath();
  let open = false;
  for (const p of points) {
    const s = project(p);
    if (!s) {
      open = false;
      continue;
    }
    if (open) c.lineTo(s.x, s.y);
    else c.moveTo(s.x, s.y);
    open = true;
  }
  if (close) c.closePath();
}

function drawWorld(c: CanvasRenderingContext2D, w: number, h: number, camera: Camera, world: World) {
  const project = projector(camera, w, h);
  const [grid, line, muted, text, accent] = ["grid", "line", "muted", "text", "accent"].map(colour) as [string, string, string, string, string];
  c.lineJoin = c.lineCap = "round";
  c.font = `11px ${colour("font")}`;
  c.textBaseline = "middle";
  // the ground, around what is looked at
  const step = camera.distance > 40 ? 10 : camera.distance > 12 ? 2 : camera.distance > 2.5 ? 1 : 0.25;
  const cx = Math.round(camera.target[0] / step) * step, cy = Math.round(camera.target[1] / step) * step;
  const n = 8;
  for (let i = -n; i <= n; ++i) {
    const at = i * step;
    c.lineWidth = 1;
    for (const [a, b, axis] of [[[cx + at, cy - n * step, 0], [cx + at, cy + n * step, 0], cx + at === 0], [[cx - n * step, cy + at, 0], [cx + n * step, cy + at, 0], cy + at === 0]] as [Vec, Vec, boolean][]) {
      c.strokeStyle = axis ? line : grid;
      c.lineWidth = axis ? 1.5 : 1;
      const points: Vec[] = Array.from({ length: 17 }, (_, k) => [a[0] + ((b[0] - a[0]) * k) / 16, a[1] + ((b[1] - a[1]) * k) / 16, 0]);
      path(c, project, points);
      c.stroke();
    }
  }
  c.fillStyle = muted;
  c.textAlign = "center";
  for (const [label, at] of [["x", [Math.min(n, 3) * step, 0, 0]], ["y", [0, Math.min(n, 3) * step, 0]]] as [string, Vec][]) {
    const s = project(at);
    if (s) c.fillText(`${label} ${Math.min(n, 3) * step} m`, s.x, s.y + 10);
  }
  // path, and its shadow on the ground
  if (world.path.length > 1) {
    c.lineWidth = 1.5;
    c.strokeStyle = line;
    path(c, project, world.path.map(([x, y]) => [x, y, 0]));
    c.stroke();
    c.lineWidth = 2;
    c.strokeStyle = seriesColour(0);
    c.globalAlpha = 0.75;
    path(c, project, world.path);
    c.stroke();
    c.globalAlpha = 1;
  }
  // points
  let row = 0;
  for (const [name, p] of world.points) {
    const s = project(p);
    if (!s) continue;
    const hue = name === "setpoint" ? seriesColour(2) : seriesColour(1);
    c.strokeStyle = c.fillStyle = hue;
    c.lineWidth = 1.5;
    if (name === "setpoint") {
      c.beginPath();
      c.arc(s.x, s.y, 5, 0, 7);
      c.stroke();
    } else {
      for (const r of [0.1, 0.25]) {
        path(c, project, circle(p, r), true);
        c.stroke();
      }
    }
    c.textAlign = "left";
    c.fillText(name, s.x + 16, s.y - 14 - 13 * (row++ % 3));
  }
  if (world.pose) {
    const { p } = world.pose;
    c.strokeStyle = muted;
    c.setLineDash([3, 4]);
    c.lineWidth = 1;
    path(c, project, [p, [p[0], p[1], 0]]);
    c.stroke();
    c.setLineDash([]);
    drawBody(c, project, world.pose, world.rotors, text, accent);
    drawAxes(c, project, world.pose);
  }
}

function circle([x, y, z]: Vec, r: number, q?: Quat): Vec[] {
  return Array.from({ length: 25 }, (_, i): Vec => {
    const a = (i / 24) * 2 * Math.PI;
    const at: Vec = [r * Math.cos(a), r * Math.sin(a), 0];
    const [dx, dy, dz] = q ? rotate(q, at) : at;
    return [x + dx, y + dy, z + dz];
  });
}

const kArm_m = 0.12;

/** With four rotors a quadrotor, its discs as bright as its motors turn; else a plain box. */
function drawBody(c: CanvasRenderingContext2D, project: Project, { q, p }: Pose, rotors: number[] | null, hue: string, accent: string) {
  const at = (v: Vec): Vec => {
    const [x, y, z] = rotate(q, v);
    return [p[0] + x, p[1] + y, p[2] + z];
  };
  c.strokeStyle = hue;
  c.lineWidth = 2.5;
  if (rotors) {
    const arms: Vec[] = [[kArm_m, kArm_m, 0], [-kArm_m, kArm_m, 0], [-kArm_m, -kArm_m, 0], [kArm_m, -kArm_m, 0]];
    path(c, project, [at(arms[0]!), at(arms[2]!)]);
    c.stroke();
    path(c, project, [at(arms[1]!), at(arms[3]!)]);
    c.stroke();
    arms.forEach((arm, i) => {
      path(c, project, circle(at([arm[0], arm[1], 0.02]), 0.075, q), true);
      c.fillStyle = accent;
      c.globalAlpha = 0.12 + 0.6 * rotors[i]!;
      c.fill();
      c.globalAlpha = 1;
      c.lineWidth = 1.25;
      c.stroke();
    });
    path(c, project, ([[0.05, 0.03, 0], [0.05, -0.03, 0], [-0.05, -0.03, 0], [-0.05, 0.03, 0]] as Vec[]).map(at), true);
    c.fillStyle = hue;
    c.fill();
    return;
  }
  const [l, b, t] = [0.15, 0.1, 0.05];
  const corners: Vec[] = [[l, b, -t], [l, -b, -t], [-l, -b, -t], [-l, b, -t], [l, b, t], [l, -b, t], [-l, -b, t], [-l, b, t]];
  const s = corners.map(at);
  c.lineWidth = 1.5;
  for (const face of [[0, 1, 2, 3], [4, 5, 6, 7], [0, 1, 5, 4], [2, 3, 7, 6]]) {
    path(c, project, face.map((i) => s[i]!), true);
    c.fillStyle = accent;
    c.globalAlpha = face[0] === 0 && face[2] === 5 ? 0.4 : 0.12;
    c.fill();
    c.globalAlpha = 1;
    c.stroke();
  }
}

function drawAxes(c: CanvasRenderingContext2D, project: Project, { q, p }: Pose) {
  for (const [axis, hue] of [[[0.35, 0, 0], "axis-x"], [[0, 0.35, 0], "axis-y"], [[0, 0, 0.35], "axis-z"]] as [Vec, string][]) {
    const [x, y, z] = rotate(q, axis);
    c.strokeStyle = colour(hue);
    c.lineWidth = 2;
    path(c, project, [p, [p[0] + x, p[1] + y, p[2] + z]]);
    c.stroke();
  }
}
