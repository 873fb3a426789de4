// Shared code of the browser tests: a demo with its page, a browser, and waiting for a condition.
import { spawn } from 'node:child_process';
import { cpSync, mkdtempSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { createInterface } from 'node:readline';
import { after } from 'node:test';
import { fileURLToPath } from 'node:url';

export const repository = join(dirname(fileURLToPath(import.meta.url)), '../..');
const { chromium } = createRequire(join(process.env.HYSTCAN_NPM, 'package.json'))('playwright-core');

// Ends a test that hangs: the only limit in host time besides the TIMEOUT of ctest. Every wait uses it, and
// nothing else in a test depends on the speed of the machine.
const patience_ms = 120_000;

/** Waits until `condition()` is truthy and returns its value; throws an error with the name of the condition after `patience_ms`. */
export async function until(what, condition) {
  for (const end = Date.now() + patience_ms; ;) {
    const value = await condition();
    if (value) return value;
    if (Date.now() > end) throw new Error(`not within ${patience_ms / 1000} s: ${what}`);
    await new Promise((done) => setTimeout(done, 20));
  }
}

/** Returns a folder that is removed at the end of the process, after its last program has ended. */
export function scratchFolder() {
  const folder = mkdtempSync(join(tmpdir(), 'hystcan-page.'));
  process.on('exit', () => rmSync(folder, { recursive: true, force: true, maxRetries: 50, retryDelay: 100 }));
  return folder;
}

/** Copies the shipped configuration files, which a test may change; returns the path of NAME. */
export function copyOfConfig(name = 'piezo.toml') {
  const folder = scratchFolder();
  cpSync(join(repository, 'config'), folder, { recursive: true, filter: (file) => !/\.(cpp|h)$/.test(file) });
  return join(folder, name);
}

const names = { page: 'url', token: 'token', 'control socket': 'socket', 'twin socket': 'twinSocket' };
const running = new Set();
process.on('exit', () => running.forEach((child) => child.kill('SIGKILL')));

/** Starts `hystcan demo --page` and returns its url, token, socket and twinSocket. */
export async function startDemo({ config, port = 0, options = [] } = {}) {
  const words = ['demo', '--page', `127.0.0.1:${port}`, ...options];
  if (config) words.push('--config', config);
  const folder = scratchFolder();  // a killed demo leaves its files there
  const environment = { ...process.env, TMPDIR: folder };
  const child = spawn(process.env.HYSTCAN, words, { cwd: folder, env: environment, stdio: ['ignore', 'pipe', 'pipe'] });
  running.add(child);
  const demo = { child, log: '', url: '', token: '', socket: '', twinSocket: '', status: null };
  demo.ended = new Promise((done) => child.once('exit', (status, signal) => done((demo.status = status ?? signal))));
  demo.ended.then(() => running.delete(child));
  child.stderr.on('data', (text) => (demo.log += text));
  createInterface(child.stdout).on('line', (line) => {
    const said = /^(page|token|control socket|twin socket): (.*)$/.exec(line);
    if (said) demo[names[said[1]]] = said[2];
  });
  await until('the demo gives its page, token and control socket', () => {
    if (demo.status !== null) throw new Error(`the demo ended with status ${demo.status}: ${demo.log}`);
    return demo.url && demo.token && demo.socket && demo.twinSocket;
  });
  demo.port = Number(new URL(demo.url).port);
  demo.stop = async (signal = 'SIGTERM') => {
    child.kill(signal);
    return demo.ended;
  };
  return demo;
}

/** Runs `hystcan ctl` with the socket of the demo's controller, or of its twin; returns status and output. */
export async function ctl(socket, ...words) {
  const limit_s = String(patience_ms / 1000); // of the command itself: 5 s by default
  const child = spawn(process.env.HYSTCAN, ['ctl', '--socket', socket, '--timeout', limit_s, ...words]);
  let output = '';
  child.stdout.on('data', (text) => (output += text));
  child.stderr.on('data', (text) => (output += text));
  const status = await new Promise((done) => child.once('close', done));
  return { status, output };
}

export async function startBrowser() {
  return chromium.launch({
    timeout: patience_ms,
    executablePath: process.env.HYSTCAN_BROWSER,
    args: ['--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
      '--disable-component-update', '--disable-sync'],
  });
}

/**
 * Makes the page draw ten frames per second and request a hundred rows. The server disconnects a page that reads nothing
 * for 5 s: this page needs few resources of a busy machine, and its rows of ten seconds wait in the socket.
 */
function goEasy() {
  window.requestAnimationFrame = (draw) => setTimeout(() => draw(performance.now()), 100);
  const { send } = WebSocket.prototype;
  WebSocket.prototype.send = function sendEasy(text) {
    send.call(this, text.replace('"rate_Hz":1000', '"rate_Hz":100'));
  };
}

/**
 * Opens the page in a separate context. `page.problems` collects errors on the console, violations of the content
 * security policy and requests to other hosts. `isAtFullRate`: the page draws every frame and receives every row.
 */
export async function openPage(browser, demo, { isAtFullRate = false, ...options } = {}) {
  const context = await browser.newContext({ viewport: { width: 1400, height: 900 }, ...options });
  context.setDefaultTimeout(patience_ms);
  if (!isAtFullRate) await context.addInitScript(goEasy);
  const page = await context.newPage();
  page.problems = [];
  page.on('console', (message) => {
    if (message.type() === 'error') page.problems.push(message.text());
  });
  page.on('pageerror', (error) => page.problems.push(String(error)));
  page.on('request', (request) => {
    const url = new URL(request.url());
    if (/^(https?|wss?):$/.test(url.protocol) && url.host !== new URL(demo.url).host)
      page.problems.push(`request to ${url.host}`);
  });
  await page.goto(demo.url);
  return page;
}

/** Returns the canvases of a chart as one text. */
export async function pictureOf(page, chart) {
  return page.evaluate((selector) => {
    const place = document.querySelector(selector);
    return [...(place.matches('canvas') ? [place] : place.querySelectorAll('canvas'))].map((one) => one.toDataURL()).join();
  }, chart);
}

/** Takes control, with the token if the page requests it, from another page if necessary. */
export async function takeControl(page, demo) {
  const role = page.locator('#take-control');
  const token = page.locator('#token');
  const takeOver = page.getByRole('button', { name: /take over/i });
  await role.click();
  await until('control is taken', async () => {
    if (await token.isVisible()) {
      // Repeats this if a busy machine has delayed the answer, or has separated page and server.
      await token.fill(demo.token);
      await token.press('Enter');
      await until('an answer', async () =>
        !(await token.isVisible()) || !/^(|checking \.\.\.)$/.test(await page.textContent('#token-answer')));
    }
    if (await takeOver.isVisible()) await takeOver.click();
    return (await role.textContent()) === 'Release';
  });
}

/** Waits until the page has drawn rows of the axis. */
export async function seesTheLoopRun(page, axis = 0) {
  await page.waitForFunction((index) => window.hystcanPage?.rows(index) > 100 && window.hystcanPage.firstPlotMs > 0, axis);
}

/** Waits until the page shows the first axis as tracking. A busy machine may show a state as unknown for a moment. */
export async function seesTracking(page) {
  await until('the first axis tracks', async () => /tracking/.test(await page.textContent('#axis-0-state')));
}

/** Arms the trigger of the form and waits for a capture. The server disarms a page when it loses the connection. */
export async function captureNext(page) {
  const captures = () => page.evaluate(() => window.hystcanPage.captures);
  const before = await captures();
  await until('a capture', async () => {
    if ((await captures()) > before) return true;
    if ((await page.getAttribute('#armed', 'data-state')) !== 'armed') await page.click('#arm');
    return false;
  });
}

/** Starts a demo, a browser and its page with the loop, as most scripts need. They end after the last test. */
export async function startDemoWithPage({ isAtFullRate = false, ...options } = {}) {
  const demo = await startDemo(options);
  const browser = await startBrowser();
  after(async () => {
    await browser.close();
    await demo.stop();
  });
  const page = await openPage(browser, demo, { isAtFullRate });
  await seesTheLoopRun(page);
  return { demo, browser, page };
}
