// test_checker.mjs CLAIMS WASM [COUNT]: verify.wasm gives the verdicts of the library, claim by claim, for 200,000 random
// claims that the program CLAIMS makes, and of the kernel also the bits of what is proven; it imports nothing; and words that
// are no claim are refused.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { readFileSync } from "node:fs";
import { Checker } from "../../../npm/dist/index.js";

const [claims, wasm, count = "200000"] = process.argv.slice(2);
const octets = readFileSync(wasm);
const module = await WebAssembly.compile(octets);
assert.deepEqual(WebAssembly.Module.imports(module), [], "verify.wasm needs nothing of its host");
const checker = await Checker.create(octets);

const child = spawn(claims, [count], { stdio: ["ignore", "pipe", "inherit"] });
const verdicts = [0, 0, 0, 0, 0, 0, 0, 0], kernel = new Array(14).fill(0);
let rest = Buffer.alloc(0), checked = 0, words = 0, spent = 0n;
for await (const piece of child.stdout) {
  rest = rest.length > 0 ? Buffer.concat([rest, piece]) : piece;
  const whole = new Float64Array(rest.buffer.slice(rest.byteOffset, rest.byteOffset + (rest.length & ~7)));
  let at = 0;
  while (at < whole.length && at + whole[at] + 5 <= whole.length) {
    const n = whole[at], claim = whole.subarray(at + 1, at + 1 + n), expected = whole[at + 1 + n];
    const begin = process.hrtime.bigint();
    const got = checker.checkWords(claim);
    spent += process.hrtime.bigint() - begin;
    if (got !== expected) assert.fail(`claim ${checked}: ${got} here, ${expected} by the library`);
    const by = checker.kernelWords(claim, 1e-9), told = whole.subarray(at + 2 + n, at + 5 + n);
    if (by.status !== told[0] || !Object.is(by.lo, told[1]) || !Object.is(by.hi, told[2]))
      assert.fail(`claim ${checked}: the kernel says ${by.status} [${by.lo}, ${by.hi}] here, natively ${told}`);
    verdicts[got]++;
    kernel[by.status]++;
    checked++;
    words += n;
    at += n + 5;
  }
  rest = rest.subarray(8 * at);
}
assert.equal(child.exitCode ?? await new Promise((r) => child.on("exit", r)), 0);
assert.equal(checked, Number(count));
// Proven, refused, and of compounds neither: all of these have to be there for this to test anything.
assert.ok(verdicts[0] > checked / 10 && verdicts[3] > checked / 10 && verdicts[7] > 0, `verdicts: ${verdicts}`);
// By the kernel: proven, not lo, not hi, a depth, a bad axis, a bad claim.
for (const status of [0, 1, 2, 3, 10, 11]) assert.ok(kernel[status] > 0, `statuses of the kernel: ${kernel}`);
// What is no claim.
for (const bad of [[], [0], new Array(40).fill(0), new Array(53).fill(NaN), new Array(53).fill(1e300)]) {
  assert.equal(checker.checkWords(Float64Array.from(bad)), 1);
  assert.ok(checker.kernelWords(Float64Array.from(bad)).status > 4);
}
console.log(`${checked} claims: ${verdicts[0]} proven, ${verdicts[3]} refused, ${verdicts[7]} neither, ${kernel[0]} proven by the kernel; ` +
  `${(Number(spent) / checked / 1000).toFixed(2)} us each, ${octets.length} octets of WebAssembly`);
