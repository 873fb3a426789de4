// The page loads, shows the loop, and asks no other server.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';

import { openPage, pictureOf, seesTheLoopRun, seesTracking, startBrowser, startDemo, until } from './support.mjs';

let demo, browser, page;
before(async () => {
  demo = await startDemo();
  browser = await startBrowser();
  page = await openPage(browser, demo, { isAtFullRate: true });
});
after(async () => {
  await browser.close();
  await demo.stop();
});

test('The page has a title', async () => {
  assert.match(await page.title(), /hystcan/i);
});

test('It draws what the controller sends', async () => {
  await seesTheLoopRun(page);
});

test('The axis is shown as tracking', async () => {
  await seesTracking(page);
});

test('The loop moves', async () => {
  const first = await page.evaluate(() => window.hystcanPage.latest(0).position_um);
  assert.equal(typeof first, 'number');
  await until('another position', () => page.evaluate((was) => window.hystcanPage.latest(0).position_um !== was, first));
  for (const chart of ['#loop-chart', '#tracking-chart', '#error-chart', '#drive-chart']) {
    const picture = await pictureOf(page, chart);
    await until(`another picture of ${chart}`, async () => (await pictureOf(page, chart)) !== picture);
  }
});

test('Two axes are received', async () => {
  await seesTheLoopRun(page, 1);
});

test('No error on the console, no violated policy, no request to another host', async () => {
  assert.deepEqual(page.problems, []);
});
