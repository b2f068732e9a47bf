// Messages by their ros2msg schema: XCDR1 as the monitor sends them (docs/recording.md), with the units and names of
// values that our schemas have in their remarks: "float64 height_m  # [m] above ground".

export type Primitive =
  | "bool" | "int8" | "uint8" | "int16" | "uint16" | "int32" | "uint32" | "int64" | "uint64" | "float32" | "float64" | "string";

export interface Field {
  name: string;
  type: Primitive | Struct;
  /** null: one value; a number: an array of that length; "sequence": of any length. */
  array: null | number | "sequence";
  unit: string;
  doc: string;
  /** Names of values; `bits`: or-ed. */
  names: Map<number, string> | null;
  bits: boolean;
}

export interface Struct {
  name: string;
  doc: string;
  fields: Field[];
}

export type Value = number | boolean | string | Value[] | Uint8Array | Message;
export interface Message {
  [field: string]: Value;
}

const kSizes: Record<Exclude<Primitive, "string">, number> = {
  bool: 1, int8: 1, uint8: 1, int16: 2, uint16: 2, int32: 4, uint32: 4, int64: 8, uint64: 8, float32: 4, float64: 8,
};
const kAliases: Record<string, string> = { byte: "uint8", char: "uint8", wstring: "string" };

function isPrimitive(name: string): name is Primitive {
  return name === "string" || name in kSizes;
}

/** "[m] above ground" and "0 idle, 1 follow; what it does". */
function readRemark(text: string): Pick<Field, "unit" | "doc" | "names" | "bits"> {
  const unit = /^\[([^\]]*)\]\s*/.exec(text);
  let doc = unit ? text.slice(unit[0].length) : text;
  const list = /^(bits: )?(-?\d+ [^,;]+(?:, -?\d+ [^,;]+)*)(?:; |$)/.exec(doc);
  let names: Map<number, string> | null = null;
  if (list) {
    names = new Map(list[2]!.split(", ").map((entry) => {
      const at = entry.indexOf(" ");
      return [Number(entry.slice(0, at)), entry.slice(at + 1)];
    }));
    doc = doc.slice(list[0].length);
  }
  return { unit: unit?.[1] ?? "", doc, names, bits: Boolean(list?.[1]) };
}

/** Throws with the line that it cannot read. */
export function parseSchema(name: string, text: string): Struct {
  const sections = text.split(/^={3,}\s*$/m);
  const structs = new Map<string, Struct>();
  const unresolved: { field: Field; type: string; from: string }[] = [];
  const shortName = (full: string) => full.replace("/msg/", "/");
  sections.forEach((section, index) => {
    const lines = section.split("\n");
    let own = shortName(name);
    const struct: Struct = { name: own, doc: "", fields: [] };
    for (const raw of lines) {
      const head = /^MSG:\s*(\S+)/.exec(raw);
      if (head && index > 0) {
        own = struct.name = shortName(head[1]!);
        continue;
      }
      const hash = raw.indexOf("#");
      const code = (hash < 0 ? raw : raw.slice(0, hash)).trim();
      const remark = hash < 0 ? "" : raw.slice(hash + 1).trim();
      if (!code) {
        if (remark && struct.fields.length === 0) struct.doc += (struct.doc ? " " : "") + remark;
        continue;
      }
      const match = /^([\w/]+)(?:<=\d+)?(\[(?:<=)?\d*\])?\s+(\w+)\s*(=)?/.exec(code);
      if (!match) throw new Error(`${own}: cannot read the line '${code}'`);
      if (match[4]) continue; // a constant
      const type = kAliases[match[1]!] ?? match[1]!;
      const brackets = match[2];
      const array = brackets == null ? null : /^\[\d+\]$/.test(brackets) ? Number(brackets.slice(1, -1)) : "sequence";
      const field: Field = { name: match[3]!, type: "uint8", array, ...readRemark(remark) };
      if (isPrimitive(type)) field.type = type;
      else unresolved.push({ field, type: shortName(type), from: own });
      struct.fields.push(field);
    }
    structs.set(own, struct);
  });
  const time = (unsigned: boolean): Struct => ({
    name: unsigned ? "Time" : "Duration", doc: "",
    fields: [["sec", "int32", "s"], ["nanosec", "uint32", "ns"]].map(([n, t, u]) => ({
      name: n!, type: t as Primitive, array: null, unit: u!, doc: "", names: null, bits: false })),
  });
  for (const { field, type, from } of unresolved) {
    const found = structs.get(type) ?? structs.get(`${from.split("/")[0]}/${type}`) ??
      [...structs.values()].find((s) => s.name.endsWith(`/${type}`));
    if (found) field.type = found;
    else if (/(^|\/)(Time|time)$/.test(type)) field.type = time(true);
    else if (/(^|\/)(Duration|duration)$/.test(type)) field.type = time(false);
    else throw new Error(`${from}: no definition of ${type}`);
  }
  return structs.get(shortName(name))!;
}

/** A cursor in the bytes of one message. Aligned to the size of each number, counted from behind the header of 4 bytes. */
class Cursor {
  at = 4;
  readonly little: boolean;
  constructor(readonly view: DataView) {
    if (view.byteLength < 4) throw new Error("a message without its header");
    this.little = (view.getUint8(1) & 1) === 1;
  }
  align(size: number) {
    const over = (this.at - 4) % size;
    if (over) this.at += size - over;
  }
  number(type: Primitive): number | boolean | string {
    if (type === "string") {
      const length = this.number("uint32") as number;
      const bytes = new Uint8Array(this.view.buffer, this.view.byteOffset + this.at, length);
      this.at += length;
      return new TextDecoder().decode(length > 0 && bytes[length - 1] === 0 ? bytes.subarray(0, -1) : bytes);
    }
    const size = kSizes[type];
    this.align(size);
    const value = readNumber(this.view, this.at, type, this.little);
    this.at += size;
    return type === "bool" ? value !== 0 : value;
  }
}

function readNumber(view: DataView, at: number, type: Primitive, little: boolean): number {
  switch (type) {
    case "bool": case "uint8": return view.getUint8(at);
    case "int8": return view.getInt8(at);
    case "int16": return view.getInt16(at, little);
    case "uint16": return view.getUint16(at, little);
    case "int32": return view.getInt32(at, little);
    case "uint32": return view.getUint32(at, little);
    case "int64": return Number(view.getBigInt64(at, little));
    case "uint64": return Number(view.getBigUint64(at, little));
    case "float32": return view.getFloat32(at, little);
    case "float64": return view.getFloat64(at, little);
    case "string": throw new Error("a text is no number");
  }
}

function readOne(cursor: Cursor, type: Field["type"]): Value {
  return typeof type === "string" ? cursor.number(type) : readStruct(cursor, type);
}

function readStruct(cursor: Cursor, struct: Struct): Message {
  const message: Message = {};
  for (const field of struct.fields) {
    if (field.array === null) {
      message[field.name] = readOne(cursor, field.type);
      continue;
    }
    const length = field.array === "sequence" ? (cursor.number("uint32") as number) : field.array;
    if (field.type === "uint8" || field.type === "int8") {
      if (cursor.at + length > cursor.view.byteLength) throw new Error(`${field.name}: longer than the message`);
      message[field.name] = new Uint8Array(cursor.view.buffer, cursor.view.byteOffset + cursor.at, length);
      cursor.at += length;
      continue;
    }
    if (length > cursor.view.byteLength) throw new Error(`${field.name}: longer than the message`);
    const list: Value[] = [];
    for (let i = 0; i < length; ++i) list.push(readOne(cursor, field.type));
    message[field.name] = list;
  }
  return message;
}

/** Throws when the bytes are too few. Times and 64-bit counts are numbers: exact below 2^53. */
export function decode(struct: Struct, bytes: DataView): Message {
  return readStruct(new Cursor(bytes), struct);
}

export interface Leaf {
  /** "p_world_m.x", "position_rad[2]" */
  path: string;
  unit: string;
  doc: string;
  integer: boolean;
  names: Map<number, string> | null;
}

const kMostOfArray = 64;

/** Every field that is a number, those of arrays one by one; of sequences, whose length no schema knows, none. */
export function numbersOf(struct: Struct): Leaf[] {
  const leaves: Leaf[] = [];
  const walk = (s: Struct, before: string, unitOf: string) => {
    for (const field of s.fields) {
      if (field.array === "sequence" || field.type === "string") continue;
      const unit = field.unit || unitOf;
      const count = field.array ?? 1;
      for (let i = 0; i < Math.min(count, kMostOfArray); ++i) {
        const path = before + field.name + (field.array === null ? "" : `[${i}]`);
        if (typeof field.type === "object") walk(field.type, `${path}.`, unit);
        else leaves.push({ path, unit, doc: field.doc, integer: !field.type.startsWith("float"), names: field.names });
      }
    }
  };
  walk(struct, "", "");
  return leaves;
}

export type Getter = (bytes: DataView) => number;

/** Reads one number of a message without decoding the rest, where nothing of variable length stands before it. Null: the
 *  schema has no such number. */
export function getterOf(struct: Struct, path: string): Getter | null {
  const steps = [...path.matchAll(/(\w+)(?:\[(\d+)\])?\.?/g)].map((m) => ({ name: m[1]!, index: m[2] == null ? null : Number(m[2]) }));
  let at = 0;
  let fixed = true;
  let found: Exclude<Primitive, "string"> | null = null;
  const skip = (type: Field["type"], count: number) => {
    if (typeof type === "object") {
      for (let i = 0; i < count && fixed; ++i) for (const f of type.fields) skipField(f);
    } else if (type === "string") {
      fixed = false;
    } else if (count > 0) {
      const size = kSizes[type];
      at = Math.ceil(at / size) * size + size * count;
    }
  };
  const skipField = (f: Field) => {
    if (!fixed) return;
    if (f.array === "sequence") fixed = false;
    else skip(f.type, f.array ?? 1);
  };
  let struct_: Struct | null = struct;
  for (const [depth, step] of steps.entries()) {
    if (!struct_) return null;
    const field: Field | undefined = struct_.fields.find((f) => f.name === step.name);
    if (!field || (field.array === null) !== (step.index === null)) return null;
    if (typeof field.array === "number" && step.index! >= field.array) return null;
    for (const before of struct_.fields) {
      if (before === field) break;
      skipField(before);
    }
    if (field.array === "sequence") fixed = false;
    else if (fixed && step.index) skip(field.type, step.index);
    if (typeof field.type === "object") struct_ = field.type;
    else {
      if (depth + 1 !== steps.length || field.type === "string") return null;
      found = field.type;
      struct_ = null;
    }
  }
  if (!found) return null;
  const type = found;
  if (fixed) {
    const size = kSizes[type];
    const offset = 4 + Math.ceil(at / size) * size;
    return (view) => (offset + size > view.byteLength ? NaN : readNumber(view, offset, type, (view.getUint8(1) & 1) === 1));
  }
  return (view) => Number(valueAt(decode(struct, view), path) ?? NaN);
}

export function valueAt(message: Message, path: string): Value | undefined {
  let value: Value | undefined = message;
  for (const step of path.matchAll(/(\w+)|\[(\d+)\]/g)) {
    if (value == null || typeof value !== "object") return undefined;
    value = step[1] != null ? (value as Message)[step[1]] : (value as Value[])[Number(step[2])];
  }
  return value;
}

export function nameOfValue(field: Pick<Field, "names" | "bits">, x: number): string {
  if (!field.names) return "";
  if (!field.bits) return field.names.get(x) ?? "";
  return [...field.names].filter(([bit]) => (x & bit) !== 0).map(([, name]) => name).join(", ");
}
