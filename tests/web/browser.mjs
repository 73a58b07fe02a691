// browser: a headless Chromium for the tests of the page, and what all of them ask of it. Exit 77 (skipped) where it is absent.
import { existsSync } from "node:fs";

const chromium = ["/usr/bin/chromium", "/usr/bin/chromium-browser"].find(existsSync);

/** A browser without a network but loopback; `more`: further arguments. */
export async function launch(more = []) {
  if (!chromium) {
    console.log("skipped: there is no Chromium (apt-get install chromium)");
    process.exit(77);
  }
  const { default: puppeteer } = await import("puppeteer-core");
  return puppeteer.launch({ executablePath: chromium, headless: true, protocolTimeout: 240000,
    args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-proxy-server",
      "--disable-background-networking", "--disable-dev-shm-usage", "--disable-component-update", ...more] });
}

/** A page of that address; what it asks for is in page.asked, its errors are in page.wrong. */
export async function open(browser, url, { width = 640, height = 480 } = {}) {
  const page = await browser.newPage();
  page.asked = [];
  page.wrong = [];
  page.on("request", (r) => page.asked.push(r.url()));
  page.on("pageerror", (e) => page.wrong.push(e.message));
  page.on("console", (m) => { if (m.type() === "error") page.wrong.push(m.text()); });
  await page.setViewport({ width, height });
  await page.goto(url);
  return page;
}

/** Waits until what the page computes is true. */
export const until = (page, what, ...args) => page.waitForFunction(what, { timeout: 120000, polling: 100 }, ...args);
export const text = (page, selector) => page.$eval(selector, (e) => e.textContent);
