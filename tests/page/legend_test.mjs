// The legend of a chart has one instant: streams of two programs do not end at the same time.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { newestTogether, traceOfArrays } from '../../app/page/web/trace.js';

const speed_um_per_s = 480;

/** Makes a rising position, every 2 ms up to `end_s` of the page, in a stream whose clock lags the page by `shift_s`. */
function rising(end_s, shift_s = 0, phase_s = 0) {
  const time = Float64Array.from({ length: 200 }, (_, at) => end_s - shift_s - phase_s - 0.002 * (199 - at));
  return traceOfArrays(time, time.map((time_s) => speed_um_per_s * (time_s + shift_s)), shift_s);
}

test('All values are of the last instant that all traces have reached', () => {
  const values = newestTogether([rising(9.98, 3.3), rising(10), rising(10, 0, 0.001)]);
  for (const { value, age_s } of values) {
    assert.ok(Math.abs(value - speed_um_per_s * 9.98) < 1e-6, `${value}`);
    assert.equal(age_s, 0);
  }
});

test('A trace that has ended has its last value with its age', () => {
  const [ended, current, never] = newestTogether([rising(8.5), rising(10), undefined]);
  assert.ok(Math.abs(ended.value - speed_um_per_s * 8.5) < 1e-6);
  assert.ok(Math.abs(ended.age_s - 1.5) < 1e-9);
  assert.ok(Math.abs(current.value - speed_um_per_s * 10) < 1e-6);
  assert.ok(Number.isNaN(never.value));
});

test('A number of a segment has no value between two rows', () => {
  const segment = traceOfArrays(Float64Array.of(1, 1.002), Float64Array.of(0, 1));
  const [{ value }] = newestTogether([segment, rising(1.0005)], (at) => at === 0);
  assert.equal(value, 0);
});
