// The writer's role, and the effect of a change.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';

import { copyOfConfig, openPage, seesTheLoopRun, startDemoWithPage, takeControl, until } from './support.mjs';

const config = copyOfConfig();
const { demo, browser, page } = await startDemoWithPage({ config });

/** Returns the answer to one message on a separate WebSocket without the token. */
function askWithoutToken(message) {
  return page.evaluate((text) => new Promise((done, fail) => {
    const socket = new WebSocket(`ws://${location.host}/socket`);
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => socket.send(text);
    socket.onerror = () => fail(new Error('no connection'));
    socket.onmessage = ({ data }) => {
      const answer = typeof data === 'string' ? JSON.parse(data) : {};
      if (answer.type !== 'answer') return;
      socket.close();
      done(answer);
    };
  }), JSON.stringify({ id: 1, ...message }));
}

/** Returns the value of a setting in force, as TOML. */
async function valueInForce(key) {
  const { settings } = await askWithoutToken({ do: 'settings' });
  return settings.find((setting) => setting.key === key)?.value;
}

test('Controls that write are disabled until control is taken', async () => {
  assert.ok(await page.locator('#save').isDisabled());
  assert.ok(await page.locator('#undo').isDisabled());
});

test('A wrong token is refused, the right one gives control', async () => {
  await page.click('#take-control');
  await page.fill('#token', 'wrong');
  await page.press('#token', 'Enter');
  await until('the refusal', async () => /the token is wrong/.test(await page.textContent('#token-dialog')));
  await page.fill('#token', demo.token);
  await page.press('#token', 'Enter');
  await until('the gain can be changed', () => gain().isEnabled());
});

const gain = () => page.getByRole('textbox', { name: /\bkp\b/i }).or(page.getByRole('spinbutton', { name: /\bkp\b/i })).first();

test('A gain takes effect on Enter', async () => {
  await gain().fill('0.0123');
  await gain().press('Enter');
  await until('the gain is in force', async () => Number(await valueInForce('axis[0].control.kp')) === 0.0123);
});

test('A value out of range is refused in the server\'s words', async () => {
  await gain().fill('-1');
  await gain().press('Enter');
  await until('the refusal', async () => /kp is -1, expected a number >= 0/.test(await page.textContent('body')));
  assert.equal(Number(await valueInForce('axis[0].control.kp')), 0.0123);
});

const body = () => page.textContent('#steering');

test('A refusal disappears when the value in force is restored', async () => {
  await gain().press('Escape');
  await until('no refusal', async () => !/expected a number >= 0/.test(await body()));
  assert.equal(await gain().inputValue(), '0.0123');
});

test('A refusal disappears with the next success of the field', async () => {
  await gain().fill('-1');
  await gain().press('Enter');
  await until('the refusal', async () => /expected a number >= 0/.test(await body()));
  await gain().fill('0.0124');
  await gain().press('Enter');
  await until('the success', async () => /0\.0124 is active/.test(await body()));
  assert.doesNotMatch(await body(), /expected a number >= 0/);
});

test('A decimal comma is refused with the corrected number', async () => {
  await gain().fill('0,05');
  await gain().press('Enter');
  await until('the refusal', async () => /decimal point, not comma: 0\.05/.test(await body()));
  assert.equal(Number(await valueInForce('axis[0].control.kp')), 0.0124);
  await gain().press('Escape');
  const position = page.getByRole('textbox', { name: 'Go to position of axis x, um' });
  await position.fill('12,5');
  await position.press('Enter');
  await until('the refusal', async () => /decimal point, not comma: 12\.5/.test(await body()));
  await position.press('Escape');
  await until('no refusal', async () => !/decimal point/.test(await body()));
});

test('A position that is out of range is refused with the limits in force', async () => {
  const position = page.getByRole('textbox', { name: 'Go to position of axis x, um' });
  await position.fill('50');
  await position.press('Enter');
  await until('the limits', async () => /range of the model \(-3\.\.34 um\)/.test(await body()));
  await position.press('Escape');
});

test('An unconfigured value is off, without a unit', async () => {
  assert.match(await body(), /Learning: off/);
  assert.match(await body(), /Notch: off/);
  const rate = page.getByRole('textbox', { name: 'learning.rate, axis x', includeHidden: true });
  assert.equal(await rate.getAttribute('placeholder'), 'off');
  const unit = page.locator('.field', { has: rate }).locator('.unit');
  assert.equal(await unit.evaluate((shown) => getComputedStyle(shown).visibility), 'hidden');
});

test('The configuration defines the meaning, unit, range and words of a field', async () => {
  const label = (text) => page.locator('.axis-card').first().locator('label', { hasText: text }).first();
  assert.equal(await label('kp').getAttribute('title'), 'axis[0].control.kp; proportional gain; a number >= 0');
  const titles = await page.locator('#steering label[title]').evaluateAll((all) => all.map(({ title }) => title));
  assert.ok(titles.length > 20);
  assert.deepEqual(titles.filter((title) => /`|\]\(/.test(title)), [], 'none has the marks of the documents');
  assert.equal(await gain().getAttribute('aria-label'), 'kp, um/um, axis x');
  const structure = page.getByRole('combobox', { name: 'structure, axis x' });
  assert.ok((await structure.locator('option').allTextContents()).includes('inverse+pi'));
  const jump = page.getByRole('textbox', { name: 'position_jump_um, um, axis x', includeHidden: true });
  assert.equal(await jump.count(), 1);
});

test('A key that needs a restart has no field', async () => {
  assert.equal(await page.locator('[data-key="axis[0].control.model"]').count(), 0);
});

test('An absent table takes effect as a whole', async () => {
  await page.getByText('Notch: off').first().click();
  const fill = (key, value) => page.getByRole('textbox', { name: `notch.${key}` }).first().fill(value);
  await fill('frequency_Hz', '300');
  await fill('depth', '0.1');
  await fill('width', '0.5');
  await page.getByRole('button', { name: 'Apply all of notch, axis x' }).click();
  await until('the notch is in force', async () => (await valueInForce('axis[0].control.notch.depth')) === '0.1');
  await page.click('#undo');
  await until('it is off again', async () => (await valueInForce('axis[0].control.notch.depth')) === undefined);
});

test('Undo reverts the change', async () => {
  const original = /^\s*kp\s*=\s*(\S+)/m.exec(readFileSync(config, 'utf8'))?.[1] ?? '0';
  for (const left of [1, 0]) {
    await page.click('#undo');
    await until(`${left} to undo`, async () => (await page.textContent('#undo')) === `Undo (${left})`);
  }
  await until('the old gain is in force', async () => Number(await valueInForce('axis[0].control.kp')) === Number(original));
});

test('A second page shows the writer, and can take over', async () => {
  const second = await openPage(browser, demo);
  await seesTheLoopRun(second);
  await until('the second page says that another one has control',
    async () => /another/i.test(await second.textContent('body')));
  await takeControl(second, demo);
  await until('the first page has lost control', async () => !(await gain().isEnabled()));
  assert.deepEqual(second.problems, []);
  await second.context().close();
});

test('The page reports no problems', () => {
  assert.deepEqual(page.problems, []);
});
