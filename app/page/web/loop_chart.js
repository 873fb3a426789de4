// The hysteresis loop: position against drive, the newest bright, the older fading.

import uPlot from './uPlot.esm.js';
import { colours, linear, swatch } from './chart.js';
import { element } from './dom.js';
import { compact, plain } from './format.js';
import { SteadyRange } from './steady_range.js';
import { dashes, line as lineColour } from './theme.js';
import { rowsBetween } from './trace.js';

const shades = 10; // steps of the fading
const faintest = 0.1;
const leastStep_px = 1.5; // nearer points are left out
export const longest_s = 5;

export class LoopChart {
  constructor(host, title) {
    this.host = host;
    this.title = title;
    this.loops = []; // {label, unit, colour, dash, drive: () => trace, position: () => trace}
    this.legend = element('figcaption', { class: 'legend' });
    this.plot = element('div', { class: 'plot', role: 'img', 'aria-label': title });
    host.append(this.legend, this.plot);
    this.x = new SteadyRange();
    this.y = new SteadyRange();
    this.zoomedTo = null;
    this.references = []; // of the model, behind the loops: {drive, ascending_um, descending_um}
    new ResizeObserver(() => this.uplot?.setSize(this.#size())).observe(this.plot);
  }

  setLoops(loops) {
    this.loops = loops;
    this.x = new SteadyRange();
    this.y = new SteadyRange();
    this.zoomedTo = null;
    this.#buildLegend();
    this.#build();
  }

  setReferences(references) {
    this.references = references;
    this.#buildLegend();
    this.uplot?.redraw();
  }

  draw(from_s, to_s) {
    if (!this.uplot || this.plot.clientWidth === 0) return;
    this.shown = [Math.max(from_s, to_s - longest_s), to_s];
    this.pairs = this.loops.map(({ drive, position }) => pairOf(drive(), position(), ...this.shown));
    const reach = reachOf(this.pairs);
    const [x, y] = this.zoomedTo ?? [this.x.follow(reach.left, reach.right), this.y.follow(reach.bottom, reach.top)];
    this.uplot.batch(() => {
      this.uplot.setData(this.data, false);
      this.uplot.setScale('x', { min: x[0], max: x[1] });
      this.uplot.setScale('y', { min: y[0], max: y[1] });
    });
  }

  showValues() {
    const newest = this.loops.map(({ label, unit, drive, position }) => {
      const pair = pairOf(drive(), position(), -Infinity, Infinity);
      const at = pair && pair.end > pair.begin ? (pair.end - 1) & pair.mask : -1;
      const [x, y] = at < 0 ? [NaN, NaN] : [pair.drive[at], pair.position[at]];
      return `${label} ${plain(x, 2)} ${unit}, ${plain(y, 3)} um`;
    });
    this.plot.setAttribute('aria-label', `${this.title}: ${newest.join('; ')}`);
  }

  recolour() {
    if (this.loops.length) this.#buildLegend();
    this.uplot?.redraw();
  }

  #buildLegend() {
    this.legend.replaceChildren(
      element('b', { text: this.title }),
      ...this.loops.map(({ label, colour, dash }) =>
        element('span', { class: 'key' }, swatch(lineColour(colour), dashes[dash]), label),
      ),
      ...(this.references.length
        ? [element('span', { class: 'key' }, swatch(colours().stroke(), [5, 4]), 'reference curves of the model')]
        : []),
    );
  }

  #size() {
    return { width: Math.max(120, this.plot.clientWidth), height: Math.max(120, this.plot.clientHeight) };
  }

  #build() {
    this.uplot?.destroy();
    this.data = [new Float64Array([0, 1]), new Float64Array(2)];
    const units = [...new Set(this.loops.map(({ unit }) => unit))].join(' or ');
    const axis = {
      ...colours(),
      labelSize: 16,
      labelGap: 0,
      values: (_, splits) => splits.map((mark) => compact(mark, 6)),
    };
    const range = (_, low, high) => [low ?? 0, high ?? 1];
    this.uplot = new uPlot(
      {
        ...this.#size(),
        legend: { show: false },
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
      this.plot,
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
    this.pairs?.forEach((pair, at) => pair && paintLoop(ctx, pair, this.loops[at], toX, toY));
    ctx.restore();
  }
}

/** The rows of two columns of the same axis between two times. */
function pairOf(drive, position, from_s, to_s) {
  if (!drive || !position) return null;
  const [begin, end] = rowsBetween(drive, from_s, to_s);
  return { drive: drive.values, position: position.values, mask: drive.mask, begin, end };
}

function reachOf(pairs) {
  const reach = { left: Infinity, right: -Infinity, bottom: Infinity, top: -Infinity };
  for (const pair of pairs) {
    if (!pair) continue;
    for (let row = pair.begin; row < pair.end; ++row) {
      const x = pair.drive[row & pair.mask];
      const y = pair.position[row & pair.mask];
      if (x < reach.left) reach.left = x;
      if (x > reach.right) reach.right = x;
      if (y < reach.bottom) reach.bottom = y;
      if (y > reach.top) reach.top = y;
    }
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

function paintLoop(ctx, { drive, position, mask, begin, end }, { colour, dash }, toX, toY) {
  ctx.strokeStyle = ctx.fillStyle = lineColour(colour);
  ctx.setLineDash((dashes[dash] ?? []).map((part) => part * devicePixelRatio));
  ctx.lineWidth = 1.4 * devicePixelRatio;
  const share = (end - begin) / shades;
  let [x, y] = [NaN, NaN];
  for (let shade = 0; shade < shades; ++shade) {
    ctx.globalAlpha = faintest + (1 - faintest) * ((shade + 1) / shades) ** 2;
    ctx.beginPath();
    if (x === x) ctx.moveTo(x, y);
    const last = Math.floor(begin + share * (shade + 1));
    for (let row = Math.floor(begin + share * shade); row < last; ++row) {
      const nextX = drive[row & mask] * toX.scale + toX.offset;
      const nextY = position[row & mask] * toY.scale + toY.offset;
      if (Math.abs(nextX - x) + Math.abs(nextY - y) < leastStep_px) continue;
      if (x === x) ctx.lineTo(nextX, nextY);
      else ctx.moveTo(nextX, nextY);
      [x, y] = [nextX, nextY];
    }
    ctx.stroke();
  }
  if (x !== x) return;
  ctx.beginPath();
  ctx.arc(x, y, 4 * devicePixelRatio, 0, 2 * Math.PI);
  ctx.fill();
}
