// A chart over time: uPlot draws axes and grid and handles the pointer; the lines come from traces.
//
// A line is {label, unit, colour (a number of theme.js, or 'reference'), alpha (two hexadecimal digits),
// dash (a number), width, trace: () => trace}.
// uPlot itself gets only two points; the function `paths` of each series draws the trace between them.

import { Chart, SteadyRange, colours, legendKey, linear } from './chart.js';
import { element, setText } from './dom.js';
import { compact, plain } from './format.js';
import { dashes, line as lineColour, palette } from './theme.js';
import { extent, newestTogether, pathOf, valueAt } from './trace.js';

const digitsOf = { um: 4, V: 2, A: 3, s: 4, us: 0 };
const leastDrag_px = 8;
const colourOf = ({ colour, alpha = '' }) =>
  colour === 'reference' ? palette().reference : lineColour(colour) + alpha;

export class TimeChart extends Chart {
  lines = [];
  shown = [0, 1];
  origin_s = 0;

  /** Calls `zoomed(from_s, to_s)` after a drag in time, and `reset()` after a double click. */
  constructor(host, { title, zoomed = () => {}, reset = () => {}, timeLabel = '' }) {
    super(host, title);
    this.zoomed = zoomed;
    this.reset = reset;
    this.timeLabel = timeLabel;
  }

  setLines(lines) {
    this.lines = lines;
    this.units = [...new Set(lines.map(({ unit }) => unit))];
    this.ranges = new Map(this.units.map((unit) => [unit, new SteadyRange()]));
    this.zoomedRanges = new Map();
    this.showLegend();
    this.#build();
  }

  /** Draws the traces between two times; the marks of the time axis count from `origin_s`. */
  draw(from_s, to_s, origin_s = 0) {
    const { uplot } = this;
    if (!uplot || this.plot.clientWidth === 0) return;
    this.shown = [from_s, to_s];
    this.origin_s = origin_s;
    this.x[0] = from_s;
    this.x[1] = to_s;
    const traces = this.lines.map(({ trace }) => trace());
    this.traces = traces;
    uplot.batch(() => {
      uplot.setData(this.data, false);
      uplot.setScale('x', { min: from_s, max: to_s });
      for (const unit of this.units) {
        const reach = { low: Infinity, high: -Infinity };
        this.lines.forEach((line, at) => line.unit === unit && traces[at] && extent(traces[at], from_s, to_s, reach));
        const [min, max] = this.zoomedRanges.get(unit) ?? this.ranges.get(unit).follow(reach.low, reach.high);
        uplot.setScale(`y ${unit}`, { min, max });
      }
    });
  }

  /** Writes the newest values of one instant to the legend and the screen readers' label; adds the age of old ones. */
  showValues() {
    const values = newestTogether(
      this.lines.map(({ trace }) => trace()),
      (at) => this.lines[at].unit === '',
    );
    const texts = values.map(({ value }, at) => plain(value, digitsOf[this.lines[at].unit] ?? 3));
    const ages = values.map(({ age_s }) => (age_s > 0 ? `, ${plain(age_s, 1)} s old` : ''));
    texts.forEach((text, at) => {
      setText(this.values[at], text);
      setText(this.ages[at], ages[at]);
    });
    const spoken = this.lines.map(({ label, unit }, at) => `${label} ${texts[at]} ${unit}${ages[at]}`);
    this.plot.setAttribute('aria-label', `${this.title}: ${spoken.join(', ')}`);
  }

  valuesAt(time_s) {
    return this.lines.map(({ trace }) => {
      const now = trace();
      return now ? valueAt(now, time_s) : NaN;
    });
  }

  legendKeys() {
    this.values = this.lines.map(() => element('output', { class: 'value', text: '-' }));
    this.ages = this.lines.map(() => element('span', { class: 'warn' }));
    return this.lines.map((line, at) =>
      legendKey(
        colourOf(line),
        dashes[line.dash ?? 0],
        line.width,
        line.label,
        this.values[at],
        element('span', { class: 'unit', text: line.unit }),
        this.ages[at],
      ),
    );
  }

  #build() {
    this.x = new Float64Array([0, 1]);
    this.data = [this.x, ...this.lines.map(() => new Float64Array(2))];
    const scales = { x: { time: false } };
    for (const unit of this.units)
      scales[`y ${unit}`] = { auto: false, range: (_, low, high) => [low ?? 0, high ?? 1] };
    this.make(
      {
        scales,
        padding: [6, 10, 0, 0],
        cursor: {
          points: { show: false },
          drag: { x: true, y: true, uni: 24, setScale: false },
          bind: { dblclick: () => () => this.#unzoom() },
        },
        axes: [this.#axisOfTime(), ...this.units.map((unit, at) => this.#axisOfValue(unit, at))],
        series: [{}, ...this.lines.map((line, at) => this.#series(line, at))],
        hooks: { setSelect: [(uplot) => this.#select(uplot)] },
      },
      this.data,
    );
  }

  #axisOfTime() {
    return {
      ...colours(),
      size: 22,
      label: this.timeLabel || undefined,
      labelSize: 15,
      labelGap: 0,
      space: 60,
      splits: (_, __, min, max, step) =>
        marks(min - this.origin_s, max - this.origin_s, step).map((mark) => mark + this.origin_s),
      values: (_, splits) =>
        splits.map((mark) => compact(Math.abs(mark - this.origin_s) < 1e-9 ? 0 : mark - this.origin_s, 7)),
    };
  }

  #axisOfValue(unit, at) {
    return {
      ...colours(),
      scale: `y ${unit}`,
      side: at === 0 ? 3 : 1,
      size: 46,
      label: unit || 'number',
      labelSize: 16,
      labelGap: 0,
      space: 26,
      grid: { ...colours().grid, show: at === 0 },
      values: (_, splits) => splits.map((mark) => (mark === null ? '' : compact(mark, 6))),
    };
  }

  #series(line, at) {
    const width = line.width ?? 1.5;
    const dash = (dashes[line.dash ?? 0] ?? []).map((part) => part * devicePixelRatio);
    return {
      label: line.label,
      scale: `y ${line.unit}`,
      auto: false,
      points: { show: false },
      width,
      stroke: () => colourOf(line),
      dash,
      cap: 'butt',
      paths: (uplot) => {
        const trace = this.traces?.[at];
        if (!trace) return null;
        const { left, top, width: across, height } = uplot.bbox;
        const y = uplot.scales[`y ${line.unit}`];
        const toX = linear(uplot.scales.x.min, uplot.scales.x.max, left, across);
        const toY = linear(y.min, y.max, top + height, -height);
        const { path, isDense } = pathOf(trace, ...this.shown, toX, toY);
        const series = uplot.series[at + 1];
        // If the rows are dense, dashes and broad lines are slow and not visible.
        series.dash = isDense ? [] : dash;
        series.width = isDense ? Math.min(width, line.alpha ? 3 : 1) : width;
        return { stroke: path, fill: null, clip: null, flags: 2 };
      },
    };
  }

  #select(uplot) {
    const { left, top, width, height } = uplot.select;
    if (width < leastDrag_px && height < leastDrag_px) return;
    const full = { width: uplot.over.clientWidth, height: uplot.over.clientHeight };
    if (height >= leastDrag_px && height < full.height - 1)
      for (const unit of this.units)
        this.zoomedRanges.set(unit, [uplot.posToVal(top + height, `y ${unit}`), uplot.posToVal(top, `y ${unit}`)]);
    if (width >= leastDrag_px && width < full.width - 1)
      this.zoomed(uplot.posToVal(left, 'x'), uplot.posToVal(left + width, 'x'));
    else this.draw(...this.shown, this.origin_s);
    uplot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
  }

  forgetZoom() {
    this.zoomedRanges?.clear();
  }

  #unzoom() {
    this.forgetZoom();
    this.reset();
    this.draw(...this.shown, this.origin_s);
  }
}

function marks(min, max, step) {
  const made = [];
  for (let mark = Math.ceil(min / step) * step; mark <= max + step * 1e-6; mark += step) made.push(mark);
  return made;
}
