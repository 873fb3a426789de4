// Numbers as text, with a fixed count of decimals for each unit, so that nothing jumps.

const decimals = { um: 4, V: 3, A: 4, s: 3, us: 0, Hz: 2, '%': 2, '': 0, dB: 1, deg: 1, ms: 2 };

/** The number with its unit; "-" where there is none. */
export function quantity(value, unit, digits = decimals[unit] ?? 3) {
  const text = plain(value, digits);
  return text === '-' || !unit ? text : `${text} ${unit}`;
}

export function plain(value, digits) {
  if (typeof value !== 'number' || !Number.isFinite(value)) return '-';
  const text = value.toFixed(digits);
  return Number(text) === 0 ? text.replace('-', '') : text.replace('-', '\u2212');
}

/** A short number for the marks of an axis and for small or large values. */
export function compact(value, digits = 4) {
  return typeof value === 'number' && Number.isFinite(value) ? String(Number(value.toPrecision(digits))) : '-';
}

export function count(value) {
  return typeof value === 'number' && Number.isFinite(value) ? value.toLocaleString('en-US') : '-';
}

/** Hours, minutes and seconds of a time in seconds. */
export function clock(seconds) {
  if (!Number.isFinite(seconds)) return '-';
  const whole = Math.floor(seconds);
  const two = (number) => String(number).padStart(2, '0');
  return `${Math.floor(whole / 3600)}:${two(Math.floor(whole / 60) % 60)}:${two(whole % 60)}`;
}

const words = {
  reference_um: 'reference', position_um: 'position', demand_um: 'demand', learnt_um: 'learnt correction',
  amplifier_output: 'amplifier output', turnaround_us: 'turnaround', lateness_us: 'lateness', error_um: 'error',
  sample_missing: 'sample missing', shape_time_s: 'time in segment', scan_line: 'scan line', scan_pixel: 'scan pixel',
  measured_um: 'measured position', hysteresis_um: 'hysteresis',
};

/** The word of a column for a reader. */
export const columnWord = (name) => words[name] ?? name.replaceAll('_', ' ');
