// Figures of a response: steps, spectra. Pure functions.

/** Fourier transform in place; the length is a power of two. */
export function fourier(real, imaginary) {
  const size = real.length;
  for (let i = 1, j = 0; i < size; ++i) {
    let bit = size >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) {
      [real[i], real[j]] = [real[j], real[i]];
      [imaginary[i], imaginary[j]] = [imaginary[j], imaginary[i]];
    }
  }
  for (let length = 2; length <= size; length *= 2) {
    const half = length / 2;
    for (let k = 0; k < half; ++k) {
      const [c, s] = [Math.cos((-2 * Math.PI * k) / length), Math.sin((-2 * Math.PI * k) / length)];
      for (let start = k; start < size; start += length) {
        const other = start + half;
        const re = real[other] * c - imaginary[other] * s;
        const im = real[other] * s + imaginary[other] * c;
        real[other] = real[start] - re;
        imaginary[other] = imaginary[start] - im;
        real[start] += re;
        imaginary[start] += im;
      }
    }
  }
}

/**
 * One-sided spectrum of evenly sampled values by Welch's method: Hann window, segments that overlap by half, mean of
 * their powers. With w the window and X the transform of w (x - mean):
 *
 *   density[k]   = sqrt(2 |X[k]|^2 / (rate sum w^2))     in unit/sqrt(Hz)
 *   amplitude[k] = 2 |X[k]| / sum w                      in unit: the amplitude of a sine at that frequency
 */
export function spectrum(values, rate_Hz, longest = 4096) {
  let size = 64;
  while (2 * size <= Math.min(values.length, longest)) size *= 2;
  if (values.length < size) return null;
  const mean = values.reduce((sum, value) => sum + value, 0) / values.length;
  const window = Float64Array.from({ length: size }, (_, i) => 0.5 - 0.5 * Math.cos((2 * Math.PI * i) / size));
  const power = new Float64Array(size / 2);
  let segments = 0;
  for (let start = 0; start + size <= values.length; start += size / 2, ++segments) {
    const real = window.map((weight, i) => weight * (values[start + i] - mean));
    const imaginary = new Float64Array(size);
    fourier(real, imaginary);
    for (let k = 0; k < size / 2; ++k) power[k] += real[k] ** 2 + imaginary[k] ** 2;
  }
  const ofWindow = window.reduce((sum, weight) => sum + weight, 0);
  const ofSquares = window.reduce((sum, weight) => sum + weight * weight, 0);
  const kept = [...power.keys()].slice(1);
  return {
    frequency_Hz: kept.map((k) => (k * rate_Hz) / size),
    density: kept.map((k) => Math.sqrt((2 * power[k]) / segments / (rate_Hz * ofSquares))),
    amplitude: kept.map((k) => (2 * Math.sqrt(power[k] / segments)) / ofWindow),
    segments,
    size,
  };
}

/**
 * The response to the step of the reference at `triggerAt`, until the reference leaves the new level: sizes in um,
 * times in s from the step. The settling band is 2 % of the step around the new level. Null where there is no step.
 */
export function stepResponse(time, reference, position, triggerAt) {
  const from = reference[triggerAt - 1];
  const to = reference[triggerAt];
  const step = to - from;
  if (!Number.isFinite(step) || Math.abs(step) < 1e-6) return null;
  let end = triggerAt;
  while (end < reference.length && Math.abs(reference[end] - to) < 0.02 * Math.abs(step)) ++end;
  if (end - triggerAt < 5) return null;
  const level = mean(position, Math.max(0, triggerAt - 10), triggerAt);
  const share = (row) => (position[row] - level) / (to - level);
  const since = (row) => time[row] - time[triggerAt];
  let [peak, outside, tenth_s, ninetieth_s] = [-Infinity, triggerAt - 1, NaN, NaN];
  // The time at which the line from the row before reaches this part of the step.
  const crossing = (row, part) => {
    const [before, now] = [row > 0 ? share(row - 1) : 0, share(row)];
    return time[row] - (time[row] - time[Math.max(0, row - 1)]) * Math.min(1, (now - part) / (now - before));
  };
  for (let row = triggerAt; row < end; ++row) {
    const part = share(row);
    peak = Math.max(peak, (position[row] - to) / step);
    if (!(Math.abs(position[row] - to) <= 0.02 * Math.abs(step))) outside = row;
    if (Number.isNaN(tenth_s) && part >= 0.1) tenth_s = crossing(row, 0.1);
    if (Number.isNaN(ninetieth_s) && part >= 0.9) ninetieth_s = crossing(row, 0.9);
  }
  const rest = Math.max(triggerAt, Math.floor(end - 0.2 * (end - triggerAt)));
  return {
    from_um: from,
    to_um: to,
    step_um: step,
    overshoot_percent: Math.max(0, 100 * peak),
    rise_s: ninetieth_s - tenth_s,
    settling_s: outside + 1 < end ? since(outside + 1) : NaN,
    steady_error_um: to - mean(position, rest, end),
    judged_s: since(end - 1),
  };
}

function mean(values, begin, end) {
  let [sum, number] = [0, 0];
  for (let row = begin; row < end; ++row) {
    if (values[row] !== values[row]) continue;
    sum += values[row];
    ++number;
  }
  return sum / number;
}
