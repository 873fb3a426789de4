// A chart of curves over a logarithmic frequency.

import uPlot from './uPlot.esm.js';
import { Chart, colours, legendKey } from './chart.js';
import { compact } from './format.js';
import { dashes, line as lineColour } from './theme.js';

export class CurveChart extends Chart {
  curves = [];

  /** `steps`: the allowed distances between marks. */
  constructor(host, { title, yLog = false, steps }) {
    super(host, title);
    this.yLog = yLog;
    this.steps = steps;
  }

  /** `curves`: list of {label, values, colour, dash}; values below `lowest` are clipped. */
  show(frequency_Hz, curves, lowest) {
    this.lowest = lowest;
    const data = [
      frequency_Hz,
      ...curves.map(({ values }) =>
        values.map((value) => (Number.isFinite(value) && (!this.yLog || value > 0) ? value : null)),
      ),
    ];
    const shape = curves.map(({ label }) => label).join();
    if (shape === this.shape && this.uplot) this.uplot.setData(data);
    else this.#build(data, curves);
    this.shape = shape;
    this.plot.setAttribute('aria-label', `${this.title}: ${curves.map(({ label }) => label).join(', ')}`);
  }

  legendKeys() {
    return this.curves.map(({ label, colour, dash }) => legendKey(lineColour(colour), dashes[dash], undefined, label));
  }

  #build(data, curves) {
    this.curves = curves;
    this.showLegend();
    const axis = { ...colours(), labelSize: 16, labelGap: 0 };
    const log = { splits: logMarks, filter: (_, splits) => splits, values: logWords };
    const range = (_, low, high) =>
      this.lowest === undefined
        ? uPlot.rangeNum(low, high, 0.1, true)
        : rangeAbove(this.lowest, low, high);
    this.make(
      {
        padding: [6, 18, 0, 0],
        scales: {
          x: { time: false, distr: 3, range: (_, low, high) => [low, high] },
          y: this.yLog ? { distr: 3 } : { range },
        },
        cursor: { points: { show: false }, drag: { x: true, y: true, uni: 24 } },
        axes: [
          { ...axis, label: 'frequency, Hz', size: 22, ...log },
          { ...axis, size: 52, space: 22, incrs: this.steps, ...(this.yLog ? log : {}) },
        ],
        series: [
          {},
          ...curves.map(({ label, colour, dash }) => ({
            label,
            width: 1.6,
            points: { show: false },
            stroke: () => lineColour(colour),
            dash: dashes[dash].map((part) => part * devicePixelRatio),
          })),
        ],
      },
      data,
    );
  }
}

/** Returns the range for values from `low` to `high`: not below `lowest`, and up to the highest peak. */
export const rangeAbove = (lowest, low, high) => [Math.max(low, lowest), Math.max(high, 0) + 2];

/** Returns 1, 2, ... 9, 10, 20, ... within the scale. */
function logMarks(_, __, min, max) {
  const marks = [];
  for (let decade = Math.floor(Math.log10(min)); decade <= Math.log10(max); ++decade)
    for (let digit = 1; digit < 10; ++digit) marks.push(Number(`${digit}e${decade}`));
  return marks.filter((mark) => mark >= min && mark <= max);
}

/** Labels 1, 10, 100; if the scale has less than two decades, also 2 and 5. */
function logWords(_, marks) {
  const digits = marks.at(-1) / marks[0] < 100 ? '125' : '1';
  return marks.map((mark) => {
    const word = mark.toExponential(0);
    return digits.includes(word[0]) ? (mark < 0.001 ? word : compact(mark, 3)) : '';
  });
}
