// Save and Undo save: the saved file, the kept copy, and the way back.
import assert from 'node:assert/strict';
import { existsSync, mkdirSync, readFileSync, rmdirSync } from 'node:fs';
import { test } from 'node:test';

import { copyOfConfig, startDemoWithPage, takeControl, until } from './support.mjs';

const config = copyOfConfig();
const former = readFileSync(config, 'utf8');
const { demo, page } = await startDemoWithPage({ config });
await takeControl(page, demo);

const gain = () => page.getByRole('textbox', { name: /\bkp\b/i }).first();
const kept = () => `${config}.before-save`;
const text = () => readFileSync(config, 'utf8');
const write = () => page.locator('#save-dialog').getByRole('button', { name: 'Write the file' }).click();

async function setGain(value) {
  await gain().fill(value);
  await gain().press('Enter');
  await until('the gain is in force', async () => (await page.textContent('#steering-axes')).includes(`${value} is active`));
}

/** A busy machine may disconnect the page or answer too late; the page shows this, and a user repeats the request. */
const isCutOff = (refusal) => /no answer within|connection was lost|not connected/.test(refusal);

async function open(button, words) {
  await page.click(button);
  await until(`the dialog says ${words}`, async () => {
    if (words.test(await page.textContent('#save-dialog'))) return true;
    const refusal = await page.textContent('#save-answer');
    if (isCutOff(refusal)) await page.click(button);
    else assert.equal(refusal, '', 'the answer in the dialog');
    return false;
  });
}

test('Before the first save there is nothing to undo', async () => {
  await until('the settings', () => page.locator('#save').isDisabled());
  assert.ok(await page.locator('#undo-save').isDisabled());
});

test('A save is refused if the former file cannot be kept', async () => {
  await setGain('0.0321');
  mkdirSync(kept()); // a folder in its place
  await open('#save', /kept as piezo\.toml\.before-save/);
  await write();
  await until('the refusal', async () => /cannot be kept, so nothing is saved/.test(await page.textContent('#save-answer')));
  assert.equal(text(), former);
  rmdirSync(kept());
  await page.locator('#save-dialog').getByRole('button', { name: 'Close' }).click();
});

test('Save keeps the former file beside it and shows its path', async () => {
  await open('#save', /kp.*0\.0321/);
  await write();
  await until('the answer', async () => /previous one is piezo\.toml\.before-save/.test(await page.textContent('#settings-answer')));
  assert.match(text(), /^kp\s*= 0\.0321/m);
  assert.equal(readFileSync(kept(), 'utf8'), former);
});

test('Undo save shows the difference, and restores the file and the settings', async () => {
  const saved = text();
  await until('the button', () => page.locator('#undo-save').isEnabled());
  await open('#undo-save', /- kp\s+= 0\.0321/);
  assert.equal(text(), saved, 'nothing is written before it is confirmed');
  await write();
  await until('the answer', async () => /active again/.test(await page.textContent('#settings-answer')));
  assert.equal(text(), former);
  assert.equal(readFileSync(kept(), 'utf8'), saved);
  await until('the old gain', async () => (await gain().inputValue()) === '0');
});

test('A second Undo save brings the saved file back', async () => {
  await open('#undo-save', /\+ kp\s+= 0\.0321/);
  await write();
  await until('the gain of the save', async () => (await gain().inputValue()) === '0.0321');
  assert.equal(readFileSync(kept(), 'utf8'), former);
  assert.ok(existsSync(config));
});

test('The page reports no problems', () => {
  assert.deepEqual(page.problems, []);
});
