/* status: rows of the tables that the daemon's counters fill: streams, clients, latency, pairs by stage, drops. */
import type { StatusFrame } from "../../client/src/index.js";
import { countText, secondsText } from "./format.js";
import type { Row } from "./table.js";

export type Counters = ReadonlyMap<string, number>;

export function countersOf(s: StatusFrame | null): Counters {
  return new Map(Object.entries(s?.counters ?? {}).map(([name, value]) => [name, Number(value)]));
}

/** Counters that begin so, and the rest of their names. */
function* beginning(c: Counters, prefix: string): Generator<[string, number]> {
  for (const [name, value] of c) if (name.startsWith(prefix)) yield [name.slice(prefix.length), value];
}

/** What a counter grew by a second between two states. */
export function rate(now: Counters, before: Counters, name: string, seconds: number): number {
  const was = before.get(name);
  return was === undefined || seconds <= 0 ? 0 : Math.max(0, ((now.get(name) ?? 0) - was) / seconds);
}
function rateText(x: number): string { return x < 99.95 && x > 0 ? x.toFixed(1) : countText(Math.round(x)); }
const ns = (c: Counters, name: string): string => (c.has(name) ? secondsText(c.get(name)! / 1e9) : "–");

export const streamColumns = [{ title: "stream" }, { title: "events/s", number: true }, { title: "events", number: true },
  { title: "work a tick", number: true }, { title: "waiting", number: true }];
export function streamRows(now: Counters, before: Counters, s: number): Row[] {
  return [...beginning(now, "events_of_")].map(([name, events]) => ({
    key: name, cells: [name, rateText(rate(now, before, `events_of_${name}`, s)), countText(events),
      secondsText((now.get(`work_of_${name}`) ?? 0) / 1e9), countText(now.get(`behind_of_${name}`) ?? 0)],
  }));
}

export const clientColumns = [{ title: "client" }, { title: "bodies", number: true }, { title: "poses/s", number: true },
  { title: "newest pose", number: true }, { title: "last heard", number: true }, { title: "work a tick", number: true }];
export function clientRows(now: Counters, before: Counters, s: number): Row[] {
  return [...beginning(now, "client_name_")].map(([rest]) => {
    const id = rest.slice(0, 16), name = rest.slice(17);
    return {
      key: id, cells: [name || id, countText(now.get(`client_bodies_${id}`) ?? 0), rateText(rate(now, before, `client_poses_${id}`, s)),
        ns(now, `client_pose_age_ns_${id}`), ns(now, `client_silent_ns_${id}`), secondsText((now.get(`client_work_${id}`) ?? 0) / 1e9)],
    };
  });
}

export const latencyColumns = [{ title: "since the last status" }, { title: "p50", number: true }, { title: "p90", number: true },
  { title: "p99", number: true }, { title: "most", number: true }];
export function latencyRows(now: Counters): Row[] {
  return [["latency", "pose to told"], ["tick", "a tick"]].filter(([k]) => now.has(`${k}_p50_ns`)).map(([k, title]) => ({
    key: k!, cells: [title!, ...["p50", "p90", "p99", "most"].map((p) => ns(now, `${k}_${p}_ns`))],
  }));
}

export const stageColumns = [{ title: "stage" }, { title: "pairs/s", number: true }, { title: "since the start", number: true }];
export function stageRows(now: Counters, before: Counters, s: number): Row[] {
  return [...beginning(now, "pairs_by_")].filter(([, n]) => n > 0).map(([stage, n]) => ({
    key: stage, cells: [stage.replaceAll("_", " "), rateText(rate(now, before, `pairs_by_${stage}`, s)), countText(n)],
  }));
}

const causes = ["rejects_untold", "late_poses", "clients_lost", "steps_missed", "batches_skipped", "dds_refused", "dds_foreign",
  "dds_write_failed", "dds_no_stream", "dds_history_full", "dds_samples_lost", "lcm_refused", "lcm_queue_full",
  "lcm_queue_full_poses", "lcm_out_dropped", "lcm_datagrams_dropped", "lcm_bad_frames", "lcm_gateway_restarts",
  "record_failures", "dropped_motions", "queries_cut", "share_refused", "pairs_left_out"];
export const dropColumns = [{ title: "cause" }, { title: "a second", number: true }, { title: "since the start", number: true }];
export function dropRows(now: Counters, before: Counters, s: number): Row[] {
  const names = [...causes, ...[...beginning(now, "reject_")].map(([c]) => `reject_${c}`)];
  return names.filter((n) => (now.get(n) ?? 0) > 0).map((n) => ({
    key: n, cells: [n.replaceAll("_", " "), rateText(rate(now, before, n, s)), countText(now.get(n)!)],
  }));
}
