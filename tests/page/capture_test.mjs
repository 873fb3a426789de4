// Captures, and the files saved by the page.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';

import { captureNext, startDemoWithPage, until } from './support.mjs';

const pre_s = 0.5;
const post_s = 0.25;
const rate_Hz = 1000;
const { page } = await startDemoWithPage();
// The history contains the rows before the trigger.
await page.waitForFunction((time_s) => window.hystcanPage.latest(0).time_s > time_s, 2 * pre_s);

async function download(button) {
  const [file] = await Promise.all([page.waitForEvent('download'), page.click(button)]);
  return { name: file.suggestedFilename(), content: readFileSync(await file.path()) };
}

async function arm(kind) {
  await page.getByRole('tab', { name: 'Capture' }).click();
  await page.getByLabel('Trigger on').selectOption(kind);
  await page.getByLabel('Before').fill(String(pre_s));
  await page.getByLabel('After').fill(String(post_s));
}

/** Returns the columns and rows of a CSV. */
function parse(content) {
  const lines = content.toString().trim().split('\n');
  return { columns: lines[0].split(','), rows: lines.slice(1).map((line) => line.split(',')) };
}
const named = (columns, name) => columns.findIndex((column) => column.startsWith(`${name} [`) || column === name);

/** Returns the newest capture, with a function for its columns. */
async function nextCapture() {
  await captureNext(page);
  const { columns, rows } = parse((await download('#capture-list > li:first-child button')).content);
  return { rows, column: (name) => rows.map((row) => Number(row[named(columns, name)])) };
}

test('A capture on a level has its time before and after the trigger, each cycle of it', async () => {
  await arm('level');
  await page.selectOption('#capture-signal', 'position_um');
  const level_um = 8;
  await page.locator('#capture-level').fill(String(level_um));
  await page.getByLabel('Edge').selectOption('rising');
  // A machine that is busy for a second loses rows of the stream: the next capture may contain all of them.
  const position = await until('a capture of every cycle', async () => {
    const { rows, column } = await nextCapture();
    const time = column('time_s');
    const isWhole = Math.abs(rows.length - (pre_s + post_s) * rate_Hz) <= 2 &&
      time.slice(1).every((at, i) => Math.abs(at - time[i] - 1 / rate_Hz) < 1e-6);
    return isWhole && column('position_um');
  });
  const trigger = Math.round(pre_s * rate_Hz);
  assert.ok(position.slice(trigger - 2, trigger + 2).some((value, i, near) => near[i - 1] < level_um && value >= level_um),
    `the level is crossed ${pre_s} s after the first row`);
});

test('The CSV has a name and a unit for each column and every digit', async () => {
  const { columns, rows } = parse((await download('#capture-csv')).content);
  for (const column of ['time_s [s]', 'reference_um [um]', 'position_um [um]', 'drive [V]'])
    assert.ok(columns.includes(column), `${column} in ${columns}`);
  assert.ok(rows.every((row) => row.length === columns.length));
  assert.ok(rows.some((row) => row[named(columns, 'position_um')].replace(/[-.]/g, '').length >= 12), 'every digit');
});

test('The axis, the state, the fault and the limits are words, as in the CSV of the controller', async () => {
  for (const button of ['#capture-csv', '#export-csv']) {
    const { columns, rows } = parse((await download(button)).content);
    const words = (name) => [...new Set(rows.map((row) => row[named(columns, name)]))].sort();
    assert.deepEqual(words('axis'), button === '#capture-csv' ? ['x'] : ['x', 'y']);
    assert.deepEqual(words('fault'), ['none']);
    assert.ok(words('state').every((word) => /^(waiting|initialising|ready|tracking)$/.test(word)), String(words('state')));
    assert.ok(words('limits').every((word) => word === '' || /^[a-z_+]+$/.test(word)), String(words('limits')));
  }
});

test('The live charts can be exported', async () => {
  const { columns, rows } = parse((await download('#export-csv')).content);
  assert.ok(columns.includes('position_um [um]'), String(columns));
  assert.ok(rows.length > 100, `${rows.length} rows`);
});

test('The PNG is a picture of some size', async () => {
  const { name, content } = await download('#export-png');
  assert.match(name, /\.png$/);
  assert.equal(content.subarray(0, 8).toString('latin1'), '\x89PNG\r\n\x1a\n');
  assert.ok(content.readUInt32BE(16) >= 400 && content.readUInt32BE(20) >= 200, 'width and height');
  assert.ok(content.length > 5000, `${content.length} bytes`);
});

test('The page reports no problems', () => {
  assert.deepEqual(page.problems, []);
});
