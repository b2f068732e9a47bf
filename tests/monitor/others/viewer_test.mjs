// The monitor's WebSocket through the protocol's own npm client, and its messages through the format's own decoder.
// usage: URL=ws://HOST:PORT TOKEN=T ROBOT=NAME ECHO='["sinew", "topic", ...]' node --test viewer_test.mjs
import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import wsProtocol from "@foxglove/ws-protocol";
import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { test } from "node:test";
import { promisify } from "node:util";
import WebSocket from "ws";

const { FoxgloveClient, BinaryOpcode } = wsProtocol;
const { URL, TOKEN, ROBOT, ECHO } = process.env;
const LIMIT_MS = 60_000; // for any step here, on a machine that is busy elsewhere
const text = new TextDecoder();

/** A connection that remembers what came, by event. */
class Viewer {
  constructor(path, options = {}) {
    this.came = new Map();
    this.waiting = [];
    this.ws = new WebSocket(URL + path, [FoxgloveClient.SUPPORTED_SUBPROTOCOL], options);
    this.client = new FoxgloveClient({ ws: this.ws });
    for (const event of ["serverInfo", "advertise", "unadvertise", "advertiseServices", "status", "message", "time",
      "parameterValues", "serviceCallResponse", "serviceCallFailure", "connectionGraphUpdate", "close", "error"])
      this.client.on(event, (what) => {
        this.came.set(event, [...(this.came.get(event) ?? []), what]);
        this.waiting = this.waiting.filter((w) => !w());
      });
  }
  all(event) {
    return this.came.get(event) ?? [];
  }
  /** The first of this event that fits, also of those that came already. */
  async next(event, fits = () => true) {
    return new Promise((resolve, reject) => {
      const timer = setTimeout(() => reject(new Error(`no ${event} that fits; status: ${
        JSON.stringify(this.all("status"))}`)), LIMIT_MS);
      const look = () => {
        const found = this.all(event).find(fits);
        if (found === undefined) return false;
        clearTimeout(timer);
        resolve(found);
        return true;
      };
      if (!look()) this.waiting.push(look);
    });
  }
  async channel(topic) {
    const list = await this.next("advertise", (channels) => channels.some((c) => c.topic === topic));
    return list.find((c) => c.topic === topic);
  }
  async service(name) {
    const list = await this.next("advertiseServices", (services) => services.some((s) => s.name === name));
    return list.find((s) => s.name === name);
  }
  /** Subscribes, and waits for the first message. */
  async first(topic) {
    const channel = await this.channel(topic);
    const id = this.client.subscribe(channel.id);
    return { channel, id, message: await this.next("message", (m) => m.subscriptionId === id) };
  }
  close() {
    this.client.close();
  }
}

const bytes_of = (view) => new Uint8Array(view.buffer, view.byteOffset, view.byteLength);
const decoder = (channel) => new MessageReader(parse(channel.schema, { ros2: true }));
/** As JSON, with integers that need 64 bits as text. */
const plain = (value) => JSON.parse(JSON.stringify(value, (_, v) =>
  typeof v === "bigint" ? String(v) : ArrayBuffer.isView(v) ? Array.from(v) : v));
const exact = (line) => JSON.parse(line.replace(/([:[,])(-?\d{16,})(?=[,\]}])/g, '$1"$2"'));

test("a session begins with what the server can do and all channels", async () => {
  const v = new Viewer(`/${ROBOT}`);
  const info = await v.next("serverInfo");
  assert.deepEqual(info.capabilities, ["parameters", "parametersSubscribe", "services", "connectionGraph", "time"]);
  assert.deepEqual(info.supportedEncodings, ["json"]);
  assert.equal(info.metadata.robot, ROBOT);
  assert.equal((await v.channel("/counter.range")).schemaName, "sinew_msgs/msg/RangeSample");
  assert.equal((await v.channel("/eye.image")).schemaName, "sensor_msgs/msg/Image");
  assert.equal((await v.channel("/eye.image/jpeg")).schemaName, "sensor_msgs/msg/CompressedImage");
  assert.equal((await v.channel("/sinew/status")).schemaEncoding, "jsonschema");
  v.close();
});

test("messages decode to the values that sinew topic echo shows, and none is missing", async () => {
  const v = new Viewer(`/${ROBOT}`);
  const { channel, id } = await v.first("/counter.range");
  const command = JSON.parse(ECHO);
  const { stdout } = await promisify(execFile)(command[0], [...command.slice(1), "counter.range", "-n", "100", "--json"]);
  const echoed = stdout.trim().split("\n").map(exact);
  assert.equal(echoed.length, 100);
  const last = String(echoed.at(-1).message.stamp);
  const reader = decoder(channel);
  const decoded = (m) => plain(reader.readMessage(bytes_of(m.data)));
  await v.next("message", (m) => m.subscriptionId === id && String(decoded(m).stamp) === last);
  const ours = v.all("message").filter((m) => m.subscriptionId === id);
  const by_stamp = new Map(ours.map((m) => [String(decoded(m).stamp), m]));
  assert.equal(by_stamp.size, ours.length, "each comes once");
  for (const line of echoed) {
    const m = by_stamp.get(String(line.message.stamp));
    assert.ok(m, `no message of ${line.message.stamp}`);
    const { stamp, ...rest } = decoded(m);
    const { stamp: _, ...expected } = line.message;
    assert.deepEqual(rest, expected);
    assert.equal(String(m.timestamp), String(line.published_ns));
  }
  v.close();
});

test("pictures come as sensor_msgs/msg/Image with all their pixels", async () => {
  const v = new Viewer(`/${ROBOT}`);
  const { channel, message } = await v.first("/eye.image");
  const image = decoder(channel).readMessage(bytes_of(message.data));
  assert.deepEqual([image.width, image.height, image.encoding, image.step], [160, 100, "mono8", 160]);
  assert.equal(image.data.length, 16000);
  assert.ok(image.data.every((p) => p === image.data[0]), "a torn picture shows");
  assert.equal(image.header.frame_id, "eye.image");
  v.close();
});

test("pictures come as JPEG beside", async () => {
  const v = new Viewer(`/${ROBOT}`);
  const { channel, id } = await v.first("/camera.raw/jpeg");
  await new Promise((r) => setTimeout(r, 1000));
  const all = v.all("message").filter((m) => m.subscriptionId === id).map((m) => decoder(channel).readMessage(bytes_of(m.data)));
  assert.ok(all.length >= 3, `${all.length} pictures in a second`);
  for (const picture of all) {
    assert.equal(picture.format, "jpeg");
    assert.deepEqual(Array.from(picture.data.slice(0, 3)), [0xff, 0xd8, 0xff]);
    assert.deepEqual(Array.from(picture.data.slice(-2)), [0xff, 0xd9]);
  }
  const stamps = all.map((p) => p.header.stamp.sec * 1e9 + p.header.stamp.nsec);
  assert.ok(stamps.every((s, i) => i === 0 || s > stamps[i - 1]), "each is newer than the one before");
  v.close();
});

test("all robots come with their names in front", async () => {
  const v = new Viewer("/");
  const { message } = await v.first(`/${ROBOT}/counter.range`);
  assert.ok(message.data.byteLength > 0);
  assert.ok(!(await v.next("serverInfo")).capabilities.includes("time"));
  v.close();
});

test("a robot that ends is taken back, and advertised again when it runs again", async () => {
  const v = new Viewer(`/?token=${TOKEN}`);
  const { channel, id } = await v.first("/phoenix/counter.range");
  const stop = await v.service("/phoenix/sinew/stop");
  v.client.sendServiceCallRequest({ serviceId: stop.id, callId: 1, encoding: "json", data: new Uint8Array() });
  await v.next("serviceCallResponse");
  await v.next("unadvertise", (ids) => ids.includes(channel.id));
  const again = await v.next("advertise", (list) => list.some((c) => c.topic === channel.topic && c.id !== channel.id));
  const other = v.client.subscribe(again.find((c) => c.topic === channel.topic).id);
  assert.notEqual(other, id);
  await v.next("message", (m) => m.subscriptionId === other);
  v.close();
});

test("the status comes about five times a second, the time line about once", async () => {
  const v = new Viewer(`/${ROBOT}`);
  const { id, message } = await v.first("/sinew/status");
  const status = JSON.parse(text.decode(message.data));
  assert.ok(status.modules.some((m) => m.name === "counter"));
  await new Promise((r) => setTimeout(r, 2000));
  assert.ok(v.all("message").filter((m) => m.subscriptionId === id).length >= 3);
  const timeline = await v.first("/sinew/timeline");
  const line = JSON.parse(text.decode(timeline.message.data));
  assert.ok(line.events.some((e) => e[0] === "step"));
  v.close();
});

test("the robot's time comes, and messages have times of the same clock", async () => {
  const v = new Viewer(`/${ROBOT}`);
  const { message } = await v.first("/counter.range");
  const first = await v.next("time");
  const later = await v.next("time", (t) => t.timestamp > first.timestamp);
  assert.ok(later.timestamp - message.timestamp < 60_000_000_000n);
  v.close();
});

test("without the token everything is shown and nothing can be changed", async () => {
  const v = new Viewer(`/${ROBOT}`);
  await v.channel("/counter.range");
  v.client.setParameters([{ name: "counter.gain", value: 5 }], "set");
  assert.match((await v.next("status")).message, /counter\.gain: needs the token/);
  const service = await v.service("/sinew/disarm");
  v.client.sendServiceCallRequest({ serviceId: service.id, callId: 3, encoding: "json", data: new Uint8Array() });
  assert.match((await v.next("serviceCallFailure")).message, /needs the token/);
  v.close();
});

test("a wrong token is refused", async () => {
  const v = new Viewer(`/${ROBOT}?token=wrong`);
  const error = await v.next("error");
  assert.match(error.message, /401/);
});

test("a page of another site is refused, and so is a name that is not the monitor's", async () => {
  const site = new Viewer(`/${ROBOT}`, { headers: { Origin: "http://evil.example" } });
  assert.match((await site.next("error")).message, /403/);
  const name = new Viewer(`/${ROBOT}`, { headers: { Host: "evil.example" } });
  assert.match((await name.next("error")).message, /403/);
  const nobody = new Viewer("/nobody");
  assert.match((await nobody.next("error")).message, /404/);
});

test("parameters are read, written and followed", async () => {
  const v = new Viewer(`/${ROBOT}?token=${TOKEN}`);
  const other = new Viewer(`/${ROBOT}`);
  await v.channel("/counter.range");
  await other.channel("/counter.range");
  other.client.subscribeParameterUpdates(["counter.gain"]);
  const value = (list, name) => list.parameters.find((p) => p.name === name)?.value;
  await other.next("parameterValues", (p) => value(p, "counter.gain") === 1);
  v.client.getParameters([], "all");
  const all = await v.next("parameterValues", (p) => p.id === "all");
  assert.deepEqual(all.parameters.find((p) => p.name === "counter.gain"), { name: "counter.gain", value: 1, type: "float64" });
  assert.equal(value(all, "counter.active"), true);
  assert.equal(value(all, "eye.enabled"), true);
  assert.equal(value(all, "fast.period_us"), 5000);
  v.client.setParameters([{ name: "counter.gain", value: 2.5 }, { name: "eye.enabled", value: false }], "set");
  const set = await v.next("parameterValues", (p) => p.id === "set");
  assert.equal(value(set, "counter.gain"), 2.5);
  assert.equal(value(set, "eye.enabled"), false);
  await other.next("parameterValues", (p) => value(p, "counter.gain") === 2.5);
  v.client.setParameters([{ name: "counter.gain", value: 99 }], "refused");
  assert.match((await v.next("status")).message, /counter\.gain: .*from 0 to 10/);
  v.client.setParameters([{ name: "counter.gain", value: 1 }, { name: "eye.enabled", value: true }], "back");
  await v.next("parameterValues", (p) => p.id === "back");
  v.close();
  other.close();
});

test("a client's message reaches its topic, and what is wrong with one is said", async () => {
  const v = new Viewer(`/${ROBOT}?token=${TOKEN}`);
  assert.ok((await v.next("serverInfo")).capabilities.includes("clientPublish"));
  await v.channel("/operator.range");
  const channel = v.client.advertise({ topic: "/operator.range", encoding: "json", schemaName: "RangeSample" });
  v.client.sendMessage(channel, new TextEncoder().encode(JSON.stringify({ stamp: 7, range_m: 4.25 })));
  const { channel: ours, message } = await v.first("/operator.range");
  assert.equal(decoder(ours).readMessage(bytes_of(message.data)).range_m, 4.25);
  v.client.sendMessage(channel, new TextEncoder().encode(JSON.stringify({ range: 1 })));
  assert.match((await v.next("status")).message, /no such field: stamp, range_m/);
  v.close();
});

test("services are the robot's requests", async () => {
  const v = new Viewer(`/${ROBOT}?token=${TOKEN}`);
  const call = async (name, callId) => {
    const service = await v.service(name);
    v.client.sendServiceCallRequest({ serviceId: service.id, callId, encoding: "json", data: new TextEncoder().encode("{}") });
    return Promise.race([v.next("serviceCallResponse", (r) => r.callId === callId),
      v.next("serviceCallFailure", (r) => r.callId === callId)]);
  };
  assert.match((await call("/sinew/record.status", 1)).message, /no recorder/);
  const disarmed = await call("/sinew/disarm", 2);
  assert.ok(disarmed.op === BinaryOpcode.SERVICE_CALL_RESPONSE || /guardian/.test(disarmed.message), JSON.stringify(disarmed));
  v.close();
});

test("the graph has modules as publishers and subscribers", async () => {
  const v = new Viewer(`/${ROBOT}`);
  await v.channel("/counter.range");
  v.client.subscribeConnectionGraph();
  const graph = await v.next("connectionGraphUpdate");
  assert.deepEqual(graph.publishedTopics.find((t) => t.name === "/counter.range").publisherIds, ["counter"]);
  assert.deepEqual(graph.subscribedTopics.find((t) => t.name === "/counter.range").subscriberIds, ["follower", "eye"]);
  assert.ok(graph.advertisedServices.some((s) => s.name === "/sinew/arm"));
  v.close();
});

test("a client that reads nothing is closed, and others go on", async () => {
  const slow = new Viewer(`/${ROBOT}`);
  const camera = await slow.channel("/camera.raw");
  slow.client.subscribe(camera.id);
  slow.ws.pause();
  const v = new Viewer(`/${ROBOT}`);
  const { id } = await v.first("/counter.range");
  const before = v.all("message").length;
  await v.next("message", (m) => m.subscriptionId === id && v.all("message").length > before + 400);
  v.close();
  // It is closed ten seconds after the buffers between us are full; what they hold comes before the end.
  await new Promise((r) => setTimeout(r, 20_000));
  slow.ws.resume();
  await slow.next("close");
});
