// test_live.mjs BIN WEB: the built page, and the example of @collided/client, against collided-web, a daemon and the robot cell:
// explain says what collidectl says; what is shown is proven; a daemon that is killed is told of, and its successor followed.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { cpSync, mkdirSync, symlinkSync, rmSync } from "node:fs";
import { join } from "node:path";
import { launch, open, text, until as within } from "./browser.mjs";
import { ctl, run, serve, start, until, uri } from "./harness.mjs";

const web = process.argv[3];
const browser = await launch();
const daemon = () => start("collided", "--links", uri);
let first = daemon();
await until("a daemon is ready", () => first.err.includes("is ready"));
start("vehicle_simulator", "--connect", uri, "--seconds", "600");
start("arm_controller", "--connect", uri, "--seconds", "600");
const server = await serve("--root", join(web, "page"));
const page = await open(browser, `http://127.0.0.1:${server.port}/#t=${server.token}`, { width: 480, height: 360 });

async function explain_is_collidectls() {
  await within(page, () => document.querySelectorAll("#pairs td button").length > 0);
  const [a, b] = ["base_link", "wedge"]; // which stand, so that both say the same at two times, but for the ages of poses
  await page.evaluate((n) => {
    const p = globalThis.collided.page, body = [...p.world.bodies.values()].find((x) => x.name === n);
    p.select({ body: body.id, contact: null });
  }, a);
  await within(page, () => document.querySelector("#other"));
  await page.evaluate((n) => {
    document.querySelector("#other").value = n;
    document.querySelector("#explain").click();
  }, b);
  await within(page, () => !["", "asking …"].includes(document.querySelector("#answer").textContent));
  const lines = (s) => s.trim().replaceAll(/[0-9.e-]+ s old/g, "some s old").split("\n").map((l) => l.trim()).filter(Boolean);
  const told = ctl("query", "explain", a, b);
  assert.equal(told.status, 0, told.stderr);
  assert.deepEqual(lines(await text(page, "#answer")), lines(told.stdout));
}

async function what_is_shown_is_proven() {
  await within(page, () => [...globalThis.collided.page.verdicts.values()].filter((v) => v.verdict === "proven").length >= 20);
  assert.deepEqual(await page.evaluate(() => globalThis.collided.page.refusals), []);
}

async function nothing_is_asked_of_others() {
  const own = `http://127.0.0.1:${server.port}/`;
  assert.ok(page.asked.length >= 5 && page.asked.every((u) => u.startsWith(own) || u.startsWith("data:")), `${page.asked}`);
  assert.deepEqual(page.wrong, []);
}

async function the_example_of_the_package_runs() {
  const folder = join(web, "work", "example"), modules = join(folder, "node_modules", "@collided");
  rmSync(folder, { recursive: true, force: true });
  mkdirSync(modules, { recursive: true });
  cpSync(join(web, "npm"), join(modules, "client"), { recursive: true });
  symlinkSync(join(web, "work", "node_modules", "ws"), join(folder, "node_modules", "ws"));
  cpSync(join(web, "npm", "examples", "watch.mjs"), join(folder, "watch.mjs"));
  const child = spawn(process.execPath, [join(folder, "watch.mjs"), `ws://127.0.0.1:${server.port}/ws`, server.token], { stdio: ["ignore", "pipe", "inherit"] });
  let out = "";
  child.stdout.on("data", (d) => (out += d));
  try {
    await until("the example tells of an event and a proof", () => /^near /m.test(out) && /, proven$/m.test(out), 60000);
    assert.doesNotMatch(out, /refused/);
  } finally {
    child.kill();
  }
}

async function a_killed_daemon_is_told_and_its_successor_followed() {
  const before = await page.evaluate(() => globalThis.collided.page.world.hello.epoch);
  first.kill("SIGKILL");
  await first.ended;
  await within(page, () => /not heard/.test(document.querySelector("#health").textContent + document.querySelector("#notice").textContent));
  first = daemon();
  await within(page, (e) => {
    const p = globalThis.collided.page;
    return p.world.hello.epoch !== e && p.world.bodies.size >= 16 && document.querySelector("#notice").hidden;
  }, before);
}

process.on("exit", () => browser.process()?.kill("SIGKILL"));
await run([explain_is_collidectls, what_is_shown_is_proven, nothing_is_asked_of_others, the_example_of_the_package_runs,
  a_killed_daemon_is_told_and_its_successor_followed]);
