// test_page.mjs WEB: the built page in a headless Chromium, against fake.mjs: pixels, proofs, what is stale, tables without
// WebGL, names that look like markup, accessibility, requests, draw calls, script time, memory, and the film.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { gzipSync } from "node:zlib";
import { launch, open, text, until } from "./browser.mjs";
import { Fake, ballAndBox, contacts, events, frame, geometry, poses, scene } from "./fake.mjs";

const web = process.argv[2], nightly = process.env.COLLIDED_NIGHTLY !== undefined;
const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const browser = await launch();
let failures = 0;

async function test(what, run) {
  const fake = new Fake(join(web, "page"));
  await fake.listen();
  try {
    await run(fake);
    console.log(`ok ${what}`);
  } catch (e) {
    failures++;
    console.error(`FAILED ${what}: ${e.stack}`);
  } finally {
    fake.close();
    for (const p of await browser.pages()) if (p.url() !== "about:blank") await p.close();
  }
}

const drawn = (page) => until(page, () => globalThis.collided?.page.view?.drawCalls > 0 && globalThis.collided.page.world.bodies.size > 0);
const idAt = (page, at) => page.evaluate((p) => {
  const v = globalThis.collided.page.view, [x, y] = v.project(p);
  return v.bodiesAt([[x, y]])[0]?.name ?? null;
}, at);

for (const far of [0, 1e7])
  await test(`the pixels of known bodies are theirs, from three sides, at ${far} m`, async (fake) => {
    const { ball, box, pair } = ballAndBox(far), origin = [far, 0, 0];
    fake.opening = () => [[2, scene(1, [ball, box])], [4, poses([[1, 0, ball.pose], [2, 0, box.pose]], origin)], [5, contacts([pair])], [7, fake.status()]];
    const page = await open(browser, fake.url);
    await drawn(page);
    for (const eye of [[far, -3, 0.5], [far + 1, -2, 2], [far - 1, 2, 1]]) {
      await page.evaluate((e, at) => globalThis.collided.page.view.look(e, at), eye, [far, 0, 0.2]);
      assert.equal(await idAt(page, ball.pose.slice(0, 3)), "ball");
      assert.equal(await idAt(page, box.pose.slice(0, 3)), "box");
      assert.equal(await idAt(page, [far, 0, 0.9]), null);
      // A third of the way from its centre to its side the box still is; as far beyond its side it is not.
      assert.equal(await idAt(page, [far + 0.25, 0, 0.26]), "box");
      assert.equal(await idAt(page, [far + 0.25, 0, 0.75]), null);
    }
    assert.deepEqual(page.wrong, []);
  });

await test("what is shown is proven in the page, and what was tampered with turns red", async (fake) => {
  const { ball, box, pair } = ballAndBox();
  fake.opening = () => [[2, scene(1, [ball, box])], [5, contacts([pair])], [7, fake.status()]];
  const page = await open(browser, fake.url);
  await until(page, () => document.querySelector("#pairs td.verdict")?.textContent === "proven");
  await page.click("#pairs td button");
  await until(page, () => document.querySelector("#selected-title").textContent === "Selected pair");
  await page.evaluate(() => document.querySelector("#prove").click());
  assert.match(await text(page, "#verdict"), /^proven by code in your browser/);
  assert.match(await text(page, "#verdict"), /\. The kernel proves .+ … .+$/);
  assert.equal(await page.$eval("#notice", (e) => e.hidden), true);
  fake.send(5, contacts([{ ...pair, lo: pair.lo + 1e-6, hi: pair.hi + 1e-6 }])); // on the way, by a micrometre
  await until(page, () => document.querySelector("#pairs td.verdict")?.textContent === "refused");
  await until(page, () => /1 of the intervals shown are NOT proven/.test(document.querySelector("#notice").textContent));
  const red = await page.$eval("#pairs td.verdict", (e) => getComputedStyle(e).backgroundColor);
  assert.match(red, /rgb\((255|196)/);
  await page.evaluate(() => document.querySelector("#prove").click());
  assert.match(await text(page, "#verdict"), /^REFUSED/);
});

await test("a stopped publisher's body is hatched, and called stale", async (fake) => {
  const { ball, box } = ballAndBox();
  fake.opening = () => [[2, scene(1, [ball, box])], [4, poses([[1, 0, ball.pose], [2, 0, box.pose]])], [7, fake.status()]];
  const page = await open(browser, fake.url);
  await drawn(page);
  await page.evaluate(() => globalThis.collided.page.view.look([-0.5, -1.2, 0.2], [-0.5, 0, 0.2]));
  // Two colours beside each other, again and again, where there was one: along a line through the ball's middle.
  const stripes = () => page.evaluate(() => {
    const v = globalThis.collided.page.view, c = v.renderer.domElement, g = v.renderer.getContext();
    v.changed();
    v.notBefore = 0;
    v.draw();
    const [x, y] = v.project([-0.5, 0, 0.2]), n = 60, out = new Uint8Array(4 * n);
    g.readPixels(Math.round(x) - n / 2, c.height - Math.round(y), n, 1, g.RGBA, g.UNSIGNED_BYTE, out);
    let changes = 0;
    for (let i = 1; i < n; i++) if (Math.abs(out[4 * i] - out[4 * i - 4]) > 25) changes++;
    return changes;
  });
  assert.ok(await stripes() <= 1, "without a pattern while it is known");
  fake.send(4, poses([[1, 1, ball.pose]]));
  await until(page, () => [...document.querySelectorAll("#bodies tr")].some((r) => /^ball/.test(r.textContent) && /stale/.test(r.textContent)));
  assert.ok(await stripes() >= 8, "hatched");
});

await test("names are text, whatever they look like; nothing is asked of anybody else; no accessibility violation", async (fake) => {
  const { ball, box, pair } = ballAndBox(), name = '<img src="http://192.0.2.1/x" onerror="globalThis.wrong=1">';
  ball.name = ball.owner = ball.group = name;
  fake.opening = () => [[2, scene(1, [ball, box])], [5, contacts([pair])], [7, fake.status()],
    [6, events(1, [{ id: 7, a: 1, b: 2, kind: 1, stamp: fake.stamp }, { id: 3, a: 0xffffffff, b: 0xffffffff, kind: 255, stamp: fake.stamp }], 5)]];
  fake.onMessage = (m, socket) => { if (m.op === "ask" && m.what === "explain") fake.sendTo(socket, 8, answer(m.id, name)); };
  const page = await open(browser, fake.url, { width: 1000, height: 800 });
  await until(page, () => document.querySelectorAll("#events td").length > 0 && document.querySelectorAll("#bodies td").length > 0 && document.querySelector("#explain"));
  await page.evaluate(() => document.querySelector("#explain").click());
  await until(page, (n) => document.querySelector("#answer")?.textContent === n, name);
  assert.equal(await page.evaluate(() => globalThis.wrong ?? document.images.length), 0);
  assert.ok((await text(page, "#bodies")).includes(name) && (await text(page, "#events")).includes(name));
  await until(page, () => /events missed5/.test(document.querySelector("#figures").textContent));
  assert.match(await text(page, "#events"), /gap: 3 batches lost/);
  assert.ok(page.asked.every((u) => u.startsWith(fake.url) || u.startsWith("data:") || u.startsWith(`ws://127.0.0.1:${fake.port}/`)), `${page.asked}`);
  assert.deepEqual(page.wrong, []);
  const cdp = await page.createCDPSession(); // the page's policy lets no other script in: axe comes by the debugger
  await cdp.send("Runtime.evaluate", { expression: axe });
  for (const scheme of ["dark"]) {
    const found = await page.evaluate(async () => (await globalThis.axe.run()).violations.map((v) => `${v.id}: ${v.nodes.map((n) => n.html).slice(0, 3)}`));
    assert.deepEqual(found, [], scheme);
  }
});

function answer(id, textOf) {
  const t = Buffer.from(JSON.stringify({ id, status: "ok", text: textOf, tick: "1", hits: [] })), padded = Buffer.concat([t, Buffer.alloc(-t.length & 7, " ")]);
  return { parts: [padded], size: padded.length };
}

await test("10,000 bodies of 12 kinds: at most 40 draws; how long a frame's script takes", async (fake) => {
  const cube = [-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1].map((x) => 0.1 * x), list = [], n = 10000;
  const kinds = [{ type: 0, half: [0, 0, 0], radius: 0.1 }, { type: 1, half: [0, 0, 0.1], radius: 0.05 }, { type: 2, half: [0.1, 0.1, 0.1] },
    { type: 2, half: [0.1, 0.1, 0.1], radius: 0.02 }, { type: 3, half: [0.1, 0.1, 0.1] }, { type: 4, half: [0.1, 0.1, 0.1] }, { type: 5, half: [0.1, 0.05, 0.1] },
    { type: 3, half: [0.1, 0.1, 0.1], radius: 0.01 }, ...[1, 2, 3, 4].map((g) => ({ type: 7, half: [0, 0, 0], geometry: g }))];
  for (let i = 0; i < n; i++)
    list.push({ id: i + 1, name: `body ${i}`, owner: `owner ${i % 7}`, pose: [i % 100, Math.floor(i / 100), 0, 1, 0, 0, 0], shapes: [kinds[i % 12]] });
  fake.opening = () => [[2, scene(1, list, { geometries: [1, 2, 3, 4].map((number) => ({ number, kind: 1 })) })], [7, fake.status()]];
  fake.onMessage = (m, socket) => { if (m.what === "geometry") fake.sendTo(socket, 3, geometry(m.number, 1, cube, [], m.id)); };
  const page = await open(browser, fake.url, { width: 320, height: 240 });
  await page.evaluate(() => { const c = document.querySelector("#scene").style; c.minHeight = c.height = c.width = "64px"; });
  await until(page, () => globalThis.collided?.page.world.geometries.size === 4 && globalThis.collided.page.view.drawCalls >= 12);
  await page.evaluate(() => { // what the page's code takes, without the processor that draws in place of a graphics card
    const r = globalThis.collided.page.view.renderer, g = r.getContext();
    for (const f of ["drawElementsInstanced", "drawElements", "drawArrays", "drawArraysInstanced", "clear"]) g[f] = () => {};
    globalThis.collided.page.frameMs.length = 0;
  });
  const t0 = Date.now();
  for (let k = 0, drawnFrames = 0; drawnFrames < 120 && Date.now() < t0 + 60000; k++) {
    if (k % 20 === 0) drawnFrames = await page.evaluate(() => globalThis.collided.page.frameMs.length);
    fake.send(4, poses(list.map((b) => [b.id, 0, [b.pose[0], b.pose[1], Math.sin(k / 10 + b.id), 1, 0, 0, 0]])));
    await new Promise((ok) => setTimeout(ok, 33));
  }
  const { calls, frames, p50, p95 } = await page.evaluate(() => {
    const p = globalThis.collided.page, s = [...p.frameMs].sort((a, b) => a - b);
    return { calls: p.view.drawCalls, frames: s.length, p50: s[Math.floor(s.length / 2)], p95: s[Math.floor(0.95 * s.length)] };
  });
  console.log(`{"bench":"window_page","bodies":${n},"draw_calls":${calls},"script_ms_p50":${p50.toFixed(2)},"script_ms_p95":${p95.toFixed(2)},"frames":${frames},"seconds":${((Date.now() - t0) / 1000).toFixed(1)}}`);
  assert.ok(calls <= 40 && calls >= 12, `${calls} draws`);
  assert.ok(frames > 10 && p50 > 0, "frames were drawn");
});

await test("memory stays level", async (fake) => {
  const { ball, box, pair } = ballAndBox();
  fake.opening = () => [[2, scene(1, [ball, box])], [7, fake.status()]];
  const page = await open(browser, fake.url, { width: 320, height: 240 });
  await drawn(page);
  const cdp = await page.createCDPSession();
  const heap = async () => {
    await cdp.send("HeapProfiler.collectGarbage");
    return (await cdp.send("Runtime.getHeapUsage")).usedSize;
  };
  let id = 10, number = 1;
  const busy = async (s) => {
    for (const ends = Date.now() + 1000 * s; Date.now() < ends;) {
      id++; // a contact begins and another ends with each frame; a body comes and goes
      fake.stamp += 33000000n;
      fake.tick++;
      fake.send(4, poses([[1, 0, ball.pose]]));
      fake.send(5, contacts([{ ...pair, id }], { gone: [id - 1], everything: false }));
      fake.send(6, events(number, [1, 3].map((kind) => ({ id, a: 1, b: 2, kind, stamp: fake.stamp }))));
      fake.send(2, scene(id, [{ ...box, id: 100 + id, name: `box ${id}` }], { everything: false, gone: [99 + id] }));
      number += 2;
      await new Promise((ok) => setTimeout(ok, 10));
    }
  };
  await busy(nightly ? 60 : 5);
  const before = await heap();
  await busy(nightly ? 600 : 6);
  const after = await heap();
  console.log(`heap: ${(before / 1e6).toFixed(1)} MB, then ${(after / 1e6).toFixed(1)} MB`);
  assert.ok(after < before + 3e6, "the heap grew");
});

await test("a server that is back, with another daemon, is followed; a wrong token is not tried again", async (fake) => {
  const { ball, box, pair } = ballAndBox();
  fake.opening = () => [[2, scene(1, [ball, box])], [5, contacts([pair])], [7, fake.status()]];
  const page = await open(browser, fake.url);
  await until(page, () => document.querySelectorAll("#pairs td").length > 0);
  fake.epoch = "2";
  fake.opening = () => [[2, scene(1, [{ ...ball, id: 9, name: "successor" }])], [7, fake.status()]];
  for (const s of fake.sockets) s.terminate();
  await until(page, () => /successor/.test(document.querySelector("#bodies").textContent) && !/ball/.test(document.querySelector("#bodies").textContent));
  await until(page, () => /epoch 2/.test(document.querySelector("#about").textContent) && globalThis.collided.page.world.contacts.size === 0);
  fake.token = "0123456789abcdef0123456789abcdef";
  for (const s of fake.sockets) s.terminate();
  await until(page, () => /The server refuses this page: the token is wrong/.test(document.querySelector("#notice").textContent));
  const tries = fake.said.length;
  await page.goto(`${fake.url}#t=${fake.token}`);
  await page.reload();
  await until(page, () => /successor/.test(document.querySelector("#bodies").textContent));
  assert.ok(fake.said.length > tries);
});

await test("a film plays from disk, without a network, and proves", async () => {
  const { ball, box, pair } = ballAndBox(), frames = [], fake = new Fake("");
  let number = 0;
  const add = (kind, tick, body) => frames.push(frame(kind, tick, 1000000000n + BigInt(tick) * 10000000n, ++number, body));
  fake.sendTo = (_, kind, body) => add(kind, 0, body);
  fake.hello(null);
  add(2, 0, scene(1, [ball, box]));
  for (let k = 0; k < 100; k++) {
    add(4, k, poses([[1, 0, [-0.5 - 0.001 * k, 0, 0.2, 1, 0, 0, 0]]]));
    const pose = [-0.5 - 0.001 * k, 0, 0.2, 1, 0, 0, 0], d = 0.3 + 0.001 * k;
    add(5, k, contacts([{ ...pair, tick: k, lo: d - 1e-9, hi: d + 1e-9, pointA: [-0.3 - 0.001 * k, 0, 0.2], poseA: pose }]));
  }
  const file = join(web, "work", "film-of-a-test.html");
  const template = readFileSync(join(web, "page", "film.html"), "utf8");
  assert.equal(template.split("\nFRAMES\n").length, 2);
  writeFileSync(file, template.replace("\nFRAMES\n", () => `\n${gzipSync(Buffer.concat(frames)).toString("base64")}\n`));
  const page = await open(browser, pathToFileURL(file).href);
  await until(page, () => globalThis.collided?.page.world.bodies.size === 2 && document.querySelector("#pairs td.verdict")?.textContent === "proven");
  await until(page, () => /399\.000 mm/.test(document.querySelector("#selected .big")?.textContent ?? ""));
  await page.$eval("#position", (e) => { e.value = "500"; e.dispatchEvent(new Event("input")); });
  await until(page, () => /349\.\d+ mm|350\.000 mm|348\.\d+ mm/.test(document.querySelector("#selected .big")?.textContent ?? ""));
  assert.ok(page.asked.every((u) => u.startsWith("file:") || u.startsWith("data:")), `${page.asked}`);
  assert.deepEqual(page.wrong, []);
});

await browser.close();

const bare = await launch(["--disable-3d-apis"]);
{
  const fake = new Fake(join(web, "page")), { ball, box, pair } = ballAndBox();
  await fake.listen();
  fake.opening = () => [[2, scene(1, [ball, box])], [5, contacts([pair])], [7, fake.status()]];
  try {
    const page = await open(bare, fake.url);
    await until(page, () => document.querySelector("#pairs td.verdict")?.textContent === "proven" && /ball/.test(document.querySelector("#bodies").textContent));
    assert.equal(await page.$eval("#no-picture", (e) => e.hidden), false);
    console.log("ok without WebGL the tables have everything");
  } catch (e) {
    failures++;
    console.error(`FAILED without WebGL: ${e.stack}`);
  }
  fake.close();
}
await bare.close();
process.exit(failures ? 1 : 0);
