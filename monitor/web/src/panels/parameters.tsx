// Every parameter: its value with unit, range and default; what differs from the start of the run is marked and can be
// saved for the robot file.

import { useState } from "preact/hooks";
import type { Param } from "../api";
import { unit } from "../format";
import { tomlOf, changed } from "../toml";
import type { PanelProps } from "../panels";
import type { Robot } from "../robot";
import { Asked, Button, CommandButton, cx, Dialog, Empty, Switch, Tools, useWatch, download } from "../ui";

export function ParametersPanel({ robot, tile, set }: PanelProps) {
  useWatch(robot, "params", 2000);
  const [saving, setSaving] = useState(false);
  const filter = typeof tile.state.filter === "string" ? tile.state.filter : "";
  const only = tile.state.only === true;
  const all = robot.params.value ?? [];
  const words = filter.toLowerCase().split(/\s+/).filter(Boolean);
  const some = all.filter((p) => (!only || changed(p)) && words.every((w) => `${p.module}.${p.param} ${p.doc}`.toLowerCase().includes(w)));
  const modules = [...new Set(some.map((p) => p.module))];
  const count = all.filter(changed).length;
  return (
    <>
      <Tools>
        <input type="search" class="search" placeholder="Find" aria-label="Find parameters" value={filter} onInput={(e) => set({ filter: e.currentTarget.value })} />
        <Button label={`Changed${count ? ` (${count})` : ""}`} pressed={only} onClick={() => set({ only: !only })} />
        <Button icon="save" label="Save" disabled={count === 0} title="The changed ones, as TOML for sinew run --params" onClick={() => setSaving(true)} />
      </Tools>
      <Asked robot={robot} request="params" there={robot.params.value !== null}>
        {all.length === 0 ? <Empty>The modules of this robot have no parameters.</Empty> : some.length === 0 ? <Empty>{only ? "Nothing differs from the start of the run." : `No parameter fits "${filter}".`}</Empty> : (
          <table class="table params">
            <tbody>
              {modules.map((module) => [
                <tr key={module} class="level-0"><td colSpan={4}><strong>{module}</strong></td></tr>,
                ...some.filter((p) => p.module === module).map((p) => <Row key={`${module}.${p.param}`} robot={robot} p={p} />),
              ])}
            </tbody>
          </table>
        )}
      </Asked>
      {saving && <Save robot={robot} params={all} onClose={() => setSaving(false)} />}
    </>
  );
}

function range(p: Param): string {
  if (p.type === "bool" || p.type === "text") return "";
  if (p.min !== null && p.max !== null) return `${brief(p.min)} … ${brief(p.max)}`;
  if (p.min !== null) return `≥ ${brief(p.min)}`;
  return p.max === null ? "" : `≤ ${brief(p.max)}`;
}

/** "1e-6" instead of "0.000001". */
function brief(x: Param["value"]): string {
  if (typeof x !== "number" || x === 0 || (Math.abs(x) >= 1e-3 && Math.abs(x) < 1e6)) return String(x);
  return x.toExponential().replace("e+", "e");
}

function Row({ robot, p }: { robot: Robot; p: Param }) {
  const [text, setText] = useState<string | null>(null);
  const differs = changed(p);
  const send = async (value: Param["value"]) => {
    const reply = await robot.command<{ value: Param["value"] }>("param.set", { module: p.module, param: p.param, value });
    setText(null);
    if (!reply) return;
    robot.params.value = (robot.params.peek() ?? []).map((q) => (q.module === p.module && q.param === p.param ? { ...q, value: reply.value ?? value } : q));
  };
  const submit = () => {
    if (text === null) return;
    const number = Number(text.replace(",", "."));
    void send(p.type === "text" || text.trim() === "" || Number.isNaN(number) ? text : number);
  };
  const dirty = text !== null && text !== String(p.value);
  const first = p.start ?? p.default;
  const u = unit(p.unit);
  return (
    <tr class={cx("param", differs && "differs")}>
      <td class="param-name" title={p.doc}>{differs && <span class="mark-changed" title="Differs from the start of the run" />}{p.param}{p.doc && <small>{p.doc}</small>}</td>
      <td class="param-value">
        {p.type === "bool" ? <Switch on={p.value === true} label={`${p.module}.${p.param}`} onChange={(on) => void send(on)} /> : (
          <form class="inline" onSubmit={(e) => (e.preventDefault(), submit())}>
            <input class={cx("number", dirty && "dirty")} inputMode={p.type === "text" ? "text" : "decimal"} aria-label={`${p.module}.${p.param}${u ? ` in ${u}` : ""}`} readOnly={robot.isPlayback.value || p.type === "text"} title={p.type === "text" ? "A text is set before the start only" : undefined} value={text ?? String(p.value)} size={10} onInput={(e) => setText(e.currentTarget.value)} onKeyDown={(e) => e.key === "Escape" && setText(null)} />
            <span class="unit">{u}</span>
            {dirty && <CommandButton label="Set" kind="strong" onClick={submit} />}
          </form>
        )}
      </td>
      <td class="muted num param-range" title={p.allowed}>{range(p)}</td>
      <td class="muted num param-first">
        {differs ? <Button icon="reset" label={`back to ${brief(first)}`} kind="quiet" onClick={() => void send(first)} /> : p.value !== p.default ? `default ${brief(p.default)}` : "default"}
      </td>
    </tr>
  );
}

function Save({ robot, params, onClose }: { robot: Robot; params: Param[]; onClose: () => void }) {
  const text = tomlOf(params, robot.name);
  const [copied, setCopied] = useState(false);
  return (
    <Dialog title="Parameters that differ from the start" onClose={onClose}>
      <pre class="toml">{text}</pre>
      <p class="muted">For <code>sinew run ROBOT.toml --params FILE</code>, or by hand into the robot file.</p>
      <div class="row-end">
        <Button label={copied ? "Copied" : "Copy"} onClick={() => void navigator.clipboard.writeText(text).then(() => setCopied(true))} />
        <Button label="Download" kind="strong" icon="save" onClick={() => download(`${robot.name}-params.toml`, text, "application/toml")} />
      </div>
    </Dialog>
  );
}
