// Stop: by the button, by the key, with and without the token.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';

import { openPage, seesTheLoopRun, startBrowser, startDemo, takeControl, until } from './support.mjs';

let browser;
before(async () => {
  browser = await startBrowser();
});
after(() => browser.close());

async function started(t) {
  const demo = await startDemo();
  t.after(() => demo.stop());
  const page = await openPage(browser, demo);
  await seesTheLoopRun(page);
  await until('the page says that an axis is driven', () => isDriven(page));
  return { demo, page };
}

const isDriven = async (page) => /tracking|ready|initialising/i.test(await page.textContent('#axis-0-state'));

/** No axis is driven: every axis is offline, or the controller is gone. */
async function standsStill(page) {
  await until('no axis is driven', async () => !(await isDriven(page)));
}

async function giveToken(page, demo) {
  await until('the page asks for the token', () => page.locator('#token').isVisible());
  await page.fill('#token', demo.token);
  await page.press('#token', 'Enter');
}

test('The button asks for the token and stops', async (t) => {
  const { demo, page } = await started(t);
  await page.click('#stop');
  await giveToken(page, demo);
  await standsStill(page);
});

test('Esc stops, whatever has the focus', async (t) => {
  const { demo, page } = await started(t);
  await takeControl(page, demo);
  await page.locator('#steering-axes input:not([type=checkbox])').first().focus();
  await page.keyboard.press('Escape');
  await standsStill(page);
});

test('Esc stops while a dialog is open', async (t) => {
  const { demo, page } = await started(t);
  await takeControl(page, demo);
  await page.evaluate(() => document.activeElement?.blur());
  await page.keyboard.press('?');
  await until('the help', () => page.locator('dialog[open]').first().isVisible());
  await page.keyboard.press('Escape');
  await standsStill(page);
});

test('After Stop the page says what happened', async (t) => {
  const { demo, page } = await started(t);
  await page.click('#stop');
  await giveToken(page, demo);
  await standsStill(page);
  await until('the words', async () => /stopped|switched off|ramp/i.test(await page.textContent('body')));
  assert.deepEqual(page.problems.filter((problem) => !/WebSocket/.test(problem)), []);
});
