// The segments of the setpoint: shown with their shape, added and removed.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';

import { copyOfConfig, openPage, seesTracking, startDemoWithPage, takeControl, until } from './support.mjs';

const config = copyOfConfig();
const { demo, browser, page } = await startDemoWithPage({ config });
await takeControl(page, demo);
await seesTracking(page);
const summaries = page.getByText('Setpoint segments');
await until('the segments of both axes', async () => (await summaries.count()) === 2);
for (const summary of await summaries.all()) await summary.click();

const card = () => page.getByRole('region', { name: 'Axis x', exact: true });
const titles = () => card().locator('.segment h4').allTextContents();
const add = () => card().getByRole('button', { name: 'Add a segment' });

async function save() {
  await until('what is not saved', () => page.locator('#save').isEnabled());
  await page.click('#save');
  await page.locator('#save-dialog').getByRole('button', { name: 'Write the file' }).click();
  await until('the file has all', async () => /The file has all active settings/.test(await page.textContent('#unsaved')));
}
const showsSegments = (wanted) =>
  until(`the segments ${wanted}`, async () => (await titles()).join() === wanted.join());

test('Each segment is shown with its number and shape', async () => {
  await showsSegments(['1: triangle', '2: staircase']);
});

test('Add appends a copy of the last segment', async () => {
  await add().click();
  await showsSegments(['1: triangle', '2: staircase', '3: staircase']);
  const levels = () => card().getByRole('textbox', { name: /^Segment \d: staircase, levels_um/ }).all();
  const [second, third] = await Promise.all((await levels()).map((field) => field.inputValue()));
  assert.match(second, /^\[27, 5, /);
  assert.equal(third, second);
});

test('A key of the added segment can be set', async () => {
  const rise = card().getByRole('textbox', { name: 'Segment 3: staircase, rise_s' });
  await rise.fill('0.04');
  await rise.press('Enter');
  await until('the answer', async () => /0\.04 is active/.test(await card().textContent()));
});

test('Remove removes one segment, even after a change of a later one', async () => {
  await card().getByRole('button', { name: 'Remove segment 1: triangle' }).click();
  await showsSegments(['1: staircase', '2: staircase']);
  const rise = card().getByRole('textbox', { name: 'Segment 2: staircase, rise_s' });
  await until('its key moves with it', async () => (await rise.inputValue()) === '0.04');
});

test('Undo brings the removed segment back', async () => {
  await page.click('#undo');
  await showsSegments(['1: triangle', '2: staircase', '3: staircase']);
});

test('The last segment cannot be removed', async () => {
  for (let left = 3; left > 1; --left) {
    await card().getByRole('button', { name: `Remove segment ${left}` }).click();
    await until(`${left - 1} segments`, async () => (await titles()).length === left - 1);
  }
  assert.ok(await card().getByRole('button', { name: 'Remove segment 1' }).isDisabled());
});

test('Save comments out removed segments, and the file then contains all settings in force', async () => {
  await save();
  assert.match(readFileSync(config, 'utf8'), /^# \[\[axis\.control\.setpoint\]\]/m);
});

test('Save writes an added segment', async () => {
  const headers = () => readFileSync(config, 'utf8').match(/^\[\[axis\.control\.setpoint\]\]/gm).length;
  const before = headers();
  await add().click();
  await until('two segments', async () => (await titles()).length === 2);
  await save();
  assert.equal(headers(), before + 1);
});

test('The axis still tracks, and the reference curves are still drawn', async () => {
  await seesTracking(page);
  const second = await openPage(browser, demo); // requests the curves with the settings in force
  await until('the curves', () => second.evaluate(() => window.hystcanPage?.loopReference?.(0)?.ok));
  await second.context().close();
});

test('The page reports no problems', () => {
  assert.deepEqual(page.problems, []);
});
