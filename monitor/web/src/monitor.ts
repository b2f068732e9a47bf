// What this page sees: the machine that gave us the page, others that its monitor relays, and all their robots.

import { computed, effect, signal } from "@preact/signals";
import { get, post, Refusal, type OtherMonitor } from "./api";
import { hidden } from "./browser";
import { Machine } from "./machine";

const kPeriodMs = 1000;

const listed = signal(false); // others, at least once

export const local = new Machine("");
/** Other machines, in the monitor's order. */
export const others = signal<Machine[]>([]);
export const machines = computed(() => [local, ...others.value]);
export const robots = computed(() => machines.value.flatMap((m) => m.robots.value));
/** Whether each machine was asked: a robot that is not there now, is not there. */
export const settled = computed(() => listed.value && machines.value.every((m) => m.answers.value !== "not yet"));

/** The monitor's list of others, with their state in its words. */
export function takeMonitors(list: OtherMonitor[]) {
  const known = new Map(others.peek().map((m) => [m.address, m]));
  const now = list.map((one) => known.get(one.address) ?? new Machine(one.address));
  for (const machine of others.peek()) if (!now.includes(machine)) machine.close();
  if (now.length !== others.peek().length || now.some((m, i) => m !== others.peek()[i])) others.value = now;
  list.forEach((one, i) => {
    if (one.state !== "reached") now[i]!.lose(one.why || one.state);
  });
  listed.value = true;
  return now.filter((_, i) => list[i]!.state === "reached");
}

async function lookAtOthers() {
  if (local.answers.peek() !== "yes") return;
  if (!local.info.peek()?.monitors) {
    listed.value = true;
    return;
  }
  try {
    const reached = takeMonitors((await get<{ monitors: OtherMonitor[] }>("/api/monitors")).monitors);
    await Promise.all(reached.map((m) => m.look()));
  } catch {
    // The next look at our own monitor says what is wrong.
  }
}

export async function lookOnce() {
  await local.look();
  await lookAtOthers();
}

/** Adds or removes another machine; why not, or nothing. */
export async function changeMonitors(request: "monitors" | "monitors/remove", address: string): Promise<string> {
  if (!local.token.peek()) return "This page only looks: give the token first (key symbol, top right).";
  try {
    await post(`/api/${request}`, { address }, { token: local.token.peek() });
  } catch (e) {
    return e instanceof Refusal ? e.message : "The monitor does not answer.";
  }
  await lookOnce();
  return "";
}

/** Ends with the returned function. */
export function begin(): () => void {
  const hash = new URLSearchParams(location.hash.slice(1));
  const given = hash.get("token");
  if (given) {
    hash.delete("token"); // so that it is in no bookmark and no picture of the screen
    history.replaceState(null, "", location.pathname + (hash.size ? `#${hash}` : ""));
    local.setToken(given);
  }
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
