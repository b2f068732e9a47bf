// Small parts that all panels share.

import { createContext, render, type ComponentChildren, type JSX } from "preact";
import { useContext, useEffect, useLayoutEffect, useRef, useState } from "preact/hooks";
import type { Machine } from "./machine";
import { local } from "./monitor";
import type { Robot } from "./robot";

export function cx(...names: (string | false | null | undefined)[]): string {
  return names.filter(Boolean).join(" ");
}

const kIcons: Record<string, string> = {
  close: "M4 4l8 8M12 4l-8 8",
  right: "M2.5 3h11v10h-11zM8 3v10",
  below: "M2.5 3h11v10h-11zM2.5 8h11",
  large: "M3 6V3h3M13 6V3h-3M3 10v3h3M13 10v3h-3",
  small: "M6 3v3H3M10 3v3h3M6 13v-3H3M10 13v-3h3",
  key: "M9.500 6.500a3 3 0 1 0-2.6 2.960L8 10.500h1.500V12H11v1.500h2.500V11L9.300 6.800M6 6.200v.01",
  play: "M5 3.500v9l7-4.500z",
  pause: "M5.500 3.500v9M10.500 3.500v9",
  step: "M4 3.500v9l6-4.500zM12 3.500v9",
  plus: "M8 3v10M3 8h10",
  plot: "M2.500 12.500l3.500-5 3 3 4.5-7",
  help: "M6 6.200a2 2 0 1 1 2.7 1.900c-.5.200-.7.500-.7 1v.5M8 12v.01",
  robots: "M2.500 4h11M2.500 8h11M2.500 12h11",
  reset: "M3.500 8a4.500 4.5 0 1 0 1.5-3.300M3.200 2.800v2.700h2.700",
  save: "M8 2.500v7M5 7l3 3 3-3M3 13h10",
  beside: "M2.500 3h4.500v10H2.500zM9 3h4.500v10H9z",
};

export function Icon({ name }: { name: string }) {
  return (
    <svg class="icon" viewBox="0 0 16 16" aria-hidden="true">
      <path d={kIcons[name]} fill="none" stroke="currentColor" stroke-width="1.5" stroke-linecap="round" stroke-linejoin="round" />
    </svg>
  );
}

type ButtonProps = {
  icon?: string;
  label: string;
  kind?: "plain" | "strong" | "danger" | "quiet";
  hideLabel?: boolean;
  pressed?: boolean;
  disabled?: boolean;
  title?: string;
  class?: string;
  onClick: () => void;
};

export function Button({ icon, label, kind = "plain", hideLabel, pressed, disabled, title, onClick, ...rest }: ButtonProps) {
  return (
    <button
      type="button"
      class={cx("button", kind, hideLabel && "only-icon", rest.class)}
      aria-label={hideLabel ? label : undefined}
      aria-pressed={pressed}
      disabled={disabled}
      title={title ?? (hideLabel ? label : undefined)}
      onClick={onClick}
    >
      {icon && <Icon name={icon} />}
      {!hideLabel && <span>{label}</span>}
    </button>
  );
}

/** Where commands of these parts of the page go. */
export const MachineContext = createContext<Machine>(local);

/** A button that changes the robot: dimmed while this page only looks; a click then says what is needed. */
export function CommandButton(props: ButtonProps) {
  const machine = useContext(MachineContext);
  return <Button {...props} class={cx(props.class, !machine.mayCommand.value && "only-looks")} />;
}

export function Switch({ on, label, onChange }: { on: boolean; label: string; onChange: (on: boolean) => void }) {
  const machine = useContext(MachineContext);
  return (
    <button type="button" role="switch" aria-checked={on} aria-label={label} title={`${label}: ${on ? "on" : "off"}`} class={cx("switch", !machine.mayCommand.value && "only-looks")} onClick={() => onChange(!on)}>
      <span />
    </button>
  );
}

export function Choice<T extends string>({ label, value, options, onChange }: {
  label: string;
  value: T;
  options: readonly (readonly [T, string])[];
  onChange: (value: T) => void;
}) {
  return (
    <select class="choice" aria-label={label} title={label} value={value} onChange={(e) => onChange(e.currentTarget.value as T)}>
      {options.map(([id, text]) => (
        <option key={id} value={id}>{text}</option>
      ))}
    </select>
  );
}

/** A few alternatives side by side. */
export function Segments<T extends string | number>({ label, value, options, onChange }: {
  label: string;
  value: T;
  options: readonly (readonly [T, string])[];
  onChange: (value: T) => void;
}) {
  return (
    <div class="segments" role="group" aria-label={label}>
      {options.map(([id, text]) => (
        <button key={id} type="button" aria-pressed={id === value} onClick={() => onChange(id)}>{text}</button>
      ))}
    </div>
  );
}

export function Empty({ children, title }: { title?: string; children?: ComponentChildren }) {
  return (
    <div class="empty">
      {title && <strong>{title}</strong>}
      <p>{children}</p>
    </div>
  );
}

export function Badge({ tone, children }: { tone: "ok" | "warn" | "bad" | "muted" | "accent"; children: ComponentChildren }) {
  return <span class={`badge ${tone}`}>{children}</span>;
}

/** Why a panel has nothing, in words; the panel's own content otherwise. */
export function Asked({ robot, request, there, children }: { robot: Robot; request: string; there: boolean; children: ComponentChildren }) {
  const why = robot.failures.value.get(request);
  if (there) return <>{children}</>;
  if (robot.ended.value !== null) return <Empty title="The robot has ended">Nothing of this was asked before it ended.</Empty>;
  return why ? <Empty title="No answer">{why}</Empty> : <Empty>Asking {robot.label} …</Empty>;
}

/** Of panels that show messages, while there are none. */
export function NoMessages({ robot, children }: { robot: Robot; children: ComponentChildren }) {
  if (robot.ended.value !== null) return <Empty title="The robot has ended">Its messages went with it.</Empty>;
  return <Empty>{robot.socket.state.value === "open" ? children : `Connecting to the messages of ${robot.label} …`}</Empty>;
}

export function useSize<T extends HTMLElement>(): [{ current: T | null }, { width: number; height: number }] {
  const ref = useRef<T>(null);
  const [size, setSize] = useState({ width: 0, height: 0 });
  useEffect(() => {
    const element = ref.current;
    if (!element) return;
    const observer = new ResizeObserver(() => {
      const { clientWidth: width, clientHeight: height } = element;
      setSize((old) => (old.width === width && old.height === height ? old : { width, height }));
    });
    observer.observe(element);
    return () => observer.disconnect();
  }, []);
  return [ref, size];
}

/** The colours of the page's style sheet, for canvases. */
export function colour(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

const kSeries = 8;
export function seriesColour(index: number): string {
  return colour(`series-${(index % kSeries) + 1}`);
}

/** Calls when the colours change with the system's light or dark. */
export function useScheme(): string {
  const [scheme, set] = useState(matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
  useEffect(() => {
    const query = matchMedia("(prefers-color-scheme: dark)");
    const on = () => set(query.matches ? "dark" : "light");
    query.addEventListener("change", on);
    return () => query.removeEventListener("change", on);
  }, []);
  return scheme;
}

/** A canvas of its element's size, sharp on this screen, drawn once a frame while `draw` changes anything. */
export function Canvas({ draw, label, class: name, ...handlers }: {
  draw: (context: CanvasRenderingContext2D, width: number, height: number) => void;
  label: string;
  class?: string;
} & Omit<JSX.HTMLAttributes<HTMLCanvasElement>, "label">) {
  const [box, size] = useSize<HTMLDivElement>();
  const canvas = useRef<HTMLCanvasElement>(null);
  useEffect(() => {
    const c = canvas.current;
    if (!c || size.width === 0 || size.height === 0) return;
    const ratio = devicePixelRatio || 1;
    const width = Math.round(size.width * ratio), height = Math.round(size.height * ratio);
    if (c.width !== width || c.height !== height) (c.width = width), (c.height = height);
    const frame = requestAnimationFrame(() => {
      const context = c.getContext("2d");
      if (!context) return;
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      context.clearRect(0, 0, size.width, size.height);
      draw(context, size.width, size.height);
    });
    return () => cancelAnimationFrame(frame);
  });
  return (
    <div ref={box} class={cx("canvas", name)}>
      <canvas ref={canvas} role="img" aria-label={label} {...handlers} />
    </div>
  );
}

export function download(name: string, content: string | Blob, type = "text/plain") {
  const url = URL.createObjectURL(typeof content === "string" ? new Blob([content], { type }) : content);
  const link = document.createElement("a");
  link.href = url;
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}

/** Watches a request of the robot while the panel is there. */
export function useWatch(robot: Robot, request: Parameters<Robot["watch"]>[0], period_ms: number) {
  useEffect(() => robot.watch(request, period_ms), [robot, request, period_ms]);
}

export function Dialog({ title, onClose, children }: { title: string; onClose: () => void; children: ComponentChildren }) {
  const ref = useRef<HTMLDialogElement>(null);
  useEffect(() => {
    ref.current?.showModal();
  }, []);
  return (
    <dialog ref={ref} class="dialog" aria-label={title} onClose={onClose} onClick={(e) => e.target === ref.current && ref.current?.close()}>
      <div class="dialog-inside">
        <header>
          <h2>{title}</h2>
          <Button icon="close" label="Close" hideLabel kind="quiet" onClick={() => ref.current?.close()} />
        </header>
        {children}
      </div>
    </dialog>
  );
}

// ---- the tools of a panel, which stand in its tile's header

export const ToolsPlace = createContext("");

export function Tools({ children }: { children: ComponentChildren }) {
  const id = useContext(ToolsPlace);
  const machine = useContext(MachineContext);
  useLayoutEffect(() => {
    const place = document.getElementById(id);
    if (place) render(<MachineContext.Provider value={machine}>{children}</MachineContext.Provider>, place);
  });
  useEffect(() => () => {
    const place = document.getElementById(id);
    if (place) render(null, place);
  }, [id]);
  return null;
}
