// One robot: what the page knows of it, asked only while a panel looks, and the commands to it.

import { computed, signal, type Signal } from "@preact/signals";
import { get, post, query, Refusal, type Control, type Param, type Playback, type RecordStatus, type RobotInfo, type Status, type Timeline, type Topic } from "./api";
import { FoxgloveClient, type OnMessage } from "./foxglove";
import { hidden } from "./browser";
import type { Machine } from "./machine";
import { parseSchema, type Struct } from "./ros2msg";

const kCommandLivesNs = 1e9; // a click that takes longer to arrive is void
const kKeepMs = 1000;
const kRateWindowNs = 1e9;

interface Poll {
  lookers: number;
  period_ms: number;
  timer: ReturnType<typeof setTimeout> | undefined;
}

/** Rates per second of the robot's clock, over about one second. */
export interface Rates {
  /** of all counters: "topic:imu.raw" messages, "thread:stabilise" completions, "module:imu" steps */
  hz: Map<string, number>;
  /** busy time of threads and modules, as a share of one processor */
  share: Map<string, number>;
}

export interface Event {
  at_ns: number;
  text: string;
  grave: boolean;
}

export function countersOf(status: Status): Map<string, [count: number, busy_ns: number]> {
  const all = new Map<string, [number, number]>();
  for (const t of status.threads) all.set(`thread:${t.name}`, [t.completions, t.exec.mean_ns * t.exec.count]);
  for (const m of status.modules) all.set(`module:${m.name}`, [m.steps, m.exec.mean_ns * m.exec.count]);
  for (const t of status.topics) all.set(`topic:${t.name}`, [t.messages, 0]);
  return all;
}

export function ratesBetween(before: Status, now: Status): Rates {
  const seconds = (now.now_ns - before.now_ns) / 1e9;
  const hz = new Map<string, number>(), share = new Map<string, number>();
  if (seconds <= 0) return { hz, share };
  const was = countersOf(before);
  for (const [key, [count, busy]] of countersOf(now)) {
    const old = was.get(key);
    if (!old) continue;
    hz.set(key, (count - old[0]) / seconds);
    share.set(key, Math.max(0, (busy - old[1]) / (seconds * 1e9)));
  }
  return { hz, share };
}

export class Robot {
  /** On its machine. */
  readonly name: string;
  /** Among those of all machines: in links, and wherever robots are told apart. Names have no "@". */
  readonly id: string;
  /** The same for people. */
  readonly label: string;
  readonly info: Signal<RobotInfo>;
  readonly ended = signal<number | null>(null); // by this page's clock, ms
  readonly status = signal<Status | null>(null);
  readonly rates = signal<Rates | null>(null);
  readonly topics = signal<Topic[] | null>(null);
  readonly params = signal<Param[] | null>(null);
  readonly timeline = signal<Timeline | null>(null);
  readonly record = signal<RecordStatus | null>(null);
  readonly playback = signal<Playback | null>(null);
  readonly control = signal<Control>({ who: null, asked: [] });
  /** By request: why the last look failed. */
  readonly failures = signal<ReadonlyMap<string, string>>(new Map());
  readonly events = signal<Event[]>([]);
  /** The last refusal of a command, until the next command. */
  readonly refusal = signal<string | null>(null);
  readonly key = signal("");
  readonly isPlayback = computed(() => Boolean(this.info.value.recording));
  readonly socket: FoxgloveClient;
  private polls = new Map<string, Poll>();
  private keeper: ReturnType<typeof setInterval> | undefined;
  private history: Status[] = [];
  private structs = new Map<string, Struct | string>();
  private clock: { robot_ns: number; page_ms: number } | null = null;

  constructor(first: RobotInfo, readonly machine: Machine) {
    this.name = first.robot;
    this.id = machine.address ? `${this.name}@${machine.address}` : this.name;
    this.label = machine.address ? `${this.name} @ ${machine.address}` : this.name;
    this.info = signal(first);
    this.control.value = first.control ?? this.control.value;
    this.socket = new FoxgloveClient(() => {
      const token = machine.token.peek();
      return `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}${machine.base}/${encodeURIComponent(this.name)}${token ? query({ token }) : ""}`;
    });
    this.socket.pause(hidden.peek());
  }

  /** News from the list of robots. */
  take(now: RobotInfo) {
    const before = this.info.peek();
    if (now.control) this.control.value = now.control;
    if (before.pid !== now.pid || this.ended.peek() !== null) {
      this.ended.value = null;
      this.restart(); // its clock may be another one
      this.history = [];
      this.clock = null;
      this.structs.clear();
      this.rates.value = null;
      this.topics.value = null;
      this.params.value = null;
      this.timeline.value = null;
      this.events.value = [];
      for (const [request, poll] of this.polls)
        if (poll.lookers > 0) {
          clearTimeout(poll.timer);
          poll.timer = setTimeout(() => void this.ask(request, poll.period_ms, poll), 0);
        }
    }
    if (JSON.stringify(before) !== JSON.stringify(now)) this.info.value = now;
  }

  /** With another token the connection begins anew. */
  restart() {
    if (this.socket.state.peek() !== "closed") this.socket.reconnect();
  }

  close() {
    clearInterval(this.keeper);
    for (const poll of this.polls.values()) clearTimeout(poll.timer);
    this.socket.close();
  }

  // ---- looking

  /** Asks again and again until the returned function is called; several who look share one question. */
  watch(request: "status" | "params" | "timeline" | "record.status" | "playback" | "topics", period_ms: number): () => void {
    let poll = this.polls.get(request);
    if (!poll) this.polls.set(request, (poll = { lookers: 0, period_ms, timer: undefined }));
    const p = poll;
    if (p.lookers++ === 0) void this.ask(request, period_ms, p);
    return () => {
      if (--p.lookers === 0) clearTimeout(p.timer);
    };
  }

  /** A request that looks. */
  look<T>(request: string, args: Record<string, string | number | boolean> = {}): Promise<T> {
    return get<T>(this.path(request) + query(args));
  }

  private path(request: string): string {
    return `${this.machine.base}/api/robots/${encodeURIComponent(this.name)}/${request}`;
  }

  /** The newest picture of a topic as a file. */
  picture(topic: string, args: Record<string, string | number | boolean>): string {
    return `${this.machine.base}/${encodeURIComponent(this.name)}/images/${encodeURIComponent(topic)}.jpg${query(args)}`;
  }

  private async ask(request: string, period_ms: number, poll: Poll) {
    let wait = period_ms;
    if (!hidden.peek() && this.ended.peek() === null)
      try {
        this.takeReply(request, await this.look(request, request === "timeline" ? { last_ms: 1000 } : {}));
        this.note(request, null);
      } catch (e) {
        this.note(request, e instanceof Refusal ? e.message : "The monitor does not answer.");
        wait = Math.max(period_ms, 1000);
      }
    if (poll.lookers > 0) poll.timer = setTimeout(() => void this.ask(request, period_ms, poll), wait);
  }

  private note(request: string, why: string | null) {
    const before = this.failures.peek();
    if ((before.get(request) ?? null) === why) return;
    const now = new Map(before);
    if (why === null) now.delete(request);
    else now.set(request, why);
    this.failures.value = now;
  }

  private takeReply(request: string, reply: unknown) {
    switch (request) {
      case "status":
        return this.takeStatus(reply as Status);
      case "topics":
        if (this.topics.peek()?.length !== (reply as { topics: Topic[] }).topics.length) this.topics.value = (reply as { topics: Topic[] }).topics;
        return;
      case "params":
        this.params.value = (reply as { params: Param[] }).params;
        return;
      case "timeline":
        this.timeline.value = reply as Timeline;
        return;
      case "record.status":
        this.record.value = reply as RecordStatus;
        return;
      case "playback":
        this.playback.value = reply as Playback;
        return;
    }
  }

  takeStatus(now: Status, page_ms = performance.now()) {
    const last = this.history.at(-1);
    if (last && now.now_ns < last.now_ns) this.history = []; // a recorded run went back
    this.history.push(now);
    while (this.history.length > 2 && now.now_ns - this.history[1]!.now_ns > kRateWindowNs) this.history.shift();
    if (this.history.length > 1) this.rates.value = ratesBetween(this.history[0]!, now);
    this.clock = { robot_ns: now.now_ns, page_ms };
    this.noteEvents(last ?? null, now);
    this.status.value = now;
  }

  /** What changed in the guardian's state while this page looked, in words with the robot's time. */
  private noteEvents(before: Status | null, now: Status) {
    const a = before?.guardian, b = now.guardian;
    if (!a || !b) return;
    const news: Event[] = [];
    const names = this.info.peek().failsafes ?? [];
    for (let bit = 0; bit < Math.max(names.length, 16); ++bit) {
      const mask = 1 << bit;
      const name = names[bit] ?? `failsafe ${bit}`;
      const measured = b.measured?.[bit];
      const by = measured == null ? "" : ` (measured ${measured.toPrecision(3)})`;
      if ((b.acted & mask) !== 0 && (a.acted & mask) === 0) news.push({ at_ns: b.stamp, text: `failsafe ${name} acted${by}`, grave: true });
      else if ((b.conditions & mask) !== 0 && (a.conditions & mask) === 0)
        news.push({ at_ns: b.stamp, text: `condition of ${name} holds${by}`, grave: true });
      else if ((b.conditions & mask) === 0 && (a.conditions & mask) !== 0) news.push({ at_ns: b.stamp, text: `condition of ${name} is over`, grave: false });
    }
    if (a.permitted !== b.permitted) news.push({ at_ns: b.stamp, text: b.permitted ? "armed: commands pass" : "not armed: commands do not pass", grave: false });
    if (a.mode !== b.mode && b.mode === 3) news.push({ at_ns: b.stamp, text: "the guardian took the actuators to their safe action", grave: true });
    if (news.length) this.events.value = [...news.reverse(), ...this.events.peek()].slice(0, 200);
  }

  /** The robot's clock now, going on since the last status; null: not known. */
  now_ns(): number | null {
    if (!this.clock) return null;
    const playback = this.playback.peek();
    const speed = playback ? (playback.state === "playing" ? playback.speed : 0) : 1;
    return this.clock.robot_ns + (performance.now() - this.clock.page_ms) * 1e6 * speed;
  }

  /** The layout of a channel's messages; a text: why there is none. */
  struct(topic: string): Struct | string | null {
    const channel = this.socket.channels.value.get(topic);
    if (!channel) return null;
    const key = `${channel.schemaName}\n${channel.schema.length}`;
    let found = this.structs.get(key);
    if (!found) {
      try {
        found = channel.encoding === "cdr" ? parseSchema(channel.schemaName, channel.schema) : `encoding ${channel.encoding} is not shown here`;
      } catch (e) {
        found = (e as Error).message;
      }
      this.structs.set(key, found);
    }
    return found;
  }

  subscribe(topic: string, listener: OnMessage): () => void {
    return this.socket.subscribe(topic, listener);
  }

  // ---- commanding

  /** The reply; null: refused, and `refusal` says why. */
  async command<T = unknown>(request: string, body: object = {}): Promise<T | null> {
    this.refusal.value = null;
    if (this.ended.peek() !== null) return this.refuse("The robot has ended.");
    const plays = request.startsWith("playback");
    if (!plays && !this.machine.token.peek()) return this.refuse(`This page only looks: a command needs the token of the monitor of ${this.machine.name} (key symbol, top right).`);
    try {
      const reply = await post<T>(this.path(request), body, {
        token: plays ? "" : this.machine.token.peek(),
        key: this.key.peek() || undefined,
        until_ns: this.machine.now() + kCommandLivesNs,
      });
      return reply;
    } catch (e) {
      if (e instanceof Refusal) {
        if (e.status === 409 && /control/i.test(e.message)) this.dropKey();
        return this.refuse(e.status === 401 ? `${e.message}: give the token that the monitor printed (key symbol, top right).` : e.message);
      }
      return this.refuse("The monitor did not answer in time; the command is void.");
    }
  }

  private refuse(why: string): null {
    this.refusal.value = why;
    return null;
  }

  async takeControl(who: string) {
    const reply = await this.command<{ key: string }>("control", { action: "take", who });
    if (!reply) return;
    this.key.value = reply.key;
    this.control.value = { who, asked: [] };
    clearInterval(this.keeper);
    this.keeper = setInterval(() => void this.keepControl(who), kKeepMs);
  }

  private async keepControl(who: string) {
    try {
      await post(this.path("control"), { action: "keep", who, key: this.key.peek() }, { token: this.machine.token.peek(), key: this.key.peek() });
    } catch (e) {
      if (!(e instanceof Refusal)) return; // the monitor is away: the next second tries again
      this.dropKey();
      this.refusal.value = `Control was lost: ${e.message}`;
    }
  }

  async releaseControl(who: string) {
    const key = this.key.peek();
    await this.command("control", { action: "release", who, key });
    this.dropKey();
    this.control.value = { ...this.control.peek(), who: null };
  }

  async askControl(who: string) {
    await this.command("control", { action: "ask", who });
  }

  private dropKey() {
    clearInterval(this.keeper);
    this.key.value = "";
  }
}
