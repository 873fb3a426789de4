// The range of a scale that follows the data without jumping: it grows at once and shrinks when the data stay small.

const margin = 0.06;
const shrinksBelow = 0.55; // share of the range that the data take
const shrinksAfter_ms = 800;

export class SteadyRange {
  low = 0;
  high = 1;
  #small_ms = null;
  #isEmpty = true;

  /** Takes the least and the largest value; returns [low, high]. */
  follow(low, high, now_ms = performance.now()) {
    if (!(low <= high)) return [this.low, this.high];
    const least = Math.max(Math.abs(low), Math.abs(high)) * 1e-4 || 1; // a constant value gets a range too
    const span = Math.max(high - low, least);
    const fits = low >= this.low && high <= this.high;
    const isSmall = span < shrinksBelow * (this.high - this.low);
    if (!isSmall) this.#small_ms = null;
    else this.#small_ms ??= now_ms;
    if (this.#isEmpty || !fits || (isSmall && now_ms - this.#small_ms > shrinksAfter_ms)) {
      const middle = (low + high) / 2;
      this.low = middle - span * (0.5 + margin);
      this.high = middle + span * (0.5 + margin);
      this.#isEmpty = false;
      this.#small_ms = null;
    }
    return [this.low, this.high];
  }
}
