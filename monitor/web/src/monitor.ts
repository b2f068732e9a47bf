// The monitor as this page sees it: whether it answers, its robots as they come, go and stay, and who may command.

import { computed, effect, signal } from "@preact/signals";
import { get, type ApiInfo, type RobotInfo } from "./api";
import { Robot } from "./robot";

const kPeriodMs = 1000;
const kSilentAfter = 2; // looks in a row without an answer

function kept(key: string): string {
  try {
    return sessionStorage.getItem(key) ?? "";
  } catch {
    return ""; // a browser that stores nothing for us
  }
}

export function keep(key: string, value: string, store: "sessionStorage" | "localStorage" = "sessionStorage") {
  try {
    if (value) window[store].setItem(key, value);
    else window[store].removeItem(key);
  } catch {
    // Then it lasts as long as the page.
  }
}

export const answers = signal<"not yet" | "yes" | "no">("not yet");
export const silentSince = signal<number | null>(null);
export const info = signal<ApiInfo | null>(null);
export const problem = signal("");
export const robots = signal<Robot[]>([]);
export const token = signal("");
export const mayCommand = computed(() => token.value !== "" && info.value?.commands !== false);
export const hidden = signal(false);

let clockOffsetNs = 0; // the monitor's clock less this page's

/** The monitor's clock. */
export function monitorNow(): number {
  return performance.now() * 1e6 + clockOffsetNs;
}

export function setToken(text: string) {
  token.value = text.trim();
  keep("sinew.token", token.value);
  for (const robot of robots.peek()) robot.restart();
}

export function forget(robot: Robot) {
  robot.close();
  robots.value = robots.value.filter((r) => r !== robot);
}

/** Robots that ended stay until they are closed; one that comes back under its name takes its place. */
export function takeList(list: RobotInfo[], now = Date.now()) {
  const known = new Map(robots.peek().map((r) => [r.name, r]));
  let changed = false;
  for (const one of list) {
    const before = known.get(one.robot);
    if (before) before.take(one);
    else {
      known.set(one.robot, new Robot(one));
      changed = true;
    }
  }
  const running = new Set(list.map((r) => r.robot));
  for (const [name, robot] of known) if (!running.has(name)) robot.ended.value ??= now;
  if (changed) robots.value = [...known.values()].sort((a, b) => (a.name < b.name ? -1 : 1));
}

let misses = 0;
let looks = 0;

async function lookOnce() {
  try {
    if (looks++ % 5 === 0 || !info.peek()) {
      const asked = performance.now();
      const api = await get<ApiInfo>("/api");
      clockOffsetNs = api.now_ns - ((asked + performance.now()) / 2) * 1e6;
      info.value = api;
    }
    const list = await get<{ robots: RobotInfo[]; problem?: string }>("/api/robots");
    misses = 0;
    problem.value = list.problem ?? "";
    answers.value = "yes";
    silentSince.value = null;
    takeList(list.robots);
  } catch {
    if (++misses < kSilentAfter) return;
    answers.value = "no";
    silentSince.value ??= Date.now();
    looks = 0;
  }
}

/** Ends with the returned function. */
export function begin(): () => void {
  const hash = new URLSearchParams(location.hash.slice(1));
  const given = hash.get("token");
  if (given) {
    hash.delete("token"); // so that it is in no bookmark and no picture of the screen
    history.replaceState(null, "", location.pathname + (hash.size ? `#${hash}` : ""));
    keep("sinew.token", given);
  }
  token.value = given ?? kept("sinew.token");
  const onVisibility = () => (hidden.value = document.visibilityState === "hidden");
  document.addEventListener("visibilitychange", onVisibility);
  onVisibility();
  let timer: ReturnType<typeof setTimeout> | undefined;
  let over = false;
  const loop = async () => {
    if (!hidden.peek()) await lookOnce();
    if (!over) timer = setTimeout(loop, kPeriodMs);
  };
  void loop();
  const end = effect(() => {
    const is = hidden.value;
    for (const robot of robots.value) robot.socket.pause(is);
  });
  return () => {
    over = true;
    clearTimeout(timer);
    end();
    document.removeEventListener("visibilitychange", onVisibility);
  };
}
