// Pause, zoom and cursors of the charts.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { pictureOf, startDemoWithPage, until } from './support.mjs';

const { page } = await startDemoWithPage();

const rows = () => page.evaluate(() => window.hystcanPage.rows(0));
const isPaused = () => page.evaluate(() => window.hystcanPage.paused);

/** Returns the drawing area of the charts: the box of the sensitive area. */
async function plotBox(chart) {
  return page.locator(`${chart} .u-over`).first().boundingBox();
}

async function pause(wanted) {
  if ((await isPaused()) !== wanted) await page.click('#pause');
  await until(`paused: ${wanted}`, async () => (await isPaused()) === wanted);
}

/** Returns the picture after two equal frames. */
async function restingPicture(chart) {
  let last;
  return until(`${chart} rests`, async () => {
    await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
    const picture = await pictureOf(page, chart);
    const rests = picture === last;
    last = picture;
    return rests && picture;
  });
}

test('Pause stops the charts while data continues', async () => {
  await pause(true);
  const picture = await restingPicture('#tracking-chart');
  const before = await rows();
  await until('more rows', async () => (await rows()) > before + 50);
  assert.equal(await pictureOf(page, '#tracking-chart'), picture);
  await pause(false);
  await until('another picture', async () => (await pictureOf(page, '#tracking-chart')) !== picture);
});

test('Space pauses and continues', async () => {
  await page.evaluate(() => document.activeElement?.blur());
  await page.keyboard.press('Space');
  await until('it is paused', isPaused);
  await page.keyboard.press('Space');
  await until('it goes on', async () => !(await isPaused()));
});

/** Returns the cursors from the line of the readout: "A 0.6 s, B 1.2 s, Δt 0.6 s, 1/Δt 1.6667 Hz". */
async function cursorTimes() {
  const text = (await page.textContent('#cursor-readout')).replaceAll('\u2212', '-');
  const number = '(-?[\\d.]+)';
  const found = new RegExp(`A ${number} s, B ${number} s, Δt ${number} s, 1/Δt ${number} Hz`).exec(text);
  return found && { a_s: Number(found[1]), b_s: Number(found[2]), apart_s: Number(found[3]), rate_Hz: Number(found[4]) };
}

/** Returns the name with unit of each signal, its values at A and at B, and their difference. */
async function cursorValues() {
  const rows = await page.locator('#cursor-readout tbody tr').evaluateAll((all) =>
    all.map((row) => [...row.cells].map((cell) => cell.textContent.replaceAll('\u2212', '-'))));
  return rows.map(([name, ...values]) => ({ name, values: values.map(Number) }));
}

test('Two cursors give the differences with their units while the charts run', async () => {
  await page.click('#cursors');
  const values = await until('values at both cursors', async () => {
    const all = (await cursorValues()).filter(({ values: three }) => three.every(Number.isFinite));
    return all.some(({ name }) => /position, um/.test(name)) && all.some(({ name }) => /drive, V/.test(name)) && all;
  });
  for (const { name, values: [a, b, difference] } of values)
    assert.ok(Math.abs(b - a - difference) < 2e-4, `${name}: ${a} ${b} ${difference}`);
  const times = await cursorTimes();
  assert.ok(Math.abs(times.b_s - times.a_s - times.apart_s) < 2e-4 && times.apart_s > 0, JSON.stringify(times));
  assert.ok(Math.abs(times.rate_Hz * times.apart_s - 1) < 1e-3, JSON.stringify(times));
  await until('other times', async () => (await cursorTimes()).a_s !== times.a_s);
});

test('A cursor moves with the arrow keys and with the pointer', async () => {
  const apart = async () => (await cursorTimes()).apart_s;
  const before = await apart();
  const cursor = page.locator('#tracking-chart').getByRole('slider', { name: 'Cursor B' });
  await cursor.focus();
  await page.keyboard.press('ArrowRight');
  await until('a larger distance', async () => (await apart()) > before);
  const [box, chart] = [await cursor.boundingBox(), await plotBox('#tracking-chart')];
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(chart.x + 0.4 * chart.width, box.y + box.height / 2, { steps: 5 });
  await page.mouse.up();
  await until('a smaller distance', async () => (await apart()) < before);
  await page.click('#cursors');
});

test('A drag zooms in, a double click shows all again', async () => {
  await pause(true);
  await page.click('#cursors');
  const apart_s = async () => (await cursorTimes())?.apart_s;
  const whole_s = await until('the cursors', apart_s);
  const box = await plotBox('#tracking-chart');
  const y = box.y + 0.5 * box.height;
  await page.mouse.move(box.x + 0.1 * box.width, y);
  await page.mouse.down();
  await page.mouse.move(box.x + 0.3 * box.width, y, { steps: 8 });
  await page.mouse.up();
  await until('a fifth of the time', async () => Math.abs((await apart_s()) / whole_s - 0.2) < 0.02);
  await page.mouse.dblclick(box.x + 0.2 * box.width, y);
  await until('the whole time', async () => (await apart_s()) === whole_s);
  await page.click('#cursors');
  await pause(false);
});

test('+ and - zoom paused charts about the middle, 0 shows the whole range again', async () => {
  await pause(true);
  await page.click('#cursors');
  await page.evaluate(() => document.activeElement?.blur());
  const places = await page.locator('#tracking-chart').getByRole('slider').evaluateAll((cursors) =>
    cursors.map((cursor) => Number(cursor.getAttribute('aria-valuenow')) / 100)); // share of the shown time
  const times = async () => {
    const found = await cursorTimes();
    const whole_s = found && found.apart_s / (places[1] - places[0]);
    return found && { middle_s: found.a_s + (0.5 - places[0]) * whole_s, apart_s: found.apart_s };
  };
  const whole = await until('the cursors', times);
  const becomes = (share) =>
    until(`${share} of the time`, async () => {
      const now = await times();
      return Math.abs(now.apart_s / whole.apart_s - share) < 0.01 && Math.abs(now.middle_s - whole.middle_s) < 0.01;
    });
  await page.keyboard.press('+');
  await becomes(0.5);
  await page.keyboard.press('+');
  await becomes(0.25);
  await page.keyboard.press('-');
  await becomes(0.5);
  await page.keyboard.press('0');
  await becomes(1);
  await page.click('#cursors');
  await pause(false);
});

test('+ and - choose a shorter and a longer time of running charts', async () => {
  await page.evaluate(() => document.activeElement?.blur());
  const window_s = () => page.inputValue('#window-seconds');
  const before = await window_s();
  await page.keyboard.press('-');
  assert.equal(await window_s(), '5');
  await page.keyboard.press('+');
  assert.equal(await window_s(), before);
});

test('The window shows the chosen number of seconds', async () => {
  const first = await pictureOf(page, '#tracking-chart');
  await page.selectOption('#window-seconds', '1');
  await until('another picture', async () => (await pictureOf(page, '#tracking-chart')) !== first);
  assert.equal(await page.inputValue('#window-seconds'), '1');
});

test('The Bode plot goes up to the peak of a resonance', async () => {
  const ranges = await page.evaluate(async () => {
    const { rangeAbove } = await import('/curve_chart.js');
    return [rangeAbove(-60, -80, 34), rangeAbove(-60, -20, -5)];
  });
  assert.deepEqual(ranges, [[-60, 36], [-20, 2]]);
});

test('The page reports no problems', () => {
  assert.deepEqual(page.problems, []);
});
