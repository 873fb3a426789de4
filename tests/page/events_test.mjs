// Actions of people are events on every page: person, key, old and new value.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { copyOfConfig, ctl, openPage, seesTracking, startDemoWithPage, takeControl, until } from './support.mjs';

const { demo, browser, page } = await startDemoWithPage({ config: copyOfConfig() });
const other = await openPage(browser, demo);
await seesTracking(page);

/** Waits for an event on this page and on the other one, which shows the number of the first page. */
async function bothSee(words) {
  await until(`this page: ${words}`, async () => (await page.textContent('#events')).includes(`this page: ${words}`));
  const ofOther = await until(`page N: ${words}`, async () => {
    const all = await other.locator('#events li').allTextContents();
    return all.find((line) => line.includes(words));
  });
  assert.match(ofOther, /page \d+: /);
}

async function enter(name, value) {
  const field = page.getByRole('textbox', { name }).first();
  await field.fill(value);
  await field.press('Enter');
}

test('Taking control is an event', async () => {
  await takeControl(page, demo);
  await bothSee('takes control');
});

test('A setting is an event with its key, its old and its new value', async () => {
  await enter(/\bkp\b/, '0.0123');
  await bothSee('set axis[0].control.kp: 0 -> 0.0123');
});

test('Undo is an event with the key too', async () => {
  await until('the undo', () => page.locator('#undo').isEnabled());
  await page.click('#undo');
  await bothSee('undo axis[0].control.kp: 0.0123 -> 0');
});

test('A refused setting is an event with the reason', async () => {
  await enter(/\bkp\b/, '-1');
  await bothSee('x: set "kp" = -1: refused: ');
});

test('A go_to and a recording are events', async () => {
  await enter('Go to position of axis x, um', '12.5');
  await bothSee('x: go to 12.5 um');
  await page.click('#record');
  await bothSee('record: ');
});

test('A setting that another program changes is an event', async () => {
  await page.click('#take-control'); // releases the writer's role
  await until('the role is free', async () => (await page.textContent('#take-control')) === 'Take control');
  const set = await ctl(demo.socket, 'set', 'x', 'kp', '0.02');
  assert.equal(set.status, 0, set.output);
  await until('the event', async () =>
    /file or control socket: set axis\[0\]\.control\.kp: 0 -> 0\.02/.test(await page.textContent('#events')));
});

test('A page that connects later shows these events in order', async () => {
  const late = await openPage(browser, demo);
  const lines = await until('the events', async () => {
    const all = await late.locator('#events li').allTextContents();
    return all.some((line) => line.includes('takes control')) && all;
  });
  const at = (words) => lines.findIndex((line) => line.includes(words)); // the newest first
  assert.ok(at('go to 12.5 um') < at('-> 0.0123') && at('-> 0.0123') < at('takes control'), lines.join('\n'));
  await late.context().close();
});

test('Stop is an event', async () => {
  await page.click('#stop');
  await bothSee('stop');
});

test('The page reports no problems', () => {
  assert.deepEqual(page.problems, []);
});
