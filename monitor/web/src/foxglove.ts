// A client of the Foxglove WebSocket protocol v1, as docs/monitor.md has it: channels and their messages.

import { signal } from "@preact/signals";

export interface Channel {
  id: number;
  topic: string;
  encoding: string;
  schemaName: string;
  schema: string;
  schemaEncoding?: string;
}

/** `time_ns`: of the robot's clock. */
export type OnMessage = (payload: DataView, time_ns: number, channel: Channel) => void;

interface Wanted {
  listeners: Set<OnMessage>;
  id: number | null; // of the subscription; null: the topic is not there, or nobody may look now
}

/** What it needs of a WebSocket; tests give one of their own. */
export interface SocketLike {
  binaryType: string;
  onopen: ((e: unknown) => void) | null;
  onmessage: ((e: { data: unknown }) => void) | null;
  onclose: ((e: unknown) => void) | null;
  send(data: string | ArrayBufferView): void;
  close(): void;
}

const kProtocols = ["foxglove.websocket.v1"];
const kLongestWaitMs = 4000;

export class FoxgloveClient {
  readonly state = signal<"connecting" | "open" | "closed">("closed");
  readonly channels = signal<ReadonlyMap<string, Channel>>(new Map());
  /** What the monitor adds to the robot's clock in its messages, so that others read a date. */
  unix_ns = 0n;
  private socket: SocketLike | null = null;
  private wanted = new Map<string, Wanted>();
  private bySubscription = new Map<number, { channel: Channel; wanted: Wanted }>();
  private nextId = 1;
  private paused = false;
  private over = false;
  private waitMs = 250;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly url: () => string,
    private readonly make: (url: string, protocols: string[]) => SocketLike = (u, p) => new WebSocket(u, p) as unknown as SocketLike,
  ) {}

  connect() {
    if (this.over || this.socket) return;
    this.state.value = "connecting";
    const socket = this.make(this.url(), kProtocols);
    this.socket = socket;
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.waitMs = 250;
      this.state.value = "open";
    };
    socket.onmessage = (e) => {
      if (typeof e.data === "string") this.text(e.data);
      else if (e.data instanceof ArrayBuffer) this.binary(e.data);
    };
    socket.onclose = () => this.lost();
  }

  close() {
    this.over = true;
    clearTimeout(this.timer);
    this.socket?.close();
  }

  /** Ends this connection; the next one begins at once. */
  reconnect() {
    this.waitMs = 0;
    this.socket?.close();
  }

  /** Ends with the returned function. The topic need not be there yet. */
  subscribe(topic: string, listener: OnMessage): () => void {
    let wanted = this.wanted.get(topic);
    if (!wanted) this.wanted.set(topic, (wanted = { listeners: new Set(), id: null }));
    wanted.listeners.add(listener);
    this.begin(topic, wanted);
    this.connect();
    return () => {
      wanted.listeners.delete(listener);
      if (wanted.listeners.size > 0 || this.wanted.get(topic) !== wanted) return;
      this.end(wanted);
      this.wanted.delete(topic);
    };
  }

  /** A page that nobody sees asks for nothing. */
  pause(paused: boolean) {
    if (this.paused === paused) return;
    this.paused = paused;
    for (const [topic, wanted] of this.wanted)
      if (paused) this.end(wanted);
      else this.begin(topic, wanted);
  }

  /** Of subscriptions that the monitor has now; for tests and the page's own words. */
  get subscriptions(): number {
    return this.bySubscription.size;
  }

  private begin(topic: string, wanted: Wanted) {
    const channel = this.channels.peek().get(topic);
    if (!channel || this.paused || wanted.id !== null || this.state.peek() !== "open") return;
    wanted.id = this.nextId++;
    this.bySubscription.set(wanted.id, { channel, wanted });
    this.send({ op: "subscribe", subscriptions: [{ id: wanted.id, channelId: channel.id }] });
  }

  private end(wanted: Wanted) {
    if (wanted.id === null) return;
    if (this.state.peek() === "open") this.send({ op: "unsubscribe", subscriptionIds: [wanted.id] });
    this.bySubscription.delete(wanted.id);
    wanted.id = null;
  }

  private send(message: object) {
    this.socket?.send(JSON.stringify(message));
  }

  private lost() {
    this.socket = null;
    this.state.value = "closed";
    this.channels.value = new Map();
    this.bySubscription.clear();
    for (const wanted of this.wanted.values()) wanted.id = null;
    if (this.over) return;
    this.timer = setTimeout(() => this.connect(), this.waitMs);
    this.waitMs = Math.min(this.waitMs * 2, kLongestWaitMs);
  }

  private text(text: string) {
    const message = JSON.parse(text);
    switch (message.op) {
      case "serverInfo":
        this.unix_ns = BigInt(message.metadata?.unix_ns ?? 0);
        break;
      case "advertise": {
        const channels = new Map(this.channels.peek());
        for (const channel of message.channels as Channel[]) channels.set(channel.topic, channel);
        this.channels.value = channels;
        for (const channel of message.channels as Channel[]) {
          const wanted = this.wanted.get(channel.topic);
          if (!wanted) continue;
          if (wanted.id !== null) this.bySubscription.delete(wanted.id);
          wanted.id = null;
          this.begin(channel.topic, wanted);
        }
        break;
      }
      case "unadvertise": {
        const gone = new Set(message.channelIds as number[]);
        this.channels.value = new Map([...this.channels.peek()].filter(([, c]) => !gone.has(c.id)));
        for (const [id, entry] of [...this.bySubscription])
          if (gone.has(entry.channel.id)) {
            this.bySubscription.delete(id);
            entry.wanted.id = null;
          }
        break;
      }
    }
  }

  private binary(data: ArrayBuffer) {
    const view = new DataView(data);
    if (view.byteLength < 13 || view.getUint8(0) !== 1) return; // other kinds are not the page's
    const entry = this.bySubscription.get(view.getUint32(1, true));
    if (!entry) return; // unsubscribed meanwhile
    const time = Number(view.getBigUint64(5, true) - this.unix_ns);
    const payload = new DataView(data, 13);
    for (const listener of entry.wanted.listeners) listener(payload, time, entry.channel);
  }
}
