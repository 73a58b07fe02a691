// test_film.mjs BIN WEB: a robot cell is recorded and filmed: the one file opens from disk in a browser without a network, plays,
// is sought, names the bodies that moved where the recording has them, proves what it shows, and asks for nothing.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { launch, open, until as within } from "./browser.mjs";
import { bin, start, until, uri } from "./harness.mjs";

const folder = mkdtempSync(join(tmpdir(), "collided-film-"));
process.on("exit", () => rmSync(folder, { recursive: true, force: true }));
const recording = join(folder, "session.lcmlog"), file = join(folder, "session.html");
const env = { ...process.env, COLLIDED_WEB_ROOT: join(process.argv[3], "page") };
const film = (...args) => spawnSync(join(bin, "collidectl"), ["film", ...args], { encoding: "utf8", env });
const browser = await launch(["--proxy-server=127.0.0.1:9"]);

const daemon = start("collided", "--links", uri, "--record", recording);
await until("a daemon is ready", () => daemon.err.includes("is ready"));
const actors = ["vehicle_simulator", "arm_controller"].map((n) => start(n, "--connect", uri, "--seconds", "600"));
await new Promise((ok) => setTimeout(ok, 6000)); // so long is the session; nothing is waited for
daemon.kill("SIGINT");
await daemon.ended;
for (const a of actors) a.kill("SIGINT");

const made = film(recording, "--output", file, "--range", "0.5");
assert.equal(made.status, 0, made.stderr);
assert.equal(film(recording, "--output", file).status, 73, "a file that is there is not written over");
assert.equal(film(recording).status, 64);
env.COLLIDED_WEB_ROOT = folder;
assert.equal(film(recording, "--output", join(folder, "other.html")).status, 72, "no page, no film");
assert.ok(!existsSync(join(folder, "other.html")));

const page = await open(browser, pathToFileURL(file).href, { width: 480, height: 360 });
await within(page, () => globalThis.collided?.page.world.bodies.size >= 16);
const place = () => page.evaluate(() => {
  const w = globalThis.collided.page.world, b = [...w.bodies.values()].find((x) => x.name === "vehicle");
  return b ? JSON.stringify([...w.poses.subarray(8 * b.slot, 8 * b.slot + 3)]) : "";
});
const seek = (share) => page.$eval("#position", (e, v) => { e.value = v; e.dispatchEvent(new Event("input")); }, String(1000 * share));
await page.evaluate(() => { if (document.querySelector("#play").textContent === "pause") document.querySelector("#play").click(); });
// Pictures come when the browser has time for them: places are waited for.
await seek(0.2);
await within(page, () => /^1\.\d+ of /.test(document.querySelector("#position-text").textContent));
const early = await place();
await seek(0.9);
const late = await until("the vehicle has moved", async () => ((await place()) !== early ? place() : null));
await seek(0.2);
await until("a place is the same each time", async () => (await place()) === early);
assert.notEqual(early, late);
await within(page, () => globalThis.collided.page.world.bodies.size >= 16);
await page.evaluate(() => { const c = document.querySelector("#prove-all"); if (c && !c.checked) c.click(); });
await within(page, () => [...globalThis.collided.page.verdicts.values()].filter((v) => v.verdict === "proven").length >= 5);
assert.deepEqual(await page.evaluate(() => globalThis.collided.page.refusals), []);
assert.ok(page.asked.every((u) => u.startsWith("file:") || u.startsWith("data:")), `${page.asked}`);
assert.deepEqual(page.wrong, []);
console.log(made.stdout.trim());
await browser.close();
process.exit(0);
