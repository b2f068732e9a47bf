// How old the picture is that a viewer sees, and the values of a plot beside it.
// usage: node thin_link.mjs URL PICTURES PLOT SECONDS      prints JSON; times are of CLOCK_MONOTONIC, the robot's clock
import wsProtocol from "@foxglove/ws-protocol";
import WebSocket from "ws";

const { FoxgloveClient } = wsProtocol;
const [url, pictures, plot, seconds] = process.argv.slice(2);
const now_ms = () => Number(process.hrtime.bigint() / 1000n) / 1000;
const client = new FoxgloveClient({ ws: new WebSocket(url, [FoxgloveClient.SUPPORTED_SUBPROTOCOL]) });
const shown = [], values = [];
let unix_ns = 0n, picture_id, plot_id, begin_ms;

client.on("error", (e) => {
  console.error(String(e));
  process.exit(1);
});
client.on("serverInfo", (info) => (unix_ns = BigInt(info.metadata.unix_ns)));
client.on("advertise", (channels) => {
  for (const c of channels) {
    if (c.topic === pictures) picture_id = client.subscribe(c.id);
    if (c.topic === plot) plot_id = client.subscribe(c.id);
  }
});
client.on("message", ({ subscriptionId, timestamp, data }) => {
  const at = now_ms();
  if (subscriptionId === plot_id) values.push({ at, age: at - Number(timestamp - unix_ns) / 1e6 });
  if (subscriptionId !== picture_id) return;
  // sensor_msgs/msg/CompressedImage: behind the encapsulation the stamp's seconds and nanoseconds.
  const stamp = BigInt(data.getInt32(4, true)) * 1_000_000_000n + BigInt(data.getUint32(8, true)) - unix_ns;
  begin_ms ??= at;
  shown.push({ at, stamp: Number(stamp) / 1e6, bytes: data.byteLength });
});

const share = (sorted, p) => sorted[Math.min(sorted.length - 1, Math.floor(p * sorted.length))];
const digest = (list) => {
  const sorted = list.slice().sort((a, b) => a - b);
  return Object.fromEntries([["p50", 0.5], ["p95", 0.95], ["p99", 0.99], ["max", 1]].map(([n, p]) => [n, Math.round(share(sorted, p))]));
};
setTimeout(() => {
  // The first seconds, in which the sizes are found, count too.
  const end = now_ms(), ages = [];
  for (let t = begin_ms, i = 0; t < end; t += 10) {
    while (i + 1 < shown.length && shown[i + 1].at <= t) ++i;
    ages.push(t - shown[i].stamp);
  }
  const gaps = values.slice(1).map((v, i) => v.at - values[i].at);
  console.log(JSON.stringify({
    seconds: Math.round((end - begin_ms) / 1000),
    pictures: shown.length,
    shown_age_ms: digest(ages),
    arrival_age_ms: digest(shown.map((s) => s.at - s.stamp)),
    picture_bytes: digest(shown.map((s) => s.bytes)),
    plot: { values: values.length, age_ms: digest(values.map((v) => v.age)), gap_ms: digest(gaps) },
  }));
  process.exit(0);
}, Number(seconds) * 1000);
