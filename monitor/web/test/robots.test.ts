import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type { RobotInfo, Status } from "../src/api";

vi.stubGlobal("location", { protocol: "http:", host: "127.0.0.1:8080", hash: "", pathname: "/" });
const monitor = await import("../src/monitor");
const page = await import("../src/page");
const { local } = monitor;

const info = (robot: string, pid = 1, more: Partial<RobotInfo> = {}): RobotInfo => ({ robot, pid, board: "sim", robot_file: "", virtual_time: false, failsafes: ["camera_lost"], ...more });

function status(now_ns: number, guardian: Record<string, unknown> = {}): Status {
  return { now_ns, threads: [], modules: [], topics: [], chains: [], guardian: { stamp: now_ns, mode: "active", permitted: 1, ready: 1, conditions: 0, latched: 0, acted: 0, measured: [0.51], ...guardian } };
}

function answer(code: number, body: object) {
  return new Response(JSON.stringify(body), { status: code });
}

describe("robots of a monitor", () => {
  beforeEach(() => {
    for (const r of monitor.robots.peek()) r.machine.forget(r);
    local.token.value = "";
  });
  afterEach(() => vi.unstubAllGlobals);

  it("stay when they ended until they are closed, and come back under their name", () => {
    local.takeList([info("quad"), info("head")], 1000);
    local.takeList([info("head")], 2000);
    const [head, quad] = monitor.robots.value;
    expect([head!.ended.value, quad!.ended.value]).toEqual([null, 2000]);
    local.takeList([info("head"), info("quad", 2)], 3000);
    expect(quad!.ended.value).toBeNull();
    expect(quad!.info.value.pid).toBe(2);
    local.takeList([info("head")], 4000);
    local.forget(quad!);
    expect(monitor.robots.value.map((r) => r.name)).toEqual(["head"]);
  });

  it("note failsafes with the robot's time and cause while the page looks", () => {
    local.takeList([info("quad")]);
    const [quad] = monitor.robots.value;
    quad!.takeStatus(status(1e9), 0);
    quad!.takeStatus(status(2e9, { acted: 1, latched: 1, conditions: 1 }), 1000);
    expect(quad!.events.value).toEqual([{ at_ns: 2e9, text: "failsafe camera_lost acted (measured 0.510)", grave: true }]);
  });

  it("forget rates when a recorded run goes back", () => {
    local.takeList([info("quad")]);
    const [quad] = monitor.robots.value;
    quad!.takeStatus(status(5e9), 0);
    quad!.takeStatus(status(6e9), 1000);
    quad!.takeStatus(status(1e9), 2000);
    expect(quad!.rates.value!.hz.size).toBe(0);
    quad!.takeStatus(status(1.5e9), 2500);
    expect(quad!.events.value).toEqual([]);
  });
});

describe("commands", () => {
  beforeEach(() => {
    for (const r of monitor.robots.peek()) r.machine.forget(r);
    local.takeList([info("quad")]);
  });

  it("are not even sent without a token, and the page says what is needed", async () => {
    const fetch = vi.fn();
    vi.stubGlobal("fetch", fetch);
    local.token.value = "";
    const [quad] = monitor.robots.value;
    expect(await quad!.command("arm")).toBeNull();
    expect(fetch).not.toHaveBeenCalled();
    expect(quad!.refusal.value).toMatch("token");
  });

  it("carry token, key of control and a time to live", async () => {
    const fetch = vi.fn(async () => answer(200, { ok: true, step: 7 }));
    vi.stubGlobal("fetch", fetch);
    local.token.value = "abc";
    const [quad] = monitor.robots.value;
    quad!.key.value = "k1";
    const before = local.now();
    expect(await quad!.command("module.disable", { module: "imu" })).toMatchObject({ step: 7 });
    const [url, options] = fetch.mock.calls[0] as unknown as [string, RequestInit];
    expect(url).toBe("/api/robots/quad/module.disable");
    expect(options.headers).toMatchObject({ authorization: "Bearer abc", "x-sinew-control": "k1", "content-type": "application/json" });
    const until = Number((options.headers as Record<string, string>)["x-sinew-until-ns"]);
    expect(until).toBeGreaterThanOrEqual(Math.floor(before + 1e9));
    expect(until).toBeLessThanOrEqual(Math.ceil(local.now() + 1e9));
    quad!.key.value = "";
  });

  it("that are refused say why in the robot's words", async () => {
    vi.stubGlobal("fetch", async () => answer(400, { ok: false, error: { code: "bad_argument", why: "rate.kp: 7.5: a number from 0 to 2 s" } }));
    local.token.value = "abc";
    const [quad] = monitor.robots.value;
    expect(await quad!.command("param.set")).toBeNull();
    expect(quad!.refusal.value).toBe("rate.kp: 7.5: a number from 0 to 2 s");
  });

  it("of a recorded run need no token", async () => {
    const fetch = vi.fn(async () => answer(200, { ok: true }));
    vi.stubGlobal("fetch", fetch);
    local.token.value = "";
    const [quad] = monitor.robots.value;
    expect(await quad!.command("playback.pause")).not.toBeNull();
    expect((fetch.mock.calls[0] as unknown as [string, RequestInit])[1].headers).not.toHaveProperty("authorization");
  });
});

describe("other machines", () => {
  /** Our monitor with one robot, and the others that it relays, each with a quadrotor under the same name. */
  class FakeMonitor {
    asked: { url: string; method: string; headers: Record<string, string>; body: unknown }[] = [];
    others = new Map<string, { state: "reached" | "not reached"; why: string; now_ns: number }>();

    fetch = async (url: string, options: RequestInit = {}) => {
      const headers = (options.headers ?? {}) as Record<string, string>;
      const body = options.body ? JSON.parse(String(options.body)) : undefined;
      this.asked.push({ url, method: options.method ?? "GET", headers, body });
      if (url === "/api/monitors" && options.method === "POST") {
        if (headers.authorization !== "Bearer local") return answer(401, { ok: false, error: { code: "denied", why: "wrong token" } });
        this.others.set(body.address, { state: "reached", why: "", now_ns: 0 });
        return answer(200, { ok: true });
      }
      if (url === "/api/monitors/remove") return this.others.delete(body.address), answer(200, { ok: true });
      if (url === "/api/monitors") return answer(200, { ok: true, monitors: [...this.others].map(([address, { state, why }]) => ({ address, state, why, program: "sinew-monitor", commands: true })) });
      const [, at, rest] = /^\/at\/([^/]+)(\/.*)$/.exec(url) ?? [null, "", url];
      const other = this.others.get(at!);
      if (at && other?.state !== "reached") return answer(502, { ok: false, error: { code: "io", why: `${at}: connection refused` } });
      if (rest === "/api") return answer(200, { ok: true, version: 1, program: "sinew-monitor", now_ns: other?.now_ns ?? 0, commands: true, panels: [], runs: true, monitors: true });
      if (rest === "/api/robots") return answer(200, { ok: true, robots: [info("quad", at ? 2 : 1)] });
      return answer(200, { ok: true });
    };
  }
  let fake: FakeMonitor;
  beforeEach(async () => {
    fake = new FakeMonitor();
    vi.stubGlobal("fetch", fake.fetch);
    for (const r of monitor.robots.peek()) r.machine.forget(r);
    monitor.takeMonitors([]);
    local.token.value = "local";
    page.shown.value = [];
  });

  it("are added with our token, and their robots stand beside those of the same name here", async () => {
    await monitor.lookOnce();
    expect(await monitor.changeMonitors("monitors", "desk:8080")).toBe("");
    expect(monitor.robots.value.map((r) => [r.id, r.label])).toEqual([["quad", "quad"], ["quad@desk:8080", "quad @ desk:8080"]]);
    expect(monitor.robots.value.map((r) => r.info.value.pid)).toEqual([1, 2]);
    expect(fake.asked.map((a) => a.url)).toContain("/at/desk:8080/api/robots");
    await monitor.changeMonitors("monitors/remove", "desk:8080");
    expect(monitor.robots.value.map((r) => r.id)).toEqual(["quad"]);
  });

  it("are not added by a page that only looks, or with a wrong token", async () => {
    await monitor.lookOnce();
    local.token.value = "";
    expect(await monitor.changeMonitors("monitors", "desk:8080")).toMatch("token");
    expect(fake.asked.some((a) => a.method === "POST")).toBe(false);
    local.token.value = "guess";
    expect(await monitor.changeMonitors("monitors", "desk:8080")).toBe("wrong token");
  });

  it("have a token and a clock of their own", async () => {
    fake.others.set("desk:8080", { state: "reached", why: "", now_ns: 5e15 });
    await monitor.lookOnce();
    const quad = monitor.robots.value[1]!;
    expect(await quad.command("arm")).toBeNull();
    expect(quad.refusal.value).toMatch("desk:8080");
    quad.machine.setToken("theirs");
    expect(await quad.command("arm")).not.toBeNull();
    const last = fake.asked.at(-1)!;
    expect(last.url).toBe("/at/desk:8080/api/robots/quad/arm");
    expect(last.headers.authorization).toBe("Bearer theirs");
    expect(Math.abs(Number(last.headers["x-sinew-until-ns"]) - 5e15)).toBeLessThan(60e9);
    expect(local.token.value).toBe("local");
  });

  it("that are away say why; their robots stay, and come back", async () => {
    fake.others.set("desk:8080", { state: "reached", why: "", now_ns: 0 });
    await monitor.lookOnce();
    fake.others.set("desk:8080", { state: "not reached", why: "connection refused", now_ns: 0 });
    await monitor.lookOnce();
    const [machine] = monitor.others.value;
    expect([machine!.answers.value, machine!.why.value, local.answers.value]).toEqual(["no", "connection refused", "yes"]);
    expect(monitor.robots.value.map((r) => r.ended.value)).toEqual([null, null]);
    fake.others.set("desk:8080", { state: "reached", why: "", now_ns: 0 });
    await monitor.lookOnce();
    expect([machine!.answers.value, machine!.why.value]).toEqual(["yes", ""]);
  });

  it("are part of a robot's name in links: the one of this machine is not shown in its place", async () => {
    fake.others.set("desk:8080", { state: "reached", why: "", now_ns: 0 });
    page.shown.value = ["quad@desk:8080"];
    await monitor.lookOnce();
    expect(page.shownRobots.value.map((r) => r.label)).toEqual(["quad @ desk:8080"]);
    page.show("quad", true);
    expect(page.shown.value).toEqual(["quad@desk:8080", "quad"]);
  });
});
