// What this page shows: which robots, which view, how its tiles stand. Kept in the browser; the robots and the view are
// in the address, so that a link shows the same.

import { computed, effect, signal } from "@preact/signals";
import { keep } from "./browser";
import { robots, settled } from "./monitor";
import { readNode, split, tile, tilesOf, type Node } from "./tiling";

export interface View {
  id: string;
  name: string;
  root: Node;
}

/** The views as they come. */
export function firstViews(): View[] {
  return [
    { id: "overview", name: "Overview", root: split("row", [34, 33, 33], split("column", [1, 1], tile("images"), tile("scene")), split("column", [1, 1], tile("plots"), tile("messages")), tile("health")) },
    { id: "timing", name: "Timing", root: split("column", [44, 56], tile("layout", { mode: "graph" }), tile("chronometer")) },
    { id: "signals", name: "Signals", root: split("row", [62, 38], split("column", [1, 1], tile("plots"), tile("plots", { fields: [] })), tile("messages")) },
    { id: "tuning", name: "Tuning", root: split("row", [48, 52], tile("parameters"), split("column", [1, 1], tile("plots"), tile("scene"))) },
    { id: "behaviour", name: "Behaviour", root: split("row", [72, 28], tile("behaviour"), split("column", [1, 1], tile("images"), tile("scene"))) },
    { id: "runs", name: "Runs", root: split("row", [55, 45], tile("record"), tile("layout", { mode: "tree" })) },
  ];
}

const kViews = "sinew.views";

function storedViews(): View[] {
  try {
    const list: unknown = JSON.parse(localStorage.getItem(kViews) ?? "null");
    if (!Array.isArray(list)) return firstViews();
    const views = list.flatMap((v: Partial<View>) => {
      const root = readNode(v?.root);
      return root && typeof v.id === "string" && typeof v.name === "string" ? [{ id: v.id, name: v.name, root }] : [];
    });
    return views.length ? views : firstViews();
  } catch {
    return firstViews();
  }
}

export const views = signal<View[]>([]);
export const viewId = signal("overview");
export const shown = signal<string[]>([]); // robots, side by side, by their id
export const large = signal<string | null>(null); // the tile that fills the page
export const railOpen = signal(false); // on small screens
export const view = computed(() => views.value.find((v) => v.id === viewId.value) ?? views.value[0]);
/** Robots to show: the chosen ones, else the first; not before it is known which there are. */
export const shownRobots = computed(() => {
  const chosen = shown.value.flatMap((id) => robots.value.filter((r) => r.id === id));
  return chosen.length || (shown.value.length && !settled.value) ? chosen : robots.value.slice(0, 1);
});
export const who = signal("");

export function setRoot(root: Node) {
  const id = view.peek()?.id;
  views.value = views.peek().map((v) => (v.id === id ? { ...v, root } : v));
}

export function resetView() {
  const id = view.peek()?.id;
  const first = firstViews().find((v) => v.id === id);
  if (first) setRoot(first.root);
  large.value = null;
}

export function show(id: string, beside = false) {
  const now = shownRobots.peek().map((r) => r.id);
  if (!beside) shown.value = [id];
  else if (now.includes(id)) shown.value = now.length > 1 ? now.filter((n) => n !== id) : now;
  else shown.value = [...now, id];
  railOpen.value = false;
}

/** A field for the first plot of this view, from the panel of messages. */
export function plotField(topic: string, path: string): boolean {
  const root = view.peek()?.root;
  const first = root && tilesOf(root).find((t) => t.panel === "plots");
  if (!root || !first) return false;
  plotRequests.value = { tile: first.id, topic, path };
  return true;
}
export const plotRequests = signal<{ tile: string; topic: string; path: string } | null>(null);

export function begin(): () => void {
  views.value = storedViews();
  const hash = new URLSearchParams(location.hash.slice(1));
  if (hash.get("view")) viewId.value = hash.get("view")!;
  if (hash.get("robot")) shown.value = hash.get("robot")!.split(",").filter(Boolean);
  try {
    who.value = localStorage.getItem("sinew.who") ?? "";
  } catch {
    who.value = "";
  }
  const ends = [
    effect(() => {
      const text = JSON.stringify(views.value);
      keep(kViews, text, "localStorage");
    }),
    effect(() => keep("sinew.who", who.value, "localStorage")),
    effect(() => {
      const parts = [`view=${encodeURIComponent(viewId.value)}`];
      if (shown.value.length) parts.unshift(`robot=${shown.value.map(encodeURIComponent).join(",")}`);
      history.replaceState(null, "", `#${parts.join("&")}`);
    }),
  ];
  return () => ends.forEach((end) => end());
}
