// foxglove.sdk.v1 and playback control, by a client that is written from the specification: no npm package speaks them.
// usage: URL=ws://HOST:PORT ROBOT=NAME [RECORDED=NAME] TOKEN=T node --test sdk_test.mjs
import assert from "node:assert/strict";
import { test } from "node:test";
import WebSocket from "ws";

const { URL, ROBOT, RECORDED, TOKEN } = process.env;
const LIMIT_MS = 60_000; // for any step here, on a machine that is busy elsewhere

/** Text messages as objects in `texts`, binary ones as DataViews in `binaries`. */
function connect(path, protocols) {
  const c = { ws: new WebSocket(URL + path, protocols), texts: [], binaries: [], waiting: [] };
  c.ws.binaryType = "arraybuffer";
  c.ws.onmessage = ({ data }) => {
    if (typeof data === "string") c.texts.push(JSON.parse(data));
    else c.binaries.push(new DataView(data));
    c.waiting = c.waiting.filter((look) => !look());
  };
  c.next = (list, fits) => new Promise((resolve, reject) => {
    const timer = setTimeout(() => reject(new Error(`nothing that fits; ${
      JSON.stringify(c.texts.filter((t) => t.op === "status"))}`)), LIMIT_MS);
    const look = () => {
      const found = list.find(fits);
      if (found === undefined) return false;
      clearTimeout(timer);
      resolve(found);
      return true;
    };
    if (!look()) c.waiting.push(look);
  });
  c.text = (op, fits = () => true) => c.next(c.texts, (t) => t.op === op && fits(t));
  c.binary = (op, fits = () => true) => c.next(c.binaries, (b) => b.getUint8(0) === op && fits(b));
  c.channel = async (topic) =>
    (await c.text("advertise", (a) => a.channels.some((x) => x.topic === topic))).channels.find((x) => x.topic === topic);
  c.subscribe = async (topic, id) => {
    c.ws.send(JSON.stringify({ op: "subscribe", subscriptions: [{ id, channelId: (await c.channel(topic)).id }] }));
    return c.binary(1, (b) => b.getUint32(1, true) === id);
  };
  return c;
}

const refused = (protocols) => new Promise((resolve, reject) => {
  const ws = new WebSocket(`${URL}/${ROBOT}`, protocols);
  ws.on("unexpected-response", (_, response) => resolve(response.statusCode));
  ws.on("open", () => reject(new Error("it was let in")));
  ws.on("error", () => resolve("closed"));
});

test("the protocol's newer name is taken and answered by itself", async () => {
  const c = connect(`/${ROBOT}`, ["foxglove.sdk.v1"]);
  await c.text("serverInfo");
  assert.equal(c.ws.protocol, "foxglove.sdk.v1");
  c.ws.close();
});

test("of both names the one that the client offers first is taken", async () => {
  for (const offered of [["foxglove.websocket.v1", "foxglove.sdk.v1"], ["foxglove.sdk.v1", "foxglove.websocket.v1"]]) {
    const c = connect(`/${ROBOT}`, offered);
    await c.text("serverInfo");
    assert.equal(c.ws.protocol, offered[0]);
    c.ws.close();
  }
});

test("a client that offers neither name is refused", async () => {
  assert.equal(await refused(["other.v1"]), "closed");
  assert.equal(await refused(undefined), 400);
});

test("messages have the opcode, the subscription, the time and the payload, in this order", async () => {
  const c = connect(`/${ROBOT}`, ["foxglove.sdk.v1"]);
  const message = await c.subscribe("/counter.range", 7);
  assert.equal(message.byteLength, 1 + 4 + 8 + 4 + 16, "RangeSample in CDR is its encapsulation and two numbers of 8 bytes");
  assert.deepEqual(Array.from(new Uint8Array(message.buffer, 13, 4)), [0, 1, 0, 0]);
  assert.ok(message.getBigInt64(17, true) <= message.getBigUint64(5, true), "its stamp is not after its publication");
  c.ws.close();
});

test("what is no message is told, and the ninth ends the connection", async () => {
  const c = connect(`/${ROBOT}`, ["foxglove.sdk.v1"]);
  await c.text("serverInfo");
  const closed = new Promise((resolve) => c.ws.on("close", resolve));
  c.ws.send("[1, 2");
  assert.equal((await c.text("status")).level, 2);
  for (let i = 0; i < 9; ++i) c.ws.send(new Uint8Array([99]));
  await closed;
});

const skip = RECORDED ? false : "this build has no simulator to record a flight of";

/** Opcode 3: command, speed, whether it seeks, where to, the request's id. */
function control(c, { play, speed, seek, id }) {
  const name = new TextEncoder().encode(id);
  const view = new DataView(new ArrayBuffer(19 + name.length));
  view.setUint8(0, 3);
  view.setUint8(1, play ? 0 : 1);
  view.setFloat32(2, speed, true);
  view.setUint8(6, seek === undefined ? 0 : 1);
  view.setBigUint64(7, seek ?? 0n, true);
  view.setUint32(15, name.length, true);
  new Uint8Array(view.buffer).set(name, 19);
  c.ws.send(view.buffer);
}

/** Opcode 5. */
const state_of = (b) => ({
  status: ["playing", "paused", "buffering", "ended"][b.getUint8(1)],
  time: b.getBigUint64(2, true),
  speed: b.getFloat32(10, true),
  did_seek: b.getUint8(14) !== 0,
  id: new TextDecoder().decode(new Uint8Array(b.buffer, 19, b.getUint32(15, true))),
});

const ns = ({ sec, nsec }) => BigInt(sec) * 1_000_000_000n + BigInt(nsec);

test("a recorded run says its range, and is paused, sought, played and made faster", { skip }, async () => {
  const c = connect(`/${RECORDED}`, ["foxglove.sdk.v1"]);
  const info = await c.text("serverInfo");
  assert.ok(info.capabilities.includes("playbackControl"));
  assert.ok(info.capabilities.includes("time"));
  const [begin, end] = [ns(info.dataStartTime), ns(info.dataEndTime)];
  assert.ok(end > begin);
  const state = async (request) => {
    control(c, request);
    return state_of(await c.binary(5, (b) => state_of(b).id === request.id));
  };
  const middle = begin + (end - begin) / 2n;
  const sought = await state({ play: false, speed: 1, seek: middle, id: "seek" });
  assert.deepEqual([sought.status, sought.did_seek, sought.time], ["paused", true, middle]);
  const slower = await state({ play: true, speed: 0.25, id: "play" });
  assert.deepEqual([slower.status, slower.speed, slower.did_seek], ["playing", 0.25, false]);
  assert.ok(slower.time >= middle);
  assert.ok(await c.binary(2, (b) => b.getBigUint64(1, true) > middle), "its time goes on");
  const paused = await state({ play: false, speed: 0.25, id: "pause" });
  assert.equal(paused.status, "paused");
  // Others steer it, too: what they do is told.
  const other = connect(`/${RECORDED}`, ["foxglove.sdk.v1"]);
  await other.text("serverInfo");
  control(other, { play: true, speed: 2, id: "other" });
  assert.ok(await c.binary(5, (b) => state_of(b).id === "" && state_of(b).speed === 2));
  control(other, { play: false, speed: 1, seek: begin, id: "back" });
  await other.binary(5, (b) => state_of(b).id === "back");
  c.ws.close();
  other.ws.close();
});

test("a recorded run's playback is a channel, and its topics have messages of the time that is shown", { skip }, async () => {
  const c = connect(`/${RECORDED}`, ["foxglove.sdk.v1"]);
  const info = await c.text("serverInfo");
  const middle = (ns(info.dataStartTime) + ns(info.dataEndTime)) / 2n;
  control(c, { play: false, speed: 1, seek: middle, id: "s" });
  await c.binary(5, (b) => state_of(b).id === "s");
  const playback = await c.subscribe("/sinew/playback", 1);
  const shown = JSON.parse(new TextDecoder().decode(new Uint8Array(playback.buffer, 13)));
  assert.ok(["paused", "playing", "ended"].includes(shown.state));
  const topics = (await c.text("advertise", (a) => a.channels.length > 3)).channels.filter((x) => x.encoding === "cdr");
  assert.ok(topics.length > 0);
  const range = topics.find((t) => t.topic.endsWith(".raw") && t.schemaName.startsWith("sinew_msgs"));
  const message = await c.subscribe(range.topic, 2);
  assert.ok(message.getBigUint64(5, true) <= middle);
  c.ws.close();
});

test("of a robot that runs playback is refused", async () => {
  const c = connect(`/${ROBOT}?token=${TOKEN}`, ["foxglove.sdk.v1"]);
  const info = await c.text("serverInfo");
  assert.ok(!info.capabilities.includes("playbackControl"));
  control(c, { play: false, speed: 1, id: "x" });
  assert.match((await c.text("status")).message, /only of a recorded run/);
  c.ws.close();
});
