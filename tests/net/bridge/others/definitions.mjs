// definitions.mjs humble|jazzy DEFINITIONS.json IDL: checks our definitions against those of others.
//  - each parses as a .msg definition, and the IDL as IDL;
//  - where the distribution's own definition is known, its fields are the same, in their order;
//  - a sample of each type, decoded by its definition and by the distribution's, gives the same values.
import { readFileSync } from "node:fs";
import { parse } from "@foxglove/rosmsg";
import { parseIDL } from "@foxglove/omgidl-parser";
import * as common from "@foxglove/rosmsg-msgs-common";
import { MessageReader } from "@foxglove/rosmsg2-serialization";

const [distro, file, idl] = process.argv.slice(2);
const ours = JSON.parse(readFileSync(file, "utf8"));
const theirs = common[distro === "jazzy" ? "ros2jazzy" : "ros2humble"];
let failed = 0, compared = 0;
const fail = (name, why) => (console.log(`${name}: ${why}`), ++failed);
const short = (name) => name.replace(/\/(msg|srv)\//, "/");

const fieldsOf = (definition) =>
  definition.definitions
    .filter((f) => !f.isConstant)
    .map((f) => [f.name, short(f.type), !!f.isArray, f.arrayLength ?? 0, f.arrayUpperBound ?? 0].join(" "))
    // A time is an own type here, and built in there; an octet is an uint8 of their table.
    .map((f) => f.replace(" builtin_interfaces/Time ", " time ").replace(" builtin_interfaces/Duration ", " duration ").replace(/ (byte|char) /, " uint8 "));

/// Everything a type needs, of their table.
const closure = (name, seen = new Map()) => {
  const definition = theirs[name];
  if (!definition || seen.has(name)) return seen;
  seen.set(name, definition);
  for (const f of definition.definitions) if (f.isComplex) closure(f.type, seen);
  return seen;
};
const plain = (value) =>
  JSON.stringify(value, (_, v) => (typeof v === "bigint" ? String(v) : ArrayBuffer.isView(v) ? Array.from(v, (x) => (typeof x === "bigint" ? String(x) : x)) : v && typeof v === "object" && "nsec" in v ? { sec: v.sec, nanosec: v.nsec } : v));

const idlTypes = parseIDL(readFileSync(idl, "utf8"));
for (const [name, { definition, sample }] of Object.entries(ours)) {
  let parsed;
  try {
    parsed = parse(definition, { ros2: true });
  } catch (e) {
    fail(name, `the definition does not parse: ${e.message}`);
    continue;
  }
  if (!idlTypes.some((t) => t.name === name.replaceAll("/", "::"))) fail(name, "is not in the IDL");
  const bytes = Buffer.from(sample, "hex");
  let values;
  try {
    values = plain(new MessageReader(parsed).readMessage(bytes));
  } catch (e) {
    fail(name, `its sample is not decoded: ${e.message}`);
    continue;
  }
  const other = theirs[short(name)];
  if (name.includes("/srv/") || !other) continue;
  ++compared;
  const a = fieldsOf(parsed[0]).join("\n"), b = fieldsOf(other).join("\n");
  if (a !== b) fail(name, `other fields:\n${a}\n-- theirs:\n${b}`);
  const theirValues = plain(new MessageReader([...closure(short(name)).values()]).readMessage(bytes));
  if (values !== theirValues) fail(name, `other values:\n${values}\n-- theirs:\n${theirValues}`);
}
console.log(`${distro}: ${Object.keys(ours).length} definitions parse, ${compared} compared with the distribution's, ${failed} failed`);
process.exit(failed === 0 ? 0 : 1);
