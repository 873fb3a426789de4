// One setting: its value in force, an input for a new one, and the controller's answer beside it.

import { element, setText } from './dom.js';

let nextId = 0;

/** TOML of a value as a user types it: 'inverse+pi' without its quotes. */
export function wordOfToml(toml) {
  return /^'.*'$|^".*"$/s.test(toml) ? toml.slice(1, -1) : toml;
}

/** What a user types as a value of JSON: a number, true, false, a list, or else a word. */
export function valueOfText(text) {
  const bare = text.trim().replace(/^(['"])(.*)\1$/s, '$2');
  try {
    return JSON.parse(text.trim().replaceAll("'", '"').replace(/^\+/, ''));
  } catch {
    return bare;
  }
}

/** `apply(value)` gives the answer of the controller. */
export function settingField(key, { label, long = label, unit, choices, axis }, apply) {
  const id = `setting-${nextId++}`;
  const input = choices ? element('select', { id }, ...choices.map((value) => element('option', { value, text: value })))
    : element('input', { id, type: 'text', spellcheck: 'false', autocomplete: 'off' });
  input.setAttribute('aria-label', `${long}${unit && unit !== '1' ? `, ${unit}` : ''}, axis ${axis}`);
  input.dataset.key = key;
  const answer = element('p', { class: 'answer', role: 'status' });
  const button = element('button', { type: 'button', text: 'Apply', 'aria-label': `Apply ${long}, axis ${axis}` });
  const root = element('div', { class: 'field' }, element('label', { for: id, text: label, title: `${long}: ${key}` }),
    element('span', { class: 'entry' }, input, element('span', { class: 'unit', text: unit ?? '' })), button, answer);
  let inForce = '';
  let isTyped = false;
  const send = async () => {
    setText(answer, '...');
    const told = await apply(valueOfText(input.value));
    answer.className = `answer ${told.ok ? 'done' : 'refused'}`;
    setText(answer, told.ok ? `${input.value} is in force` : told.error ?? 'refused');
    if (told.ok) isTyped = false;
  };
  input.addEventListener('input', () => (isTyped = input.value !== inForce));
  input.addEventListener('keydown', (event) => {
    if (event.key !== 'Enter') return;
    event.preventDefault();
    send();
  });
  button.addEventListener('click', send);
  return {
    key, root,
    typed: () => input.value,
    reset: () => (isTyped = false),
    /** The value in force as TOML, undefined where there is none. What is being typed stays. */
    show(toml, isUnsaved) {
      inForce = toml === undefined ? '' : wordOfToml(toml);
      if (!isTyped && input.value !== inForce && document.activeElement !== input) input.value = inForce;
      if (!choices) input.placeholder = inForce || 'none';
      root.classList.toggle('changed', isUnsaved);
    },
  };
}
