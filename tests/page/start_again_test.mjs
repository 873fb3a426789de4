// Start again: another rehearsal in the process of the demo, after Stop.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { test } from 'node:test';

import { copyOfConfig, ctl, openPage, seesTracking, startDemoWithPage, takeControl, until } from './support.mjs';

const config = copyOfConfig();
const { demo, browser, page } = await startDemoWithPage({ config });

const startAgain = () => page.locator('#start-again');

/** The button is shown while the page has no rows, which may briefly occur on a busy machine. */
async function hasNothingToStart() {
  await until('no button', async () => (await startAgain().count()) === 0);
}

async function stop() {
  await seesTracking(page);
  await hasNothingToStart();
  await page.click('#stop');
  await until('the button', () => startAgain().isVisible());
  await until('the axis is not driven', async () => !/tracking/.test(await page.textContent('#axis-0-state')));
}

test('Start is unavailable while the rehearsal runs', async () => {
  await takeControl(page, demo);
  await hasNothingToStart();
});

test('After Stop a click begins another rehearsal, and the page shows it', async () => {
  await stop();
  await startAgain().click();
  await seesTracking(page);
  await hasNothingToStart();
  assert.equal(await page.textContent('#stop-message'), '');
});

test('The first command after the start is executed', async () => {
  const position = page.getByRole('textbox', { name: 'Go to position of axis x, um' });
  await position.fill('12');
  await position.press('Enter');
  await until('the answer', async () => /moving to 12 um/.test(await page.textContent('#steering-axes')));
});

test('The control socket belongs to the new rehearsal', async () => {
  const status = JSON.parse((await ctl(demo.socket, '--json', 'status')).output);
  assert.equal(status.ok, true);
});

test('The button and its answer remain while the page looks for the controller', async () => {
  const looks = () => page.locator('#events li', { hasText: 'no controller' }).count();
  const before = await looks();
  await stop();
  const message = await page.locator('#stream-message > *').elementHandles();
  await until('another reason why there is none', async () => (await looks()) >= before + 2);
  for (const one of message) assert.ok(await one.evaluate((element) => element.isConnected));
  await startAgain().click();
  await seesTracking(page);
});

test('A damaged configuration is shown as the reason, and starts after its repair', async () => {
  await stop();
  const text = readFileSync(config, 'utf8');
  writeFileSync(config, text.replace(/^kp\s*=.*/m, 'kp = "much"'));
  await startAgain().click();
  await until('the reason', async () => /The start failed: .*kp/.test(await page.textContent('#stream-message')));
  writeFileSync(config, text);
  await startAgain().click();
  await seesTracking(page);
});

test('Changes of the file are shown after the start', async () => {
  await stop();
  writeFileSync(config, readFileSync(config, 'utf8').replace(/^amplifier_bandwidth_Hz\s*=.*/m, 'amplifier_bandwidth_Hz = 500.0'));
  await startAgain().click();
  await until('the new delay in the legend', async () =>
    /drive 1\.9 or 1\.6 ms earlier/.test(await page.textContent('#loop-chart figcaption')));
});

test('A page without the token requests it', async () => {
  await stop();
  const other = await openPage(browser, demo);
  await until('the button', () => other.locator('#start-again').isVisible());
  await other.click('#start-again');
  await until('the question', () => other.locator('#token').isVisible());
  await other.fill('#token', demo.token);
  await other.press('#token', 'Enter');
  await seesTracking(page);
  await other.context().close();
});

test('The page reports no problems', () => {
  assert.deepEqual(page.problems, []);
});
