// What the loop chart draws: each position with the drive that caused it, and which of these points a path needs.

import { rowsBetween } from './trace.js';

const gap_s = 0.3; // rows that are farther apart are not joined
const leastStep_px = 1.5; // a path leaves out points that are nearer than this to the last one,
const turn_px = 0.3; // but not one where it turns back by more than this

/** The points of one axis, in memory that is used again. A point without a drive or a position is NaN. */
export class LoopPoints {
  number = 0;
  drive = new Float64Array(0);
  position = new Float64Array(0);

  /** Takes the positions between two times, each with the drive of `delay_s` before, interpolated between the rows. */
  take(drive, position, from_s, to_s, delay_s) {
    this.number = 0;
    if (!drive || !position) return this;
    const [begin, end] = rowsBetween(position, from_s, to_s);
    this.#makeRoom(end - begin);
    const { time, mask, first } = drive;
    let before = Math.max(rowsBetween(drive, from_s - delay_s, to_s)[0], first); // the row before the drive's time
    for (let row = begin; row < end; ++row, ++this.number) {
      const at_s = time[row & mask] - delay_s;
      while (before < row && time[(before + 1) & mask] <= at_s) ++before;
      this.position[this.number] = position.values[row & mask];
      this.drive[this.number] = valueBetween(drive, before, at_s);
    }
    return this;
  }

  /** The newest point that is there: [drive, position]. */
  get newest() {
    for (let at = this.number - 1; at >= 0; --at) {
      const point = [this.drive[at], this.position[at]];
      if (point.every(Number.isFinite)) return point;
    }
    return [NaN, NaN];
  }

  #makeRoom(number) {
    if (number <= this.drive.length) return;
    this.drive = new Float64Array(2 * number);
    this.position = new Float64Array(2 * number);
  }
}

/** The value at a time at or after the row `before` and before the next one; NaN where there is none. */
function valueBetween({ time, values, mask, end }, before, at_s) {
  const from = before & mask;
  if (time[from] === at_s) return values[from];
  const to = (before + 1) & mask;
  const apart_s = time[to] - time[from];
  if (before + 1 >= end || time[from] > at_s || !(apart_s > 0 && apart_s < gap_s)) return NaN;
  return values[from] + ((values[to] - values[from]) * (at_s - time[from])) / apart_s;
}

/**
 * Thins the points of a path out: `draw(x, y, isJoined)` is called with those that it needs, in canvas pixels. A point
 * near the last one is left out, except where the path turns back: the tips of a loop stay.
 */
export class Thinning {
  #x = NaN; // the last point that was drawn
  #y = NaN;
  #far = 0; // distance of the farthest point that was left out since
  #farX = NaN;
  #farY = NaN;

  constructor(draw) {
    this.draw = draw;
  }

  add(x, y) {
    if (x !== x || y !== y) {
      this.#x = NaN;
      return;
    }
    if (this.#x !== this.#x) return this.#put(x, y, false);
    const distance = Math.abs(x - this.#x) + Math.abs(y - this.#y);
    if (this.#far > turn_px && this.#turnsBack(x, y, distance)) this.#put(this.#farX, this.#farY, true);
    else if (distance < leastStep_px) return this.#leaveOut(x, y, distance);
    this.#put(x, y, true);
  }

  #turnsBack(x, y, distance) {
    if (distance < this.#far - turn_px) return true;
    const along = (this.#farX - this.#x) * (x - this.#farX) + (this.#farY - this.#y) * (y - this.#farY);
    return along < 0 && distance >= leastStep_px;
  }

  #leaveOut(x, y, distance) {
    if (distance <= this.#far) return;
    [this.#far, this.#farX, this.#farY] = [distance, x, y];
  }

  #put(x, y, isJoined) {
    this.draw(x, y, isJoined);
    [this.#x, this.#y, this.#far] = [x, y, 0];
  }
}
