// Steering and settings of the axes, applied while the controller runs.

import { answerPlace, byId, element, openDialog, setText, tell } from './dom.js';
import { Segments, commaTrouble, settingField, valueOfText } from './settings.js';

const structures = ['average', 'inverse', 'pi', 'average+pi', 'inverse+pi'];
const settingsEvery_ms = 3000; // another program may change them too

const tuning = [
  { key: 'structure', label: 'Structure', choices: structures },
  { key: 'kp', label: 'Gain kp', long: 'Proportional gain kp', unit: 'um/um' },
  { key: 'ki_per_s', label: 'Gain ki', long: 'Integral gain ki', unit: '1/s' },
  { key: 'measurement_filter_Hz', label: 'Filter', long: 'Measurement filter', unit: 'Hz' },
];
const notch = [
  { key: 'notch.frequency_Hz', label: 'Frequency', long: 'Notch frequency', unit: 'Hz' },
  { key: 'notch.depth', label: 'Depth', long: 'Notch depth', unit: '1' },
  { key: 'notch.width', label: 'Width', long: 'Notch width', unit: '1' },
];
const learning = [
  { key: 'learning.correction_max_um', label: 'Largest correction', unit: 'um' },
  { key: 'learning.rate', label: 'Rate', long: 'Learning rate', unit: '1' },
  { key: 'learning.forget_percent', label: 'Forgotten', long: 'Forgotten in a period', unit: '%' },
  { key: 'learning.resonance_percent', label: 'Resonance +-', long: 'Resonance uncertain by', unit: '%' },
  { key: 'learning.frozen', label: 'Frozen', long: 'Learning frozen', choices: ['false', 'true'] },
];

export class Steering {
  #fields = []; // of all axes: {key, show(toml, isUnsaved)}
  #asked = false;
  #isStale = false; // what was asked for may have changed since

  constructor(connection, access) {
    this.connection = connection;
    this.access = access;
    byId('undo').addEventListener('click', () => this.#settingsCommand({ do: 'undo' }));
    byId('reload').addEventListener('click', () => this.#settingsCommand({ do: 'reload' }));
    new SaveDialog(connection, (answer, words) => {
      tell(byId('settings-answer'), answer, words);
      this.refresh();
    });
    setInterval(() => !document.hidden && !byId('steering').hidden && this.refresh(), settingsEvery_ms);
  }

  begin(greeting) {
    this.#fields = [];
    this.segments = []; // per axis
    this.groups = []; // that are off where no key begins with their start: {start, title, summary}
    byId('steering-axes').replaceChildren(...greeting.axes.map((axis, at) => this.#card(axis, at)));
    this.refresh();
  }

  /** Asks for the settings in force and shows them. */
  async refresh() {
    this.#isStale = this.#asked;
    if (this.#asked || !this.connection.isOpen) return;
    this.#asked = true;
    const answer = await this.connection.ask({ do: 'settings' });
    this.#asked = false;
    if (this.#isStale) return this.refresh();
    if (answer.ok) this.#show(answer);
  }

  #show({ settings, unsaved, undo, undo_save: hasKept }) {
    const values = valuesOf({ settings });
    const changed = new Set(unsaved.map(({ key }) => key));
    this.values = values;
    for (const segments of this.segments ?? []) this.#showSegments(segments, values);
    for (const field of this.#fields) field.show(values.get(field.key), changed.has(field.key));
    for (const { start, title, summary } of this.groups ?? [])
      setText(summary, [...values.keys()].some((key) => key.startsWith(start)) ? title : `${title}: off`);
    setText(byId('undo'), `Undo (${undo})`);
    byId('undo').disabled = undo === 0;
    byId('save').disabled = unsaved.length === 0;
    byId('undo-save').disabled = !hasKept;
    setText(
      byId('unsaved'),
      unsaved.length === 0
        ? 'The file has all settings in force.'
        : `In force, not in the file: ${wordsOfChanges(unsaved)}`,
    );
  }

  #card({ name }, axis) {
    const answer = answerPlace();
    const act = (command) => async () =>
      tell(answer, await this.#command({ axis: name, ...command }), `${command.do} is done`);
    const button = (text, command) =>
      element('button', { type: 'button', text, 'aria-label': `${text} axis ${name}`, onclick: act(command) });
    const position = element('input', {
      type: 'text',
      inputmode: 'decimal',
      'aria-label': `Go to position of axis ${name}, um`,
    });
    const goTo = async () => {
      const position_um = Number(position.value);
      const isNone = position.value.trim() === '' || Number.isNaN(position_um);
      const trouble = commaTrouble(position.value) || (isNone ? `"${position.value}" is not a number` : '');
      if (trouble) return tell(answer, { error: trouble });
      const result = await this.#command({ do: 'go_to', axis: name, position_um });
      tell(answer, this.#withLimits(result, axis), `goes to ${position_um} um`);
    };
    position.addEventListener('keydown', ({ key }) => key === 'Enter' && goTo());
    position.addEventListener('leave', () => {
      position.value = '';
      tell(answer, { ok: true }, '');
    });
    const segmentsAnswer = answerPlace();
    const segments = new Segments(
      axis,
      name,
      (about) => this.#settingField(axis, name, about),
      async (list) => {
        const changed = { error: 'the segments have changed meanwhile: look again' };
        const answer = list ? await this.#set(name, 'setpoint', list) : changed;
        if (!list) this.refresh();
        tell(segmentsAnswer, answer, 'in force: the reference begins anew');
      },
      async () => valuesOf(await this.connection.ask({ do: 'settings' })) ?? this.values,
    );
    this.segments.push(segments);
    return element(
      'section',
      { class: 'axis-card', 'aria-label': `Axis ${name}` },
      element('h3', { text: `Axis ${name}` }),
      element(
        'div',
        { class: 'tools' },
        element('span', { class: 'entry' }, position, ' um '),
        element('button', { type: 'button', text: 'Go to', 'aria-label': `Go to, axis ${name}`, onclick: goTo }),
        button('Resume', { do: 'resume' }),
        button('Enable', { do: 'enable' }),
        button('Disable', { do: 'disable' }),
        button('Clear fault', { do: 'clear' }),
        button('Revert learnt', { do: 'revert' }),
      ),
      answer,
      element('div', { class: 'fields' }, ...tuning.map((about) => this.#field(axis, name, about))),
      this.#optionalGroup(axis, 'Notch', 'notch', [
        ...notch.map((about) => this.#field(axis, name, { ...about, absent: 'off' })),
        this.#wholeNotch(axis, name),
      ]),
      this.#optionalGroup(
        axis,
        'Learning',
        'learning',
        learning.map((about) => this.#field(axis, name, { ...about, absent: 'off' })),
      ),
      group('Setpoint segments', segments.root, segmentsAnswer),
      group('Any other key', element('div', { class: 'fields' }, this.#anyKey(name))),
    );
  }

  /** A table of settings that may be absent as a whole: it is off then, and its title says so. */
  #optionalGroup(axis, title, table, children) {
    const made = group(title, element('div', { class: 'fields' }, ...children));
    this.groups.push({ start: `axis[${axis}].control.${table}.`, title, summary: made.querySelector('summary') });
    return made;
  }

  /** The refusal of a position, with the limits in force beside the names of their keys. */
  #withLimits(answer, axis) {
    const value = (key) => this.values?.get(`axis[${axis}].control.${key}`) ?? '?';
    const limits = `(${value('position_min_um')}..${value('position_max_um')} um)`;
    return answer.ok
      ? answer
      : { ...answer, error: answer.error.replace('position_min_um..position_max_um', `$& ${limits}`) };
  }

  #field(axis, name, about) {
    return this.#settingField(axis, name, about).root;
  }

  #settingField(axis, name, about) {
    const field = settingField(`axis[${axis}].control.${about.key}`, { ...about, axis: name }, (value) =>
      this.#set(name, about.key, value),
    );
    this.#fields.push(field);
    return field;
  }

  /** All three values at once: a notch that is not there yet cannot get one key alone. */
  #wholeNotch(axis, name) {
    const answer = answerPlace();
    const apply = async () => {
      const own = this.#fields.filter(({ key }) => key.startsWith(`axis[${axis}].control.notch.`));
      const trouble = own.map(({ typed }) => commaTrouble(typed())).find(Boolean);
      if (trouble) return tell(answer, { error: trouble });
      const value = Object.fromEntries(own.map(({ key, typed }) => [key.split('.').at(-1), valueOfText(typed())]));
      const result = await this.#set(name, 'notch', value);
      if (result.ok) own.forEach((field) => field.reset());
      tell(answer, result, 'in force');
    };
    return element(
      'div',
      { class: 'field' },
      element('button', { type: 'button', text: 'Apply the three together', onclick: apply }),
      answer,
    );
  }

  #anyKey(name) {
    const key = element('input', {
      type: 'text',
      'aria-label': `Key of axis.control, axis ${name}`,
      placeholder: 'key, as deadband_um',
      spellcheck: 'false',
    });
    const value = element('input', {
      type: 'text',
      'aria-label': `Value of the key, axis ${name}`,
      placeholder: 'value',
      spellcheck: 'false',
    });
    const answer = answerPlace();
    const apply = async () => {
      const trouble = commaTrouble(value.value);
      if (trouble) return tell(answer, { error: trouble });
      tell(answer, await this.#set(name, key.value.trim(), valueOfText(value.value)), 'in force');
    };
    for (const input of [key, value]) input.addEventListener('keydown', (event) => event.key === 'Enter' && apply());
    return element(
      'div',
      { class: 'field wide' },
      key,
      value,
      element('span', { text: '' }),
      element('button', {
        type: 'button',
        text: 'Apply',
        'aria-label': `Apply the key, axis ${name}`,
        onclick: apply,
      }),
      answer,
    );
  }

  #showSegments(segments, values) {
    const before = this.#fields;
    const made = segments.show(values);
    if (made) this.#fields = [...before.filter(({ key }) => !segments.owns(key)), ...made];
  }

  #command(command) {
    return this.connection.ask({ do: 'command', command });
  }

  async #set(axis, key, value) {
    const answer = await this.#command({ do: 'set', axis, key, value });
    this.refresh();
    return answer;
  }

  async #settingsCommand(command) {
    const answer = await this.#command(command);
    const changed = answer.answer?.changed ?? [];
    const words = wordsOfChanges(changed);
    tell(byId('settings-answer'), answer, words || 'nothing has changed');
    this.refresh();
  }
}

/** Key -> TOML of the settings in an answer; undefined where it has none. */
const valuesOf = ({ settings }) => settings && new Map(settings.map(({ key, value }) => [key, value]));

const wordsOfChanges = (changes) =>
  changes.map(({ key, from, to }) => `${key}: ${from || 'none'} \u2192 ${to || 'none'}`).join('; ');

const group = (title, ...children) => element('details', {}, element('summary', { text: title }), ...children);

const waysToSave = {
  save: {
    title: 'Save to the configuration file',
    text: (kept) =>
      'The file gets these lines. Comments and everything else stay. ' +
      `The file as it is now is kept beside it as ${kept}; Undo save brings it back.`,
    done: (kept) => `the file is written; the former one is ${kept}`,
  },
  undo_save: {
    title: 'Undo save',
    text: (kept) =>
      `The file gets these lines: it becomes what ${kept} holds, and the controller takes it over. ` +
      'What was set here and not saved is lost. ' +
      `The file as it is now is kept as ${kept}: a second Undo save brings it back.`,
    done: (kept) => `the former file is in force again; what it replaced is ${kept}`,
  },
};

/** Save and Undo save: both show first what the configuration file would get. */
class SaveDialog {
  /** `onWritten(answer, words)` is called when the file is written. */
  constructor(connection, onWritten) {
    this.connection = connection;
    this.onWritten = onWritten;
    byId('save').addEventListener('click', () => this.#open('save'));
    byId('undo-save').addEventListener('click', () => this.#open('undo_save'));
    byId('save-confirm').addEventListener('click', () => this.#confirm());
  }

  async #open(way) {
    const answer = await this.connection.ask({ do: way });
    this.way = way;
    this.digest = answer.digest;
    setText(byId('save-title'), waysToSave[way].title);
    setText(byId('save-answer'), answer.ok ? '' : answer.error);
    setText(byId('save-text'), answer.ok ? waysToSave[way].text(answer.kept) : '');
    byId('save-diff').replaceChildren(
      ...(answer.diff ?? '').split('\n').map((text) =>
        element('span', {
          class: text.startsWith('+') ? 'added' : text.startsWith('-') ? 'removed' : '',
          text: `${text}\n`,
        }),
      ),
    );
    byId('save-confirm').disabled = !answer.ok || !answer.digest;
    openDialog('save-dialog');
  }

  async #confirm() {
    const answer = await this.connection.ask({ do: this.way, digest: this.digest });
    if (!answer.ok) return setText(byId('save-answer'), answer.error);
    byId('save-dialog').close();
    const { kept, not_applied: trouble } = answer;
    if (trouble)
      this.onWritten({ error: `the former file is restored, but the controller has not taken it over: ${trouble}` });
    else this.onWritten(answer, waysToSave[this.way].done(kept));
  }
}
