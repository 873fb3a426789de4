// The live charts: their signals, their time span, paused or running.

import { byId, element, setText } from './dom.js';
import { columnWord } from './format.js';
import { LoopChart, longest_s } from './loop_chart.js';
import { onThemeChange } from './theme.js';
import { TimeChart } from './time_chart.js';
import { traceOfAxis } from './trace.js';

const shortest_s = 0.002; // minimum span of a zoom by key
const dashOf = (axis) => (axis === 0 ? 0 : 6); // index of the axis's dash in theme.js

export class LiveView {
  isPaused = false;
  zoom = null; // [from_s, to_s] while paused
  cursorChanged = () => {};

  /** `streams`: {controller, twin, twinShift_s()}: row stores, or null. */
  constructor(streams) {
    this.streams = streams;
    this.frozen = null;
    this.firstPlotMs = 0;
    const chart = (id, title, timeLabel) =>
      new TimeChart(byId(id), {
        title,
        timeLabel,
        zoomed: (from_s, to_s) => this.#zoomTo(from_s, to_s),
        reset: () => this.#resetZoom(),
      });
    this.loop = new LoopChart(byId('loop-chart'), `Hysteresis loop, at most the last ${longest_s} s`);
    this.tracking = chart('tracking-chart', 'Tracking');
    this.error = chart('error-chart', 'Following error');
    this.drive = chart('drive-chart', 'Drive', 'time since the start of the controller, s');
    this.free = chart('signals-chart', 'Signals', 'time since the start of the controller, s');
    this.timeCharts = [this.tracking, this.error, this.drive, this.free];
    byId('window-seconds').addEventListener('change', () => this.#resetZoom());
    byId('pause').addEventListener('click', () => this.setPaused(!this.isPaused));
    addEventListener('click', ({ target }) => {
      if (!byId('signals').contains(target)) byId('signals').open = false;
    });
    onThemeChange(() => [this.loop, ...this.timeCharts].forEach((one) => one.recolour()));
  }

  get charts() {
    return [this.loop, ...this.timeCharts].filter(({ host }) => host.clientWidth > 0 && !host.hidden);
  }

  get stores() {
    return this.frozen ?? this.streams;
  }

  /** Returns the times that the charts show. */
  get range() {
    if (this.zoom) return this.zoom;
    const newest = this.stores.controller?.newest_s ?? 0;
    const to_s = Number.isFinite(newest) ? newest : 0;
    return [to_s - this.#window_s, to_s];
  }

  get #window_s() {
    return Number(byId('window-seconds').value);
  }

  setPaused(isPaused) {
    if (isPaused === this.isPaused) return;
    this.isPaused = isPaused;
    const { controller, twin, twinShift_s } = this.streams;
    this.frozen = isPaused ? { controller: controller?.copy(), twin: twin?.copy(), twinShift_s } : null;
    if (!isPaused) this.zoom = null;
    byId('pause').setAttribute('aria-pressed', String(isPaused));
    setText(byId('pause'), isPaused ? 'Continue' : 'Pause');
    document.body.classList.toggle('paused', isPaused);
    this.isDirty = true;
  }

  /** Processes a new greeting of a stream, which lists its axes and signals. */
  rebuild() {
    const store = this.streams.controller;
    if (!store) return;
    this.#buildChoices(store);
    this.#buildLines();
  }

  frame() {
    if (!this.streams.controller || (this.isPaused && !this.isDirty)) return;
    this.isDirty = false;
    const [from_s, to_s] = this.range;
    const origin_s = this.stores.controller.offset_s;
    this.loop.draw(from_s, to_s);
    for (const one of this.timeCharts) if (!one.host.hidden) one.draw(from_s, to_s, origin_s);
    if (!this.firstPlotMs && this.streams.controller.newest_s > -Infinity) this.firstPlotMs = performance.now();
  }

  showValues() {
    this.loop.showValues();
    for (const one of this.timeCharts) if (!one.host.hidden) one.showValues();
  }

  /** Changes the time span: around the middle if paused, up to the newest row if running. */
  zoomBy(factor) {
    if (!this.isPaused) return this.#stepWindow(factor < 1 ? -1 : 1);
    const [from_s, to_s] = this.range;
    const middle_s = (from_s + to_s) / 2;
    const half_s = Math.max((factor * (to_s - from_s)) / 2, shortest_s / 2);
    this.zoom = 2 * half_s < this.#window_s ? [middle_s - half_s, middle_s + half_s] : null;
    this.isDirty = true;
  }

  /** Shows the whole range of every chart again. */
  showAll() {
    for (const one of [this.loop, ...this.timeCharts]) one.forgetZoom();
    this.#resetZoom();
  }

  #stepWindow(step) {
    const { options, selectedIndex } = byId('window-seconds');
    byId('window-seconds').selectedIndex = Math.min(Math.max(selectedIndex + step, 0), options.length - 1);
    this.#resetZoom();
  }

  #zoomTo(from_s, to_s) {
    this.wasRunning ??= !this.isPaused;
    this.setPaused(true);
    this.zoom = [from_s, to_s];
    this.isDirty = true;
  }

  #resetZoom() {
    this.zoom = null;
    if (this.wasRunning) this.setPaused(false);
    this.wasRunning = undefined;
    this.isDirty = true;
  }

  #buildChoices(store) {
    const names = store.greeting.axes.map(({ name }) => name);
    const boxes = (host, items) => {
      const checked = new Map([...host.querySelectorAll('input')].map(({ value, checked }) => [value, checked]));
      host.replaceChildren(
        ...items.map(([value, text, isOn]) => {
          const box = element('input', { type: 'checkbox', value, onchange: () => this.#buildLines() });
          box.checked = checked.get(value) ?? isOn;
          return element('label', {}, box, text);
        }),
      );
    };
    boxes(
      byId('axes'),
      names.map((name, at) => [String(at), `axis ${name}`, true]),
    );
    boxes(byId('twin-choice'), this.streams.twin ? [['twin', 'true values of the twin', true]] : []);
    const columns = [...store.units.keys()].filter((name) => !['time_s', 'axis'].includes(name));
    const ofTwin = this.streams.twin ? [...this.streams.twin.units.keys()] : [];
    boxes(byId('signal-choice'), [
      ...names.flatMap((name, axis) =>
        columns.map((column) => [`controller ${axis} ${column}`, `${name} ${columnWord(column)}`, false]),
      ),
      ...names.flatMap((name, axis) =>
        ofTwin
          .filter((column) => !['time_s', 'axis'].includes(column))
          .map((column) => [`twin ${axis} ${column}`, `${name} ${columnWord(column)} (twin)`, false]),
      ),
    ]);
  }

  #line(axis, column, look, stream = 'controller') {
    const { greeting } = this.streams.controller;
    return {
      label: `${greeting.axes[axis].name} ${columnWord(column)}`,
      unit: this.streams[stream].unitOf(column, axis),
      ...look,
      axis,
      column,
      stream,
      trace: () => {
        const rows = this.stores[stream]?.axes[axis];
        return rows && traceOfAxis(rows, column, stream === 'twin' ? this.stores.twinShift_s() : 0);
      },
    };
  }

  #buildLines() {
    const axes = [...byId('axes').querySelectorAll('input:checked')].map(({ value }) => Number(value));
    const withTwin = Boolean(this.streams.twin && byId('twin-choice').querySelector('input')?.checked);
    const each = (make) => axes.flatMap((axis) => make(axis).filter(Boolean));
    const truth = (axis, column, label) =>
      withTwin && {
        ...this.#line(axis, column, { colour: axis + 2, alpha: '88', width: 5 }, 'twin'),
        label: `${this.streams.controller.greeting.axes[axis].name} ${label}`,
      };
    this.tracking.setLines(
      each((axis) => [
        truth(axis, 'position_um', 'true'), // a pale band below the other lines
        this.#line(axis, 'reference_um', { colour: 'reference', dash: 1 + 2 * axis, width: 1.3 }),
        this.#line(axis, 'position_um', { colour: axis, dash: dashOf(axis), width: 2 }),
      ]),
    );
    this.error.setLines(each((axis) => [this.#line(axis, 'error_um', { colour: axis, dash: dashOf(axis) })]));
    this.drive.setLines(
      each((axis) => [
        truth(axis, 'driven', 'driven'),
        this.#line(axis, 'drive', { colour: axis, dash: dashOf(axis) }),
      ]),
    );
    this.loop.setLoops(
      axes.map((axis) => {
        const drive = this.#line(axis, 'drive', {});
        return {
          label: `axis ${this.streams.controller.greeting.axes[axis].name}`,
          unit: drive.unit,
          axis,
          colour: axis,
          dash: dashOf(axis),
          drive: drive.trace,
          position: this.#line(axis, 'position_um', {}).trace,
        };
      }),
    );
    const chosen = [...byId('signal-choice').querySelectorAll('input:checked')].map(({ value }) => value.split(' '));
    this.free.host.hidden = chosen.length === 0;
    this.free.setLines(
      chosen.map(([stream, axis, column], at) =>
        this.#line(Number(axis), column, { colour: at, dash: at % 7 }, stream),
      ),
    );
    this.isDirty = true;
    this.cursorChanged();
  }
}
