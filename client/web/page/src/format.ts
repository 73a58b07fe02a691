/* format: numbers in words, as the page writes them everywhere. */

/** A length in metres, as millimetres below a metre. Three decimals of a millimetre. */
export function lengthText(m: number): string {
  if (Number.isNaN(m)) return "–";
  if (!Number.isFinite(m)) return m > 0 ? "+∞" : "−∞";
  const a = Math.abs(m), sign = m < 0 ? "−" : "";
  if (a >= 1) return `${sign}${a.toPrecision(6)} m`;
  if (a >= 1e-4 || a === 0) return `${sign}${(1000 * a).toFixed(3)} mm`;
  return `${sign}${(1e6 * a).toPrecision(3)} µm`;
}

/** A time in seconds. */
export function secondsText(s: number): string {
  if (Number.isNaN(s)) return "–";
  if (!Number.isFinite(s)) return s > 0 ? "+∞" : "−∞";
  const a = Math.abs(s), sign = s < 0 ? "−" : "";
  if (a >= 100) return `${sign}${a.toFixed(0)} s`;
  if (a >= 1) return `${sign}${a.toFixed(2)} s`;
  if (a >= 1e-3) return `${sign}${(1e3 * a).toFixed(1)} ms`;
  return `${sign}${(1e6 * a).toFixed(1)} µs`;
}

/** An age: -1 stands for what is fixed, or not stamped. */
export function ageText(s: number): string { return s < 0 ? "not stamped" : secondsText(s); }

/** A count, in groups of three digits. */
export function countText(n: number | bigint): string { return n.toLocaleString("en-US").replaceAll(",", "\u202f"); }

/** A stamp in ns since 1970: the time of day, to the millisecond, local. */
export function clockText(ns: bigint): string {
  const d = new Date(Number(ns / 1000000n));
  const two = (n: number): string => String(n).padStart(2, "0");
  return `${two(d.getHours())}:${two(d.getMinutes())}:${two(d.getSeconds())}.${String(d.getMilliseconds()).padStart(3, "0")}`;
}
