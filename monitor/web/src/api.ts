// HTTP of docs/monitor.md: what the monitor answers, and the errors that it gives.

export interface Control {
  who: string | null;
  asked: string[];
}

export interface RobotInfo {
  robot: string;
  pid: number;
  board: string;
  robot_file: string;
  virtual_time: boolean;
  recording?: string | null;
  control?: Control;
  failsafes?: string[];
}

export interface ApiInfo {
  version: number;
  program: string;
  now_ns: number;
  commands: boolean;
  panels: string[];
  runs: boolean;
  /** Whether it relays others; older monitors do not say it. */
  monitors?: boolean;
}

export interface OtherMonitor {
  address: string;
  state: "reached" | "not reached" | "refused";
  why: string;
  program: string;
  commands: boolean;
}

export interface Histogram {
  count: number;
  min_ns: number;
  mean_ns: number;
  p50_ns: number;
  p99_ns: number;
  p999_ns: number;
  max_ns: number;
}

export interface ThreadStatus {
  name: string;
  priority: number;
  trigger: "period" | "topics" | "device";
  period_ns: number;
  modules: string[];
  releases: number;
  completions: number;
  overruns: number;
  skips: number;
  coalesced: number;
  timeouts: number;
  preemptions: number;
  lateness: Histogram;
  exec: Histogram;
}

export interface ModuleStatus {
  name: string;
  type: string;
  thread: string;
  running: boolean;
  steps: number;
  ok: number;
  stale: number;
  fault: number;
  stops: number;
  exec: Histogram;
}

export interface TopicStatus {
  name: string;
  messages: number;
  drops: number;
  last_stamp_ns: number;
  last_published_ns: number;
  age: Histogram;
}

export interface Guardian {
  stamp: number;
  disarmed?: number;
  measured?: (number | null)[];
  mode: string | number;
  permitted: number;
  ready: number;
  action?: string | number;
  conditions: number;
  latched: number;
  acted: number;
  reasons?: string[];
  [field: string]: unknown;
}

export interface Status {
  now_ns: number;
  threads: ThreadStatus[];
  modules: ModuleStatus[];
  topics: TopicStatus[];
  chains: { name: string; budget_ns: number; budget_misses: number; age: Histogram }[];
  guardian?: Guardian;
  devices?: { complaints: string } | string | string[];
  outsiders?: Record<string, number>;
}

export interface Topic {
  name: string;
  type: string;
  writer: string;
  thread: string;
  /** Modules. */
  readers?: string[];
  message_bytes: number;
  bulk_bytes: number;
  keep: number;
  rate_hz: number;
}

export interface Param {
  module: string;
  param: string;
  type: "bool" | "integer" | "number" | "text";
  value: boolean | number | string;
  default: boolean | number | string;
  /** What the run began with; monitors of older robots do not say it. */
  start?: boolean | number | string;
  unit: string;
  min: number | null;
  max: number | null;
  doc: string;
  allowed: string;
}

export type TimelineEvent = [kind: string, thread: number, module: number | null, at_ns: number, length_ns: number, zone: string | null];

export interface Timeline {
  threads: string[];
  modules: string[];
  columns: string[];
  events: TimelineEvent[];
  left_out: number;
}

export interface Playback {
  state: "playing" | "paused" | "ended";
  time_ns: number;
  begin_ns: number;
  end_ns: number;
  speed: number;
  loop?: boolean;
}

export interface RecordStatus {
  recording: { path: string; bytes: number; files: number; seconds: number; lost_messages?: unknown; lost_steps?: unknown } | null;
  ring: {
    seconds: number;
    bytes: number;
    room_bytes: number;
    dumps: { reason: string; at_s: number; path: string; bytes: number; done?: boolean; error?: string }[];
    not_dumped?: number;
  } | null;
}

export interface Run {
  name: string;
  /** Of its file, as `recording` of the robot that shows it. */
  path: string;
  bytes: number;
  begin_unix_ns: number;
  duration_s: number;
  robot: string;
  verdict: string;
  replay: JobState;
  /** Whether this monitor shows it as a robot. */
  open: boolean;
}

export type JobState = "none" | "running" | "identical" | "differs" | "failed" | "done";

/** Work on recorded runs: a replay or a comparison. */
export interface Job<Result> {
  state: JobState;
  seconds?: number;
  result?: Result;
  why?: string;
}

export interface Replayed {
  identical: boolean;
  steps: number;
  messages: number;
  robot_s?: number;
  wall_s?: number;
  modules: Record<string, { steps: number; stopped?: string }>;
  first_difference?: { module: string; step: number; time_s: number; what: string; recorded?: unknown; now?: unknown };
  problems?: unknown[];
  compared?: { name: string; unit: string; messages: number; rms: number; max: number; max_at_s?: number; one_sided: number }[];
}

export interface ComparedRuns {
  a: { file: string; result: string };
  b: { file: string; result: string };
  from_event: string;
  events: { text: string; a_s: number | null; b_s: number | null }[];
  fields: { name: string; unit: string; messages: number; rms: number; max: number; max_at_s?: number }[];
}

export interface DoctorSays {
  problems: number;
  warnings: number;
  checks: { id: string; state: "ok" | "problem" | "warning" | "unknown"; seen: string; advice: string }[];
}

/** What the monitor or the robot refuses, in their words. */
export class Refusal extends Error {
  constructor(readonly status: number, readonly code: string, why: string) {
    super(why);
  }
}

const kPatienceMs = 6000;

async function read(response: Response): Promise<unknown> {
  const text = await response.text();
  let body: unknown;
  try {
    body = JSON.parse(text);
  } catch {
    if (response.ok) throw new Refusal(502, "bad_data", "The monitor's answer is no JSON.");
  }
  const reply = body as { ok?: boolean; error?: { code: string; why: string } } | undefined;
  if (!response.ok || reply?.ok === false)
    throw new Refusal(response.status, reply?.error?.code ?? "io", reply?.error?.why ?? (text.trim() || response.statusText));
  return body;
}

export async function get<T>(url: string, patience_ms = kPatienceMs): Promise<T> {
  return (await read(await fetch(url, { signal: AbortSignal.timeout(patience_ms) }))) as T;
}

export function query(args: Record<string, string | number | boolean>): string {
  const text = new URLSearchParams(Object.entries(args).map(([k, v]) => [k, String(v)])).toString();
  return text ? `?${text}` : "";
}

export interface CommandHeaders {
  token: string;
  key?: string | undefined;
  until_ns?: number | undefined;
}

export async function post<T>(url: string, body: object, head: CommandHeaders, patience_ms = kPatienceMs): Promise<T> {
  const headers: Record<string, string> = { "content-type": "application/json" };
  if (head.token) headers.authorization = `Bearer ${head.token}`;
  if (head.key) headers["x-sinew-control"] = head.key;
  if (head.until_ns) headers["x-sinew-until-ns"] = String(Math.round(head.until_ns));
  return (await read(
    await fetch(url, { method: "POST", headers, body: JSON.stringify(body), signal: AbortSignal.timeout(patience_ms) }),
  )) as T;
}
