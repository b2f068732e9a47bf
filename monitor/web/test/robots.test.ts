import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type { RobotInfo, Status } from "../src/api";

vi.stubGlobal("location", { protocol: "http:", host: "127.0.0.1:8080", hash: "", pathname: "/" });
const monitor = await import("../src/monitor");

const info = (robot: string, pid = 1, more: Partial<RobotInfo> = {}): RobotInfo => ({ robot, pid, board: "sim", robot_file: "", virtual_time: false, failsafes: ["camera_lost"], ...more });

function status(now_ns: number, guardian: Record<string, unknown> = {}): Status {
  return { now_ns, threads: [], modules: [], topics: [], chains: [], guardian: { stamp: now_ns, mode: "active", permitted: 1, ready: 1, conditions: 0, latched: 0, acted: 0, measured: [0.51], ...guardian } };
}

function answer(code: number, body: object) {
  return new Response(JSON.stringify(body), { status: code });
}

describe("robots of a monitor", () => {
  beforeEach(() => {
    for (const r of monitor.robots.peek()) monitor.forget(r);
    monitor.token.value = "";
  });
  afterEach(() => vi.unstubAllGlobals);

  it("stay when they ended until they are closed, and come back under their name", () => {
    monitor.takeList([info("quad"), info("head")], 1000);
    monitor.takeList([info("head")], 2000);
    const [head, quad] = monitor.robots.value;
    expect([head!.ended.value, quad!.ended.value]).toEqual([null, 2000]);
    monitor.takeList([info("head"), info("quad", 2)], 3000);
    expect(quad!.ended.value).toBeNull();
    expect(quad!.info.value.pid).toBe(2);
    monitor.takeList([info("head")], 4000);
    monitor.forget(quad!);
    expect(monitor.robots.value.map((r) => r.name)).toEqual(["head"]);
  });

  it("note failsafes with the robot's time and cause while the page looks", () => {
    monitor.takeList([info("quad")]);
    const [quad] = monitor.robots.value;
    quad!.takeStatus(status(1e9), 0);
    quad!.takeStatus(status(2e9, { acted: 1, latched: 1, conditions: 1 }), 1000);
    expect(quad!.events.value).toEqual([{ at_ns: 2e9, text: "failsafe camera_lost acted (measured 0.510)", grave: true }]);
  });

  it("forget rates when a recorded run goes back", () => {
    monitor.takeList([info("quad")]);
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
    for (const r of monitor.robots.peek()) monitor.forget(r);
    monitor.takeList([info("quad")]);
  });

  it("are not even sent without a token, and the page says what is needed", async () => {
    const fetch = vi.fn();
    vi.stubGlobal("fetch", fetch);
    monitor.token.value = "";
    const [quad] = monitor.robots.value;
    expect(await quad!.command("arm")).toBeNull();
    expect(fetch).not.toHaveBeenCalled();
    expect(quad!.refusal.value).toMatch("token");
  });

  it("carry token, key of control and a time to live", async () => {
    const fetch = vi.fn(async () => answer(200, { ok: true, step: 7 }));
    vi.stubGlobal("fetch", fetch);
    monitor.token.value = "abc";
    const [quad] = monitor.robots.value;
    quad!.key.value = "k1";
    expect(await quad!.command("module.disable", { module: "imu" })).toMatchObject({ step: 7 });
    const [url, options] = fetch.mock.calls[0] as unknown as [string, RequestInit];
    expect(url).toBe("/api/robots/quad/module.disable");
    expect(options.headers).toMatchObject({ authorization: "Bearer abc", "x-sinew-control": "k1", "content-type": "application/json" });
    const until = Number((options.headers as Record<string, string>)["x-sinew-until-ns"]);
    expect(until - monitor.monitorNow()).toBeGreaterThan(0.5e9);
    expect(until - monitor.monitorNow()).toBeLessThanOrEqual(1e9);
    quad!.key.value = "";
  });

  it("that are refused say why in the robot's words", async () => {
    vi.stubGlobal("fetch", async () => answer(400, { ok: false, error: { code: "bad_argument", why: "rate.kp: 7.5: a number from 0 to 2 s" } }));
    monitor.token.value = "abc";
    const [quad] = monitor.robots.value;
    expect(await quad!.command("param.set")).toBeNull();
    expect(quad!.refusal.value).toBe("rate.kp: 7.5: a number from 0 to 2 s");
  });

  it("of a recorded run need no token", async () => {
    const fetch = vi.fn(async () => answer(200, { ok: true }));
    vi.stubGlobal("fetch", fetch);
    monitor.token.value = "";
    const [quad] = monitor.robots.value;
    expect(await quad!.command("playback.pause")).not.toBeNull();
    expect((fetch.mock.calls[0] as unknown as [string, RequestInit])[1].headers).not.toHaveProperty("authorization");
  });
});
