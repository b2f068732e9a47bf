// Each panel of the monitor's page does its job in a real browser, against robots in the simulator and a recorded run.
//
// usage: SINEW_PROGRAMS=build/release/bin SINEW_PICTURES=build/page node --test tests/monitor/web
//
// Needs npm ci in monitor/web, and chromium. Each test leaves a picture.

import assert from "node:assert/strict";
import { existsSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { coloursOf, Fixture, press, root, until } from "./fixture.mjs";

const f = new Fixture(process.env.SINEW_PROGRAMS ?? join(root, "build/release/bin"), process.env.SINEW_PICTURES ?? join(root, "build/page"));

before(async () => {
  await f.monitor();
  f.quad();
  f.head();
  await f.browser();
  await f.listed("quad");
  await f.listed("desk_head");
});
after(() => f.end());

const column = (page, robot) => page.locator(`section.column[aria-label="Robot ${robot}"]`);
const tile = (page, panel, robot = "quad") => column(page, robot).locator(`[data-panel="${panel}"]`).first();
const status = () => f.ask("quad", "status");
const text = (locator) => locator.textContent();
const refused = async (page, pattern) => {
  const alert = page.getByRole("alert");
  return (await alert.count()) === 1 && /Refused/.test(await text(alert)) && pattern.test(await text(alert));
};
const matches = (locator, pattern) => until(async () => pattern.test((await text(locator)) ?? ""), String(pattern));

/** Panels of these robots show what they are for: the moment for a picture. */
async function shown(page, robots, panels) {
  for (const robot of robots)
    for (const panel of panels) {
      const at = tile(page, panel, robot);
      if (panel === "images") await until(async () => (await coloursOf(at.locator("canvas"))) > 50, `a picture of ${robot}`);
      else if (panel === "plots") {
        await matches(at.locator(".legend output").first(), /[0-9]/);
        await drawn(at);
      } else if (panel === "scene") await matches(at.locator(".space-note"), /x.*y.*z.*m.*roll/);
      else if (panel === "messages") await matches(at.locator("tbody"), /[0-9]/);
      else if (panel === "health") await matches(at, /Armed|Not armed|no actuators/);
    }
}

/** The lines of a plot fill at least this share of it. */
async function drawn(at, share = 0.2) {
  await until(async () => {
    const [box, first] = await at.locator(".plot-box canvas").first().evaluate((canvas) => {
      const { data, width, height } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
      // The leftmost column in which something of the colour of a line stands: saturated, unlike the grid.
      for (let x = 0; x < width; ++x)
        for (let y = 0; y < height; ++y) {
          const i = 4 * (y * width + x);
          if (data[i + 3] > 120 && Math.max(data[i], data[i + 1], data[i + 2]) - Math.min(data[i], data[i + 1], data[i + 2]) > 70) return [width, x];
        }
      return [width, width];
    });
    return first < box * (1 - share);
  }, "lines in a plot");
}

test("Robots: all of this machine are listed, and several stand side by side", async () => {
  const page = await f.open();
  await page.getByRole("button", { name: "Show desk_head beside" }).click();
  await column(page, "desk_head").waitFor();
  assert.equal(await page.locator("section.column").count(), 2);
  await shown(page, ["quad", "desk_head"], ["images", "plots", "health"]);
  await f.picture(page, "robots");
  await page.context().close();
});

test("Layout: the tree shows live rates; modules go off and on, periods change, and what is refused says why", async () => {
  const page = await f.open({ view: "runs" });
  const tree = tile(page, "layout");
  await matches(tree.locator("tr", { hasText: "imu.raw" }), /1000 Hz|[0-9]+ Hz/);
  const motion = tree.getByRole("switch", { name: "Module motion" });
  const runs = async () => (await status()).modules.find((m) => m.name === "motion").running;
  await press(() => motion.click(), async () => !(await runs()));
  await matches(tree.locator("tr", { hasText: "vision::MotionField" }), /off/);
  await f.picture(page, "layout-tree");
  await press(() => motion.click(), runs);
  const period = tree.getByLabel("Period of housekeeping in µs");
  const send = (us) => async () => {
    await period.fill(us);
    await period.press("Enter");
  };
  await press(send("50000"), async () => (await status()).threads.find((t) => t.name === "housekeeping").period_ns === 50e6);
  await press(send("0"), () => refused(page, /period/));
  await page.context().close();
});

test("Layout: the graph connects modules by the topics that they read", async () => {
  const page = await f.open({ view: "timing" });
  await until(() => page.locator(".edge").count().then((n) => n >= 10), "edges of the graph");
  await matches(page.locator(".node", { hasText: "filter" }).first(), /state[0-9.]+ Hz/);
  await page.context().close();
});

test("Chronometer: times, their distribution, and the time line of the last second", async () => {
  const page = await f.open({ view: "timing" });
  const panel = tile(page, "chronometer");
  await matches(panel.locator("tr", { hasText: "stabilise" }).first(), /[0-9.]+ [nµm]s/);
  await panel.locator("tr", { hasText: "pad" }).first().click();
  await matches(panel.locator("figcaption").first(), /pad takes [1-9]/);
  await until(async () => (await coloursOf(panel.locator(".timeline-canvas canvas"))) > 5, "steps in the time line");
  await panel.getByRole("button", { name: "Hold" }).click();
  await panel.getByRole("button", { name: "Go on" }).waitFor();
  await f.picture(page, "timing");
  await page.context().close();
});

test("Images: the newest picture of a topic, with the marks of detectors", async () => {
  const page = await f.open({ robot: "desk_head" });
  const panel = tile(page, "images", "desk_head");
  await matches(panel.locator(".picture-note"), /[0-9]+.*× [0-9]+ px · [1-9][0-9.]* Hz/);
  await until(async () => (await coloursOf(panel.locator("canvas"))) > 50, "a picture");
  const shown = () => page.locator('[data-panel="images"] canvas').evaluate((canvas) => canvas.toDataURL());
  const first = await shown();
  for (let i = 0; i < 3; ++i) {
    const before = await shown();
    await until(async () => (await shown()) !== before, "the next picture"); // the head moves all the time
  }
  assert.notEqual(await shown(), first);
  await f.picture(page, "images");
  await page.context().close();
});

test("Plots: fields chosen by name, held, zoomed, under the cursor, and exported", async () => {
  const page = await f.open({ view: "signals" });
  const panel = tile(page, "plots");
  await matches(panel.locator(".legend"), /p_world_m/); // of its own accord
  while (await panel.getByRole("button", { name: /^Remove/ }).count()) await panel.getByRole("button", { name: /^Remove/ }).first().click();
  await panel.getByRole("button", { name: "Choose a field" }).click();
  const dialog = page.getByRole("dialog");
  for (const field of ["gyro_radps", "accel_mps2"]) {
    await dialog.getByLabel("Find a field").fill(`imu.raw ${field}`);
    for (const box of await dialog.getByRole("checkbox").all()) await box.check();
  }
  await page.keyboard.press("Escape");
  assert.equal(await panel.locator(".legend li").count(), 6);
  await matches(panel.locator(".legend output").nth(5), /^[−-]?[0-9]/);
  await until(async () => (await coloursOf(panel.locator("canvas"))) > 6, "lines");
  await drawn(panel);
  await panel.getByRole("button", { name: "Hold" }).click();
  const box = await panel.locator(".plot-box").boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  const [csv] = await Promise.all([page.waitForEvent("download"), panel.getByRole("button", { name: "CSV" }).click()]);
  const lines = readFileSync(await csv.path(), "utf8").trim().split("\n");
  assert.match(lines[0], /^time \[s\],imu\.raw gyro_radps\.x \[rad\/s\],/);
  assert.ok(lines.length > 100, `${lines.length} lines`);
  assert.equal(lines[1].split(",").length, 7);
  const [png] = await Promise.all([page.waitForEvent("download"), panel.getByRole("button", { name: "PNG" }).click()]);
  assert.equal(readFileSync(await png.path()).subarray(1, 4).toString(), "PNG");
  await f.picture(page, "plots");
  await page.context().close();
});

test("Plots: 20 fields are drawn anew for each frame of the screen", async () => {
  const page = await f.open({ view: "signals" });
  await page.evaluate(() => {
    const fields = ["x", "y", "z"].flatMap((a) => [["imu.raw", `gyro_radps.${a}`], ["imu.raw", `accel_mps2.${a}`], ["filter.state", `v_world_mps.${a}`], ["filter.state", `p_world_m.${a}`], ["filter.state", `gyro_bias_radps.${a}`], ["filter.state", `accel_bias_mps2.${a}`], ["attitude.wrench", `torque_nm.${a}`]]).slice(0, 20).map(([topic, path]) => ({ topic, path }));
    const tile = { kind: "tile", id: "t", panel: "plots", state: { fields } };
    localStorage.setItem("sinew.views", JSON.stringify([{ id: "signals", name: "Signals", root: tile }]));
  });
  await page.reload();
  const panel = tile(page, "plots");
  await until(() => panel.locator(".legend li").count().then((n) => n === 20), "20 fields");
  await matches(panel.locator(".legend output").nth(19), /[0-9]/);
  await drawn(panel);
  const { frames, redraws, seconds } = await page.evaluate(() => new Promise((done) => {
    let frames = 0, redraws = 0, begun = 0;
    const frame = (now) => {
      if (!begun) (begun = now), (redraws = -window.sinewRedraws);
      else if (++frames === 180) return done({ frames, redraws: redraws + window.sinewRedraws, seconds: (now - begun) / 1000 });
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }));
  console.log(`plots: ${(redraws / seconds).toFixed(1)} redraws a second with 20 fields, of ${(frames / seconds).toFixed(1)} frames`);
  assert.ok(redraws > 0.9 * frames, `${redraws} redraws in ${frames} frames`);
  await f.picture(page, "plots-20");
  await page.context().close();
});

test("Messages: a topic as a tree with units, as sinew topic echo shows it", async () => {
  const page = await f.open({ view: "signals" });
  const panel = tile(page, "messages");
  await panel.getByLabel("Topic").selectOption("battery.raw");
  const row = panel.locator("tr", { hasText: "voltage_v" });
  await matches(row, /1[0-9]\.[0-9]+V/);
  await panel.getByLabel("Topic").selectOption("filter.state");
  await matches(panel.locator("tr", { hasText: "height_m" }), /[0-9.]+m/);
  await f.picture(page, "messages");
  await page.context().close();
});

test("Parameters: changed within their range, marked, saved; what is refused says why", async () => {
  const page = await f.open({ view: "tuning" });
  const panel = tile(page, "parameters");
  const value = async () => (await f.ask("quad", "params?module=attitude")).params.find((p) => p.param === "kp_rate").value;
  const first = await value();
  const input = panel.getByLabel("attitude.kp_rate in 1/s");
  const send = (x) => async () => {
    await input.fill(x);
    await input.press("Enter");
  };
  await press(send(String(first + 1)), async () => (await value()) === first + 1);
  await panel.locator("tr.differs", { hasText: "kp_rate" }).waitFor();
  await panel.getByRole("button", { name: "Save" }).click();
  assert.match(await text(page.locator("pre.toml")), new RegExp(`\\[attitude\\]\nkp_rate = ${first + 1}\\b`));
  await page.keyboard.press("Escape");
  await press(send("-1e9"), () => refused(page, /kp_rate.*from/));
  await f.picture(page, "parameters");
  await press(() => panel.getByRole("button", { name: /^back to/ }).click(), async () => (await value()) === first);
  await page.context().close();
});

test("Behaviour: active options, their states, what decisions read; a state is held and released", async () => {
  f.kid();
  await f.listed("kid_blue");
  const page = await f.open({ view: "behaviour", robot: "kid_blue" });
  const panel = tile(page, "behaviour", "kid_blue");
  const row = (option) => panel.getByRole("row").filter({ has: page.locator("strong", { hasText: new RegExp(`^${option}$`) }) });
  const card = (option) => panel.getByRole("region", { name: `Option ${option}`, exact: true });
  const force = async () => (await f.ask("kid_blue", "params?module=player")).params.find((p) => p.param === "force").value;
  await matches(row("game"), /playing/);
  await matches(row("striker"), /search|approach|align|kick|follow/);
  await matches(card("game").locator(".behaviour-state.active"), /playing/);
  assert.equal(await card("striker").locator(".behaviour-state").count(), 5); // as docs/soccer-play.md draws it
  await matches(card("striker").locator(".behaviour-decisions"), /ball_age_s [0-9.]+|place_m [0-9.]+|in_state_s [0-9.]+/);
  await until(() => panel.locator(".behaviour-strip rect").count().then((n) => n >= 4), "what was before, in the strip");
  await matches(card("striker").locator(".behaviour-came"), /ago by/);
  await f.picture(page, "behaviour");

  await card("striker").getByRole("button", { name: "Hold striker / follow" }).click();
  await press(() => panel.getByRole("button", { name: "Hold", exact: true }).click(), async () => (await force()) === 14);
  await matches(panel.getByRole("status"), /held striker \/ follow by player\.force/);
  await matches(card("striker").locator(".behaviour-state.active.held"), /follow/);
  await matches(card("striker"), /its decisions are not asked/);
  await f.picture(page, "behaviour-held");
  await press(() => panel.getByRole("button", { name: "Release" }).click(), async () => (await force()) === 0);
  await until(async () => (await panel.getByRole("status").count()) === 0, "it to be released");

  const looker = await f.open({ view: "behaviour", robot: "kid_blue", token: "" });
  const looks = tile(looker, "behaviour", "kid_blue");
  await looks.getByRole("button", { name: "Hold game / halt" }).click();
  await looks.getByRole("button", { name: "Hold", exact: true }).click();
  await matches(looker.getByRole("alert"), /token/);
  assert.equal(await force(), 0);
  await looker.context().close();
  await page.context().close();
  await f.stop("kid");
});

test("Behaviour: of a recorded run, with all options, by day; nothing can be held there", async () => {
  await f.recordKid("game", 25);
  const player = f.start("recorded game", "sinew", ["bag", "play", join(f.runs, "game/run.mcap"), "--name", "game", "--loop"]);
  await f.listed("game");
  const page = await f.open({ view: "behaviour", robot: "game", scheme: "light" });
  const panel = tile(page, "behaviour", "game");
  await panel.getByRole("button", { name: "All", exact: true }).click();
  await until(() => panel.locator(".behaviour-option").count().then((n) => n === 6), `the six options\n${player.output}`);
  await matches(panel.locator(".behaviour-option.active h3", { hasText: /^striker/ }), /striker/);
  await until(() => panel.locator(".behaviour-strip rect").count().then((n) => n >= 4), "the strip");
  assert.equal(await panel.getByRole("button", { name: /^Hold/ }).count(), 0);
  await f.picture(page, "behaviour-recorded");
  await page.context().close();
  await f.stop("recorded game");
});

test("Record: starts and stops a recording, with size and verdict", async () => {
  f.seesaw();
  await f.listed("seesaw");
  const page = await f.open({ view: "runs", robot: "seesaw" });
  const panel = tile(page, "record", "seesaw");
  const records = async () => (await f.ask("seesaw", "record.status")).recording !== null;
  const done = () => panel.getByRole("status").count().then((n) => n === 1);
  await matches(panel, /Records[0-9].*[0-9.]+ [kM]?B/); // as the robot file says
  await press(() => panel.getByRole("button", { name: "Stop" }).click(), async () => !(await records()) && (await done()));
  await matches(panel.getByRole("status"), /Recorded .*run\.mcap, [0-9.]+ [kM]?B; .*replayed/);
  const path = /Recorded (\S+\.mcap)/.exec(await text(panel.getByRole("status")))[1];
  assert.ok(existsSync(join(f.folder, path)) || existsSync(path), path);
  await press(() => panel.getByRole("button", { name: "Record" }).click(), records);
  await matches(panel, /Records[0-9]/);
  await f.picture(page, "record");
  await page.context().close();
  await f.stop("seesaw of this");
});

test("3D: attitude and position of the body", async () => {
  const page = await f.open({ view: "tuning" });
  const panel = tile(page, "scene");
  await matches(panel.locator(".space-note"), /x.*y.*z.*m.*roll/);
  assert.ok((await coloursOf(panel.locator("canvas"))) > 5);
  await page.context().close();
});

test("Runs: executed again to the same bytes, compared, and opened as a robot that plays, steps, jumps and ends", async () => {
  await f.record("flight", 14, 7);
  await f.record("other", 6, 8);
  const page = await f.open({ view: "runs" });
  const panel = tile(page, "record");
  await panel.getByRole("button", { name: "Look again" }).click();
  const row = panel.locator("tr", { hasText: "flight" }).first();
  await row.getByRole("button", { name: "Replay" }).click();
  const result = panel.locator(".job");
  await matches(result, /same bytes.*All [1-9][0-9 ]* messages of [1-9][0-9 ]* steps are the same bytes/);
  await f.picture(page, "runs-replay");
  await panel.getByLabel("Compare flight").check();
  await panel.getByLabel("Compare other").check();
  await panel.getByRole("button", { name: "Compare", exact: true }).click();
  await matches(result, /Comparison of A, flight, with B, other.*climbing.*p_world_m/);
  await f.picture(page, "runs-compare");

  await row.getByRole("button", { name: "Open" }).click();
  const bar = page.getByRole("group", { name: "Recorded run" });
  await bar.waitFor();
  const recorded = (await f.list()).find((r) => r.recording === join(f.runs, "flight/run.mcap")).robot;
  const playback = () => f.ask(recorded, "playback");
  await bar.getByRole("button", { name: "Play" }).click();
  await until(async () => (await playback()).state === "playing", "it to play");
  await bar.getByLabel("Speed").selectOption("2");
  await until(async () => (await playback()).speed === 2, "twice the speed");
  await bar.getByRole("button", { name: "Pause" }).click();
  await until(async () => (await playback()).state === "paused", "it to pause");
  const { begin_ns, end_ns } = await playback();
  await bar.getByRole("slider").evaluate((slider) => {
    slider.value = "500";
    slider.dispatchEvent(new Event("input", { bubbles: true }));
    slider.dispatchEvent(new Event("change", { bubbles: true }));
  });
  await until(async () => Math.abs(((await playback()).time_ns - begin_ns) / (end_ns - begin_ns) - 0.5) < 0.01, "the middle");
  const { time_ns } = await playback();
  await bar.getByRole("button", { name: "Step: one message" }).click();
  await until(async () => (await playback()).time_ns > time_ns, "a step");
  const looker = await f.open({ robot: recorded, token: "" }); // it plays for everybody
  await looker.getByRole("group", { name: "Recorded run" }).getByRole("button", { name: "Play" }).click();
  await shown(looker, [recorded], ["scene", "plots", "images", "messages"]);
  await f.picture(looker, "recorded");
  await looker.context().close();
  await tile(page, "record", recorded).locator("tr", { hasText: "flight" }).first().getByRole("button", { name: "Close" }).click();
  await until(async () => !(await f.list()).some((r) => r.robot === recorded), "its robot to end");
  await page.context().close();
});

test("Runs: a page without the token cannot begin anything", async () => {
  const page = await f.open({ view: "runs", token: "" });
  const panel = tile(page, "record");
  await panel.locator("tr", { hasText: "flight" }).first().getByRole("button", { name: "Replay" }).click();
  await matches(panel.getByRole("alert"), /token/);
  await page.context().close();
});

test("Other machines: added by address, shown beside our own, commanded with their own token, missed and found again", async () => {
  const other = await f.monitorOn("desk");
  const desk = new URL(other.address).host;
  f.seesaw("desk");
  f.start("recorded of desk", "sinew", ["bag", "play", join(f.runs, "flight/run.mcap"), "--name", "flight", "--loop"], "desk");
  await f.listed("seesaw", other.address);
  await f.listed("flight", other.address);
  const page = await f.open();
  await page.getByRole("button", { name: "Other machines" }).click();
  const dialog = page.getByRole("dialog");
  await dialog.getByLabel("Address of a monitor").fill(desk);
  await dialog.getByRole("button", { name: "Add" }).click();
  await matches(dialog.locator("tr", { hasText: desk }), /reached2/); // and its two robots
  await f.picture(page, "machines");
  await page.keyboard.press("Escape");

  await page.getByRole("button", { name: `Show flight @ ${desk} beside` }).click();
  await shown(page, [`flight @ ${desk}`], ["images", "plots", "messages", "scene"]);
  await shown(page, ["quad"], ["images", "plots"]);
  assert.match(page.url(), new RegExp(`robot=quad,${encodeURIComponent(`flight@${desk}`)}`));
  await f.picture(page, "other-machine");

  await page.goto(`${f.address}/#robot=${encodeURIComponent(`seesaw@${desk}`)}&view=tuning`);
  await page.reload(); // a link shows the same
  const panel = tile(page, "parameters", `seesaw @ ${desk}`);
  const input = panel.getByLabel(/^balance\.stiffness/);
  const before = await input.inputValue();
  const change = async () => {
    await input.fill(String(Number(before) * 1.01));
    await input.press("Enter");
  };
  await press(change, () => refused(page, /token of the monitor of/));
  await page.getByRole("button", { name: /looks only/ }).click();
  await page.getByLabel(`Token of ${desk}`).fill(other.token);
  await page.getByRole("button", { name: "Use" }).click();
  await press(change, () => panel.locator("tr.differs").count().then((n) => n === 1));

  await f.stop("monitor of desk");
  await matches(page.getByRole("alert"), new RegExp(`${desk} is not reached`));
  await f.picture(page, "other-machine-lost");
  await f.monitorOn("desk", new URL(other.address).port);
  await until(async () => (await page.getByRole("alert").count()) === 0, "the other machine to come back");
  await page.getByRole("button", { name: "Other machines" }).click();
  await press(() => dialog.getByRole("button", { name: `Remove ${desk}` }).click(), () => page.locator(".rail").textContent().then((t) => !t.includes(desk)));
  for (const name of ["recorded of desk", "seesaw of desk", "monitor of desk"]) await f.stop(name);
  await page.context().close();
});

test("Control: one commander at a time; others see who, are refused, and can ask", async () => {
  const [a, b] = [await f.open({ view: "runs" }), await f.open({ view: "runs" })];
  for (const [page, name] of [[a, "Anna"], [b, "Bert"]]) {
    await page.getByRole("button", { name: /may command/ }).click();
    await page.getByLabel(/Your name/).fill(name);
    await page.getByRole("button", { name: "Use" }).click();
  }
  await press(() => a.getByRole("button", { name: "Take control" }).click(), () => a.getByText("you have control").count().then((n) => n === 1));
  await b.locator(".head").getByText("control: Anna").waitFor();
  await press(() => tile(b, "layout").getByRole("switch", { name: "Module motion" }).click(), () => refused(b, /Anna has control/));
  await press(() => b.getByRole("button", { name: "Ask" }).click(), () => a.getByText("asked by Bert").count().then((n) => n === 1));
  await f.picture(a, "control");
  await a.getByRole("button", { name: "Release" }).click();
  await b.getByRole("button", { name: "Take control" }).waitFor();
  await a.context().close();
  await b.context().close();
});

test("A page without the token only looks", async () => {
  const page = await f.open({ view: "runs", token: "" });
  await page.getByRole("button", { name: /looks only/ }).waitFor();
  await tile(page, "layout").getByRole("switch", { name: "Module motion" }).click();
  await matches(page.getByRole("alert"), /token/);
  assert.equal((await status()).modules.find((m) => m.name === "motion").running, true);
  await page.context().close();
});

test("The token is in the address no longer than the page takes to read it", async () => {
  const page = await f.open();
  await page.locator(".head h1").waitFor();
  assert.doesNotMatch(page.url(), /token/);
  assert.match(page.url(), /view=overview/);
  await page.context().close();
});

test("A panel of one's own is one plain file", async () => {
  const page = await f.open({ view: "runs" });
  await tile(page, "record").getByLabel("Panel", { exact: true }).selectOption({ label: "Height" });
  const own = page.locator(".own-panel");
  await matches(own, /[0-9.]+ mDisarm/);
  await f.picture(page, "own-panel");
  await page.context().close();
});

test("A tab that nobody sees unsubscribes, and subscribes again when it is seen", async () => {
  const page = await f.open();
  await shown(page, ["quad"], ["images", "plots", "messages", "scene"]);
  const hide = (state) => page.evaluate((s) => {
    Object.defineProperty(document, "visibilityState", { value: s, configurable: true });
    document.dispatchEvent(new Event("visibilitychange"));
  }, state);
  const open = () => page.evaluate(() => {
    const ids = new Set();
    for (const m of window.sinewSent) {
      for (const s of m.op === "subscribe" ? m.subscriptions : []) ids.add(s.id);
      for (const id of m.op === "unsubscribe" ? m.subscriptionIds : []) ids.delete(id);
    }
    return ids.size;
  });
  const some = await open();
  assert.ok(some > 0);
  await hide("hidden");
  await until(async () => (await open()) === 0, "no subscription");
  await hide("visible");
  await until(async () => (await open()) >= some, "as many subscriptions as before");
  await page.context().close();
});

test("Keyboard: views by digits, panels fill the page, borders move, all that can be pressed has a name", async () => {
  const page = await f.open();
  await page.locator(".head h1").waitFor();
  await page.keyboard.press("2");
  await tile(page, "chronometer").waitFor();
  await page.keyboard.press("1");
  await tile(page, "images").getByLabel("Panel", { exact: true }).focus();
  await tile(page, "images").getByRole("button", { name: /Fill the page/ }).focus();
  await page.keyboard.press("m");
  await until(() => page.locator(".tile").count().then((n) => n === 1), "one panel");
  await page.keyboard.press("Escape");
  await until(() => page.locator(".tile").count().then((n) => n === 5), "all panels");
  const border = page.getByRole("separator").first();
  const before = await border.getAttribute("aria-valuenow");
  await border.focus();
  await page.keyboard.press("ArrowRight");
  await until(async () => (await border.getAttribute("aria-valuenow")) !== before, "the border to move");
  const nameless = await page.evaluate(() => [...document.querySelectorAll("button, input, select, [role=separator]")].filter((e) => !(e.getAttribute("aria-label") || e.textContent.trim() || e.labels?.length)).map((e) => e.outerHTML));
  assert.deepEqual(nameless, []);
  await page.context().close();
});

test("Phone: one panel at a time, nothing beside the screen", async () => {
  const page = await f.open({ width: 390, height: 844 });
  await page.locator(".head h1").waitFor();
  for (const [name, panel] of [["Images", "images"], ["3D", "scene"], ["Plots", "plots"], ["Messages", "messages"], ["Health", "health"]]) {
    await page.locator(".tiles-tabs").getByRole("button", { name, exact: true }).click();
    await shown(page, ["quad"], [panel]);
    assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= 390, name);
    if (name === "Health") await f.picture(page, "phone-health");
    if (name === "3D") await f.picture(page, "phone-3d");
  }
  await page.getByRole("button", { name: "Robots" }).click();
  await page.getByRole("button", { name: /^desk_head/ }).click();
  await column(page, "desk_head").waitFor();
  await page.context().close();
});

test("Light: the same by day", async () => {
  const page = await f.open({ scheme: "light", robot: "desk_head" });
  await shown(page, ["desk_head"], ["images", "plots", "messages", "health"]);
  await f.picture(page, "light");
  await page.context().close();
});

test("Health: arms, shows the flight, and stops it; says that the page is no safety function", async () => {
  const page = await f.open();
  const panel = tile(page, "health");
  await matches(panel, /no safety function/);
  await matches(panel, /Not armed/);
  await press(() => panel.getByRole("button", { name: "Arm", exact: true }).click(), async () => (await status()).guardian.permitted === 1);
  await matches(panel.locator(".state"), /^Armed/);
  await until(async () => Number(/z\s*([0-9.]+)/.exec(await text(tile(page, "scene").locator(".space-note")))?.[1] ?? 0) > 1, "it to climb");
  await f.picture(page, "overview");
  const permitted = async () => (await f.ask("quad", "status")).guardian?.permitted === 1; // false also of a run that ended
  if (await permitted()) await press(() => panel.getByRole("button", { name: "Emergency stop" }).click(), async () => !(await permitted()));
  await matches(panel.locator(".events"), /armed: commands pass/);
  await matches(panel.locator(".doctor"), /checks?/);
  await panel.locator(".doctor").scrollIntoViewIfNeeded();
  await f.picture(page, "doctor");
  await page.context().close();
});

test("A robot that ended stays until it is closed", async () => {
  const page = await f.open({ robot: "desk_head" });
  await column(page, "desk_head").waitFor();
  await f.stop("desk_head");
  const entry = page.locator(".rail .robot", { hasText: "desk_head" });
  await matches(entry, /ended/);
  await f.picture(page, "ended");
  await entry.getByRole("button", { name: "Close desk_head" }).click();
  await until(() => entry.count().then((n) => n === 0), "it to be gone"); // the quadrotor's run may have ended by itself
  await page.context().close();
});

test("A page that loses the monitor says so, and comes back by itself", async () => {
  await f.stop("quad"); // the one before ends with its emergency stop
  f.quad();
  await f.listed("quad");
  const page = await f.open({ view: "runs" });
  await tile(page, "layout").locator("tr", { hasText: "imu.raw" }).waitFor();
  const port = new URL(f.address).port;
  await f.stop("monitor");
  await matches(page.getByRole("alert"), /The monitor does not answer/);
  await f.picture(page, "lost");
  await f.monitor(port);
  await until(async () => (await page.getByRole("alert").count()) === 0, "the page to come back");
  await page.context().close();
});

test("The page is below 150 kB in all, as gzip, and asks no other address", async () => {
  const page = await f.open();
  const sizes = await Promise.all(["/", "/assets/page.js", "/assets/page.css", "/icon.svg"].map(async (path) => {
    const response = await fetch(f.address + path, { headers: { "accept-encoding": "gzip" } });
    assert.equal(response.status, 200, path);
    return Number(response.headers.get("content-length"));
  }));
  const all = sizes.reduce((x, y) => x + y);
  console.log(`page: ${all} bytes as gzip`);
  assert.ok(all < 150_000);
  const addresses = await page.evaluate(() => performance.getEntriesByType("resource").map((e) => new URL(e.name).host));
  assert.deepEqual([...new Set(addresses)], [new URL(f.address).host]);
  await page.context().close();
});

test("The browser complained about nothing", () => assert.deepEqual(f.problems, []));
