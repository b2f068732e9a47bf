// One machine with a monitor: the one that gave us this page, or another one that it relays. Its robots as they come, go
// and stay, and who may command there.

import { computed, signal } from "@preact/signals";
import { get, Refusal, type ApiInfo, type RobotInfo } from "./api";
import { keep, kept } from "./browser";
import { Robot } from "./robot";

const kSilentAfter = 2; // looks in a row without an answer
const kInfoEach = 5; // looks

export class Machine {
  readonly answers = signal<"not yet" | "yes" | "no">("not yet");
  /** By this page's clock, ms. */
  readonly silentSince = signal<number | null>(null);
  /** Why another machine is not reached. */
  readonly why = signal("");
  readonly info = signal<ApiInfo | null>(null);
  readonly problem = signal("");
  readonly robots = signal<Robot[]>([]);
  readonly token = signal("");
  readonly mayCommand = computed(() => this.token.value !== "" && this.info.value?.commands !== false);
  /** In front of each path of this machine. */
  readonly base: string;
  private clockOffsetNs = 0; // its monitor's clock less this page's
  private misses = 0;
  private looks = 0;

  /** `address`: as the monitor lists it, "desk:8080"; empty: the machine that gave us this page. */
  constructor(readonly address: string) {
    this.base = address ? `/at/${encodeURIComponent(address).replace(/%3A/g, ":")}` : "";
    this.token.value = kept(this.tokenKey);
  }

  get name(): string {
    return this.address || "this machine";
  }

  private get tokenKey(): string {
    return this.address ? `sinew.token@${this.address}` : "sinew.token";
  }

  /** The clock of its monitor. */
  now(): number {
    return performance.now() * 1e6 + this.clockOffsetNs;
  }

  setToken(text: string) {
    if (this.token.peek() === text.trim()) return;
    this.token.value = text.trim();
    keep(this.tokenKey, this.token.peek());
    for (const robot of this.robots.peek()) robot.restart();
  }

  forget(robot: Robot) {
    robot.close();
    this.robots.value = this.robots.peek().filter((r) => r !== robot);
  }

  /** Robots that ended stay until they are closed; one that comes back under its name takes its place. */
  takeList(list: RobotInfo[], now = Date.now()) {
    const known = new Map(this.robots.peek().map((r) => [r.name, r]));
    let changed = false;
    for (const one of list) {
      const before = known.get(one.robot);
      if (before) before.take(one);
      else {
        known.set(one.robot, new Robot(one, this));
        changed = true;
      }
    }
    const running = new Set(list.map((r) => r.robot));
    for (const [name, robot] of known) if (!running.has(name)) robot.ended.value ??= now;
    if (changed) this.robots.value = [...known.values()].sort((a, b) => (a.name < b.name ? -1 : 1));
  }

  async look() {
    try {
      if (this.looks++ % kInfoEach === 0 || !this.info.peek()) {
        const asked = performance.now();
        const api = await get<ApiInfo>(`${this.base}/api`);
        this.clockOffsetNs = api.now_ns - ((asked + performance.now()) / 2) * 1e6;
        this.info.value = api;
      }
      const list = await get<{ robots: RobotInfo[]; problem?: string }>(`${this.base}/api/robots`);
      this.misses = 0;
      this.problem.value = list.problem ?? "";
      this.answers.value = "yes";
      this.silentSince.value = null;
      this.why.value = "";
      this.takeList(list.robots);
    } catch (e) {
      if (++this.misses >= kSilentAfter) this.lose(e instanceof Refusal ? e.message : "");
    }
  }

  /** It does not answer; what is known of it stays. */
  lose(why: string) {
    this.why.value = why;
    this.answers.value = "no";
    this.silentSince.value ??= Date.now();
    this.looks = 0;
  }

  close() {
    for (const robot of this.robots.peek()) robot.close();
    this.robots.value = [];
  }
}
