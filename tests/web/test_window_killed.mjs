// Whatever becomes of collided-web, no event of others changes: a simulator in lock-step does the same with nobody who looks
// on, and while one collided-web is stopped and others are killed and started all the time. Its hash of events is the same.
import { Socket } from "./client.mjs";
import { check, equal, run, serve, start, uri } from "./harness.mjs";

start("collided", "--links", uri, "--heartbeat", "0.2");

async function simulate(scene) {
  const simulator = start("impact_simulator", "--connect", uri, "--scene", scene, "--json");
  const { code } = await simulator.ended;
  equal(`impact_simulator ${scene} ends well: ${simulator.err}`, code, 0);
  const summary = simulator.out.trim().split("\n").map((line) => JSON.parse(line)).find((l) => l.event === "summary");
  return { hash: summary.hash, steps: summary.steps, impacts: summary.impacts };
}

async function look() { // a window with a page that wants everything
  const { child, port, token } = await serve();
  const page = new Socket(port, {});
  await page.opened;
  page.send({ op: "hello", token });
  page.send({ op: "subscribe", rate_hz: 60, range_m: 1 });
  return { child, page };
}

async function no_window_changes_an_event() {
  const alone = await simulate("billiards");
  check("something happens", alone.impacts > 10, JSON.stringify(alone));
  const stopped = await look();
  stopped.child.kill("SIGSTOP");
  let over = false, kills = 0;
  const watched = (async () => {
    const all = [];
    while (all.length < 3) all.push(await simulate("billiards"));
    return all;
  })().finally(() => (over = true));
  while (!over) {
    const { child, page } = await look();
    await Promise.race([page.next(1), watched]);
    child.kill("SIGKILL");
    await child.ended;
    kills++;
  }
  stopped.child.kill("SIGKILL");
  const all = await watched;
  check("windows were killed", kills >= 1, `${kills}`);
  for (const seen of all) equal("what was seen", JSON.stringify(seen), JSON.stringify(alone));
  console.log(`${kills} windows killed; ${JSON.stringify(alone)}`);
}

await run([no_window_changes_an_event]);
