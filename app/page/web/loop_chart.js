// The hysteresis loop: position against the drive that caused it; new parts are bright, older ones fade.

import { Chart, SteadyRange, colours, legendKey, linear } from './chart.js';
import { element } from './dom.js';
import { compact, plain } from './format.js';
import { dashes, line as lineColour } from './theme.js';
import { gap_s, rowsBetween, valueBetween } from './trace.js';

const leastStep_px = 1.5; // a path omits points closer than this to the last one,
const turn_px = 0.3; // except a point at which it turns back by more than this
const shades = 10; // steps of the fading
const faintest = 0.1;
export const longest_s = 5;

export class LoopChart extends Chart {
  loops = []; // {label, unit, axis, colour, dash, drive: () => trace, position: () => trace, points}
  references = []; // of each axis's model, drawn behind the loops: {axis, drive, ascending_um, descending_um, delay_s}
  x = new SteadyRange();
  y = new SteadyRange();
  zoomedTo = null;

  constructor(host, title) {
    super(host, title, 120);
  }

  setLoops(loops) {
    this.loops = loops.map((loop) => ({ ...loop, points: new LoopPoints() }));
    this.x = new SteadyRange();
    this.y = new SteadyRange();
    this.zoomedTo = null;
    this.showLegend();
    this.#build();
  }

  setReferences(references) {
    this.references = references;
    this.showLegend();
    this.uplot?.redraw();
  }

  draw(from_s, to_s) {
    if (!this.uplot || this.plot.clientWidth === 0) return;
    this.shown = [Math.max(from_s, to_s - longest_s), to_s];
    for (const { points, drive, position, axis } of this.loops)
      points.take(drive(), position(), ...this.shown, this.#delayOf(axis));
    const reach = reachOf(this.loops);
    const [x, y] = this.zoomedTo ?? [this.x.follow(reach.left, reach.right), this.y.follow(reach.bottom, reach.top)];
    this.uplot.batch(() => {
      this.uplot.setData(this.data, false);
      this.uplot.setScale('x', { min: x[0], max: x[1] });
      this.uplot.setScale('y', { min: y[0], max: y[1] });
    });
  }

  showValues() {
    const newest = this.loops.map(({ label, unit, points }) => {
      const [x, y] = points.newest;
      return `${label} ${plain(x, 2)} ${unit}, ${plain(y, 3)} um`;
    });
    this.plot.setAttribute('aria-label', `${this.title}: ${newest.join('; ')}`);
  }

  /** Returns the points of an axis as drawn, or with another delay. */
  pointsOf(axis, delay_s = this.#delayOf(axis)) {
    const { drive, position } = this.loops.find((loop) => loop.axis === axis);
    const points = new LoopPoints().take(drive(), position(), ...this.shown, delay_s);
    return {
      drive: [...points.drive.subarray(0, points.number)],
      position: [...points.position.subarray(0, points.number)],
    };
  }

  legendKeys() {
    const keys = this.loops.map(({ label, colour, dash }) =>
      legendKey(lineColour(colour), dashes[dash], undefined, label),
    );
    if (this.references.length)
      keys.push(legendKey(colours().stroke(), [5, 4], undefined, 'reference curves of the model'));
    return [...keys, element('span', { class: 'key', text: this.#wordsOfDelays() })];
  }

  referenceOf(axis) {
    return this.references.find((reference) => reference.axis === axis);
  }

  /** Returns the lag of a row's position behind its drive; 0 if unknown. */
  #delayOf(axis) {
    return this.referenceOf(axis)?.delay_s ?? 0;
  }

  #wordsOfDelays() {
    const known = this.loops.map(({ axis }) => this.referenceOf(axis)).filter(Boolean);
    const words = new Set(known.map(({ delay_s }) => plain(1e3 * delay_s, 1)));
    return words.size ? `drive ${[...words].join(' or ')} ms earlier, when it acted` : '';
  }

  #build() {
    this.data = [new Float64Array([0, 1]), new Float64Array(2)];
    const units = [...new Set(this.loops.map(({ unit }) => unit))].join(' or ');
    const axis = {
      ...colours(),
      labelSize: 16,
      labelGap: 0,
      values: (_, splits) => splits.map((mark) => compact(mark, 6)),
    };
    const range = (_, low, high) => [low ?? 0, high ?? 1];
    this.make(
      {
        padding: [6, 10, 0, 0],
        scales: { x: { time: false, range }, y: { auto: false, range } },
        cursor: {
          points: { show: false },
          drag: { x: true, y: true, uni: 12, setScale: false },
          bind: { dblclick: () => () => this.#zoomTo(null) },
        },
        axes: [
          { ...axis, label: `drive, ${units}`, size: 22, space: 50 },
          { ...axis, label: 'position, um', size: 40, space: 30 },
        ],
        series: [{}, { scale: 'y', auto: false, points: { show: false }, paths: () => null }],
        hooks: { draw: [(uplot) => this.#paint(uplot)], setSelect: [(uplot) => this.#select(uplot)] },
      },
      this.data,
    );
  }

  #select(uplot) {
    const { left, top, width, height } = uplot.select;
    if (width < 8 && height < 8) return;
    this.#zoomTo([
      [uplot.posToVal(left, 'x'), uplot.posToVal(left + width, 'x')],
      [uplot.posToVal(top + height, 'y'), uplot.posToVal(top, 'y')],
    ]);
    uplot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
  }

  forgetZoom() {
    this.zoomedTo = null;
  }

  #zoomTo(range) {
    this.zoomedTo = range;
    if (this.shown) this.draw(...this.shown);
  }

  #paint(uplot) {
    const { ctx, bbox, scales } = uplot;
    const toX = linear(scales.x.min, scales.x.max, bbox.left, bbox.width);
    const toY = linear(scales.y.min, scales.y.max, bbox.top + bbox.height, -bbox.height);
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.lineJoin = 'bevel';
    this.references.forEach((curves) => paintReference(ctx, curves, toX, toY));
    this.loops.forEach((loop) => paintLoop(ctx, loop, toX, toY));
    ctx.restore();
  }
}

function reachOf(loops) {
  const reach = { left: Infinity, right: -Infinity, bottom: Infinity, top: -Infinity };
  for (const { points } of loops)
    for (let at = 0; at < points.number; ++at) {
      const x = points.drive[at];
      const y = points.position[at];
      if (x < reach.left) reach.left = x;
      if (x > reach.right) reach.right = x;
      if (y < reach.bottom) reach.bottom = y;
      if (y > reach.top) reach.top = y;
    }
  return reach;
}

function paintReference(ctx, { drive, ascending_um: up, descending_um: down }, toX, toY) {
  ctx.strokeStyle = colours().stroke();
  ctx.setLineDash([5, 4].map((part) => part * devicePixelRatio));
  ctx.lineWidth = devicePixelRatio;
  ctx.globalAlpha = 1;
  for (const position of [up, down]) {
    ctx.beginPath();
    drive.forEach((x, at) => ctx.lineTo(x * toX.scale + toX.offset, position[at] * toY.scale + toY.offset));
    ctx.stroke();
  }
}

function paintLoop(ctx, { points, colour, dash }, toX, toY) {
  ctx.strokeStyle = ctx.fillStyle = lineColour(colour);
  ctx.setLineDash((dashes[dash] ?? []).map((part) => part * devicePixelRatio));
  ctx.lineWidth = 1.4 * devicePixelRatio;
  let [x, y] = [NaN, NaN];
  const thinning = new Thinning((nextX, nextY, isJoined) => {
    if (isJoined) ctx.lineTo(nextX, nextY);
    else ctx.moveTo(nextX, nextY);
    x = nextX;
    y = nextY;
  });
  const { drive, position, number } = points;
  for (let shade = 0; shade < shades; ++shade) {
    ctx.globalAlpha = faintest + (1 - faintest) * ((shade + 1) / shades) ** 2;
    ctx.beginPath();
    if (x === x) ctx.moveTo(x, y);
    const end = Math.floor((number * (shade + 1)) / shades);
    for (let at = Math.floor((number * shade) / shades); at < end; ++at)
      thinning.add(drive[at] * toX.scale + toX.offset, position[at] * toY.scale + toY.offset);
    ctx.stroke();
  }
  if (x !== x) return;
  ctx.beginPath();
  ctx.arc(x, y, 4 * devicePixelRatio, 0, 2 * Math.PI);
  ctx.fill();
}

/** The points of one axis, in reused memory. A point without a drive or a position is NaN. */
class LoopPoints {
  number = 0;
  drive = new Float64Array(0);
  position = new Float64Array(0);

  /** Sets the positions between two times, each with the drive `delay_s` earlier, interpolated between the rows. */
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

  /** Returns the newest complete point: [drive, position]. */
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

/**
 * Reduces the points of a path: calls `draw(x, y, isJoined)` for the necessary points, in canvas pixels. Omits a point
 * near the last one, except where the path turns back, so that the tips of a loop remain.
 */
export class Thinning {
  #x = NaN; // the last drawn point
  #y = NaN;
  #far = 0; // distance of the farthest point omitted since
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
