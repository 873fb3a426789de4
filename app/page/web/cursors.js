// Two cursors over all charts of time. Their screen positions are fixed while the charts run, as on an oscilloscope.

import { byId, element, fillTable, setText } from './dom.js';
import { compact, plain } from './format.js';

const step = 0.005; // fraction of the width per arrow key

export class Cursors {
  places = [0.35, 0.65]; // fraction of the width
  isOn = false;

  constructor(view) {
    this.view = view;
    view.cursorChanged = () => this.#place();
    byId('cursors').addEventListener('click', () => {
      this.isOn = !this.isOn;
      byId('cursors').setAttribute('aria-pressed', String(this.isOn));
      byId('cursor-readout').hidden = !this.isOn;
      this.#place();
      this.show();
    });
  }

  /** Updates the readout. */
  show() {
    if (!this.isOn) return;
    const [from_s, to_s] = this.view.range;
    const times = this.places.map((place) => from_s + place * (to_s - from_s));
    const apart_s = times[1] - times[0];
    const origin_s = this.view.stores.controller?.offset_s ?? 0;
    const [a_s, b_s] = times.map((time) => plain(time - origin_s, 4));
    setText(
      byId('cursor-times'),
      `A ${a_s} s, B ${b_s} s, \u0394t ${plain(apart_s, 4)} s, ` +
        `1/\u0394t ${Math.abs(apart_s) > 1e-9 ? compact(1 / apart_s, 5) : '-'} Hz`,
    );
    const charts = this.view.timeCharts.filter(({ host }) => !host.hidden);
    this.#build(charts.map(({ title }) => title));
    charts.forEach((chart, at) => {
      const [a, b] = times.map((time) => chart.valuesAt(time));
      fillTable(
        byId('cursor-tables').children[at].tBodies[0],
        chart.lines.map(({ label, unit }, row) => [
          `${label}${unit ? `, ${unit}` : ''}`,
          plain(a[row], 4),
          plain(b[row], 4),
          plain(b[row] - a[row], 4),
        ]),
      );
    });
  }

  #build(titles) {
    if (titles.join() === this.titles) return;
    this.titles = titles.join();
    byId('cursor-tables').replaceChildren(
      ...titles.map((title) => {
        const headings = [title, 'A', 'B', 'B \u2212 A'].map((text) => element('th', { scope: 'col', text }));
        const head = element('thead', {}, element('tr', {}, ...headings));
        return element('table', { class: 'values' }, head, element('tbody'));
      }),
    );
  }

  #place() {
    for (const chart of this.view.timeCharts) {
      const { uplot } = chart;
      if (!uplot) continue;
      uplot.over.querySelectorAll('.cursor').forEach((old) => old.remove());
      if (this.isOn)
        this.places.forEach((_, which) => uplot.over.append(this.#handle(which, uplot.over, chart.title)));
    }
    this.#move();
  }

  #handle(which, over, title) {
    const name = 'AB'[which];
    const handle = element('div', {
      class: `cursor cursor-${name}`,
      role: 'slider',
      tabindex: '0',
      'aria-label': `Cursor ${name}, chart ${title}`,
      'aria-valuemin': '0',
      'aria-valuemax': '100',
      'data-name': name,
    });
    const follow = ({ clientX }) => {
      const { left, width } = over.getBoundingClientRect();
      this.#set(which, (clientX - left) / width);
    };
    for (const kind of ['mousedown', 'dblclick']) handle.addEventListener(kind, (event) => event.stopPropagation());
    handle.addEventListener('pointerdown', (event) => {
      handle.setPointerCapture(event.pointerId);
      handle.addEventListener('pointermove', follow);
    });
    handle.addEventListener('pointerup', () => handle.removeEventListener('pointermove', follow));
    handle.addEventListener('keydown', (event) => {
      const ways = { ArrowLeft: -step, ArrowRight: step, PageDown: -10 * step, PageUp: 10 * step };
      if (!(event.key in ways)) return;
      event.preventDefault();
      this.#set(which, this.places[which] + ways[event.key]);
    });
    return handle;
  }

  #set(which, place) {
    this.places[which] = Math.min(1, Math.max(0, place));
    this.#move();
    this.show();
  }

  #move() {
    document.querySelectorAll('.cursor').forEach((handle) => {
      const place = this.places[handle.dataset.name === 'A' ? 0 : 1];
      handle.style.left = `${100 * place}%`;
      handle.setAttribute('aria-valuenow', (100 * place).toFixed(1));
      handle.setAttribute('aria-valuetext', `${(100 * place).toFixed(1)} % of the shown time`);
    });
  }
}
