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

/** The readout of the cursors: name of the row -> texts of A, B and B - A. */
async function readout() {
  const rows = await page.locator('#cursor-readout tbody tr').evaluateAll((all) =>
    all.map((row) => [...row.cells].map((cell) => cell.textContent.replace('\u2212', '-'))));
  return new Map(rows.map(([name, ...texts]) => [name, texts]));
}

test('Two cursors give the differences with their units while the charts run', async () => {
  await page.click('#cursors');
  const first = await until('the readout', async () => {
    const rows = await readout();
    return rows.has('time, s') && [...rows.keys()].some((name) => /position, um/.test(name)) && rows;
  });
  const apart_s = Number(first.get('time, s')[2]);
  assert.ok(apart_s > 0);
  assert.ok(Math.abs(Number(first.get('1/Δt, Hz')[2]) * apart_s - 1) < 1e-3);
  for (const [a, b, difference] of [...first.values()].filter((texts) => texts[0] && texts[0] !== '-'))
    assert.ok(Math.abs(Number(b) - Number(a) - Number(difference)) < 2e-3, `${a} ${b} ${difference}`);
  await until('other times', async () => (await readout()).get('time, s')[0] !== first.get('time, s')[0]);
});

test('A cursor moves with the arrow keys and with the pointer', async () => {
  const apart = async () => Number((await readout()).get('time, s')[2]);
  const before = await apart();
  const cursor = page.locator('#tracking-chart').getByRole('slider', { name: 'Cursor B' });
  await cursor.focus();
  await page.keyboard.press('ArrowRight');
  await until('a larger distance', async () => (await apart()) > before);
  const [box, chart] = [await cursor.boundingBox(), await plotBox('#tracking-chart')];
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(chart.x + 0.4 * chart.width, box.y + box.height / 2, { steps: 5 });
  await page.mouse.up();
  await until('a smaller distance', async () => (await apart()) < before);
  await page.click('#cursors');
});

test('A drag zooms in, a double click shows all again', async () => {
  await pause(true);
  await page.click('#cursors');
  const apart_s = async () => Number((await readout()).get('time, s')?.[2]);
  const whole_s = await until('the cursors', apart_s);
  const box = await plotBox('#tracking-chart');
  const y = box.y + 0.5 * box.height;
  await page.mouse.move(box.x + 0.1 * box.width, y);
  await page.mouse.down();
  await page.mouse.move(box.x + 0.3 * box.width, y, { steps: 8 });
  await page.mouse.up();
  await until('a fifth of the time', async () => Math.abs((await apart_s()) / whole_s - 0.2) < 0.02);
  await page.mouse.dblclick(box.x + 0.2 * box.width, y);
  await until('the whole time', async () => (await apart_s()) === whole_s);
  await page.click('#cursors');
  await pause(false);
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
