// Crashes the demo's car with the mouse in Chromium: node page.mjs FOLDER CHROMIUM [PICTURE.png]
// FOLDER is the demo as `cargo xtask web` lays it out. playwright-core is found from the working directory.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { createServer } from "node:http";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { extname, join, normalize } from "node:path";

const { chromium } = createRequire(join(process.cwd(), "here.js"))("playwright-core");
const [folder, executablePath, picture] = process.argv.slice(2);
const TYPES = { ".html": "text/html", ".js": "text/javascript", ".wasm": "application/wasm" };
const server = createServer(async (request, response) => {
  try {
    const path = normalize(new URL(request.url, "http://localhost").pathname).replace(/\/$/, "/index.html");
    const type = TYPES[extname(path)] ?? "application/octet-stream";
    response.writeHead(200, { "content-type": type }).end(await readFile(join(folder, path)));
  } catch {
    response.writeHead(404).end();
  }
});
await new Promise((ready) => server.listen(0, "127.0.0.1", ready));

// Where they are at first.
const [FRONT, DOOR, GLASS] = [[255, 440], [600, 330], [450, 230]];
const args = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-background-networking"];
const browser = await chromium.launch({ executablePath, args, env: { ...process.env, HOME: tmpdir() } });
try {
  const page = await browser.newPage({ viewport: { width: 1000, height: 600 } });
  const problems = [];
  page.on("pageerror", (error) => problems.push(String(error)));
  page.on("console", (message) => message.type() === "error" && problems.push(message.text()));
  page.on("requestfailed", (request) => problems.push(`${request.url()} failed`));
  await page.goto(`http://127.0.0.1:${server.address().port}/`);
  const status = page.locator("#status");
  const says = (text) => status.filter({ hasText: text }).waitFor({ timeout: 30_000 });
  await says("Click the car: 78706 vertices").catch((error) => assert.fail(`${error}; ${problems.join("; ")}`));
  const drawn = await page.locator("body").getAttribute("data-drawn");
  const before = await page.screenshot();
  await page.mouse.click(...FRONT);
  await says("Dented:");
  assert.match(await status.textContent(), /^Dented: [1-9]\d* vertices/);
  const after = await page.screenshot();
  assert.ok(!before.equals(after), "the picture did not change");
  await page.mouse.click(5, 5);
  assert.match(await status.textContent(), /^Dented:/, "a click beside the car dents nothing");
  await page.selectOption("#thing", "a wall's corner");
  await page.mouse.click(...GLASS);
  await says("Glass broke:");
  await page.mouse.click(...DOOR);
  await says("Dented:");
  await page.click("#rain");
  await says("Hail:");
  await page.screenshot({ path: picture });
  // The address has the damage: another visitor sees the same.
  const link = page.url();
  await page.mouse.move(300, 250);
  await page.mouse.down();
  await page.mouse.move(380, 260, { steps: 4 });
  await page.mouse.up();
  assert.match(await status.textContent(), /^Hail:/, "dragging throws nothing");
  assert.equal(page.url(), link);
  await page.goto("about:blank");
  await page.goto(link);
  await says("As the address says:").catch((error) => assert.fail(`${error}; ${problems.join("; ")}`));
  assert.equal(page.url(), link);
  await page.click("#repair");
  await says("Repaired:");
  assert.ok(!page.url().includes("#"), "a repaired car's address has no damage");
  assert.deepEqual(problems, []);
  const bytes = link.length - link.indexOf("#") - 1;
  console.log(`the page was drawn after ${drawn} ms; it dents, turns and repairs the car, and its link has ${bytes} letters`);
} finally {
  await browser.close();
  server.close();
}
