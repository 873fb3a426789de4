// The figures of a captured step: those of the controller, with its band.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { test } from 'node:test';

import { captureNext, copyOfConfig, startDemoWithPage, until } from './support.mjs';

const config = copyOfConfig();
const text = readFileSync(config, 'utf8');
const [begin, end] = [text.indexOf('[[axis.control.setpoint]]'), text.indexOf('[axis.twin]')];
const steps = "[[axis.control.setpoint]]\nkind = 'step'\nfrom_um = 10\nto_um = 12\ndwell_s = 0.5\nsteps = 1000\n\n";
writeFileSync(config, text.slice(0, begin) + steps + text.slice(end));
const { page } = await startDemoWithPage({ config });

test('A captured step has its size, its band and its settling time', async () => {
  await page.getByRole('tab', { name: 'Capture' }).click();
  await page.getByLabel('Trigger on').selectOption('step');
  await page.locator('#capture-level').fill('1');
  await page.getByLabel('Before').fill('0.1');
  await page.getByLabel('After').fill('0.4');
  const row = (name) => page.locator('#step-rows tr', { hasText: name }).locator('td').textContent();
  // A machine that is busy for a second loses rows of the stream: the next capture may contain the whole
  // step.
  await until('the figures of a step', async () => {
    await page.getByRole('tab', { name: 'Capture' }).click();
    await captureNext(page);
    await page.getByRole('tab', { name: 'Response' }).click();
    await page.locator('#response-source').selectOption({ index: 1 }); // the newest
    return await page.locator('#step-rows tr').count() && /^1[02]\.000 to 1[02]\.000 um$/.test(await row('Step'));
  });
  const settled_ms = Number(/^([\d.]+) ms$/.exec(await row('Settling time to 0.05 um'))?.[1]);
  assert.ok(settled_ms > 0 && settled_ms < 400, `${settled_ms} ms`);
});

test('The page reports no problems', () => {
  assert.deepEqual(page.problems, []);
});
