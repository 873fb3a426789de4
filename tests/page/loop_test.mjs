// The hysteresis loop: each position beside the drive that caused it, with the corners of the path.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { test } from 'node:test';

import { copyOfConfig, startDemoWithPage, until } from './support.mjs';

const level_um = 16;
const rate_Hz = 1000;
const { page } = await startDemoWithPage({ config: triangleAlone(), isAtFullRate: true });
await until('the delay and the reference curves', () => page.evaluate(() => window.hystcanPage.loopReference(0)));
await page.selectOption('#window-seconds', '1');
await until('two seconds of the triangle', () => page.evaluate(() => window.hystcanPage.latest(0).shape_time_s > 2));
const points = (delay_s) => page.evaluate((delay) => window.hystcanPage.loopPoints(0, delay), delay_s);
// A machine that is busy for a second loses rows of the stream: a later second contains all of them.
await until('a second of every cycle', async () => {
  await page.click('#pause');
  const isWhole = (await points()).drive.length >= 0.99 * rate_Hz;
  if (!isWhole) await page.click('#pause'); // it runs on
  return isWhole;
});

/** The shipped stage; axis x only follows the triangle of 10 Hz. */
function triangleAlone() {
  const config = copyOfConfig();
  const text = readFileSync(config, 'utf8');
  const staircase = text.indexOf('[[axis.control.setpoint]]         # decaying');
  const changed = text.slice(0, staircase) + text.slice(text.indexOf('[axis.twin]'));
  writeFileSync(config, changed.replace(/^cycles\s*= 10\.0/m, 'cycles = 10000.0'));
  return config;
}

/** Returns the drives at which the position crosses the level, upwards and downwards. The first point may have no drive. */
function crossings(position, drive) {
  const [up, down] = [[], []];
  for (let at = 1; at < position.length; ++at) {
    const [before, now] = [position[at - 1], position[at]];
    if (before === now || (before - level_um) * (now - level_um) > 0) continue;
    const share = (level_um - before) / (now - before);
    const crossed = drive[at - 1] + share * (drive[at] - drive[at - 1]);
    if (Number.isFinite(crossed)) (now > before ? up : down).push(crossed);
  }
  return { up, down };
}

const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;

/** Returns the crossings and the width of the drawn loop; with delay 0, drive and position are from the same row. */
async function loop(delay_s) {
  const { position, drive } = await points(delay_s);
  const { up, down } = crossings(position, drive);
  assert.ok(up.length >= 5 && down.length >= 5, `${up.length} and ${down.length} crossings in a second of 10 Hz`);
  return { up: mean(up), down: mean(down), width: mean(up) - mean(down) };
}

test('The loop is drawn with the drive that caused each position', async (t) => {
  const [ofTheRow, drawn] = [await loop(0), await loop(undefined)];
  t.diagnostic(`at ${level_um} um: ${ofTheRow.width.toFixed(2)} V of the same row, ${drawn.width.toFixed(2)} V drawn`);
  // On each branch the drive changes by more than 2 V within the 1.6 ms.
  assert.ok(ofTheRow.width > drawn.width + 4, `${ofTheRow.width} V without the delay`);
  assert.ok(drawn.width > 11 && drawn.width < 15, `${drawn.width} V`);
});

test('The loop is between the reference curves of the model', async () => {
  const reference = await page.evaluate(() => window.hystcanPage.loopReference(0));
  const [up] = crossings(reference.ascending_um, reference.drive).up;
  const [down] = crossings(reference.descending_um, reference.drive).up;
  const drawn = await loop(undefined);
  const differs_V = 1; // the twin's actuator is not exactly the controller's model
  assert.ok(drawn.width <= up - down, `${drawn.width} V, between the curves ${up - down} V`);
  assert.ok(drawn.up <= up + differs_V && drawn.down >= down - differs_V, `${drawn.down}..${drawn.up} V in ${down}..${up} V`);
});

test('The legend says by how much earlier the drive is', async () => {
  assert.match(await page.textContent('#loop-chart figcaption'), /drive 1\.6 ms earlier, when it acted/);
});

/** Returns the points that a path keeps, in pixels, by the code of the page. */
function kept(points) {
  return page.evaluate(async (all) => {
    const { Thinning } = await import('/loop_chart.js');
    const drawn = [];
    const thinning = new Thinning((x, y) => drawn.push([x, y]));
    for (const [x, y] of all) thinning.add(x, y);
    return drawn;
  }, points);
}

test('A thinned path keeps the tip where it turns back', async () => {
  const way = (from, to) => Array.from({ length: 50 }, (_, at) => [from + ((to - from) * at) / 50, 0]);
  for (const tip of [20, 20.3, 20.7, 21.1, 21.4]) {
    const drawn = await kept([...way(0, tip), [tip, 0], ...way(tip, 0)]);
    const farthest = Math.max(...drawn.map(([x]) => x));
    assert.ok(tip - farthest <= 0.3, `a tip at ${tip} px is drawn at ${farthest} px`);
    assert.ok(drawn.length < 40, `${drawn.length} of 101 points`);
  }
});

test('A thinned path omits the noise of a resting stage', async () => {
  const rest = Array.from({ length: 1000 }, (_, at) => [100 + 0.1 * Math.sin(at), 100 + 0.1 * Math.cos(3 * at)]);
  assert.ok((await kept(rest)).length <= 2);
});

test('The page reports no problems', () => {
  assert.deepEqual(page.problems, []);
});
