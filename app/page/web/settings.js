// The fields of settings: the value in force, an input for a new value, and the controller's answer; and the segments
// of an axis's setpoint, each with its fields below its number and shape.

import { answerPlace, element, setText } from './dom.js';

const longest = 12; // maximum characters of a value that shares its row
let nextId = 0;

/** Converts a TOML value to the form that a user types: 'inverse+pi' without quotes. */
function wordOfToml(toml) {
  return /^'.*'$|^".*"$/s.test(toml) ? toml.slice(1, -1) : toml;
}

/** Converts typed text or TOML to a JSON value: a number, true, false, a list, or otherwise a word. */
export function valueOfText(text) {
  const bare = text.trim().replace(/^(['"])(.*)\1$/s, '$2');
  try {
    return JSON.parse(text.trim().replaceAll("'", '"').replace(/^\+/, ''));
  } catch {
    return bare;
  }
}

/** Returns the problem if a typed number has a decimal comma; "" if it has none. */
export function commaTrouble(text) {
  const found = /^([+-]?\d*),(\d+(?:[eE][+-]?\d+)?)$/.exec(text.trim());
  return found ? `decimal point, not comma: ${found[1]}.${found[2]}` : '';
}

/** Returns a key as a label that may wrap in a narrow column. */
const broken = (key) => key.replaceAll('_', '_\u200b');

/** Returns the documents' description of a key, without markup. */
const plain = (text) => (text ?? '').replace(/\[([^\]]*)\]\([^)]*\)/g, '$1').replaceAll('`', '');

/**
 * `about`: the server's description of the key, {unit, choices, range, meaning}, and {label, long, axis, absent (the
 * word for a missing value)}. `apply(value)` returns the controller's answer.
 */
export function settingField(key, about, apply) {
  const { label, long, unit, choices, range, meaning, axis, absent = 'none' } = about;
  const id = `setting-${nextId++}`;
  const input = choices
    ? element(
        'select',
        { id },
        ...choices.map((value) => element('option', { value, text: value })),
        element('option', { value: '', text: absent, hidden: true }),
      )
    : element('input', { id, type: 'text', spellcheck: 'false', autocomplete: 'off' });
  input.setAttribute('aria-label', `${long}${unit ? `, ${unit}` : ''}, axis ${axis}`);
  input.dataset.key = key;
  const answer = answerPlace();
  const button = element('button', { type: 'button', text: 'Apply', 'aria-label': `Apply ${long}, axis ${axis}` });
  const unitText = element('span', { class: 'unit', text: unit ?? '' });
  const root = element(
    'div',
    { class: 'field' },
    element('label', { for: id, text: broken(label), title: [key, plain(meaning), range].filter(Boolean).join('; ') }),
    element('span', { class: 'entry' }, input, unitText),
    button,
    answer,
  );
  let inForce = '';
  let isTyped = false;
  let acceptedAs = null; // the value in force to which the answer belongs; null until it is known

  const say = (state, text) => {
    answer.className = `answer ${state}`;
    setText(answer, text);
  };
  const send = async () => {
    say('', '...');
    const trouble = commaTrouble(input.value);
    const result = trouble ? { error: trouble } : await apply(valueOfText(input.value));
    say(result.ok ? 'done' : 'refused', result.ok ? `${input.value} is active` : (result.error ?? 'refused'));
    if (result.ok) {
      isTyped = false;
      inForce = input.value; // until the settings arrive
    }
    acceptedAs = null;
  };
  const restore = () => {
    isTyped = false;
    input.value = inForce;
    say('', '');
  };
  input.addEventListener('input', () => {
    isTyped = input.value !== inForce;
    if (!isTyped) say('', '');
  });
  input.addEventListener('leave', restore);
  input.addEventListener('keydown', (event) => {
    if (event.key !== 'Enter') return;
    event.preventDefault();
    send();
  });
  button.addEventListener('click', send);

  /** Removes an answer when its subject is gone: the refused text, or the accepted value that was in force. */
  const forgetOldAnswer = () => {
    if (answer.classList.contains('refused')) return void (!isTyped && say('', ''));
    if (!answer.classList.contains('done')) return;
    if (acceptedAs !== null && acceptedAs !== inForce) say('', '');
    acceptedAs = inForce;
  };
  return {
    key,
    root,
    typed: () => input.value,
    reset: () => (isTyped = false),
    /** Shows the value in force, as TOML; undefined if there is none. Keeps text that is being typed. */
    show(toml, isUnsaved) {
      inForce = toml === undefined ? '' : wordOfToml(toml);
      if (!isTyped && input.value !== inForce && document.activeElement !== input) input.value = inForce;
      if (!choices) input.placeholder = inForce || absent;
      unitText.style.visibility = toml === undefined ? 'hidden' : '';
      root.classList.toggle('changed', isUnsaved);
      root.classList.toggle('wide', inForce.length > longest);
      forgetOldAnswer();
    },
  };
}

/** The segments of a setpoint; one can be added or removed. */
export class Segments {
  #keys = '';

  /**
   * `makeField(about)`: returns a setting field of this axis, {path, label, long}; `set(list)`: sets the whole list and
   * shows the answer; null: the segments have changed. `ask()`: returns the settings in force, in the form for show().
   */
  constructor(axis, name, makeField, set, ask) {
    this.start = `axis[${axis}].control.`;
    this.name = name;
    this.makeField = makeField;
    this.set = set;
    this.ask = ask;
    this.root = element('div');
  }

  /** Returns true if a key belongs to one of these segments. */
  owns(key) {
    return key.startsWith(`${this.start}setpoint[`);
  }

  /** `values`: key -> TOML of all settings in force. Returns the new fields, or null if the segments are the same. */
  show(values) {
    const { keys, list, shape } = this.#read(values);
    if (shape === this.#keys) return null;
    this.#keys = shape;
    const fields = [];
    this.root.replaceChildren(
      ...list.map((segment, at) => this.#segment(segment, at, keys, list.length, fields)),
      element('button', {
        type: 'button',
        text: 'Add a segment',
        title: 'A copy of the last segment',
        'aria-label': `Add a segment, axis ${this.name}`,
        onclick: () => this.#change((now) => [...now, now.at(-1)]),
      }),
    );
    return fields;
  }

  #read(values) {
    const keys = [...values.keys()].filter((key) => this.owns(key));
    const list = listOf(keys, values, this.start);
    return { keys, list, shape: JSON.stringify([keys, list.map(({ kind }) => kind)]) };
  }

  /** Starts from the present list, so that a key that was just set is not lost. */
  async #change(changed) {
    const { list, shape } = this.#read(await this.ask());
    this.set(shape === this.#keys ? changed(list) : null);
  }

  #segment({ kind }, at, keys, segments, fields) {
    const own = keys.filter((key) => key.startsWith(`${this.start}setpoint[${at}].`));
    const title = `${at + 1}: ${kind ?? 'segment'}`;
    const made = own.map((key) => {
      const path = key.slice(this.start.length);
      const label = path.slice(path.indexOf('.') + 1);
      return this.makeField({ path, label, long: `Segment ${title}, ${label}` });
    });
    fields.push(...made);
    const remove = element('button', {
      type: 'button',
      text: 'Remove',
      'aria-label': `Remove segment ${title}, axis ${this.name}`,
      onclick: () => this.#change((now) => now.filter((_, other) => other !== at)),
    });
    remove.disabled = segments === 1;
    return element(
      'section',
      { class: 'segment', 'aria-label': `Segment ${title}, axis ${this.name}` },
      element('div', { class: 'tools' }, element('h4', { text: title }), remove),
      element('div', { class: 'fields' }, ...made.map(({ root }) => root)),
    );
  }
}

/** Returns the segments as the list for the key `setpoint`. */
function listOf(keys, values, start) {
  const list = [];
  for (const key of keys) {
    const [, at, path] = /^setpoint\[(\d+)\]\.(.*)$/.exec(key.slice(start.length));
    let table = (list[at] ??= {});
    const parts = path.split('.');
    for (const part of parts.slice(0, -1)) table = table[part] ??= {};
    const toml = values.get(key);
    table[parts.at(-1)] = /^['"]/.test(toml) ? wordOfToml(toml) : valueOfText(toml);
  }
  return list;
}
