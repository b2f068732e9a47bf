// The list of panels: ours, and those of a project's own (docs/monitor.md, "Panels of one's own").

import { useEffect, useRef, useState } from "preact/hooks";
import { get } from "./api";
import { local } from "./monitor";
import { BehaviourPanel } from "./panels/behaviour";
import { ChronometerPanel } from "./panels/chronometer";
import { HealthPanel } from "./panels/health";
import { ImagesPanel } from "./panels/images";
import { LayoutPanel } from "./panels/layout";
import { MessagesPanel } from "./panels/messages";
import { ParametersPanel } from "./panels/parameters";
import { PlotsPanel } from "./panels/plots";
import { RecordPanel } from "./panels/record";
import { ScenePanel } from "./panels/scene";
import type { Robot } from "./robot";
import { decode, type Message } from "./ros2msg";
import type { Tile } from "./tiling";
import { Empty } from "./ui";

export interface PanelProps {
  robot: Robot;
  tile: Tile;
  /** Keeps settings of this tile; they stay with the page. */
  set: (change: Record<string, unknown>) => void;
}

const kPanels: [id: string, name: string, panel: (props: PanelProps) => preact.JSX.Element][] = [
  ["images", "Images", ImagesPanel],
  ["plots", "Plots", PlotsPanel],
  ["messages", "Messages", MessagesPanel],
  ["scene", "3D", ScenePanel],
  ["behaviour", "Behaviour", BehaviourPanel],
  ["health", "Health", HealthPanel],
  ["layout", "Layout", LayoutPanel],
  ["chronometer", "Chronometer", ChronometerPanel],
  ["parameters", "Parameters", ParametersPanel],
  ["record", "Record", RecordPanel],
];

export const panelNames = new Map(kPanels.map(([id, name]) => [id, name]));

const kOwn = "own:";

function nameOfOwn(path: string): string {
  const base = path.split("/").pop()!.replace(/\.js$/, "").replace(/[_-]+/g, " ");
  return base.charAt(0).toUpperCase() + base.slice(1);
}

export function usePanelList(): [string, string][] {
  const own = local.info.value?.panels ?? [];
  return [...kPanels.map(([id, name]): [string, string] => [id, name]), ...own.map((file): [string, string] => [kOwn + file, nameOfOwn(file)])];
}

export function PanelBody({ panel, ...props }: PanelProps & { panel: string }) {
  if (panel.startsWith(kOwn)) return <OwnPanel file={panel.slice(kOwn.length)} {...props} />;
  const Panel = kPanels.find(([id]) => id === panel)?.[2];
  return Panel ? <Panel {...props} /> : <Empty title="Unknown panel">There is no panel "{panel}" in this version.</Empty>;
}

// ---- panels of one's own

/** What such a panel gets: docs/monitor.md. */
export interface OwnRobot {
  name: string;
  subscribe(topic: string, onMessage: (message: Message, time_ns: number) => void): () => void;
  look(request: string, args?: Record<string, string | number | boolean>): Promise<unknown>;
  command(request: string, body?: object): Promise<unknown>;
}

type Mount = (element: HTMLElement, robot: OwnRobot) => void | (() => void);

function ownRobot(robot: Robot, ends: (() => void)[]): OwnRobot {
  return {
    name: robot.name,
    subscribe(topic, onMessage) {
      const end = robot.subscribe(topic, (payload, time, channel) => {
        if (channel.encoding === "json") return onMessage(JSON.parse(new TextDecoder().decode(payload)) as Message, time);
        const struct = robot.struct(topic);
        if (struct && typeof struct === "object") onMessage(decode(struct, payload), time);
      });
      ends.push(end);
      return end;
    },
    look: (request, args = {}) => robot.look(request, args),
    command: (request, body = {}) => robot.command(request, body),
  };
}

function OwnPanel({ file, robot }: PanelProps & { file: string }) {
  const place = useRef<HTMLDivElement>(null);
  const [why, setWhy] = useState("");
  useEffect(() => {
    const ends: (() => void)[] = [];
    let over = false;
    const url = file; // "/panels/battery.js"
    import(/* @vite-ignore */ url)
      .then((module: { mount?: Mount }) => {
        if (over || !place.current) return;
        if (typeof module.mount !== "function") throw new Error("it exports no function mount(element, robot)");
        const end = module.mount(place.current, ownRobot(robot, ends));
        if (end) ends.push(end);
      })
      .catch(async (e: Error) => {
        let reason = e.message;
        await get(url).catch((f: Error) => (reason = f.message.includes("no JSON") ? reason : f.message));
        setWhy(reason);
      });
    return () => {
      over = true;
      for (const end of ends) end();
      place.current?.replaceChildren();
    };
  }, [file, robot]);
  return (
    <>
      {why && <Empty title={`Panel ${file} does not work`}>{why}</Empty>}
      <div ref={place} class="own-panel" />
    </>
  );
}
