// Shared by all charts: the figure with a legend above the plot, the colours of axes, the ranges of scales.

import uPlot from './uPlot.esm.js';
import { element } from './dom.js';
import { palette } from './theme.js';

const margin = 0.06;
const shrinksBelow = 0.55; // fraction of the range used by the data
const shrinksAfter_ms = 800;

/** A subclass defines `legendKeys()` and sets `uplot`. */
export class Chart {
  uplot = null;

  /** `host`: a figure element. */
  constructor(host, title, leastHeight = 90) {
    this.host = host;
    this.title = title;
    this.leastHeight = leastHeight;
    this.legend = element('figcaption', { class: 'legend' }, element('b', { text: title }));
    this.plot = element('div', { class: 'plot', role: 'img', 'aria-label': title });
    host.append(this.legend, this.plot);
    new ResizeObserver(() => this.#fit()).observe(this.plot);
  }

  get size() {
    const { clientWidth, clientHeight } = this.plot;
    return { width: Math.max(120, clientWidth), height: Math.max(this.leastHeight, clientHeight) };
  }

  showLegend() {
    this.legend.replaceChildren(element('b', { text: this.title }), ...this.legendKeys());
  }

  /** Sets the uPlot options for the following drawings. */
  make(options, data) {
    this.uplot?.destroy();
    this.uplot = new uPlot({ ...this.size, legend: { show: false }, ...options }, data, this.plot);
  }

  recolour() {
    if (!this.uplot) return;
    this.showLegend();
    this.uplot.redraw();
  }

  #fit() {
    const { width, height } = this.size;
    if (this.uplot && (this.uplot.width !== width || this.uplot.height !== height))
      this.uplot.setSize({ width, height });
  }
}

/** Returns a legend entry: a sample of the line and its label. */
export const legendKey = (colour, dash, width, ...words) =>
  element('span', { class: 'key' }, swatch(colour, dash, width), ...words);

function swatch(colour, dash, width = 2) {
  const canvas = element('canvas', { class: 'swatch', width: 44, height: 8, 'aria-hidden': 'true' });
  const context = canvas.getContext('2d');
  context.strokeStyle = colour;
  context.lineWidth = Math.max(3, Math.min(8, 2 * width));
  context.setLineDash((dash ?? []).map((part) => part * 2));
  context.beginPath();
  context.moveTo(0, 4);
  context.lineTo(44, 4);
  context.stroke();
  return canvas;
}

/** Maps value to scale * value + offset: `low` is at pixel `start`, `high` at start + size. */
export function linear(low, high, start, size) {
  const scale = size / (high - low);
  return { scale, offset: start - low * scale };
}

export const colours = () => ({
  stroke: () => palette().faint,
  font: '11px system-ui, sans-serif',
  labelFont: '11px system-ui, sans-serif',
  grid: { stroke: () => palette().grid, width: 1 },
  ticks: { stroke: () => palette().grid, width: 1, size: 4 },
});

/** The range of a scale. It grows with the data at once, but shrinks only when the data stay small. */
export class SteadyRange {
  low = 0;
  high = 1;
  #small_ms = null;
  #isEmpty = true;

  /** Returns the range [low, high] for the smallest and the largest value. */
  follow(low, high, now_ms = performance.now()) {
    if (!(low <= high)) return [this.low, this.high];
    const least = Math.max(Math.abs(low), Math.abs(high)) * 1e-4 || 1; // a constant value needs a range, too
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
