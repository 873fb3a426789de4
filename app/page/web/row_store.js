// The newest rows of one stream in memory of a fixed size: a ring for each column of each axis.
//
// Times are page times: the stream's `time_s` plus an offset, which grows when the controller restarts, so that older
// rows stay to the left of newer ones.

const capacity = 1 << 16; // rows of an axis: 65 s at 1 kHz. A power of two, so that `index & mask` is the position
const restart_s = 0.5; // a first block that ends this long before the newest row belongs to a new run

// The twin's stream counts its time from its own start. Both streams contain each measured position: the twin as
// `measured_um`, the controller as `position_um`. The time shift at which these agree is the difference of the clocks.
const compared = 240; // rows
const reach = 120; // rows, on each side of the newest rows
const leastMotion_um = 0.05;

export const rowsOfMessage = (buffer, columns) => {
  const [kind, rows, lost, capture] = new Uint32Array(buffer, 0, 4);
  return { kind, rows, lost, capture, values: new Float64Array(buffer, 16, rows * columns) };
};

class AxisRows {
  first = 0;
  end = 0; // number of rows so far; row k is at k & mask
  mask = capacity - 1;

  constructor(names) {
    this.columns = new Map(names.map((name) => [name, new Float64Array(capacity)]));
    this.time = this.columns.get('time_s');
  }

  get newest_s() {
    return this.end > this.first ? this.time[(this.end - 1) & this.mask] : NaN;
  }

  copy() {
    const made = Object.create(AxisRows.prototype);
    const columns = new Map([...this.columns].map(([name, values]) => [name, values.slice()]));
    return Object.assign(made, {
      first: this.first,
      end: this.end,
      mask: this.mask,
      columns,
      time: columns.get('time_s'),
    });
  }
}

export class RowStore {
  /** `derived`: further columns, each a function of the row: {error_um: (value) => ...} with value(name). */
  constructor(greeting, derived = {}) {
    this.greeting = greeting;
    this.names = greeting.columns.map(({ name }) => name);
    this.units = new Map(greeting.columns.map(({ name, unit }) => [name, unit]));
    this.derived = Object.entries(derived);
    for (const [name, { unit }] of this.derived) this.units.set(name, unit);
    this.axes = greeting.axes.map(() => new AxisRows([...this.units.keys()]));
    this.offset_s = 0;
    this.lost = 0;
    this.received = greeting.axes.map(() => 0);
    this.isBeginning = true;
  }

  get newest_s() {
    return this.axes.reduce((newest, axis) => (axis.newest_s > newest ? axis.newest_s : newest), -Infinity);
  }

  fits(greeting) {
    const shape = ({ columns, axes }) => JSON.stringify([columns, axes]);
    return shape(greeting) === shape(this.greeting);
  }

  /** Call when the connection or the controller restarts: the next rows may overlap, or belong to a new run. */
  begin(greeting) {
    this.greeting = greeting;
    this.isBeginning = true;
  }

  append({ rows, lost, values }) {
    const width = this.names.length;
    const timeAt = this.names.indexOf('time_s');
    const axisAt = this.names.indexOf('axis');
    this.lost += lost;
    if (rows > 0 && this.isBeginning) this.#placeRun(values[timeAt], values[(rows - 1) * width + timeAt]);
    for (let row = 0; row < rows; ++row) {
      const at = row * width;
      const axis = this.axes[values[at + axisAt]];
      const time_s = values[at + timeAt] + this.offset_s;
      if (!axis || time_s <= axis.newest_s) continue; // unknown axis, or row already stored
      this.#put(axis, values, at, time_s);
      ++this.received[values[at + axisAt]];
    }
  }

  #placeRun(first_s, last_s) {
    this.isBeginning = false;
    const newest = this.newest_s;
    if (newest === -Infinity || last_s + this.offset_s > newest - restart_s) return;
    this.offset_s = newest + 1 - Math.min(first_s, last_s);
  }

  #put(axis, values, at, time_s) {
    const place = axis.end & axis.mask;
    this.names.forEach((name, column) => (axis.columns.get(name)[place] = values[at + column]));
    axis.time[place] = time_s;
    for (const [name, { value }] of this.derived) axis.columns.get(name)[place] = value(axis.columns, place);
    ++axis.end;
    axis.first = Math.max(axis.first, axis.end - capacity);
  }

  /** Returns the newest row of an axis as an object. */
  latest(index) {
    const axis = this.axes[index];
    if (!axis || axis.end === axis.first) return null;
    const place = (axis.end - 1) & axis.mask;
    const row = Object.fromEntries([...axis.columns].map(([name, values]) => [name, values[place]]));
    row.time_s -= this.offset_s;
    return row;
  }

  unitOf(name, axis) {
    const unit = this.units.get(name) ?? '';
    return unit === 'drive' ? this.greeting.axes[axis].drive_unit : unit;
  }

  copy() {
    return Object.assign(Object.create(RowStore.prototype), this, { axes: this.axes.map((axis) => axis.copy()) });
  }
}

/** Returns the time to add to the twin's page times; null if the stage moves too little to determine this time. */
export function shiftOfTwin(controller, twin) {
  for (let axis = 0; axis < Math.min(controller.axes.length, twin.axes.length); ++axis) {
    const shift = shiftOfAxis(controller.axes[axis], twin.axes[axis]);
    if (shift !== null) return shift;
  }
  return null;
}

function shiftOfAxis(ours, theirs) {
  const needed = compared + 2 * reach;
  if (ours.end - ours.first < needed || theirs.end - theirs.first < needed) return null;
  const position = ours.columns.get('position_um');
  const measured = theirs.columns.get('measured_um');
  const at = ours.end - reach - compared;
  let [low, high] = [Infinity, -Infinity];
  for (let row = at; row < at + compared; ++row) {
    low = Math.min(low, position[row & ours.mask]);
    high = Math.max(high, position[row & ours.mask]);
  }
  if (!(high - low > leastMotion_um)) return null;
  let [best, least] = [0, Infinity];
  for (let shift = -reach; shift <= reach; ++shift) {
    let sum = 0;
    for (let row = 0; row < compared && sum < least; ++row) {
      const away =
        position[(at + row) & ours.mask] - measured[(theirs.end - reach - compared + row + shift) & theirs.mask];
      if (away === away) sum += Math.abs(away);
    }
    if (sum < least) [best, least] = [shift, sum];
  }
  return ours.time[at & ours.mask] - theirs.time[(theirs.end - reach - compared + best) & theirs.mask];
}
