// The page's spectrum is that of metrics/spectrum.h: both are tested with the numbers of tests/metrics/spectrum.json.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';

import { spectrum } from '../../app/page/web/spectrum.js';

const shared = JSON.parse(readFileSync(new URL('../metrics/spectrum.json', import.meta.url)));

test('The density matches the shared numbers', () => {
  const { density, frequency_Hz, segments } = spectrum(Float64Array.from(shared.values), shared.rate_Hz, shared.size);
  assert.equal(segments, shared.segments);
  assert.equal(density.length, shared.density.length);
  density.forEach((value, i) => assert.ok(Math.abs(value - shared.density[i]) < 1e-8, `at ${frequency_Hz[i]} Hz`));
});
