// The spectrum of a signal, as in metrics/spectrum.h.

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
 * Returns the one-sided spectrum of evenly sampled values by Welch's method: the mean power of segments that overlap
 * by half, each without its mean and under a Hann window. With w the window, X the transform of w (x - mean) and size
 * the length of a segment, at the frequency k rate / size:
 *
 *   density[k]   = sqrt(2 |X[k]|^2 / (rate sum w^2))     in unit/sqrt(Hz); at rate / 2 without the factor 2
 *   amplitude[k] = 2 |X[k]| / sum w                      in unit: the amplitude of a sine at that frequency
 */
export function spectrum(values, rate_Hz, longest = 4096) {
  let size = 64;
  while (2 * size <= Math.min(values.length, longest)) size *= 2;
  if (values.length < size) return null;
  const window = Float64Array.from({ length: size }, (_, i) => 0.5 - 0.5 * Math.cos((2 * Math.PI * i) / size));
  const power = new Float64Array(size / 2 + 1);
  let segments = 0;
  for (let start = 0; start + size <= values.length; start += size / 2, ++segments) {
    const segment = values.slice(start, start + size);
    const mean = segment.reduce((sum, value) => sum + value, 0) / size;
    const real = window.map((weight, i) => weight * (segment[i] - mean));
    const imaginary = new Float64Array(size);
    fourier(real, imaginary);
    for (let k = 0; k <= size / 2; ++k) power[k] += real[k] ** 2 + imaginary[k] ** 2;
  }
  const ofWindow = window.reduce((sum, weight) => sum + weight, 0);
  const ofSquares = window.reduce((sum, weight) => sum + weight * weight, 0);
  const kept = [...power.keys()].slice(1);
  const twoSided = (k) => (k < size / 2 ? 2 : 1); // adds the negative frequencies, except at rate / 2
  return {
    frequency_Hz: kept.map((k) => (k * rate_Hz) / size),
    density: kept.map((k) => Math.sqrt((twoSided(k) * power[k]) / segments / (rate_Hz * ofSquares))),
    amplitude: kept.map((k) => (twoSided(k) * Math.sqrt(power[k] / segments)) / ofWindow),
    segments,
    size,
  };
}
