// Commands and settings of the axes, applied while the controller runs.

import { answerPlace, byId, element, openDialog, setText, tell } from './dom.js';
import { Segments, commaTrouble, settingField, valueOfText } from './settings.js';

const settingsEvery_ms = 3000; // another program may change them, too
const shownFirst = ['structure', 'kp', 'ki_per_s', 'measurement_filter_Hz']; // the other keys are in folded groups

export class Steering {
  #fields = []; // fields of all axes: {key, show(toml, isUnsaved)}
  #asked = false;
  #isStale = false; // true: the settings may have changed after they were requested
  #units = new Map(); // by key
  #keys = ''; // keys that have fields

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
    this.groups = []; // groups that are off if no key begins with `start`: {start, title, summary}
    this.cards = greeting.axes.map(({ name }, axis) => ({ name, axis, first: fields(), folded: element('div') }));
    this.#keys = '';
    byId('steering-axes').replaceChildren(...this.cards.map((card) => this.#card(card)));
    this.refresh();
  }

  /** Requests the settings in force and shows them. */
  async refresh() {
    this.#isStale = this.#asked;
    if (this.#asked || !this.connection.isOpen) return;
    this.#asked = true;
    const answer = await this.connection.ask({ do: 'settings' });
    this.#asked = false;
    if (this.#isStale) return this.refresh();
    if (answer.ok) this.#show(answer);
  }

  #show({ settings, keys, unsaved, undo, undo_save: hasKept }) {
    const values = valuesOf({ settings });
    this.#units = new Map([...keys, ...settings].map(({ key, unit }) => [key, unit]));
    this.#makeFields(keys);
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
        ? 'The file has all active settings.'
        : `Active, but not in the file: ${wordsOfChanges(unsaved)}`,
    );
  }

  /** Creates a field for each key that can change, in the order of the configuration; a group for each table. */
  #makeFields(keys) {
    const shape = JSON.stringify(keys);
    if (shape === this.#keys || !this.cards) return;
    this.#keys = shape;
    this.#fields = this.#fields.filter(({ key }) => this.segments.some((segments) => segments.owns(key)));
    this.groups = [];
    for (const { name, axis, first, folded } of this.cards) {
      const start = `axis[${axis}].control.`;
      const tables = new Map([['', []]]);
      for (const about of keys) {
        const path = about.key.slice(start.length);
        if (!about.key.startsWith(start) || path.startsWith('setpoint[')) continue;
        const dot = path.lastIndexOf('.');
        const table = path.slice(0, Math.max(dot, 0));
        if (!tables.has(table)) tables.set(table, []);
        const own = { ...about, path, label: path.slice(dot + 1), long: path, absent: table ? 'off' : 'none' };
        tables.get(table).push(this.#settingField(axis, name, own));
      }
      const isFirst = ({ key }) => shownFirst.includes(key.slice(start.length));
      const [plain, ...others] = [...tables].map(([table, made]) => ({ table, made }));
      first.replaceChildren(...plain.made.filter(isFirst).map(({ root }) => root));
      folded.replaceChildren(
        ...others.map(({ table, made }) => this.#tableGroup(name, start, table, made)),
        group('Other keys', fields(...plain.made.filter((field) => !isFirst(field)).map(({ root }) => root))),
      );
    }
  }

  #card({ name, axis, first, folded }) {
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
      tell(answer, this.#withLimits(result, axis), `moving to ${position_um} um`);
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
        const changed = { error: 'the segments changed in the meantime; check them again' };
        const answer = list ? await this.#set(name, 'setpoint', list) : changed;
        if (!list) this.refresh();
        tell(segmentsAnswer, answer, 'active: the reference restarts');
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
      first,
      folded,
      group('Setpoint segments', segments.root, segmentsAnswer),
    );
  }

  /** Creates the group of a table's keys. A missing table is off; the title of its group shows this. */
  #tableGroup(name, start, table, made) {
    const title = (table[0].toUpperCase() + table.slice(1)).replaceAll('_', ' ');
    const grouped = group(title, fields(...made.map(({ root }) => root), this.#wholeTable(name, table, made)));
    this.groups.push({ start: `${start}${table}.`, title, summary: grouped.querySelector('summary') });
    return grouped;
  }

  /** Adds the limits in force to an answer that refuses a position out of range; returns other answers unchanged. */
  #withLimits(answer, axis) {
    if (!Object.values(answer.answer?.refusals ?? {}).includes('position_out_of_range')) return answer;
    const value = (key) => this.values?.get(`axis[${axis}].control.${key}`) ?? '?';
    return { ...answer, error: `${answer.error} (${value('position_min_um')}..${value('position_max_um')} um)` };
  }

  #settingField(axis, name, about) {
    const key = `axis[${axis}].control.${about.path}`;
    const field = settingField(key, { ...about, unit: this.#units.get(key), axis: name }, (value) =>
      this.#set(name, about.path, value),
    );
    this.#fields.push(field);
    return field;
  }

  /** Sets all values of a table together, because a missing table can't get a single key. */
  #wholeTable(name, table, made) {
    const answer = answerPlace();
    const apply = async () => {
      const given = made.filter(({ typed }) => typed() !== '');
      const trouble = given.map(({ typed }) => commaTrouble(typed())).find(Boolean);
      if (trouble) return tell(answer, { error: trouble });
      const value = Object.fromEntries(given.map(({ key, typed }) => [key.split('.').at(-1), valueOfText(typed())]));
      const result = await this.#set(name, table, value);
      if (result.ok) made.forEach((field) => field.reset());
      tell(answer, result, 'in force');
    };
    return element(
      'div',
      { class: 'field' },
      element('button', {
        type: 'button',
        text: 'Apply all',
        'aria-label': `Apply all of ${table}, axis ${name}`,
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
    tell(byId('settings-answer'), answer, words || 'nothing changed');
    this.refresh();
  }
}

/** Returns the settings in an answer, key -> TOML; undefined if it has none. */
const valuesOf = ({ settings }) => settings && new Map(settings.map(({ key, value }) => [key, value]));

const wordsOfChanges = (changes) =>
  changes.map(({ key, from, to }) => `${key}: ${from || 'none'} \u2192 ${to || 'none'}`).join('; ');

const fields = (...children) => element('div', { class: 'fields' }, ...children);

const group = (title, ...children) => element('details', {}, element('summary', { text: title }), ...children);

const waysToSave = {
  save: {
    title: 'Save to the configuration file',
    text: (kept) =>
      'These lines are written to the file. Its comments and all other lines stay. ' +
      `The present file is kept as ${kept}; Undo save restores it.`,
    done: (kept) => `the file is written; the previous one is ${kept}`,
  },
  undo_save: {
    title: 'Undo save',
    text: (kept) =>
      `These lines are written to the file: it becomes ${kept} again, and the controller applies it. ` +
      'Unsaved settings are lost. ' +
      `The present file is kept as ${kept}; a second Undo save restores it.`,
    done: (kept) => `the previous file is active again; the replaced one is ${kept}`,
  },
};

/** The dialogs Save and Undo save: both first show the changes of the configuration file. */
class SaveDialog {
  /** Calls `onWritten(answer, words)` when the file was written. */
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
      this.onWritten({ error: `the previous file is restored, but the controller did not apply it: ${trouble}` });
    else this.onWritten(answer, waysToSave[this.way].done(kept));
  }
}
