// build.mjs OUT WASM VERSION: makes the page of collided-web, and the package @collided/client, out of this folder: bundles,
// the film's template, and THIRD-PARTY.txt. The same sources give the same octets. Run by CMake, in a copy of this folder
// above which `npm ci` has put what package.json names (script make).
import { build } from "esbuild";
import { execFileSync } from "node:child_process";
import { createHash } from "node:crypto";
import { copyFileSync, cpSync, existsSync, mkdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url)), root = resolve(here, "../..");
const tsc = join(root, "node_modules/typescript/bin/tsc");
const [out, wasm, version] = [resolve(process.argv[2]), process.argv[3] && resolve(process.argv[3]), process.argv[4] ?? "0.0.0"];
process.chdir(here);

/** Every package of which something is in the bundle, with its licence in full. */
function thirdParty(metafile) {
  const packages = new Set();
  for (const input of Object.keys(metafile.inputs)) {
    const m = /node_modules\/((?:@[^/]+\/)?[^/]+)\//.exec(input);
    if (m) packages.add(m[1]);
  }
  let text = "What other people wrote that is in page.js, worker.js and film.html, with their licences.\n";
  for (const name of [...packages].sort()) {
    const folder = join(root, "node_modules", name), about = JSON.parse(readFileSync(join(folder, "package.json"), "utf8"));
    const file = ["LICENSE", "LICENSE.md", "LICENSE.txt", "license"].map((f) => join(folder, f)).find(existsSync);
    if (!file) throw new Error(`${name} has no licence file`);
    text += `\n${"=".repeat(72)}\n${name} ${about.version} (${about.license})\n\n${readFileSync(file, "utf8").trim()}\n`;
  }
  return text;
}

const sha = (text) => `'sha256-${createHash("sha256").update(text).digest("base64")}'`;

/** One HTML file that needs no other: scripts, style and verify.wasm are in it; `collidectl film` puts the frames in place of
 * the line that says FRAMES. Its content security policy lets nothing else run, and nothing be fetched. */
function film(html, script, style, octets) {
  const safe = script.replaceAll("</script", "<\\/script").replaceAll("<!--", "<\\!--");
  const policy = `default-src 'none'; script-src ${sha(safe)} 'wasm-unsafe-eval'; style-src ${sha(style)}; img-src data:; base-uri 'none'; form-action 'none'`;
  const page = html
    .replace(/<link rel="stylesheet"[^>]*>\n/, () => `<meta http-equiv="Content-Security-Policy" content="${policy}">\n<style>${style}</style>\n`)
    .replace(/<script src=[^\n]*\n/, "");
  const data = `<script type="application/octet-stream" id="checker">${octets.toString("base64")}</script>\n` +
    `<script type="application/octet-stream" id="film" data-packed="gzip">\nFRAMES\n</script>\n`;
  return page.replace("</body>", () => `${data}<script>${safe}</script>\n</body>`);
}

const common = {
  bundle: true, minify: true, target: ["es2022"], format: "iife", charset: "utf8", legalComments: "none", metafile: true,
  write: false, logLevel: "warning", absWorkingDir: here,
};
execFileSync(process.execPath, [tsc, "-p", "."], { stdio: "inherit" });
const [page, worker] = await Promise.all([
  build({ ...common, entryPoints: ["page/src/main.ts"] }), build({ ...common, entryPoints: ["page/src/worker.ts"] }),
]);
const script = page.outputFiles[0].text, style = readFileSync("page/page.css", "utf8"), html = readFileSync("page/index.html", "utf8");

rmSync(join(out, "page"), { recursive: true, force: true });
mkdirSync(join(out, "page"), { recursive: true });
const put = (name, what) => writeFileSync(join(out, "page", name), what);
put("page.js", script);
put("worker.js", worker.outputFiles[0].text);
put("page.css", style);
put("index.html", html);
put("THIRD-PARTY.txt", thirdParty(page.metafile));
if (wasm) {
  put("verify.wasm", readFileSync(wasm));
  put("film.html", film(html, script, style, readFileSync(wasm)));
}

// The package: plain ES modules, types, the checker.
const folder = join(out, "npm");
rmSync(folder, { recursive: true, force: true });
mkdirSync(join(folder, "dist"), { recursive: true });
execFileSync(process.execPath, [tsc, "-p", "client", "--outDir", join(folder, "dist")], { stdio: "inherit" });
const about = JSON.parse(readFileSync("client/package.json", "utf8"));
about.version = version;
writeFileSync(join(folder, "package.json"), `${JSON.stringify(about, null, 2)}\n`);
copyFileSync("client/README.md", join(folder, "README.md"));
copyFileSync(join(root, "LICENSE"), join(folder, "LICENSE"));
cpSync("client/examples", join(folder, "examples"), { recursive: true });
if (wasm) copyFileSync(wasm, join(folder, "verify.wasm"));
