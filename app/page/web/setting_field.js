// One setting: its value in force, an input for a new one, and the controller's answer beside it.

import { element, setText } from './dom.js';

const longest = 12; // characters of a value that shares its row
let nextId = 0;

/** TOML of a value as a user types it: 'inverse+pi' without its quotes. */
export function wordOfToml(toml) {
  return /^'.*'$|^".*"$/s.test(toml) ? toml.slice(1, -1) : toml;
}

/** What a user types, or TOML, as a value of JSON: a number, true, false, a list, or else a word. */
export function valueOfText(text) {
  const bare = text.trim().replace(/^(['"])(.*)\1$/s, '$2');
  try {
    return JSON.parse(text.trim().replaceAll("'", '"').replace(/^\+/, ''));
  } catch {
    return bare;
  }
}

/** Why a number that was typed is none of the controller's: "" where nothing is wrong. */
export function commaTrouble(text) {
  const found = /^([+-]?\d*),(\d+(?:[eE][+-]?\d+)?)$/.exec(text.trim());
  return found ? `decimal point, not comma: ${found[1]}.${found[2]}` : '';
}

/**
 * `about`: {label, long, unit, choices, axis, absent (the word where there is no value)}. `apply(value)` gives the
 * answer of the controller.
 */
export function settingField(key, about, apply) {
  const { label, long = label, unit, choices, axis, absent = 'none' } = about;
  const id = `setting-${nextId++}`;
  const input = choices
    ? element(
        'select',
        { id },
        ...choices.map((value) => element('option', { value, text: value })),
        element('option', { value: '', text: absent, hidden: true }),
      )
    : element('input', { id, type: 'text', spellcheck: 'false', autocomplete: 'off' });
  input.setAttribute('aria-label', `${long}${unit && unit !== '1' ? `, ${unit}` : ''}, axis ${axis}`);
  input.dataset.key = key;
  const answer = element('p', { class: 'answer', role: 'status' });
  const button = element('button', { type: 'button', text: 'Apply', 'aria-label': `Apply ${long}, axis ${axis}` });
  const unitText = element('span', { class: 'unit', text: unit ?? '' });
  const root = element(
    'div',
    { class: 'field' },
    element('label', { for: id, text: label, title: `${long}: ${key}` }),
    element('span', { class: 'entry' }, input, unitText),
    button,
    answer,
  );
  let inForce = '';
  let isTyped = false;
  let acceptedAs = null; // the value in force that the answer speaks of; null until it is known

  const say = (state, text) => {
    answer.className = `answer ${state}`;
    setText(answer, text);
  };
  const send = async () => {
    say('', '...');
    const trouble = commaTrouble(input.value);
    const told = trouble ? { error: trouble } : await apply(valueOfText(input.value));
    say(told.ok ? 'done' : 'refused', told.ok ? `${input.value} is in force` : (told.error ?? 'refused'));
    if (told.ok) {
      isTyped = false;
      inForce = input.value; // until the settings come
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

  /** An answer does not outlive what it speaks of: a refused entry, or a value that was in force. */
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
    /** The value in force as TOML, undefined where there is none. What is being typed stays. */
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
