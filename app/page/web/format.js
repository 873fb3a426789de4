// Formats numbers with a fixed number of decimals for each unit, so that texts do not move.

const decimals = { um: 4, V: 3, A: 4, s: 3, us: 0, Hz: 2, '%': 2, '': 0, dB: 1, deg: 1, ms: 2 };

/** Returns the number with its unit; "-" if there is no number. */
export function quantity(value, unit, digits = decimals[unit] ?? 3) {
  const text = plain(value, digits);
  return text === '-' || !unit ? text : `${text} ${unit}`;
}

export function plain(value, digits) {
  if (typeof value !== 'number' || !Number.isFinite(value)) return '-';
  const text = value.toFixed(digits);
  return Number(text) === 0 ? text.replace('-', '') : text.replace('-', '\u2212');
}

/** Returns a short number for the marks of an axis and for small or large values. */
export function compact(value, digits = 4) {
  return typeof value === 'number' && Number.isFinite(value) ? String(Number(value.toPrecision(digits))) : '-';
}

export function count(value) {
  return typeof value === 'number' && Number.isFinite(value) ? value.toLocaleString('en-US') : '-';
}

/** Returns hours, minutes and seconds of a time in seconds. */
export function clock(seconds) {
  if (!Number.isFinite(seconds)) return '-';
  const whole = Math.floor(seconds);
  const two = (number) => String(number).padStart(2, '0');
  return `${Math.floor(whole / 3600)}:${two(Math.floor(whole / 60) % 60)}:${two(whole % 60)}`;
}

const words = {
  reference_um: 'reference',
  position_um: 'position',
  demand_um: 'demand',
  learnt_um: 'learnt correction',
  amplifier_output: 'amplifier output',
  turnaround_us: 'turnaround',
  lateness_us: 'lateness',
  error_um: 'error',
  sample_missing: 'sample missing',
  shape_time_s: 'time in segment',
  scan_line: 'scan line',
  scan_pixel: 'scan pixel',
  measured_um: 'measured position',
  hysteresis_um: 'hysteresis',
};

/** Returns the readable name of a column. */
export const columnWord = (name) => words[name] ?? name.replaceAll('_', ' ');
