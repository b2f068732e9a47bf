// What the tests of the page share: monitors, robots in the simulator, Debian's Chromium. Tests wait for what they need
// to see, never for a time: a machine with much to do makes them longer and nothing else.

import { spawn } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, realpathSync, renameSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

export const root = resolve(dirname(fileURLToPath(import.meta.url)), "../../..");
const { chromium } = createRequire(join(root, "monitor/web/package.json"))("playwright-core");

const kPatience_ms = 120_000;
// Slower than real time, so that the simulator leaves the browser a processor, and a robot has time to spare.
const kPaced = ["--rate", "0.5", "--duration", "100000"];
const kSoon = ["--set", "sim.referee_ready_s=4", "--set", "sim.referee_set_s=1"];

export class Fixture {
  constructor(programs, pictures) {
    this.programs = programs;
    this.pictures = pictures;
    this.folder = mkdtempSync(join(tmpdir(), "sinew-page-"));
    this.children = new Map();
    this.problems = []; // what the browser complained about
    mkdirSync(pictures, { recursive: true });
    const { SINEW_RECORD: _, ...env } = process.env;
    this.env = env;
    this.runs = join(this.folder, "runs");
  }

  /** One that runs under this name already goes on. `machine`: programs of one machine see each other. */
  start(name, program, args, machine = "this") {
    const before = this.children.get(name);
    if (before && before.child.exitCode === null) return before;
    const cwd = machine === "this" ? this.folder : join(this.folder, machine);
    mkdirSync(cwd, { recursive: true });
    const env = { ...this.env, SINEW_RUN_DIR: join(cwd, "run") };
    const child = spawn(join(this.programs, program), args, { cwd, env, stdio: ["ignore", "pipe", "pipe"] });
    const started = { child, output: "", over: new Promise((done) => child.on("exit", done)) };
    for (const stream of [child.stdout, child.stderr]) stream.on("data", (text) => (started.output += text));
    this.children.set(name, started);
    return started;
  }

  async stop(name, signal = "SIGTERM") {
    const started = this.children.get(name);
    if (!started) return;
    this.children.delete(name);
    started.child.kill(signal);
    await started.over;
  }

  /** Its address and token; port 0: any. */
  async monitorOn(machine, port = 0) {
    const name = machine === "this" ? "monitor" : `monitor of ${machine}`;
    const started = this.start(name, "sinew-monitor", ["--port", String(port), "--panels", join(root, "examples/panels")], machine);
    await until(() => /commands: \w+/.test(started.output), "the monitor's address and token", () => started.output);
    return { address: /http:\/\/\S+/.exec(started.output)[0], token: /commands: (\w+)/.exec(started.output)[1] };
  }

  async monitor(port = 0) {
    Object.assign(this, await this.monitorOn("this", port));
  }

  /** Waits on the ground until it is armed, so that a test decides when it flies. */
  quad() {
    const file = join(this.folder, "quad.toml");
    const text = readFileSync(join(root, "robots/quad/quad.toml"), "utf8");
    writeFileSync(file, text.replace('arming = "auto"', 'arming = "manual"'));
    return this.start("quad", "sinew", ["run", file, ...kPaced, "--no-record", "--quiet"]);
  }

  head() {
    return this.start("desk_head", "sinew", ["run", join(root, "robots/desk_head/desk_head.toml"), ...kPaced, "--no-record", "--quiet"]);
  }

  /** Has neither camera nor much to record. */
  seesaw(machine = "this") {
    return this.start(`seesaw of ${machine}`, "sinew", ["run", join(root, "robots/seesaw/seesaw.toml"), ...kPaced, "--quiet"], machine);
  }

  /** Plays soccer alone: it has a behaviour. The referee lets it begin soon. */
  kid() {
    return this.start("kid", "sinew", ["run", join(root, "robots/kid/kid_play.toml"), ...kPaced, ...kSoon, "--no-record", "--quiet"]);
  }

  /** Some seconds of its game in virtual time, as a run of this name. */
  async recordKid(name, seconds) {
    await this.run(name, ["run", join(root, "robots/kid/kid_play.toml"), "--virtual", "--duration", String(seconds), "--name", name, ...kSoon]);
  }

  /** Some seconds of a flight in virtual time, recorded with its pictures as a run of this name. */
  async record(name, seconds, seed) {
    await this.run(name, ["run", join(root, "robots/quad/quad.toml"), "--virtual", "--seed", String(seed), "--duration", String(seconds), "--name", name, "--record-images"]);
  }

  async run(name, args) {
    const folder = join(this.folder, `recorder of ${name}`);
    await this.start(name, "sinew", [...args, "--runs", folder, "--quiet"]).over;
    this.children.delete(name);
    mkdirSync(this.runs, { recursive: true });
    renameSync(realpathSync(join(folder, "latest")), join(this.runs, name));
  }

  async ask(robot, request, body) {
    const url = `${this.address}/api/robots/${robot}/${request}`;
    const response = await fetch(url, body && { method: "POST", headers: { "content-type": "application/json", authorization: `Bearer ${this.token}` }, body: JSON.stringify(body) });
    return response.json();
  }

  async list(address = this.address) {
    return (await (await fetch(`${address}/api/robots`)).json()).robots;
  }

  /** Waits for a robot in a monitor's list. */
  async listed(robot, address = this.address) {
    await until(async () => (await this.list(address)).some((r) => r.robot === robot), `${robot} in the list`, () => [...this.children.values()].map((c) => c.output).join());
  }

  async browser() {
    this.chromium = await chromium.launch({ executablePath: process.env.SINEW_CHROMIUM ?? "/usr/bin/chromium", args: ["--no-sandbox", "--disable-gpu"] });
  }

  /** A page in a browser of its own: its token, its storage. */
  async open({ view = "overview", robot = "quad", token = this.token, width = 1440, height = 900, scheme = "dark" } = {}) {
    const context = await this.chromium.newContext({ viewport: { width, height }, colorScheme: scheme, acceptDownloads: true });
    await context.addInitScript(() => {
      window.sinewSent = []; // what the page sends over its WebSockets
      const send = WebSocket.prototype.send;
      WebSocket.prototype.send = function (data) {
        window.sinewSent.push(typeof data === "string" ? JSON.parse(data) : { op: "binary" });
        return send.call(this, data);
      };
    });
    const page = await context.newPage();
    page.setDefaultTimeout(kPatience_ms);
    page.on("pageerror", (e) => this.problems.push(e.stack ?? e.message));
    page.on("console", (m) => {
      if (m.type() === "error" && /Content.Security.Policy|Refused to/i.test(m.text())) this.problems.push(m.text());
    });
    await page.goto(`${this.address}/#token=${token}&robot=${robot}&view=${view}`);
    return page;
  }

  picture(page, name) {
    return page.screenshot({ path: join(this.pictures, `${name}.png`) });
  }

  async end() {
    await this.chromium?.close();
    for (const name of [...this.children.keys()]) await this.stop(name);
    rmSync(this.folder, { recursive: true, force: true });
  }
}

export async function until(is, what, more = () => "") {
  const end = Date.now() + kPatience_ms;
  while (Date.now() < end) {
    const value = await is();
    if (value) return value;
    await new Promise((done) => setTimeout(done, 50));
  }
  throw new Error(`waited in vain for ${what}\n${more()}`);
}

/** Commands are void after a second, which is short on a machine with much to do: presses again until it took effect. */
export async function press(action, took_effect) {
  const end = Date.now() + kPatience_ms;
  while (Date.now() < end) {
    await action();
    const patience = Date.now() + 4000;
    while (Date.now() < patience) {
      if (await took_effect()) return;
      await new Promise((done) => setTimeout(done, 50));
    }
  }
  throw new Error(`pressed in vain: ${took_effect}`);
}

/** How many different colours a canvas shows; 1: nothing is drawn. */
export function coloursOf(locator) {
  return locator.first().evaluate((canvas) => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    const seen = new Set();
    for (let i = 0; i < data.length; i += 4 * 7) seen.add((data[i] << 16) | (data[i + 1] << 8) | data[i + 2]);
    return seen.size;
  });
}
