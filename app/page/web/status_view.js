// The states of the axes, the bus, the counters, the timing and the recording, from the messages `status`.

import { byId, element, fillTable, setText, setTextWithPath } from './dom.js';
import { clock, count, plain, quantity } from './format.js';

/** The rows of the table of axes: a name, and the function from an axis's status and drive unit to the text. */
const axisRows = [
  ['Position', ({ position_um }) => quantity(position_um, 'um')],
  ['Reference', ({ reference_um }) => quantity(reference_um, 'um')],
  ['Following error', ({ error_um }) => quantity(error_um, 'um')],
  ['Error, RMS', (_, __, { rms_um }) => quantity(rms_um, 'um')],
  ['Error, peak', (_, __, { peak_um }) => quantity(peak_um, 'um')],
  ['Drive', ({ drive }, unit) => quantity(drive, unit)],
  [
    'Amplifier output', // from the amplifier's last status, which does not arrive in each cycle
    ({ amplifier_output: output, amplifier_output_age_s: age_s }, unit) =>
      quantity(output, unit) + (Number.isFinite(age_s) ? `, ${plain(1000 * age_s, 0)}\u00a0ms\u00a0old` : ''),
  ],
  ['Limited by', ({ limits }) => (limits === undefined ? '-' : limits || 'nothing')],
  [
    'Goal',
    ({ live_goal, finished, state }) =>
      state !== 'tracking' ? '-' : live_goal ? 'go to' : finished ? 'at its end' : 'reference',
  ],
  ['Arrival', ({ arrival }) => arrival ?? '-'],
  ['Sample', ({ sample_missing }) => (sample_missing === undefined ? '-' : sample_missing ? 'missing' : 'received')],
  ['Learning', ({ learning, state }) => (state === 'no controller' || state === 'unknown' ? '-' : learningText(learning))],
];

const longestAge_s = 0.7; // older values are outdated: a status arrives five times a second

/** Returns sign and word of a state, because colour alone is not enough. */
const signs = {
  tracking: '\u25b6',
  ready: '\u25cf',
  initialising: '\u25d0',
  waiting: '\u25cb',
  offline: '\u25a0',
  faulted: '\u25b2',
};

function learningText(learning) {
  if (!learning) return 'off';
  const { state, periods, ...further } = learning;
  const errors = Object.entries(further)
    .filter(([, value]) => typeof value === 'number')
    .map(
      ([name, value]) =>
        `${name.replace(/_um$/, '').replaceAll('_', ' ')} ${quantity(value, name.endsWith('_um') ? 'um' : '', 4)}`,
    );
  return [`${state}, ${count(periods)} periods`, ...errors].join('; ');
}

export class StatusView {
  #names = [];
  #units = []; // units of the drives
  #cameAt_ms = NaN; // arrival of the last status

  /** `errors(axis)`: {rms_um, peak_um} over the shown time. */
  constructor(errors) {
    this.errors = errors;
    setInterval(() => this.#watch(), 200);
    byId('reveal-histogram').addEventListener('change', () => this.#showTiming(this.timing));
  }

  /** Creates the table of the controller's axes. It remains if the controller ends before its first status. */
  begin({ axes }) {
    this.#units = axes.map(({ drive_unit: unit }) => unit);
    this.#nameAxes(axes.map(({ name }) => name));
  }

  show({ controller, bus, timing, page, age_s: age }) {
    this.last = controller;
    this.#cameAt_ms = performance.now();
    const isSilent = !controller && age > longestAge_s;
    this.#showAxes(controller, isSilent ? 'unknown' : 'no controller');
    this.#showCounters(controller, page);
    this.#showBus(bus);
    this.timing = timing;
    this.#showTiming(timing);
    setText(byId('time'), controller ? clock(controller.time_s) : '-');
    this.#showAge(isSilent ? age : controller?.age_s, isSilent ? 'no answer from the controller for' : 'values are old:');
  }

  /** Marks the shown values when they are outdated. */
  #watch() {
    const age = (performance.now() - this.#cameAt_ms) / 1000;
    if (!(age > longestAge_s)) return;
    this.last = null;
    this.#showAxes(null, 'unknown');
    this.#showAge(age, 'no status for');
  }

  #showAge(age, what) {
    setText(byId('age'), age > 0.5 ? `${what} ${plain(age, 1)} s` : '');
  }

  #nameAxes(names) {
    if (names.join('\n') === this.#names.join('\n')) return;
    this.#names = names;
    byId('axis-head').replaceChildren(
      element('th', { scope: 'col', text: 'Axis' }),
      ...names.map((name) => element('th', { scope: 'col', text: name })),
    );
    const row = (title, cells) => element('tr', {}, element('th', { scope: 'row', text: title }), ...cells);
    this.states = names.map((_, axis) => element('td', { id: `axis-${axis}-state`, class: 'state' }));
    this.cells = axisRows.map(([title]) => [title, names.map(() => element('td'))]);
    byId('axis-rows').replaceChildren(
      row('State', this.states),
      ...this.cells.map(([title, cells]) => row(title, cells)),
    );
    this.waits = names.map((_, axis) => element('p', { id: `axis-${axis}-waits`, class: 'waits' }));
    this.faults = names.map((_, axis) => element('p', { id: `axis-${axis}-fault`, class: 'fault', role: 'alert' }));
    byId('faults').replaceChildren(...this.faults, ...this.waits);
  }

  #showAxes(controller, otherwise) {
    const axes = controller?.axes ?? this.#names.map((name) => ({ name, state: otherwise }));
    this.#nameAxes(axes.map(({ name }) => name));
    axes.forEach((axis, at) => {
      setText(this.states[at], `${signs[axis.state] ?? '\u25a1'} ${axis.state}`);
      this.states[at].dataset.state = axis.state;
      const errors = this.errors(at);
      axisRows.forEach(([, text], row) => setText(this.cells[row][1][at], text(axis, this.#units[at] ?? '', errors)));
      setText(this.waits[at], axis.waits_for_all ? `Axis ${axis.name} waits for: ${axis.waits_for_all.join('; ')}` : '');
      setText(this.faults[at], faultText(axis));
    });
  }

  #showCounters(controller, page) {
    const table = [
      ['Cycles', count(controller?.cycles)],
      ['Missed cycles', count(controller?.missed_cycles)],
      ['Missing samples', count(controller?.missing_samples)],
      ['Late samples', count(controller?.late_samples)],
      ['Open pages', count(page.clients)],
      ['Disconnected pages', count(page.cut_off)],
      ['Requests refused', count(page.refused)],
      ['Rows lost on the way to pages', count(page.lost_rows)],
    ];
    fillTable(byId('counters'), table);
    const alarming = ['missed_cycles', 'missing_samples', 'late_samples'].map((key) => controller?.[key] ?? 0);
    setText(
      byId('health'),
      controller
        ? `${count(alarming[0])} missed cycles, ${count(alarming[1])} missing and ${count(alarming[2])} late samples`
        : 'no controller',
    );
  }

  #showBus(bus) {
    if (!bus) return;
    const load = quantity(bus.load_percent, '%', 1);
    const rate = typeof bus.frames_per_s === 'number' ? `${count(Math.round(bus.frames_per_s))} frames/s` : '-';
    const name = bus.interface || 'bus';
    fillTable(byId('bus'), [
      ['Interface', name],
      ['State', bus.state],
      ['Frames', rate],
      ['Load', load],
    ]);
    const known = [rate, load === '-' ? load : `load ${load}`].filter((text) => text !== '-');
    setText(byId('bus-line'), [`${name} ${bus.state}`, ...known].join(', '));
  }

  #showTiming(timing) {
    if (!timing || byId('system').hidden) return;
    const isLog = byId('reveal-histogram').checked;
    for (const name of ['turnaround_us', 'lateness_us']) {
      const result = timing[name];
      const counts = result?.counts ?? result ?? [];
      drawBars(byId(name), result?.upper_us ?? timing.upper_us ?? [], counts, isLog);
    }
  }
}

/** Returns "" if there is no fault. */
function faultText({ name, state, fault, fault_time_s, remedy }) {
  if (state !== 'faulted' && (!fault || fault === 'none')) return '';
  const when = Number.isFinite(fault_time_s) ? ` at ${quantity(fault_time_s, 's')}` : '';
  return `\u25b2 Axis ${name} is faulted: ${fault}${when}.${remedy ? ` Remedy: ${remedy}.` : ''}`;
}

function drawBars(host, upper, counts, isLog) {
  const total = counts.reduce((sum, one) => sum + one, 0);
  const height = isLog ? (one) => Math.log10(one + 1) : (one) => one;
  const most = Math.max(...counts.map(height), 1e-9);
  if (host.childElementCount !== counts.length)
    host.replaceChildren(
      ...counts.map((_, at) =>
        element(
          'div',
          { class: 'class' },
          element('span', { class: 'bar' }),
          element('span', { class: 'edge', text: at < upper.length ? `\u2264 ${upper[at]}` : `> ${upper.at(-1)}` }),
          element('span', { class: 'number' }),
        ),
      ),
    );
  counts.forEach((one, at) => {
    const [bar, , number] = host.children[at].children;
    bar.style.width = `${(100 * height(one)) / most}%`;
    setText(number, count(one));
  });
  const edgeOf = (share) => {
    let sum = 0;
    const at = counts.findIndex((one) => (sum += one) >= share * total);
    return at < upper.length ? `at most ${upper[at]} us` : `more than ${upper.at(-1)} us`;
  };
  host.setAttribute(
    'aria-label',
    total === 0
      ? 'no cycles yet'
      : `${count(total)} cycles; half of them ${edgeOf(0.5)}, 99 % ${edgeOf(0.99)}, all ${edgeOf(1)}`,
  );
  setText(host.nextElementSibling, host.getAttribute('aria-label'));
}

/** The button that records a run, and the state of the recording. */
export class Recording {
  constructor(connection) {
    this.connection = connection;
    byId('record').addEventListener('click', () => this.#switch());
  }

  /** `controller`: the controller's status; null if there is none. */
  show(controller) {
    const recording = controller?.recording;
    this.isOn = recording?.on ?? false;
    setText(byId('record'), this.isOn ? 'End recording' : 'Record');
    if (!this.answer) setTextWithPath(byId('recording'), recordingText(recording));
    byId('recording').title = recording?.run ?? '';
    byId('recording').dataset.state = recording?.failure ? 'failed' : this.isOn ? 'on' : 'off';
  }

  async #switch() {
    const answer = await this.connection.ask({ do: 'command', command: { do: 'record', on: !this.isOn } });
    if (answer.ok) return;
    this.answer = answer.error;
    setTextWithPath(byId('recording'), answer.error);
    setTimeout(() => (this.answer = undefined), 5000);
  }
}

/** Returns "recording runs/run_...: 120,000 rows, 25.1 MB". */
function recordingText(recording) {
  if (!recording?.run) return 'no recording';
  const lost = recording.rows_lost ? `, ${count(recording.rows_lost)} lost` : '';
  const end = recording.failure ? `; it ended: ${recording.failure}` : '';
  return `${recording.on ? 'recording' : 'recorded'} ${recording.run}: ${count(recording.rows)} rows, ${quantity(
    recording.bytes / 1e6,
    'MB',
    1,
  )}${lost}${end}`;
}
