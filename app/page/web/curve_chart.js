// A chart of curves over a logarithmic frequency.

import uPlot from './uPlot.esm.js';
import { colours, swatch } from './chart.js';
import { element } from './dom.js';
import { compact } from './format.js';
import { dashes, line as lineColour } from './theme.js';

export class CurveChart {
  /** `steps`: the distances of marks that may be chosen. */
  constructor(host, { title, yLog = false, steps }) {
    this.host = host;
    this.title = title;
    this.yLog = yLog;
    this.steps = steps;
    this.legend = element('figcaption', { class: 'legend' }, element('b', { text: title }));
    this.plot = element('div', { class: 'plot', role: 'img', 'aria-label': title });
    host.append(this.legend, this.plot);
    new ResizeObserver(() => this.uplot?.setSize(this.#size())).observe(this.plot);
  }

  /** `curves`: list of {label, values, colour, dash}; `yRange` cuts the range where the values go further. */
  show(frequency_Hz, curves, yRange) {
    this.yRange = yRange;
    const data = [frequency_Hz, ...curves.map(({ values }) => values.map((value) => (Number.isFinite(value) && (!this.yLog || value > 0) ? value : null)))];
    const shape = curves.map(({ label }) => label).join();
    if (shape === this.shape && this.uplot) this.uplot.setData(data);
    else this.#build(data, curves);
    this.shape = shape;
    this.plot.setAttribute('aria-label', `${this.title}: ${curves.map(({ label }) => label).join(', ')}`);
  }

  recolour() {
    if (this.curves) this.#buildLegend();
    this.uplot?.redraw();
  }

  #size() {
    return { width: Math.max(120, this.plot.clientWidth), height: Math.max(90, this.plot.clientHeight) };
  }

  #buildLegend() {
    this.legend.replaceChildren(element('b', { text: this.title }), ...this.curves.map(({ label, colour, dash }) =>
      element('span', { class: 'key' }, swatch(lineColour(colour), dashes[dash]), label)));
  }

  #build(data, curves) {
    this.uplot?.destroy();
    this.curves = curves;
    this.#buildLegend();
    const axis = { ...colours(), labelSize: 16, labelGap: 0 };
    const decades = (_, splits) => splits.map((mark) => (mark !== null && isRound(mark) ? compact(mark, 3) : ''));
    const range = (_, low, high) => (this.yRange ? [Math.max(low, this.yRange[0]), Math.min(high + 2, Math.max(this.yRange[1], 0))] : uPlot.rangeNum(low, high, 0.1, true));
    this.uplot = new uPlot({
      ...this.#size(), legend: { show: false }, padding: [6, 18, 0, 0],
      scales: { x: { time: false, distr: 3, range: (_, low, high) => [low, high] }, y: this.yLog ? { distr: 3 } : { range } },
      cursor: { points: { show: false }, drag: { x: true, y: true, uni: 24 } },
      axes: [{ ...axis, label: 'frequency, Hz', size: 22, values: decades },
        { ...axis, size: 52, incrs: this.steps, values: this.yLog ? decades : undefined }],
      series: [{}, ...curves.map(({ label, colour, dash }) => ({ label, width: 1.6, points: { show: false }, stroke: () => lineColour(colour),
        dash: dashes[dash].map((part) => part * devicePixelRatio) }))],
    }, data, this.plot);
  }
}

/** 1, 10, 100 ... */
const isRound = (value) => Math.abs(Math.log10(value) - Math.round(Math.log10(value))) < 1e-6;
