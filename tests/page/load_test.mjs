// The page loads, shows the loop, and accesses no other server.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { pictureOf, startDemoWithPage, until } from './support.mjs';

const { page } = await startDemoWithPage({ isAtFullRate: true });

test('The page has a title', async () => {
  assert.match(await page.title(), /hystcan/i);
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

test('No error on the console, no violated policy, no request to another host', async () => {
  assert.deepEqual(page.problems, []);
});
