// What the browser tests share: a demo with its page, a browser, and waiting for a condition.
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

// Only how long a test waits before it fails: a slow machine needs long.
const patience_ms = 60_000;

/** Waits until `condition()` is truthy and returns its value; after a minute it throws and says what did not come. */
export async function until(what, condition) {
  for (const end = Date.now() + patience_ms; ;) {
    const value = await condition();
    if (value) return value;
    if (Date.now() > end) throw new Error(`it did not come to this: ${what}`);
    await new Promise((done) => setTimeout(done, 20));
  }
}

/** A folder that is removed at the end of the process, when the last program of it has ended. */
export function scratchFolder() {
  const folder = mkdtempSync(join(tmpdir(), 'hystcan-page.'));
  process.on('exit', () => rmSync(folder, { recursive: true, force: true, maxRetries: 50, retryDelay: 100 }));
  return folder;
}

/** A copy of the shipped configuration files, which a test may change; returns the path of NAME. */
export function copyOfConfig(name = 'piezo.toml') {
  const folder = scratchFolder();
  cpSync(join(repository, 'config'), folder, { recursive: true, filter: (file) => !/\.(cpp|h)$/.test(file) });
  return join(folder, name);
}

const names = { page: 'url', token: 'token', 'control socket': 'socket', 'twin socket': 'twinSocket' };
const running = new Set();
process.on('exit', () => running.forEach((child) => child.kill('SIGKILL')));

/** Starts `hystcan demo --page` and returns what it says: url, token, socket, twinSocket. */
export async function startDemo({ config, port = 0, options = [] } = {}) {
  const words = ['demo', '--page', `127.0.0.1:${port}`, ...options];
  if (config) words.push('--config', config);
  const folder = scratchFolder();  // a demo that is killed leaves its files there
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
  const child = spawn(process.env.HYSTCAN, ['ctl', '--socket', socket, ...words]);
  let output = '';
  child.stdout.on('data', (text) => (output += text));
  child.stderr.on('data', (text) => (output += text));
  const status = await new Promise((done) => child.once('close', done));
  return { status, output };
}

export async function startBrowser() {
  return chromium.launch({
    executablePath: process.env.HYSTCAN_BROWSER,
    args: ['--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
      '--disable-component-update', '--disable-sync'],
  });
}

/**
 * Opens the page in a context of its own. `page.problems` gathers errors on the console, violations of the content
 * security policy and requests to other hosts.
 */
export async function openPage(browser, demo, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1400, height: 900 }, ...options });
  context.setDefaultTimeout(patience_ms);
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

/** The canvases of a chart as one text. */
export async function pictureOf(page, chart) {
  return page.evaluate((selector) => {
    const place = document.querySelector(selector);
    return [...(place.matches('canvas') ? [place] : place.querySelectorAll('canvas'))].map((one) => one.toDataURL()).join();
  }, chart);
}

/** Takes control, with the token if the page asks for it, from another page if need be. */
export async function takeControl(page, demo) {
  await page.click('#take-control');
  const token = page.locator('#token');
  await until('control is taken', async () => {
    if (await token.isVisible()) {
      await token.fill(demo.token);
      await token.press('Enter');
      await until('the dialog closes', async () => !(await token.isVisible()));
    }
    const takeOver = page.getByRole('button', { name: /take over/i });
    if (await takeOver.isVisible()) await takeOver.click();
    return (await page.textContent('#take-control')) === 'Release';
  });
}

/** Waits until the page has drawn rows of the axis. */
export async function seesTheLoopRun(page, axis = 0) {
  await page.waitForFunction((index) => window.hystcanPage?.rows(index) > 100 && window.hystcanPage.firstPlotMs > 0, axis);
}

/** What most scripts begin with: a demo, a browser and its page, which shows the loop. They end with the last test. */
export async function startDemoWithPage(options) {
  const demo = await startDemo(options);
  const browser = await startBrowser();
  after(async () => {
    await browser.close();
    await demo.stop();
  });
  const page = await openPage(browser, demo);
  await seesTheLoopRun(page);
  return { demo, browser, page };
}
