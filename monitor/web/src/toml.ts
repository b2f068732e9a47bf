// Parameters as `sinew run --params` reads them.

import type { Param } from "./api";

/** Whether it differs from what the run began with. */
export function changed(p: Param): boolean {
  return p.value !== (p.start ?? p.default);
}

export function tomlValue(value: Param["value"], type: Param["type"]): string {
  if (typeof value === "boolean") return String(value);
  if (typeof value === "string") return JSON.stringify(value);
  if (type === "integer" || !Number.isInteger(value)) return String(value);
  return value.toFixed(1); // a number, not an integer
}

/** As `sinew param save` writes them: a table for each module. */
export function tomlOf(params: Param[], robot: string): string {
  const modules = new Map<string, Param[]>();
  for (const p of params) if (changed(p)) modules.set(p.module, [...(modules.get(p.module) ?? []), p]);
  let text = `# Parameters of robot ${robot} that differ from its robot file: sinew run ROBOT --params THIS\n`;
  for (const [module, list] of modules) {
    text += `\n[${module}]\n`;
    for (const p of list) text += `${p.param} = ${tomlValue(p.value, p.type)}\n`;
  }
  return text;
}
