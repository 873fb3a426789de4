// Captures and what leaves the page as a file.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, before, test } from 'node:test';

import { openPage, seesTheLoopRun, startBrowser, startDemo, until } from './support.mjs';

const pre_s = 0.5, post_s = 0.25, rate_Hz = 1000;
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

async function download(button) {
  const [file] = await Promise.all([page.waitForEvent('download'), page.click(button)]);
  return { name: file.suggestedFilename(), content: readFileSync(await file.path()) };
}

const captures = () => page.locator('#capture-list').locator('li, tbody tr').count();

test('A capture has its time before and after the trigger, each cycle of it', async () => {
  await page.evaluate(() => document.getElementById('arm').scrollIntoView());
  await page.getByLabel(/before|^pre/i).fill(String(pre_s));
  await page.getByLabel(/after|^post/i).fill(String(post_s));
  await page.getByLabel(/^(trigger|on|kind)/i).first().selectOption('now');
  await page.click('#arm');
  await until('a capture', async () => (await captures()) === 1);
  const { name, content } = await download('#export-csv');
  assert.match(name, /\.csv$/);
  const lines = content.toString().trim().split(/\r?\n/).filter((line) => !line.startsWith('#'));
  const columns = lines[0].split(',');
  const times = lines.slice(1).map((line) => Number(line.split(',')[columns.findIndex((column) => /^time_s/.test(column))]));
  assert.ok(Math.abs(times.length - (pre_s + post_s) * rate_Hz) <= 2, `${times.length} rows`);
  const steps = times.slice(1).map((time, i) => time - times[i]);
  assert.ok(steps.every((step) => Math.abs(step - 1 / rate_Hz) < 1e-6), `steps of ${Math.min(...steps)}..${Math.max(...steps)} s`);
});

test('The CSV has a name and a unit for each column and every digit', async () => {
  const { content } = await download('#export-csv');
  const lines = content.toString().trim().split(/\r?\n/).filter((line) => !line.startsWith('#'));
  const columns = lines[0].split(',');
  for (const column of ['reference_um', 'position_um', 'drive'])
    assert.ok(columns.some((name) => name.startsWith(column)), `${column} in ${lines[0]}`);
  assert.match(lines[0], /V/);
  assert.ok(lines.slice(1).every((line) => line.split(',').length === columns.length));
  const position = columns.findIndex((name) => name.startsWith('position_um'));
  assert.ok(lines.slice(1).some((line) => line.split(',')[position].replace(/[-.]/g, '').length >= 8), 'full precision');
});

test('The PNG is a picture of some size', async () => {
  const { name, content } = await download('#export-png');
  assert.match(name, /\.png$/);
  assert.equal(content.subarray(0, 8).toString('latin1'), '\x89PNG\r\n\x1a\n');
  assert.ok(content.readUInt32BE(16) >= 400 && content.readUInt32BE(20) >= 200, 'width and height');
  assert.ok(content.length > 5000, `${content.length} bytes`);
});

test('Nothing went wrong meanwhile', () => {
  assert.deepEqual(page.problems, []);
});
