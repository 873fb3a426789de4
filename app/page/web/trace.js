// The data of a chart's line: times and values, anywhere in memory, and their conversion to a path.
//
// A trace is {time, values, mask, first, end, shift_s}: row k, first <= k < end, is at `k & mask`; `shift_s` is
// added to its time. For plain arrays the mask is -1. A value that is NaN is a gap; so is a long time between rows.

export const gap_s = 0.3; // rows farther apart are not joined

export const traceOfArrays = (time, values, shift_s = 0) => ({
  time,
  values,
  mask: -1,
  first: 0,
  end: time.length,
  shift_s,
});

export const traceOfAxis = (axis, column, shift_s = 0) => ({
  time: axis.time,
  values: axis.columns.get(column),
  mask: axis.mask,
  first: axis.first,
  end: axis.end,
  shift_s,
});

/** Returns the first row at or after `time_s`, in the trace's own time. Rows of a RowStore are accepted, too. */
export function rowAt({ time, mask, first, end }, time_s) {
  let [low, high] = [first, end];
  while (low < high) {
    const middle = Math.floor((low + high) / 2);
    if (time[middle & mask] < time_s) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** Returns the value of the nearest row to a time; NaN if none is near. */
export function valueAt(trace, time_s) {
  const { time, values, mask, first, end, shift_s } = trace;
  const after = rowAt(trace, time_s - shift_s);
  let [best, distance] = [NaN, gap_s];
  for (const row of [after - 1, after]) {
    if (row < first || row >= end) continue;
    const away = Math.abs(time[row & mask] + shift_s - time_s);
    if (away < distance) [best, distance] = [values[row & mask], away];
  }
  return best;
}

/** Returns the value at a time from row `before` up to the next row; NaN if there is none. */
export function valueBetween({ time, values, mask, end }, before, at_s) {
  const from = before & mask;
  if (time[from] === at_s) return values[from];
  const to = (before + 1) & mask;
  const apart_s = time[to] - time[from];
  if (before + 1 >= end || time[from] > at_s || !(apart_s > 0 && apart_s < gap_s)) return NaN;
  return values[from] + ((values[to] - values[from]) * (at_s - time[from])) / apart_s;
}

/**
 * Returns the newest values of traces at one instant: the latest that all traces have reached. A trace that ends more
 * than a gap before the others has its last value instead. `isWhole(at)`: the values of this trace are whole numbers,
 * which are not interpolated. Returns a list of {value, age_s}: age_s is 0 at the common instant.
 */
export function newestTogether(traces, isWhole = () => false) {
  const ends_s = traces.map(endOf);
  const newest_s = Math.max(...ends_s);
  const isCurrent = (end_s) => newest_s - end_s <= gap_s;
  const instant_s = Math.min(...ends_s.filter(isCurrent));
  return traces.map((trace, at) => {
    if (ends_s[at] === -Infinity) return { value: NaN, age_s: 0 };
    if (!isCurrent(ends_s[at])) return { value: trace.values[(trace.end - 1) & trace.mask], age_s: newest_s - ends_s[at] };
    return { value: (isWhole(at) ? valueAt : valueDuring)(trace, instant_s), age_s: 0 };
  });
}

const endOf = (trace) =>
  trace && trace.end > trace.first ? trace.time[(trace.end - 1) & trace.mask] + trace.shift_s : -Infinity;

/** Returns the value at a time, not later than the last row, interpolated between the rows. */
function valueDuring(trace, time_s) {
  const last_s = trace.time[(trace.end - 1) & trace.mask];
  const at_s = Math.min(time_s - trace.shift_s, last_s); // rounding may give a time after the last row
  const after = rowAt(trace, at_s);
  const isAtRow = trace.time[after & trace.mask] === at_s;
  return valueBetween(trace, isAtRow ? after : Math.max(after - 1, trace.first), at_s);
}

/** Returns the rows between two times, with one more row at each side: [begin, end). */
export function rowsBetween(trace, from_s, to_s) {
  return [
    Math.max(rowAt(trace, from_s - trace.shift_s) - 1, trace.first),
    Math.min(rowAt(trace, to_s - trace.shift_s) + 1, trace.end),
  ];
}

/** Returns the smallest and the largest value between two times; Infinity and -Infinity if there are no values. */
export function extent(trace, from_s, to_s, range = { low: Infinity, high: -Infinity }) {
  const [begin, end] = rowsBetween(trace, from_s, to_s);
  const { values, mask } = trace;
  for (let row = begin; row < end; ++row) {
    const value = values[row & mask];
    if (value < range.low) range.low = value;
    if (value > range.high) range.high = value;
  }
  return range;
}

/**
 * Returns the path of the trace between two times. `toX` and `toY` are {scale, offset} from value to pixel. With more
 * than two rows for a pixel (`isDense`), the path goes through the least and the largest value of each pixel; pixels
 * are counted from time 0, so that a moving picture does not flicker.
 */
export function pathOf(trace, from_s, to_s, toX, toY) {
  const [begin, end] = rowsBetween(trace, from_s, to_s);
  const isDense = end - begin > 2 * Math.max(1, (to_s - from_s) * toX.scale);
  return { isDense, path: (isDense ? pathOfExtremes : pathOfRows)(trace, begin, end, toX, toY) };
}

function pathOfRows({ time, values, mask, shift_s }, begin, end, toX, toY) {
  const path = new Path2D();
  let before_s = -Infinity;
  for (let row = begin; row < end; ++row) {
    const value = values[row & mask];
    const time_s = time[row & mask] + shift_s;
    if (value !== value) {
      before_s = -Infinity;
      continue;
    }
    const x = time_s * toX.scale + toX.offset;
    const y = value * toY.scale + toY.offset;
    if (time_s - before_s < gap_s) path.lineTo(x, y);
    else path.moveTo(x, y);
    before_s = time_s;
  }
  return path;
}

/** Returns a vertical stroke for each pixel, long enough to meet the next one: cheaper to paint than a joined line. */
function pathOfExtremes({ time, values, mask, shift_s }, begin, end, toX, toY) {
  const path = new Path2D();
  const none = -1e18;
  let [pixel, low, high, before, lowBefore, highBefore] = [none, 0, 0, none, 0, 0];
  const finish = () => {
    const isNear = pixel - before < gap_s * toX.scale + 1;
    const x = pixel + toX.offset;
    if (isNear && pixel - before > 1.5) {
      // pixels without a row between them
      path.moveTo(before + toX.offset, ((lowBefore + highBefore) / 2) * toY.scale + toY.offset);
      path.lineTo(x, ((low + high) / 2) * toY.scale + toY.offset);
    }
    const bottom = isNear ? Math.min(low, highBefore) : low;
    const top = isNear ? Math.max(high, lowBefore) : high;
    path.moveTo(x, bottom * toY.scale + toY.offset + 0.5);
    path.lineTo(x, top * toY.scale + toY.offset - 0.5);
    [before, lowBefore, highBefore] = [pixel, low, high];
  };
  for (let row = begin; row < end; ++row) {
    const value = values[row & mask];
    if (value !== value) {
      if (pixel !== none) finish();
      pixel = before = none;
      continue;
    }
    const at = Math.floor((time[row & mask] + shift_s) * toX.scale);
    if (at !== pixel) {
      if (pixel !== none) finish();
      [pixel, low, high] = [at, value, value];
    } else if (value < low) low = value;
    else if (value > high) high = value;
  }
  if (pixel !== none) finish();
  return path;
}
