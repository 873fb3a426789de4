// A fault is shown with its cause and its remedy, and can be cleared.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { ctl, seesTracking, startDemoWithPage, until } from './support.mjs';

const { demo, page } = await startDemoWithPage();
await seesTracking(page);

test('A fault appears with the text and the remedy of the server', async () => {
  const injected = await ctl(demo.twinSocket, 'inject', 'wrong_crc', '--axis', 'x', '--node', 'sensor');
  assert.equal(injected.status, 0, injected.output);
  await until('the axis is shown as faulted', async () => /faulted/i.test(await page.textContent('#axis-0-state')));
  const status = JSON.parse((await ctl(demo.socket, '--json', 'status')).output).axes[0];
  const shown = await until('the remedy', async () => {
    const text = await page.textContent('#axis-0-fault');
    return text.includes(status.remedy) && text;
  });
  assert.match(shown.replaceAll('_', ' '), new RegExp(status.fault.replaceAll('_', ' '), 'i'));
});

test('The fault is in the list of events', async () => {
  await until('the event', async () => /fault|missing|sample/i.test(await page.textContent('#events')));
});
