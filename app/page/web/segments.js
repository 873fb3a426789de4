// The segments of an axis's setpoint: the fields of each one below its number and shape; one can be added or removed.

import { element } from './dom.js';
import { valueOfText, wordOfToml } from './setting_field.js';

export class Segments {
  #keys = '';

  /**
   * `makeField(about)`: a setting field of this axis; `set(list)`: sets the whole list and tells the answer; null: the
   * segments are others by now. `ask()`: the settings in force, as show() gets them.
   */
  constructor(axis, name, makeField, set, ask) {
    this.start = `axis[${axis}].control.`;
    this.name = name;
    this.makeField = makeField;
    this.set = set;
    this.ask = ask;
    this.root = element('div');
  }

  /** True if a key is one of these segments. */
  owns(key) {
    return key.startsWith(`${this.start}setpoint[`);
  }

  /** `values`: key -> TOML of all settings in force. Returns the new fields, or null where the segments are the same. */
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
        title: 'A copy of the last one',
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

  /** Of the list as it is now: a key that was set a moment ago is not lost. */
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
      const broken = label.replaceAll('_', '_\u200b'); // where a narrow column may break it
      return this.makeField({ key: path, label: broken, long: `Segment ${title}, ${label}`, unit: unitOfKey(label) });
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

/** The segments as the list that the key `setpoint` takes. */
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

/** The unit at the end of a key: low_um, frequency_Hz, ki_per_s. */
function unitOfKey(key) {
  const found = /_(um_per_s2|um_per_s|um_per_um|per_s|um|Hz|ms|us|s|percent|deg|cycles)$/.exec(key)?.[1] ?? '';
  return { percent: '%', per_s: '1/s', um_per_s: 'um/s', um_per_s2: 'um/s^2', um_per_um: 'um/um' }[found] ?? found;
}
