// Pause, zoom and cursors of the charts.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';

import { openPage, pictureOf, seesTheLoopRun, startBrowser, startDemo, until } from './support.mjs';

let demo, browser, page;
before(async () => {
  demo = await startDemo();
  browser = await startBrowser();
  page = await openPage(browser, demo);
  await seesTheLoopRun(page);
});
after(async () => {
  await browser.close();
  await demo.stop();
});

const rows = () => page.evaluate(() => window.hystcanPage.rows(0));
const isPaused = () => page.evaluate(() => window.hystcanPage.paused);

/** Where the charts draw: the box of the chart's sensitive area. */
async function plotBox(chart) {
  return page.locator(`${chart} .u-over`).first().boundingBox();
}

async function pause(wanted) {
  if ((await isPaused()) !== wanted) await page.click('#pause');
  await until(`paused: ${wanted}`, async () => (await isPaused()) === wanted);
}

/** The picture, when two frames have it equal. */
async function restingPicture(chart) {
  let last;
  return until(`${chart} rests`, async () => {
    await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
    const picture = await pictureOf(page, chart);
    const rests = picture === last;
    last = picture;
    return rests && picture;
  });
}

test('Pause stops the charts while data goes on', async () => {
  await pause(true);
  const picture = await restingPicture('#tracking-chart');
  const before = await rows();
  await until('500 more rows', async () => (await rows()) > before + 500);
  assert.equal(await pictureOf(page, '#tracking-chart'), picture);
  await pause(false);
  await until('another picture', async () => (await pictureOf(page, '#tracking-chart')) !== picture);
});

test('Space pauses and goes on', async () => {
  await page.evaluate(() => document.activeElement?.blur());
  await page.keyboard.press('Space');
  await until('it is paused', isPaused);
  await page.keyboard.press('Space');
  await until('it goes on', async () => !(await isPaused()));
});

test('A drag zooms in, a double click shows all again', async () => {
  await pause(true);
  const whole = await restingPicture('#tracking-chart');
  const box = await plotBox('#tracking-chart');
  await page.mouse.move(box.x + 0.3 * box.width, box.y + 0.5 * box.height);
  await page.mouse.down();
  await page.mouse.move(box.x + 0.6 * box.width, box.y + 0.5 * box.height, { steps: 8 });
  await page.mouse.up();
  await page.mouse.move(0, 0);
  await until('another picture', async () => (await restingPicture('#tracking-chart')) !== whole);
  await page.mouse.dblclick(box.x + 0.5 * box.width, box.y + 0.5 * box.height);
  await page.mouse.move(0, 0);
  await until('the whole picture', async () => (await restingPicture('#tracking-chart')) === whole);
  await pause(false);
});

test('Two cursors give the differences with their units', async () => {
  await page.click('#cursors');
  const box = await plotBox('#tracking-chart');
  for (const part of [0.25, 0.75]) await page.mouse.click(box.x + part * box.width, box.y + 0.5 * box.height);
  const text = await until('the differences', async () => {
    const readout = await page.textContent('#cursor-readout');
    return /Δt/.test(readout) && /\d/.test(readout) && readout;
  });
  assert.match(text, /Δt[^Δ]*\d[^Δ]*\bm?s\b/);
  assert.match(text, /1\/Δt[^Δ]*Hz/);
  assert.match(text, /um|µm|μm/);
});

test('The window shows the last seconds that were chosen', async () => {
  const first = await pictureOf(page, '#tracking-chart');
  await page.selectOption('#window-seconds', '1');
  await until('another picture', async () => (await pictureOf(page, '#tracking-chart')) !== first);
  assert.equal(await page.inputValue('#window-seconds'), '1');
});

test('Nothing went wrong meanwhile', () => {
  assert.deepEqual(page.problems, []);
});
