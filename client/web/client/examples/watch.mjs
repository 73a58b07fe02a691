// watch.mjs [ws://HOST:PORT/ws] [TOKEN]: tells what begins and ends, and checks each interval itself. Ends after SECONDS
// (environment), if set. Node 18 has no WebSocket: there `npm install ws`; later ones need nothing.
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { Checker, Connection, Kind, World, factNames, prove } from "@collided/client";

const require = createRequire(import.meta.url);
const checker = await Checker.create(await readFile(require.resolve("@collided/client/verify.wasm")));
const world = new World();
const connection = new Connection({
  url: process.argv[2] ?? "ws://127.0.0.1:9465/ws",
  token: process.argv[3] ?? "",
  subscribe: { rate_hz: 10, range_m: 0.5 },
  WebSocket: globalThis.WebSocket ?? require("ws"),
  onState: (state, why) => console.log(`${state}: ${why}`),
});
if (process.env.SECONDS) setTimeout(() => connection.close(), 1000 * Number(process.env.SECONDS));

let told = 0n;
for await (const frame of connection.frames()) {
  world.apply(frame);
  if (frame.kind === Kind.events)
    for (const e of frame.events)
      console.log(`${factNames[e.kind]} ${world.nameOf(e.bodyA)} ${world.nameOf(e.bodyB)} ${e.lo} .. ${e.hi}`);
  for (const number of world.wanted) connection.ask("geometry", { number }).catch(() => undefined);
  if (frame.kind === Kind.contacts && frame.tick > told + 500n) {
    told = frame.tick;
    for (const c of world.contacts.values())
      console.log(`${world.nameOf(c.bodyA)} and ${world.nameOf(c.bodyB)}: ${c.lo} .. ${c.hi} m, ${prove(checker, world, c)}`);
  }
}
