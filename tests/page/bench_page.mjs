// bench_page.mjs: how the page runs beside a demo: frames per second, time to the first plot, processor shares.
import { readdirSync, readFileSync } from 'node:fs';

import { openPage, seesTheLoopRun, startBrowser, startDemo, until } from './support.mjs';

const run_s = 10;
const ticks_per_s = 100;  // of /proc, on every Linux

function statOf(pid) {
  try {
    const text = readFileSync(`/proc/${pid}/stat`, 'latin1');
    const fields = text.slice(text.lastIndexOf(')') + 2).split(' ');
    return { parent: Number(fields[1]), ticks: Number(fields[11]) + Number(fields[12]) };
  } catch {
    return { parent: 0, ticks: 0 };
  }
}

/** Processor time in s of a process and its descendants. */
function processor_s(root) {
  const stats = new Map(readdirSync('/proc').filter((name) => /^\d+$/.test(name)).map((pid) => [Number(pid), statOf(pid)]));
  const family = new Set([root]);
  for (let size = 0; size !== family.size;) {
    size = family.size;
    for (const [pid, stat] of stats) if (family.has(stat.parent)) family.add(pid);
  }
  return [...family].reduce((sum, pid) => sum + (stats.get(pid)?.ticks ?? 0), 0) / ticks_per_s;
}

function report(what, value, unit, isMet, aim) {
  console.log(`${what.padEnd(34)} ${value.toFixed(1).padStart(8)} ${unit.padEnd(4)} aim ${aim}: ${isMet ? 'met' : 'MISSED'}`);
}

const demo = await startDemo();
const browser = await startBrowser();
const page = await openPage(browser, demo, { isAtFullRate: true });
await seesTheLoopRun(page);
await showSixSignalsAtFullRate(page);
const before = { rows: await rows(), page_s: performance.now() / 1000, demo_s: processor_s(demo.child.pid), all_s: processor_s(process.pid) };
const rates = [];
await until('ten seconds of frames', async () => {
  rates.push(await page.evaluate(() => window.hystcanPage.framesPerSecond()));
  await new Promise((done) => setTimeout(done, 500));
  return performance.now() / 1000 > before.page_s + run_s;
});
const elapsed_s = performance.now() / 1000 - before.page_s;
const demo_share = (processor_s(demo.child.pid) - before.demo_s) / elapsed_s;
const browser_share = (processor_s(process.pid) - before.all_s) / elapsed_s - demo_share;
const frames_per_s = rates.reduce((sum, rate) => sum + rate, 0) / rates.length;
const rows_per_s = (await rows() - before.rows) / elapsed_s;
const firstPlot_ms = await page.evaluate(() => window.hystcanPage.firstPlotMs);

report('frames per second, six signals', frames_per_s, '1/s', frames_per_s >= 59.5, '60');
report('rows of axis 0 per second', rows_per_s, '1/s', rows_per_s >= 995, '1000');
report('from navigation to the first plot', firstPlot_ms, 'ms', firstPlot_ms <= 1000, '1000');
console.log(`processor share: demo with its server ${(100 * demo_share).toFixed(0)} %, browser ${(100 * browser_share).toFixed(0)} %`);
await browser.close();
await demo.stop();

function rows() {
  return page.evaluate(() => window.hystcanPage.rows(0));
}

/** The page asks for 1 kHz by itself; six signals in one chart beside those that are there anyway. */
async function showSixSignalsAtFullRate() {
  await page.click('#signals summary');
  for (const column of ['position_um', 'reference_um', 'drive'])
    for (const axis of [0, 1]) await page.check(`#signal-choice input[value="controller ${axis} ${column}"]`);
}
