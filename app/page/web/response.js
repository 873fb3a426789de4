// The panel Response: step response of a capture, spectrum of the error, Bode plot of the loop.

import { CurveChart } from './curve_chart.js';
import { byId, fillTable, setOptions, setText } from './dom.js';
import { compact, plain, quantity } from './format.js';
import { spectrum } from './spectrum.js';
import { onThemeChange } from './theme.js';
import { rowAt } from './trace.js';

const newest_s = 8;
const every_ms = 1000;

export class ResponseView {
  constructor(connection, streams, captures) {
    this.connection = connection;
    this.streams = streams;
    this.captures = captures;
    captures.changed = () => this.#listSources();
    this.spectrumChart = new CurveChart(byId('spectrum-chart'), { title: 'Spectrum of the error', yLog: true });
    this.magnitude = new CurveChart(byId('bode-chart'), { title: 'Bode: magnitude, dB', steps: [5, 10, 20, 40] });
    this.phase = new CurveChart(byId('phase-chart'), {
      title: 'Bode: phase of the loop, deg',
      steps: [15, 30, 45, 90, 180],
    });
    for (const id of ['response-axis', 'response-source', 'spectrum-kind'])
      byId(id).addEventListener('change', () => this.refresh());
    byId('response-axis').addEventListener('change', () => this.#askBode());
    byId('bode-update').addEventListener('click', () => this.#askBode());
    setInterval(() => this.#isSeen && byId('response-source').value === 'live' && this.#showSpectrum(), every_ms);
    onThemeChange(() => [this.spectrumChart, this.magnitude, this.phase].forEach((chart) => chart.recolour()));
  }

  get #isSeen() {
    return !document.hidden && !byId('response').hidden;
  }

  begin(greeting) {
    this.greeting = greeting;
    setOptions(
      byId('response-axis'),
      greeting.axes.map(({ name }, at) => [at, name]),
    );
  }

  refresh() {
    if (!this.#isSeen || !this.greeting) return;
    this.#showSpectrum();
    this.#showStep();
    if (!this.bodeAxis) this.#askBode();
  }

  #listSources() {
    setOptions(byId('response-source'), [
      ['live', `live, the newest ${newest_s} s`],
      ...this.captures.captures.map((one) => [one.number, `capture #${one.number}: ${one.on}, axis ${one.name}`]),
    ]);
    this.refresh();
  }

  #capture() {
    return this.captures.captures.find(({ number }) => String(number) === byId('response-source').value);
  }

  /** Returns the error at equal time steps: {values, rate_Hz}, or null and the reason. */
  #error() {
    const capture = this.#capture();
    const rate_Hz = this.greeting.rate_Hz;
    if (capture) return { values: capture.columns.get('error_um').filter(Number.isFinite), rate_Hz };
    const rows = this.streams.controller?.axes[byId('response-axis').value];
    if (!rows || rows.end === rows.first) return { reason: 'There are no rows yet.' };
    const error = rows.columns.get('error_um');
    const cycle = rows.columns.get('cycle');
    const begin = rowAt(rows, rows.newest_s - newest_s);
    const values = [];
    for (let row = rows.end - 1; row >= begin; --row) {
      const at = row & rows.mask;
      if (!Number.isFinite(error[at])) break;
      if (row < rows.end - 1 && cycle[(row + 1) & rows.mask] - cycle[at] !== 1) break;
      values.push(error[at]);
    }
    if (values.length < 256)
      return { reason: 'The axis does not track, or cycles are missing in the live rows. Choose a capture as the data.' };
    return { values: Float64Array.from(values.reverse()), rate_Hz };
  }

  #showSpectrum() {
    const { values, rate_Hz, reason } = this.#error();
    const result = values && spectrum(values, rate_Hz);
    if (!result) return setText(byId('spectrum-text'), reason ?? 'There are too few rows for a spectrum.');
    const kind = byId('spectrum-kind').value;
    const unit = kind === 'density' ? 'um/sqrt(Hz)' : 'um';
    this.spectrumChart.show(result.frequency_Hz, [{ label: `error, ${unit}`, values: result[kind], colour: 0, dash: 0 }]);
    const top = result[kind].indexOf(Math.max(...result[kind]));
    setText(
      byId('spectrum-text'),
      `Largest: ${compact(result[kind][top], 3)} ${unit} at ${compact(result.frequency_Hz[top], 4)} Hz. ` +
        `Hann window, segments of ${result.size} cycles: ${result.segments}, ${compact(rate_Hz / result.size, 3)} Hz apart.`,
    );
  }

  #showStep() {
    const capture = this.#capture();
    const result = capture?.step;
    const table = result
      ? [
          ['Step', `${plain(result.from_um, 3)} to ${plain(result.to_um, 3)} um`],
          ['Overshoot', quantity(result.overshoot_percent, '%')],
          ['Rise time, 10 to 90 %', result.rise_s === null ? 'not reached' : quantity(1000 * result.rise_s, 'ms', 1)],
          [
            `Settling time to ${compact(result.band_um, 3)} um`,
            result.settling_s === null ? 'not settled' : quantity(1000 * result.settling_s, 'ms', 1),
          ],
          ['Steady error', quantity(result.steady_error_um, 'um')],
          ['Judged over', quantity(1000 * result.judged_s, 'ms', 1)],
        ]
      : [];
    fillTable(byId('step-rows'), table);
    setText(
      byId('step-text'),
      result
        ? ''
        : capture
          ? 'The reference of this capture does not step at its trigger.'
          : 'Capture a step of the reference (panel Capture) and choose it as the data.',
    );
  }

  async #askBode() {
    const axis = this.greeting?.axes[byId('response-axis').value]?.name;
    if (!axis) return;
    this.bodeAxis = axis;
    const answer = await this.connection.ask({ do: 'bode', axis });
    setText(byId('response-answer'), answer.ok ? '' : answer.error);
    if (!answer.ok) return setText(byId('bode-text'), '');
    this.magnitude.show(
      answer.frequency_Hz,
      [
        { label: 'loop', values: answer.loop_dB, colour: 0, dash: 0 },
        { label: 'sensitivity', values: answer.sensitivity_dB, colour: 1, dash: 1 },
        { label: 'closed loop', values: answer.closed_dB, colour: 2, dash: 2 },
      ],
      -60,
    );
    this.phase.show(answer.frequency_Hz, [{ label: 'loop', values: answer.loop_deg, colour: 0, dash: 0 }]);
    setText(byId('bode-text'), marginsInWords(axis, answer));
  }
}

function marginsInWords(
  axis,
  { gain_margin_dB: gain, phase_margin_deg: phase, crossover_Hz: crossover, peak_sensitivity: peak, stable },
) {
  const part = (value, text) => (Number.isFinite(value) ? text : null);
  const parts = [
    part(phase, `phase margin ${quantity(phase, 'deg', 0)}`),
    part(gain, `gain margin ${quantity(gain, 'dB')}`),
    part(crossover, `crossover ${quantity(crossover, 'Hz', 1)}`),
    part(peak, `sensitivity at most ${plain(peak, 2)}`),
  ].filter(Boolean);
  const start = stable === false ? 'the loop is unstable' : 'the loop';
  return parts.length
    ? `Axis ${axis}, ${start}: ${parts.join(', ')}.`
    : `Axis ${axis}: there is no feedback loop in this structure.`;
}
