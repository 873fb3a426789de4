// Stop: by the button, by the keys, with and without the token; and the other effect of Esc in fields and
// dialogs.
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
  t.after(() => page.close()); // it would continue to look for its server
  await seesTheLoopRun(page);
  await until('the page says that an axis is driven', () => isDriven(page));
  return { demo, page };
}

const state = (page) => page.textContent('#axis-0-state');
const isDriven = async (page) => /tracking|ready|initialising/.test(await state(page));

/** Waits until the axis is offline or the controller has ended. A busy machine may show a driven axis as unknown. */
async function standsStill(page) {
  await until('no axis is driven', async () => /offline|no controller/.test(await state(page)));
}

async function giveToken(page, demo) {
  await until('the page asks for the token', () => page.locator('#token').isVisible());
  await page.fill('#token', demo.token);
  await page.press('#token', 'Enter');
}

/** The keys that stop in every element. */
const pressStop = (page) => page.keyboard.press('Control+Shift+X');

/** Presses Esc twice, and repeats this until both arrive within a second; a slow machine may need it. */
async function pressEscTwice(page) {
  await until('two Esc within a second', async () => {
    await page.keyboard.press('Escape');
    await page.keyboard.press('Escape');
    return /Stopping|Stop was/.test(await page.textContent('#stop-message'));
  });
}

/** Returns a focused gain field whose value in force was replaced by another value. */
async function typeIntoGain(page) {
  const gain = page.getByRole('textbox', { name: /\bkp\b/i }).first();
  await until('the value in force', async () => (await gain.inputValue()) !== '');
  const inForce = await gain.inputValue();
  await gain.fill('0.0789');
  return { gain, inForce };
}

const hasFocus = (field) => field.evaluate((element) => document.activeElement === element);

test('Ctrl+Shift+X stops while a field is edited', async (t) => {
  const { demo, page } = await started(t);
  await takeControl(page, demo);
  await typeIntoGain(page);
  await pressStop(page);
  await standsStill(page);
});

test('Ctrl+Shift+X stops while a dialog is open, and the page then shows this', async (t) => {
  const { demo, page } = await started(t);
  await takeControl(page, demo);
  await page.evaluate(() => document.activeElement?.blur());
  await page.keyboard.press('?');
  await until('the help', () => page.locator('#help-dialog').isVisible());
  await pressStop(page);
  await standsStill(page);
  await until('the words', async () => /Stopped/.test(await page.textContent('#stop-message')));
});

test('Esc leaves a field with the value in force, and stops nothing', async (t) => {
  const { demo, page } = await started(t);
  await takeControl(page, demo);
  const { gain, inForce } = await typeIntoGain(page);
  await page.keyboard.press('Escape');
  assert.equal(await gain.inputValue(), inForce);
  assert.equal(await hasFocus(gain), false);
  assert.equal(await page.textContent('#stop-message'), '');
  await until('the axis is still driven', () => isDriven(page)); // unknown for a moment on a busy machine
});

test('Esc closes a dialog, and stops nothing', async (t) => {
  const { page } = await started(t);
  await page.click('#take-control');
  await until('the dialog', () => page.locator('#token-dialog').isVisible());
  await page.keyboard.type('half a token');
  await page.keyboard.press('Escape');
  await until('the dialog is closed', async () => !(await page.locator('#token-dialog').isVisible()));
  assert.equal(await page.textContent('#stop-message'), '');
  await until('the axis is still driven', () => isDriven(page)); // unknown for a moment on a busy machine
});

test('One Esc outside fields and dialogs only explains the second one', async (t) => {
  const { demo, page } = await started(t);
  await takeControl(page, demo);
  await page.evaluate(() => {
    document.activeElement?.blur();
    const said = document.getElementById('key-message');
    new MutationObserver(() => (window.said = said.textContent || window.said)).observe(said, { childList: true });
  });
  await page.keyboard.press('Escape');
  await until('the words', async () => (await page.evaluate(() => window.said)) === 'Press Esc again within a second to stop');
  await until('they go away', async () => (await page.textContent('#key-message')) === '');
  assert.equal(await page.textContent('#stop-message'), '');
  await until('the axis is still driven', () => isDriven(page)); // unknown for a moment on a busy machine
});

test('Two Esc with another key or a click between them do not stop', async (t) => {
  const { demo, page } = await started(t);
  await takeControl(page, demo);
  await page.evaluate(() => document.activeElement?.blur());
  await page.keyboard.press('Escape');
  await page.keyboard.press('Shift');
  await page.keyboard.press('Escape');
  await page.locator('#live-title').evaluate((place) => place.dispatchEvent(new Event('pointerdown', { bubbles: true })));
  await page.keyboard.press('Escape');
  assert.equal(await page.textContent('#stop-message'), '');
  await until('the axis is still driven', () => isDriven(page)); // unknown for a moment on a busy machine
});

test('Esc twice within a second stops', async (t) => {
  const { demo, page } = await started(t);
  await takeControl(page, demo);
  await page.evaluate(() => document.activeElement?.blur());
  await pressEscTwice(page);
  await standsStill(page);
});

test('After Stop the page shows what happened', async (t) => {
  const { demo, page } = await started(t);
  await page.click('#stop');
  await giveToken(page, demo);
  await standsStill(page);
  await until('the words', async () => /stopped|switched off|ramp/i.test(await page.textContent('body')));
  assert.deepEqual(page.problems.filter((problem) => !/WebSocket/.test(problem)), []);
});
