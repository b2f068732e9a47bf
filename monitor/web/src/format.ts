// Numbers for people: a fixed count of digits, so that columns do not jump, and always with their unit.

const kMissing = "–";

function digits(value: number, significant: number): string {
  const size = Math.abs(Number(value.toPrecision(significant))); // 99.96 becomes 100, not 100.0
  const before = size < 1 ? 1 : Math.floor(Math.log10(size)) + 1;
  return value.toFixed(Math.max(0, significant - before));
}

/** 1234567 -> "1.23 ms". */
export function duration(ns: number | null | undefined): string {
  if (ns == null || !Number.isFinite(ns)) return kMissing;
  const size = Math.abs(ns);
  if (size === 0) return "0 µs";
  if (size < 999.5) return `${ns.toFixed(0)} ns`;
  if (size < 999.5e3) return `${digits(ns / 1e3, 3)} µs`;
  if (size < 999.5e6) return `${digits(ns / 1e6, 3)} ms`;
  if (size < 100e9) return `${digits(ns / 1e9, 3)} s`;
  return clock(ns);
}

/** A robot's clock or a length: "7.25 s", "12:03.4", "2:12:03". */
export function clock(ns: number | null | undefined): string {
  if (ns == null || !Number.isFinite(ns)) return kMissing;
  const s = ns / 1e9;
  if (Math.abs(s) < 60) return `${s.toFixed(2)} s`;
  if (s > 1e9) return new Date(s * 1e3).toISOString().slice(11, 22);
  const minutes = Math.floor(s / 60), rest = s - minutes * 60;
  if (minutes < 60) return `${minutes}:${rest.toFixed(1).padStart(4, "0")}`;
  return `${Math.floor(minutes / 60)}:${String(minutes % 60).padStart(2, "0")}:${String(Math.floor(rest)).padStart(2, "0")}`;
}

export function rate(hz: number | null | undefined): string {
  if (hz == null || !Number.isFinite(hz)) return kMissing;
  if (hz === 0) return "0 Hz";
  if (hz >= 99.95) return `${hz.toFixed(0)} Hz`;
  return `${hz.toFixed(1)} Hz`;
}

export function bytes(count: number | null | undefined): string {
  if (count == null || !Number.isFinite(count)) return kMissing;
  if (count < 1000) return `${count} B`;
  for (const [size, unit] of [[1e9, "GB"], [1e6, "MB"], [1e3, "kB"]] as const)
    if (count >= size) return `${digits(count / size, 3)} ${unit}`;
  return `${count} B`;
}

export function percent(share: number | null | undefined): string {
  if (share == null || !Number.isFinite(share)) return kMissing;
  return `${(share * 100).toFixed(share < 0.0995 ? 2 : 1)} %`;
}

export function count(n: number | null | undefined): string {
  if (n == null || !Number.isFinite(n)) return kMissing;
  return n.toFixed(0).replace(/\B(?=(\d{3})+$)/g, " ");
}

/** A message's number: enough digits to see it move, few enough to read. */
export function value(x: number | bigint | boolean | string | null | undefined, integer = false): string {
  if (x == null) return kMissing;
  if (typeof x !== "number") return String(x);
  if (Number.isNaN(x)) return "NaN";
  if (!Number.isFinite(x)) return x > 0 ? "∞" : "−∞";
  if (integer) return x.toFixed(0);
  const size = Math.abs(x);
  if (size !== 0 && (size < 1e-4 || size >= 1e7)) return x.toExponential(3);
  return x.toFixed(size >= 1000 ? 1 : size >= 100 ? 2 : size >= 10 ? 3 : 4);
}

const kUnits: Record<string, string> = { "1": "", degC: "°C", "N m": "N·m", "m/s^2": "m/s²", "kg m^2": "kg·m²", us: "µs" };

/** As people write it; empty: a number without a unit. */
export function unit(name: string): string {
  return kUnits[name] ?? name.replace(/\^2/g, "²").replace(/\^3/g, "³");
}

/** "3 s ago" by this machine's clock. */
export function ago(ms: number): string {
  const s = Math.max(0, Math.round(ms / 1000));
  if (s < 60) return `${s} s ago`;
  if (s < 3600) return `${Math.floor(s / 60)} min ago`;
  return `${Math.floor(s / 3600)} h ago`;
}

export function timeOfDay(ms: number): string {
  return new Date(ms).toTimeString().slice(0, 8);
}
