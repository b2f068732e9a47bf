// Reads MCAP files with the packages of the format's authors and prints their contents, one line each.
// usage: node read_all.mjs FILE...      exit 1 and a line "FILE: why" for each that they refuse
import { crc32 } from "@foxglove/crc";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { loadDecompressHandlers } from "@mcap/support";
import { readFileSync } from "node:fs";

const hex = (bytes) => crc32(bytes).toString(16).padStart(8, "0");
const texts = (map) => [...map].sort(([a], [b]) => (a < b ? -1 : 1)).map(([k, v]) => `${k}=${v}`).join(",");
const expect = (good, what) => {
  if (!good) throw new Error(what);
};

const line = {
  Header: (r) => `header ${r.profile}|${r.library}`,
  Schema: (r) => `schema ${r.id} ${r.name} ${r.encoding} ${r.data.length} ${hex(r.data)}`,
  Channel: (r) => `channel ${r.id} ${r.schemaId} ${r.topic} ${r.messageEncoding} ${texts(r.metadata)}`,
  Attachment: (r) =>
    `attachment ${r.logTime} ${r.createTime} ${r.name} ${r.mediaType} ${r.data.length} ${hex(r.data)}`,
  Metadata: (r) => `metadata ${r.name} ${texts(r.metadata)}`,
  Message: (r) =>
    `message ${r.channelId} ${r.sequence} ${r.logTime} ${r.publishTime} ${r.data.length} ${hex(r.data)}`,
  Statistics: (r) =>
    `statistics ${r.messageCount} ${r.schemaCount} ${r.channelCount} ${r.attachmentCount} ${r.metadataCount} ` +
    `${r.chunkCount} ${r.messageStartTime} ${r.messageEndTime} ` +
    [...r.channelMessageCounts].sort(([a], [b]) => a - b).map(([k, v]) => `${k}:${v}`).join(","),
};

// Everything from the first byte to the last, checksums of chunks and attachments checked by the package.
function stream(bytes, decompressHandlers) {
  const reader = new McapStreamReader({ decompressHandlers, validateCrcs: true, includeChunks: true });
  const found = { lines: new Set(), messages: [], chunks: 0, dataCrc: 0 };
  reader.append(bytes);
  for (let r; (r = reader.nextRecord()); ) {
    if (r.type === "Message") found.messages.push(line.Message(r));
    else if (r.type === "Chunk") ++found.chunks;
    else if (r.type === "DataEnd") found.dataCrc = r.dataSectionCrc;
    else if (r.type === "SummaryOffset") expect(bytes[Number(r.groupStart)] === r.groupOpcode, "summary offset");
    else if (line[r.type]) found.lines.add(line[r.type](r));
  }
  expect(reader.done(), "not a whole file");
  return found;
}

async function indexed(bytes, decompressHandlers) {
  const readable = {
    size: async () => BigInt(bytes.length),
    read: async (offset, size) => bytes.subarray(Number(offset), Number(offset + size)),
  };
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
  const found = { lines: [], messages: [], chunks: reader.chunkIndexes.length };
  found.lines.push(line.Header(reader.header));
  for (const r of reader.schemasById.values()) found.lines.push(line.Schema(r));
  for (const r of reader.channelsById.values()) found.lines.push(line.Channel(r));
  for await (const r of reader.readAttachments()) found.lines.push(line.Attachment(r));
  for await (const r of reader.readMetadata()) found.lines.push(line.Metadata(r));
  if (reader.statistics) found.lines.push(line.Statistics(reader.statistics));
  let last = 0n;
  for await (const r of reader.readMessages({ validateCrcs: true })) {
    expect(r.logTime >= last, "messages out of order");
    last = r.logTime;
    found.messages.push(line.Message(r));
  }
  // Through the indexes alone: a window of time, one topic.
  for (const r of reader.channelsById.values()) {
    let count = 0n;
    for await (const _ of reader.readMessages({ topics: [r.topic] })) ++count;
    expect(count === (reader.statistics.channelMessageCounts.get(r.id) ?? 0n), `messages of ${r.topic}`);
  }
  return found;
}

const decompressHandlers = await loadDecompressHandlers();
let failed = 0;
for (const file of process.argv.slice(2)) {
  try {
    const bytes = new Uint8Array(readFileSync(file));
    const streamed = stream(bytes, decompressHandlers);
    const found = await indexed(bytes, decompressHandlers);
    expect(streamed.chunks === found.chunks, "chunks in the data and in the summary differ");
    expect(streamed.messages.sort().join() === found.messages.sort().join(), "messages with and without indexes differ");
    expect([...streamed.lines].sort().join() === found.lines.sort().join(), "records of data and summary differ");
    const head = Number(bytes.length - 37);
    const summaryStart = Number(new DataView(bytes.buffer).getBigUint64(head + 9, true));
    expect(crc32(bytes.subarray(0, summaryStart - 13)) === streamed.dataCrc, "checksum of the data section");
    console.log(`file ${file}\n${[...found.lines, ...found.messages].join("\n")}`);
  } catch (error) {
    console.log(`${file}: ${error.message}`);
    failed = 1;
  }
}
process.exitCode = failed;  // exit() would not wait for what is printed
