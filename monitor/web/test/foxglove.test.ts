import { beforeEach, describe, expect, it, vi } from "vitest";
import { FoxgloveClient, type SocketLike } from "../src/foxglove";

/** The monitor's side of one connection, as docs/monitor.md has it. */
class Peer implements SocketLike {
  static all: Peer[] = [];
  binaryType = "";
  onopen: ((e: unknown) => void) | null = null;
  onmessage: ((e: { data: unknown }) => void) | null = null;
  onclose: ((e: unknown) => void) | null = null;
  sent: { op: string; [key: string]: unknown }[] = [];
  constructor(readonly url: string, readonly protocols: string[]) {
    Peer.all.push(this);
  }
  send(data: string | ArrayBufferView) {
    this.sent.push(JSON.parse(data as string));
  }
  close() {
    this.onclose?.({});
  }
  open(...topics: [id: number, topic: string][]) {
    this.onopen?.({});
    this.says({ op: "serverInfo", name: "sinew", capabilities: [] });
    this.says({ op: "advertise", channels: topics.map(([id, topic]) => ({ id, topic, encoding: "cdr", schemaName: "p/msg/A", schema: "uint8 x\n" })) });
  }
  says(message: object) {
    this.onmessage?.({ data: JSON.stringify(message) });
  }
  data(subscription: number, time: bigint, ...payload: number[]) {
    const view = new DataView(new ArrayBuffer(13 + payload.length));
    view.setUint8(0, 1);
    view.setUint32(1, subscription, true);
    view.setBigUint64(5, time, true);
    payload.forEach((b, i) => view.setUint8(13 + i, b));
    this.onmessage?.({ data: view.buffer });
  }
  ops(op: string) {
    return this.sent.filter((m) => m.op === op);
  }
}

const last = () => Peer.all.at(-1)!;
const subscribed = (peer: Peer) => peer.ops("subscribe").flatMap((m) => m.subscriptions as { id: number; channelId: number }[]);

describe("a client of the monitor's WebSocket", () => {
  let client: FoxgloveClient;
  beforeEach(() => {
    vi.useFakeTimers();
    Peer.all = [];
    client = new FoxgloveClient(() => "ws://robot/quad", (url, protocols) => new Peer(url, protocols));
  });

  it("offers the name of the protocol", () => {
    client.connect();
    expect(last().protocols).toEqual(["foxglove.websocket.v1"]);
  });

  it("subscribes a topic once however many listen, and hands each message to all", () => {
    const a = vi.fn(), b = vi.fn();
    client.subscribe("/imu", a);
    client.subscribe("/imu", b);
    last().open([7, "/imu"]);
    expect(subscribed(last())).toEqual([{ id: 1, channelId: 7 }]);
    last().data(1, 123n, 5, 6);
    expect(a).toHaveBeenCalledOnce();
    const [payload, time] = b.mock.calls[0]!;
    expect([payload.byteLength, payload.getUint8(1), time]).toEqual([2, 6, 123]);
  });

  it("gives times of the robot's clock, exactly, though messages carry a date", () => {
    const heard = vi.fn();
    client.subscribe("/imu", heard);
    last().open([7, "/imu"]);
    last().says({ op: "serverInfo", metadata: { unix_ns: "1795630958318123456" } });
    last().data(1, 1795630958318123456n + 789n, 1);
    expect(heard.mock.calls[0]![1]).toBe(789);
  });

  it("unsubscribes with the last listener only, and a late message reaches nobody", () => {
    const a = vi.fn();
    const endA = client.subscribe("/imu", a), endB = client.subscribe("/imu", vi.fn());
    last().open([7, "/imu"]);
    endB();
    expect(last().ops("unsubscribe")).toEqual([]);
    endA();
    expect(last().ops("unsubscribe")).toEqual([{ op: "unsubscribe", subscriptionIds: [1] }]);
    last().data(1, 1n, 0);
    expect(a).not.toHaveBeenCalled();
  });

  it("takes a topic that is advertised later, and again after the robot was away", () => {
    client.subscribe("/imu", vi.fn());
    last().open();
    expect(subscribed(last())).toEqual([]);
    last().says({ op: "advertise", channels: [{ id: 9, topic: "/imu", encoding: "cdr", schemaName: "", schema: "" }] });
    last().says({ op: "unadvertise", channelIds: [9] });
    last().says({ op: "advertise", channels: [{ id: 11, topic: "/imu", encoding: "cdr", schemaName: "", schema: "" }] });
    expect(subscribed(last()).map((s) => s.channelId)).toEqual([9, 11]);
    expect(client.subscriptions).toBe(1);
  });

  it("comes back by itself after the monitor was lost, waiting longer each time", () => {
    const heard = vi.fn();
    client.subscribe("/imu", heard);
    last().open([7, "/imu"]);
    last().close();
    expect(client.state.value).toBe("closed");
    expect(client.channels.value.size).toBe(0);
    vi.advanceTimersByTime(249);
    expect(Peer.all.length).toBe(1);
    vi.advanceTimersByTime(1);
    last().close();
    vi.advanceTimersByTime(250);
    expect(Peer.all.length).toBe(2);
    vi.advanceTimersByTime(250);
    expect(Peer.all.length).toBe(3);
    last().open([1, "/imu"]);
    last().data(subscribed(last())[0]!.id, 5n, 1);
    expect(heard).toHaveBeenCalledOnce();
  });

  it("subscribes nothing while the page is hidden", () => {
    client.subscribe("/imu", vi.fn());
    last().open([7, "/imu"]);
    client.pause(true);
    expect(last().ops("unsubscribe").length).toBe(1);
    client.subscribe("/imu2", vi.fn());
    last().says({ op: "advertise", channels: [{ id: 8, topic: "/imu2", encoding: "cdr", schemaName: "", schema: "" }] });
    expect(client.subscriptions).toBe(0);
    client.pause(false);
    expect(subscribed(last()).map((s) => s.channelId)).toEqual([7, 7, 8]);
  });
});
