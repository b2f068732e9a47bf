// The frame: views, robots, the columns of tiles, and what is said when something is missing.

import { signal } from "@preact/signals";
import { useEffect, useRef, useState } from "preact/hooks";
import { ago, clock, timeOfDay } from "./format";
import type { Machine } from "./machine";
import * as monitor from "./monitor";
import * as page from "./page";
import { panelNames, PanelBody, usePanelList } from "./panels";
import { Runs } from "./panels/runs";
import { Playback } from "./playback";
import type { Robot } from "./robot";
import { closeTile, moveBorder, newId, replaceTile, splitTile, tilesOf, type Node, type Split, type Tile } from "./tiling";
import { Badge, Button, Choice, CommandButton, cx, Dialog, Empty, Icon, MachineContext, ToolsPlace, useSize, useWatch } from "./ui";

const dialog = signal<"token" | "machines" | "help" | null>(null);
const narrow = signal(matchMedia("(max-width: 760px)").matches);
matchMedia("(max-width: 760px)").addEventListener("change", (e) => (narrow.value = e.matches));
const tick = signal(Date.now());
const kLeastArranged_px = 760;
const phoneTile = signal<string | null>(null);

export function App() {
  useEffect(() => {
    const timer = setInterval(() => (tick.value = Date.now()), 1000);
    document.addEventListener("keydown", onKey);
    return () => {
      clearInterval(timer);
      document.removeEventListener("keydown", onKey);
    };
  }, []);
  const robots = page.shownRobots.value;
  return (
    <div class={cx("app", page.railOpen.value && "rail-open")}>
      <a class="skip" href="#tiles" onClick={(e) => (e.preventDefault(), document.getElementById("tiles")?.focus())}>Skip to the panels</a>
      <Bar />
      <Lost />
      <div class="body">
        <Rail />
        <main id="tiles" tabIndex={-1} class="columns" aria-label="Panels">
          {robots.length === 0 ? <NoRobot /> : robots.map((r) => <Column key={r.id} robot={r} alone={robots.length === 1} />)}
        </main>
      </div>
      {dialog.value === "token" && <TokenDialog />}
      {dialog.value === "machines" && <MachinesDialog />}
      {dialog.value === "help" && <HelpDialog />}
    </div>
  );
}

function onKey(e: KeyboardEvent) {
  const at = e.target as HTMLElement;
  if (e.ctrlKey || e.metaKey || e.altKey || /^(INPUT|SELECT|TEXTAREA)$/.test(at.tagName) || at.isContentEditable || dialog.peek()) return;
  const views = page.views.peek();
  if (/^[1-9]$/.test(e.key) && views[Number(e.key) - 1]) page.viewId.value = views[Number(e.key) - 1]!.id;
  else if (e.key === "?") dialog.value = "help";
  else if (e.key === "k") dialog.value = "token";
  else if (e.key === "n" || e.key === "p") {
    const all = monitor.robots.peek().map((r) => r.id);
    const now = all.indexOf(page.shownRobots.peek()[0]?.id ?? "");
    if (all.length) page.show(all[(now + (e.key === "n" ? 1 : all.length - 1)) % all.length]!);
  } else if (e.key === "Escape" && page.large.peek()) page.large.value = null;
  else if (e.key === "m") {
    const id = at.closest<HTMLElement>("[data-tile]")?.dataset.tile;
    if (!id) return;
    page.large.value = page.large.peek() ? null : id;
  } else return;
  e.preventDefault();
}

function Bar() {
  const machine = page.shownRobots.value[0]?.machine ?? monitor.local;
  const commands = machine.mayCommand.value;
  return (
    <header class="bar">
      <Button icon="robots" label="Robots" hideLabel kind="quiet" class="rail-button" pressed={page.railOpen.value} onClick={() => (page.railOpen.value = !page.railOpen.value)} />
      <span class="mark">
        <svg viewBox="0 0 32 32" aria-hidden="true"><path d="M3 20c5 0 5-10 9-10s4 13 8.500 13S25 9 29 9" /></svg>
        Sinew
      </span>
      <nav aria-label="Views">
        {page.views.value.map((v, i) => (
          <button key={v.id} type="button" class="tab" aria-current={v.id === page.view.value?.id ? "page" : undefined} title={`${v.name} (key ${i + 1})`} onClick={() => (page.viewId.value = v.id, page.large.value = null)}>
            {v.name}
          </button>
        ))}
      </nav>
      <span class="space" />
      <Button icon="reset" label="Arrange as at first" hideLabel kind="quiet" class="wide-only" onClick={page.resetView} />
      <Button icon="help" label="Keys and help (?)" hideLabel kind="quiet" class="wide-only" onClick={() => (dialog.value = "help")} />
      <button type="button" class={cx("button", "plain", "token", commands && "on")} onClick={() => (dialog.value = "token")} title={`Who may command on ${machine.name} (key k)`}>
        <Icon name="key" />
        <span>{commands ? "may command" : "looks only"}</span>
      </button>
    </header>
  );
}

function Lost() {
  const { answers, problem, silentSince } = monitor.local;
  if (answers.value !== "no") return problem.value ? <div class="lost" role="alert">{problem.value}</div> : null;
  const since = silentSince.value;
  return (
    <div class="lost" role="alert">
      <strong>The monitor does not answer</strong>
      {since !== null && ` since ${timeOfDay(since)}`}. What stands below is from before. This page asks again each second.
    </div>
  );
}

/** Nothing to show, above the recorded runs, which can be shown. */
function NoRobot() {
  const { answers } = monitor.local;
  if (answers.value === "no") return <Empty title="No monitor">Start it with: sinew monitor</Empty>;
  if (answers.value === "not yet" || !monitor.settled.value) return <Empty>Asking the monitor …</Empty>;
  return (
    <section class="column no-robot">
      <h1>No robot runs</h1>
      <p class="muted">Start one, for example with <code>./run</code> or <code>sinew run robots/quad/quad.toml</code>; it appears here by itself.</p>
      <div class="record"><Runs machine={monitor.local} /></div>
    </section>
  );
}

/** Another machine that is away: what its robots' panels show is from before. */
function Away({ machine }: { machine: Machine }) {
  if (!machine.address || machine.answers.value !== "no" || monitor.local.answers.value === "no") return null;
  return (
    <div class="lost" role="alert">
      <strong>{machine.address} is not reached</strong>
      {machine.silentSince.value !== null && ` since ${timeOfDay(machine.silentSince.value)}`}{machine.why.value && ` (${machine.why.value})`}. What stands below is from before.
    </div>
  );
}

// ---- robots

function Rail() {
  const { answers, info } = monitor.local;
  return (
    <aside class="rail" aria-label="Robots">
      {monitor.machines.value.map((m) => <RailMachine key={m.address} machine={m} />)}
      {info.value?.monitors && <Button icon="plus" label="Other machines" kind="quiet" onClick={() => (dialog.value = "machines")} />}
      <footer class="muted">
        {answers.value === "yes" ? (info.value?.program ?? "connected") : answers.value === "no" ? "not connected" : "…"}
      </footer>
    </aside>
  );
}

function RailMachine({ machine }: { machine: Machine }) {
  const robots = machine.robots.value;
  const away = machine.address && machine.answers.value === "no";
  return (
    <section>
      <h2>{machine.address || "This machine"}</h2>
      {away ? <p class="warn-text small">not reached{machine.why.value && `: ${machine.why.value}`}</p> : robots.length === 0 && <p class="muted small">{machine.answers.value === "not yet" ? "Asking …" : "No robots."}</p>}
      <ul>{robots.map((r) => <RailEntry key={r.id} robot={r} />)}</ul>
    </section>
  );
}

export function stateOf(robot: Robot): { tone: "ok" | "muted" | "accent" | "warn"; text: string } {
  if (robot.machine.address && robot.machine.answers.value === "no") return { tone: "muted", text: "not reached" };
  if (robot.ended.value !== null) return { tone: "muted", text: `ended ${ago(tick.value - robot.ended.value)}` };
  if (robot.isPlayback.value) return { tone: "accent", text: "recorded run" };
  return { tone: "ok", text: robot.info.value.virtual_time ? "virtual time" : "runs" };
}

function RailEntry({ robot }: { robot: Robot }) {
  const chosen = page.shownRobots.value.includes(robot);
  const state = stateOf(robot);
  const control = robot.control.value.who;
  return (
    <li class={cx("robot", chosen && "chosen", robot.ended.value !== null && "over")}>
      <button type="button" class="robot-name" aria-current={chosen ? "true" : undefined} onClick={(e) => page.show(robot.id, e.shiftKey)}>
        <span class={`dot ${state.tone}`} />
        <strong>{robot.name}{robot.machine.address && <span class="muted"> @ {robot.machine.address}</span>}</strong>
        <small>{state.text} · {robot.isPlayback.value ? robot.info.value.recording!.split("/").slice(-2, -1)[0] ?? "file" : `board ${robot.info.value.board}`}</small>
        {control && <small>control: {control}</small>}
      </button>
      <span class="robot-buttons">
        <Button icon="beside" label={chosen ? `Show ${robot.label} no more` : `Show ${robot.label} beside`} hideLabel kind="quiet" pressed={chosen} onClick={() => page.show(robot.id, true)} />
        {robot.ended.value !== null && <Button icon="close" label={`Close ${robot.label}`} hideLabel kind="quiet" onClick={() => robot.machine.forget(robot)} />}
      </span>
    </li>
  );
}

// ---- one robot's column

function Column({ robot, alone }: { robot: Robot; alone: boolean }) {
  useWatch(robot, "status", 250);
  const view = page.view.value;
  const root = view?.root ?? null;
  const tiles = root ? tilesOf(root) : [];
  const big = tiles.find((t) => t.id === page.large.value);
  const [box, size] = useSize<HTMLElement>();
  // Side by side there is no room for an arrangement: the panels stand one below the other, the same for each robot.
  const stacked = !narrow.value && !big && size.width > 0 && size.width < kLeastArranged_px && tiles.length > 1;
  const phone = tiles.find((t) => t.id === phoneTile.value) ?? tiles[0];
  return (
    <MachineContext.Provider value={robot.machine}>
    <section ref={box} class="column" aria-label={`Robot ${robot.label}`}>
      <Head robot={robot} alone={alone} />
      <Away machine={robot.machine} />
      <Refused robot={robot} />
      {robot.isPlayback.value && <Playback robot={robot} />}
      {narrow.value ? (
        <>
          <nav class="tiles-tabs" aria-label="Panels of this view">
            {tiles.map((t) => (
              <button key={t.id} type="button" class="tab" aria-current={t === phone ? "true" : undefined} onClick={() => (phoneTile.value = t.id)}>{panelNames.get(t.panel) ?? t.panel}</button>
            ))}
          </nav>
          <div class="tiling">{phone && <TileView key={phone.id} node={phone} robot={robot} />}</div>
        </>
      ) : stacked ? (
        <div class="tiling stacked">{tiles.map((t) => <TileView key={t.id} node={t} robot={robot} />)}</div>
      ) : (
        <div class="tiling">{big ? <TileView node={big} robot={robot} /> : root ? <NodeView node={root} robot={robot} /> : <Empty>This view has no panels. <Button label="Arrange as at first" onClick={page.resetView} /></Empty>}</div>
      )}
    </section>
    </MachineContext.Provider>
  );
}

function Head({ robot, alone }: { robot: Robot; alone: boolean }) {
  const status = robot.status.value;
  const guardian = robot.ended.value === null ? status?.guardian : undefined;
  const state = stateOf(robot);
  const faults = status?.modules.filter((m) => !m.running).length ?? 0;
  return (
    <header class="head">
      <span class={`dot ${state.tone}`} />
      <h1>{robot.name}{robot.machine.address && <span class="muted"> @ {robot.machine.address}</span>}</h1>
      <span class="muted">{state.text}</span>
      {status && <span class="num" title="The robot's clock">{clock(robot.isPlayback.value ? robot.playback.value?.time_ns ?? status.now_ns : status.now_ns)}</span>}
      {guardian && <Badge tone={guardian.permitted ? "warn" : "muted"}>{guardian.permitted ? "armed" : "not armed"}</Badge>}
      {guardian && (guardian.latched !== 0 || guardian.conditions !== 0) && <Badge tone="bad">failsafe</Badge>}
      {faults > 0 && <Badge tone="bad">{faults} {faults === 1 ? "module" : "modules"} off</Badge>}
      <span class="space" />
      {!robot.isPlayback.value && robot.ended.value === null && robot.machine.answers.value !== "no" && <ControlOf robot={robot} />}
      {!alone && <Button icon="close" label={`Show ${robot.label} no more`} hideLabel kind="quiet" onClick={() => page.show(robot.id, true)} />}
    </header>
  );
}

function ControlOf({ robot }: { robot: Robot }) {
  const control = robot.control.value;
  const name = page.who.value || "somebody";
  if (robot.key.value)
    return (
      <span class="control">
        {control.asked.length > 0 && <Badge tone="warn">asked by {control.asked.join(", ")}</Badge>}
        <Badge tone="accent">you have control</Badge>
        <Button label="Release" onClick={() => void robot.releaseControl(name)} />
      </span>
    );
  if (control.who)
    return (
      <span class="control">
        <span class="muted">control: {control.who}</span>
        <CommandButton label="Ask" title="Shows your name to whoever has control" onClick={() => void robot.askControl(name)} />
      </span>
    );
  return (
    <span class="control wide-only">
      <CommandButton label="Take control" title="Then nobody else commands this robot; disarm and stop stay free for all" onClick={() => (page.who.peek() ? void robot.takeControl(name) : (dialog.value = "token"))} />
    </span>
  );
}

function Refused({ robot }: { robot: Robot }) {
  const why = robot.refusal.value;
  if (!why) return null;
  return (
    <div class="refused" role="alert">
      <span><strong>Refused.</strong> {why}</span>
      <Button icon="close" label="Close this remark" hideLabel kind="quiet" onClick={() => (robot.refusal.value = null)} />
    </div>
  );
}

// ---- tiles

function NodeView({ node, robot }: { node: Node; robot: Robot }) {
  return node.kind === "tile" ? <TileView node={node} robot={robot} /> : <SplitView node={node} robot={robot} />;
}

function SplitView({ node, robot }: { node: Split; robot: Robot }) {
  const box = useRef<HTMLDivElement>(null);
  const begin = (at: number) => (e: PointerEvent) => {
    const element = box.current!;
    const handle = e.currentTarget as HTMLElement;
    handle.setPointerCapture(e.pointerId);
    let before = node.direction === "row" ? e.clientX : e.clientY;
    const whole = node.direction === "row" ? element.clientWidth : element.clientHeight;
    const move = (m: PointerEvent) => {
      const now = node.direction === "row" ? m.clientX : m.clientY;
      page.setRoot(moveBorder(page.view.peek()!.root, node.id, at, (now - before) / whole));
      before = now;
    };
    const end = () => {
      handle.removeEventListener("pointermove", move);
      handle.removeEventListener("pointerup", end);
    };
    handle.addEventListener("pointermove", move);
    handle.addEventListener("pointerup", end);
    e.preventDefault();
  };
  const key = (at: number) => (e: KeyboardEvent) => {
    const by = { ArrowLeft: -0.02, ArrowUp: -0.02, ArrowRight: 0.02, ArrowDown: 0.02 }[e.key];
    if (!by) return;
    page.setRoot(moveBorder(page.view.peek()!.root, node.id, at, by));
    e.preventDefault();
  };
  return (
    <div ref={box} class={`split ${node.direction}`}>
      {node.parts.map((part, i) => [
        <div key={part.id} class="part" style={{ flexGrow: String(node.sizes[i]) }}><NodeView node={part} robot={robot} /></div>,
        i + 1 < node.parts.length && (
          <div key={`${part.id}|`} class="border" role="separator" tabIndex={0} aria-label="Border between panels; arrow keys move it" aria-orientation={node.direction === "row" ? "vertical" : "horizontal"} aria-valuenow={Math.round(node.sizes[i]! * 100)} onPointerDown={begin(i)} onKeyDown={key(i)} />
        ),
      ])}
    </div>
  );
}

function TileView({ node, robot }: { node: Tile; robot: Robot }) {
  const list = usePanelList();
  const root = () => page.view.peek()!.root;
  const isLarge = page.large.value === node.id;
  const close = () => {
    const left = closeTile(root(), node.id);
    if (left) page.setRoot(left);
    page.large.value = null;
  };
  return (
    <section class="tile" data-tile={node.id} data-panel={node.panel} aria-label={panelNames.get(node.panel) ?? node.panel}>
      <header>
        <Choice label="Panel" value={node.panel} options={list} onChange={(panel) => page.setRoot(replaceTile(root(), node.id, { panel, state: {} }))} />
        <span class="tile-tools" id={`tools-${node.id}-${robot.id}`} />
        <span class="space" />
        <span class="tile-buttons">
          <Button icon="right" label="Split: a panel to the right" hideLabel kind="quiet" onClick={() => page.setRoot(splitTile(root(), node.id, "row", { kind: "tile", id: newId(), panel: "messages", state: {} }))} />
          <Button icon="below" label="Split: a panel below" hideLabel kind="quiet" onClick={() => page.setRoot(splitTile(root(), node.id, "column", { kind: "tile", id: newId(), panel: "messages", state: {} }))} />
          <Button icon={isLarge ? "small" : "large"} label={isLarge ? "As large as before (m)" : "Fill the page (m)"} hideLabel kind="quiet" onClick={() => (page.large.value = isLarge ? null : node.id)} />
          <Button icon="close" label="Close this panel" hideLabel kind="quiet" onClick={close} />
        </span>
      </header>
      <div class="tile-body">
        <ToolsPlace.Provider value={`tools-${node.id}-${robot.id}`}>
        <PanelBody key={`${node.panel}${robot.id}`} panel={node.panel} robot={robot} tile={node} set={(change) => {
          const now = tilesOf(root()).find((t) => t.id === node.id);
          if (now) page.setRoot(replaceTile(root(), node.id, { state: { ...now.state, ...change } }));
        }} />
        </ToolsPlace.Provider>
      </div>
    </section>
  );
}

// ---- dialogs

/** Each machine has a token of its own. */
function TokenDialog() {
  const machines = monitor.machines.value;
  const [texts, setTexts] = useState(new Map(machines.map((m) => [m, m.token.peek()])));
  const use = () => machines.forEach((m) => m.setToken(texts.get(m) ?? m.token.peek()));
  return (
    <Dialog title="Who may command" onClose={() => (dialog.value = null)}>
      <form method="dialog" onSubmit={use}>
        <p>Everybody who reaches this page may look. Commands need the token that <code>sinew monitor</code> printed when it began{machines.length > 1 && ", on each machine its own"}. It is kept until this tab is closed.</p>
        {machines.map((m) => (
          <label key={m.address} class="field">{m.address ? `Token of ${m.address}` : machines.length > 1 ? "Token of this machine" : "Token"}
            <input type="password" autocomplete="off" spellcheck={false} value={texts.get(m) ?? ""} onInput={(e) => setTexts(new Map(texts).set(m, e.currentTarget.value))} />
            {m.info.value?.commands === false && <span class="warn-text">takes no commands: it can be reached from outside and has no TLS (--tls)</span>}
          </label>
        ))}
        <label class="field">Your name, shown to others who want to command
          <input type="text" maxLength={40} value={page.who.value} onInput={(e) => (page.who.value = e.currentTarget.value)} />
        </label>
        <div class="row-end">
          <Button label="Look only" onClick={() => (machines.forEach((m) => m.setToken("")), (dialog.value = null))} />
          <button class="button strong" type="submit"><span>Use</span></button>
        </div>
      </form>
    </Dialog>
  );
}

function MachinesDialog() {
  const [address, setAddress] = useState("");
  const [why, setWhy] = useState("");
  const ask = async (request: "monitors" | "monitors/remove", which: string) => {
    const refusal = await monitor.changeMonitors(request, which);
    setWhy(refusal);
    if (!refusal && request === "monitors") setAddress("");
  };
  const others = monitor.others.value;
  return (
    <Dialog title="Other machines" onClose={() => (dialog.value = null)}>
      <p>Robots of monitors on other machines stand in the list like those of this one. This machine's monitor passes everything on; the browser asks no other address.</p>
      {others.length > 0 && (
        <table class="table">
          <thead><tr><th>Address</th><th>State</th><th class="r">Robots</th><th /></tr></thead>
          <tbody>
            {others.map((m) => (
              <tr key={m.address}>
                <td class="num">{m.address}</td>
                <td>{m.answers.value === "yes" ? <Badge tone="ok">reached</Badge> : m.answers.value === "no" ? <><Badge tone="bad">not reached</Badge> <span class="muted">{m.why.value}</span></> : <span class="muted">asking …</span>}</td>
                <td class="r num">{m.robots.value.length}</td>
                <td class="r"><CommandButton icon="close" label={`Remove ${m.address}`} hideLabel kind="quiet" onClick={() => void ask("monitors/remove", m.address)} /></td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
      <form onSubmit={(e) => (e.preventDefault(), address.trim() && void ask("monitors", address.trim()))}>
        <label class="field">Address of a monitor
          <input type="text" autocomplete="off" spellcheck={false} placeholder="desk:8080" value={address} onInput={(e) => setAddress(e.currentTarget.value)} />
        </label>
        {why && <p class="warn-text" role="alert">{why}</p>}
        <div class="row-end"><button class={cx("button strong", !monitor.local.mayCommand.value && "only-looks")} type="submit"><span>Add</span></button></div>
      </form>
    </Dialog>
  );
}

const kKeys: [string, string][] = [
  ["1 … 9", "views"],
  ["n, p", "next, previous robot"],
  ["Shift + click", "on a robot: show it beside the others"],
  ["m", "the panel that has the focus fills the page, and back"],
  ["k", "token and name"],
  ["arrow keys", "on a border between panels: move it"],
  ["space", "in plots and time lines: hold and go on"],
  ["?", "this list"],
];

function HelpDialog() {
  return (
    <Dialog title="Keys" onClose={() => (dialog.value = null)}>
      <dl class="keys">{kKeys.map(([k, what]) => [<dt key={k}><kbd>{k}</kbd></dt>, <dd key={`${k}d`}>{what}</dd>])}</dl>
      <p class="muted">The page is <code>docs/monitor.md</code> in a browser: what it uses, other programs may use, too.</p>
      <p class="muted"><a href="/licences.txt">Licences of the packages in this page</a></p>
    </Dialog>
  );
}
