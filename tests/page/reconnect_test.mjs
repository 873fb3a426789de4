// The page shows unknown states as unknown, and reconnects when its server returns.
import assert from 'node:assert/strict';
import { after, test } from 'node:test';

import { seesTracking, startDemo, startDemoWithPage, until } from './support.mjs';

let { demo, page } = await startDemoWithPage();
after(() => demo.stop()); // a different page by then

const connection = () => page.textContent('#connection');
const rows = () => page.evaluate(() => window.hystcanPage.rows(0));

test('A killed server is shown, and the rows continue after its restart', async () => {
  const connected = await connection();
  await demo.stop('SIGKILL');
  await until('the page says that the connection is lost', async () => (await connection()) !== connected);
  const before = await rows();
  demo = await startDemo({ port: demo.port });
  await until('the page is connected again', async () => (await connection()) === connected);
  await until('more rows', async () => (await rows()) > before + 50);
});

test('An unknown state is shown as unknown', async () => {
  const state = () => page.textContent('#axis-0-state');
  await seesTracking(page);
  demo.child.kill('SIGSTOP');
  // The age of the last status: a busy server may have sent one without a state before it was stopped.
  await until('the page says for how long', async () => /no status for \d/.test(await page.textContent('#age')));
  assert.match(await state(), /unknown/);
  demo.child.kill('SIGCONT');
  await until('the axis is seen again', async () => !(await state()).includes('unknown'));
  await until('the age is gone', async () => (await page.textContent('#age')) === '');
});
