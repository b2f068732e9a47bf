// Decodes every message of recorded files with the packages of the format's authors, by the schemas in the
// files, and compares every field with the line that `sinew bag cat` prints for it.
// usage: node decode_all.mjs FILE CAT [FILE CAT]...     CAT: the lines; exit 1 and the differences
import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import { McapIndexedReader } from "@mcap/core";
import { loadDecompressHandlers } from "@mcap/support";
import { readFileSync } from "node:fs";

let fields = 0;

// Integers beyond 2^53 as text: JSON.parse would round them.
const exact = (line) => JSON.parse(line.replace(/([:[,])(-?\d{16,})(?=[,\]}])/g, '$1"$2"'));

const same_time = (ours, theirs) => ours.sec === theirs.sec && ours.nanosec === (theirs.nanosec ?? theirs.nsec);
const same = {
  time: same_time,
  duration: same_time,
  bool: (ours, theirs) => ours === theirs,
  string: (ours, theirs) => ours === theirs,
  int64: (ours, theirs) => String(ours) === String(theirs),
  uint64: (ours, theirs) => String(ours) === String(theirs),
  float32: (ours, theirs) => Object.is(Math.fround(Number(ours)), theirs),
  float64: (ours, theirs) => Object.is(Number(ours), theirs),
};

function compare(types, definition, ours, theirs, path) {
  if (!definition) throw new Error(`${path}: no definition`);
  const names = definition.definitions.filter((f) => !f.isConstant).map((f) => f.name);
  if (names.join() !== Object.keys(ours).join()) throw new Error(`${path}: ${Object.keys(ours)}, not ${names}`);
  for (const f of definition.definitions) {
    if (f.isConstant) continue;
    const [a, b, at] = [ours[f.name], theirs[f.name], `${path}.${f.name}`];
    if (f.isArray && f.type === "uint8" && f.arrayLength === undefined) {
      if (a.bytes !== b.length) throw new Error(`${at}: ${a.bytes} bytes, not ${b.length}`);
      ++fields;
    } else if (f.isArray) {
      if (a.length !== b.length) throw new Error(`${at}: ${a.length} elements, not ${b.length}`);
      for (let i = 0; i < a.length; ++i) value(types, f, a[i], b[i], `${at}[${i}]`);
    } else {
      value(types, f, a, b, at);
    }
  }
}

function value(types, field, ours, theirs, path) {
  if (field.isComplex) return compare(types, types.get(field.type), ours, theirs, path);
  ++fields;
  const equal = same[field.type] ?? ((a, b) => a === b);
  if (!equal(ours, theirs)) throw new Error(`${path}: ${ours}, not ${theirs}`);
}

async function look(file, cat) {
  const bytes = new Uint8Array(readFileSync(file));
  const readable = {
    size: async () => BigInt(bytes.length),
    read: async (offset, size) => bytes.subarray(Number(offset), Number(offset + size)),
  };
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers: await loadDecompressHandlers() });
  const lines = new Map();  // by channel, sequence and time; steps have no sequence, so several of one kind
  for (const text of readFileSync(cat, "utf8").split("\n").filter((l) => l !== "")) {
    const line = exact(text);
    const key = `${line.topic} ${line.sequence} ${line.log_time_ns} ${line.stamp_ns}`;
    lines.set(key, [...(lines.get(key) ?? []), line.message]);
  }
  const decoders = new Map();
  let messages = 0;
  for await (const m of reader.readMessages({ validateCrcs: true })) {
    const channel = reader.channelsById.get(m.channelId);
    if (!decoders.has(m.channelId)) {
      const schema = reader.schemasById.get(channel.schemaId);
      const definitions = parse(new TextDecoder().decode(schema.data), { ros2: true });
      const types = new Map(definitions.filter((d) => d.name !== undefined).map((d) => [d.name, d]));
      const root = definitions.find((d) => d.name === undefined);
      decoders.set(m.channelId, { types, root, reader: new MessageReader(definitions) });
    }
    const key = `${channel.topic} ${m.sequence} ${m.logTime} ${m.publishTime}`;
    const ours = lines.get(key)?.shift();
    if (!ours) throw new Error(`${key}: not in what cat printed`);
    const d = decoders.get(m.channelId);
    compare(d.types, d.root, ours, d.reader.readMessage(m.data), key);
    ++messages;
  }
  for (const [key, left] of lines) if (left.length > 0) throw new Error(`${key}: printed, but not in the file`);
  console.log(`${file}: ${messages} messages of ${decoders.size} topics`);
}

let failed = 0;
for (let i = 2; i + 1 < process.argv.length; i += 2) {
  try {
    await look(process.argv[i], process.argv[i + 1]);
  } catch (error) {
    console.log(`${process.argv[i]}: ${error.message}`);
    failed = 1;
  }
}
console.log(`${fields} fields`);
process.exitCode = failed || fields === 0 ? 1 : 0;
