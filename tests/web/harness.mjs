// harness: a daemon, collided-web and a robot cell for the tests of the window, each a process that is ended with the
// test; domains and ports of this test alone.
import { spawn, spawnSync } from "node:child_process";
import { createHash } from "node:crypto";
import net from "node:net";
import path from "node:path";

export const bin = process.argv[2];
const children = [];
let failures = 0;
// Of the process, so that tests that run at once do not meet; DDS has 231 domains.
export const domain = 100 + (process.pid % 100);
export const uri = `dds://${domain}`;

process.on("exit", () => { for (const c of children) if (c.exitCode === null) c.kill("SIGKILL"); });

export function start(name, ...args) {
  const child = spawn(path.join(bin, name), args, { stdio: ["ignore", "pipe", "pipe"] });
  child.out = "";
  child.err = "";
  child.stdout.on("data", (d) => (child.out += d));
  child.stderr.on("data", (d) => (child.err += d));
  child.ended = new Promise((ok) => child.on("exit", (code, signal) => ok({ code, signal })));
  children.push(child);
  return child;
}

export const ctl = (...args) => spawnSync(path.join(bin, "collidectl"), ["--connect", uri, ...args], { encoding: "utf8" });

export async function until(what, fits, ms = 30000) {
  for (const ends = Date.now() + ms; ; ) {
    const found = await fits();
    if (found) return found;
    if (Date.now() > ends) throw new Error(`${what}: not within ${ms} ms`);
    await new Promise((ok) => setTimeout(ok, 20));
  }
}

export async function freePort() {
  const server = net.createServer().listen(0, "127.0.0.1");
  await new Promise((ok) => server.on("listening", ok));
  const { port } = server.address();
  await new Promise((ok) => server.close(ok));
  return port;
}

export async function serve(...args) {
  const port = await freePort();
  const child = start("collided-web", "--connect", uri, "--port", String(port), ...args);
  await until("collided-web says where it is", () => child.out.includes("\n") || child.exitCode !== null);
  const token = (child.out.match(/#t=([0-9a-f]{32})/) || ["", ""])[1];
  return { child, port, token };
}

export function check(what, holds, more = "") {
  if (holds) return;
  failures++;
  console.error(`FAILED: ${what} ${more}`);
}

export const equal = (what, got, wanted) => check(what, Object.is(got, wanted), `${got} instead of ${wanted}`);

export async function run(tests) {
  for (const test of tests) {
    try {
      await test();
      console.log(`ok ${test.name}`);
    } catch (e) {
      failures++;
      console.error(`FAILED ${test.name}: ${e.stack}`);
    }
  }
  process.exit(failures ? 1 : 0);
}
export { createHash };
