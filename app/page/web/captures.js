// Triggered captures: arming, the list, the overlay aligned on the trigger, and their CSV.

import { byId, element, setOptions, setText } from './dom.js';
import { saveCsv, wordsOf } from './export.js';
import { columnWord, quantity } from './format.js';
import { onThemeChange } from './theme.js';
import { TimeChart } from './time_chart.js';
import { traceOfArrays } from './trace.js';

const most = 20; // maximum number of stored captures
const shownAtOnce = 7; // the number of colours

export class CaptureView {
  captures = []; // newest first: {number, on, axis, time_s, step, columns: Map, rows, isShown}
  #announced = new Map();
  changed = () => {};

  constructor(connection, streams) {
    this.connection = connection;
    this.streams = streams;
    this.chart = new TimeChart(byId('overlay-chart'), {
      title: 'Captures',
      timeLabel: 'time from the trigger, s',
      zoomed: (from_s, to_s) => {
        this.zoom = [from_s, to_s];
        this.redraw();
      },
      reset: () => {
        this.zoom = null;
        this.redraw();
      },
    });
    byId('capture-form').addEventListener('submit', (event) => {
      event.preventDefault();
      this.#arm(this.#request());
    });
    byId('capture-now').addEventListener('click', () => this.captureNow());
    byId('disarm').addEventListener('click', () => this.#disarm());
    for (const id of ['capture-on', 'capture-signal', 'capture-axis'])
      byId(id).addEventListener('change', () => this.#fitForm());
    byId('overlay-signal').addEventListener('change', () => this.#showChosen());
    byId('capture-csv').addEventListener('click', () => this.#save(this.#shown()));
    byId('capture-clear').addEventListener('click', () => {
      this.captures = [];
      this.#listChanged();
    });
    connection.on('closed', () => this.disarmed('connection lost'));
    onThemeChange(() => {
      this.chart.recolour();
      this.redraw();
    });
    this.#fitForm();
  }

  begin(greeting) {
    this.greeting = greeting;
    setOptions(
      byId('capture-axis'),
      greeting.axes.map(({ name }, at) => [at, name]),
    );
    const signals = greeting.columns
      .map(({ name }) => name)
      .filter((name) => !['cycle', 'time_s', 'axis'].includes(name));
    setOptions(
      byId('capture-signal'),
      signals.map((name) => [name, columnWord(name)]),
    );
    if (!byId('capture-signal').dataset.chosen) byId('capture-signal').value = 'position_um';
    byId('capture-signal').dataset.chosen = 'yes';
    setOptions(byId('overlay-signal'), [
      ['tracking', 'reference and position'],
      ['error_um', 'error'],
      ...signals.map((name) => [name, columnWord(name)]),
    ]);
    this.#fitForm();
  }

  captureNow() {
    this.#arm({ ...this.#request(), on: 'now', repeat: false });
  }

  /** Called when the server has no trigger of this page. */
  disarmed(why) {
    if (byId('armed').dataset.state === 'armed') this.#tell('idle', `not armed: ${why}`);
  }

  announce(message) {
    this.#announced.set(message.number, message);
  }

  /** Stores the rows of an announced capture. */
  take({ capture, rows, values }) {
    const result = this.#announced.get(capture);
    this.#announced.delete(capture);
    if (!result) return;
    const names = this.greeting.columns.map(({ name }) => name);
    const columns = new Map(
      names.map((name, at) => [
        name,
        Float64Array.from({ length: rows }, (_, row) => values[row * names.length + at]),
      ]),
    );
    const position = columns.get('position_um');
    columns.set(
      'error_um',
      columns.get('reference_um').map((reference, row) => reference - position[row]),
    );
    this.captures.unshift({
      ...result,
      time_s: result.trigger_time_s,
      columns,
      rows,
      isShown: true,
      name: this.greeting.axes[result.axis].name,
    });
    this.captures.length = Math.min(this.captures.length, most);
    this.#shown()
      .slice(shownAtOnce)
      .forEach((old) => (old.isShown = false));
    if (!this.isRepeating) this.#tell('idle', `capture ${result.number} received`);
    else this.#tell('armed', `armed, capture ${result.number} received`);
    this.#listChanged();
  }

  redraw() {
    const shown = this.#shown();
    if (!shown.length || byId('capture').hidden) return;
    const times = shown.map(({ columns, time_s }) => columns.get('time_s').map((time) => time - time_s));
    const from_s = Math.min(...times.map((time) => time[0]));
    const to_s = Math.max(...times.map((time) => time.at(-1)));
    this.chart.draw(...(this.zoom ?? [from_s, Math.max(to_s, from_s + 1e-3)]));
  }

  #shown() {
    return this.captures.filter(({ isShown }) => isShown);
  }

  #request() {
    const number = (id) => Number(byId(id).value);
    const on = byId('capture-on').value;
    const request = {
      do: 'trigger',
      on,
      axis: number('capture-axis'),
      pre_s: number('capture-pre'),
      post_s: number('capture-post'),
      repeat: byId('capture-repeat').checked,
    };
    if (on === 'level')
      Object.assign(request, { signal: byId('capture-signal').value, edge: byId('capture-edge').value });
    if (on === 'level' || on === 'step') request.level = number('capture-level');
    return request;
  }

  async #arm(request) {
    this.isRepeating = request.repeat;
    const word = byId('capture-on').selectedOptions[0].textContent;
    this.#tell(
      'armed',
      `armed: ${request.on === 'now' ? 'now' : word}, axis ${this.greeting?.axes[request.axis]?.name ?? '-'}`,
    );
    const answer = await this.connection.ask(request);
    if (!answer.ok) this.#tell('refused', `not armed: ${answer.error}`);
  }

  async #disarm() {
    const answer = await this.connection.ask({ do: 'untrigger' });
    this.#tell(answer.ok ? 'idle' : 'refused', answer.ok ? 'not armed' : answer.error);
  }

  #tell(state, text) {
    byId('armed').dataset.state = state;
    setText(byId('armed'), text);
    byId('disarm').disabled = state !== 'armed';
  }

  #fitForm() {
    const on = byId('capture-on').value;
    for (const label of document.querySelectorAll('#capture-form .of-level'))
      label.hidden = !(on === 'level' || (on === 'step' && label.classList.contains('of-step')));
    if (!this.greeting) return;
    const name = on === 'level' ? byId('capture-signal').value : 'reference_um';
    setText(byId('capture-level-unit'), this.streams.controller.unitOf(name, byId('capture-axis').value));
  }

  #listChanged() {
    byId('capture-list').replaceChildren(...this.captures.map((one) => this.#item(one)));
    byId('capture-clear').disabled = this.captures.length === 0;
    this.#showChosen();
    this.changed();
  }

  #item(one) {
    const box = element('input', {
      type: 'checkbox',
      onchange: () => {
        one.isShown = box.checked;
        this.#showChosen();
      },
    });
    box.checked = one.isShown;
    const label = element(
      'label',
      {},
      box,
      `#${one.number}  ${one.on}, axis ${one.name}, ${quantity(one.time_s, 's')}, ${one.rows} rows`,
    );
    return element(
      'li',
      {},
      label,
      element('button', {
        type: 'button',
        'aria-label': `CSV of capture ${one.number}`,
        text: 'CSV',
        onclick: () => this.#save([one]),
      }),
    );
  }

  #showChosen() {
    const shown = this.#shown();
    byId('capture-csv').disabled = shown.length === 0;
    const signal = byId('overlay-signal').value || 'tracking';
    const line = (one, column, at, look = {}) => ({
      label: `#${one.number} ${one.name} ${columnWord(column)}`,
      unit: this.streams.controller.unitOf(column, one.axis),
      colour: at,
      dash: at % 7,
      ...look,
      trace: () => traceOfArrays(one.columns.get('time_s'), one.columns.get(column), -one.time_s),
    });
    this.chart.setLines(
      shown
        .slice(0, shownAtOnce)
        .flatMap((one, at) =>
          signal === 'tracking'
            ? [
                line(one, 'position_um', at),
                line(one, 'reference_um', at, { colour: 'reference', dash: 2, width: 1 }),
              ]
            : [line(one, signal, at)],
        ),
    );
    this.zoom = null;
    this.redraw();
    this.chart.showValues();
  }

  #save(captures) {
    if (!captures.length) return;
    const names = [...captures[0].columns.keys()];
    const columns = [
      { name: 'capture' },
      { name: 'time_from_trigger', unit: 's' },
      ...names.map((name) => ({ name, unit: this.streams.controller.unitOf(name, captures[0].axis) })),
    ];
    saveCsv(
      'captures',
      columns,
      (function* rows() {
        for (const one of captures)
          for (let row = 0; row < one.rows; ++row)
            yield [
              one.number,
              one.columns.get('time_s')[row] - one.time_s,
              ...names.map((name) => one.columns.get(name)[row]),
            ];
      })(),
      wordsOf(this.greeting),
    );
  }
}
