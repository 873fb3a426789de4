// The last events: those of the server, and those of the page itself.

import { byId, element } from './dom.js';
import { quantity } from './format.js';

const most = 200;
const signs = { info: '\u2139', warning: '\u26a0', error: '\u25b2' };

export class EventList {
  #seen = new Set(); // the server repeats the last events after each connection

  add({ time_s, axis, level, text, remedy }) {
    const key = `${time_s} ${axis} ${text}`;
    if (this.#seen.has(key)) return;
    this.#seen.add(key);
    if (this.#seen.size > 2 * most) this.#seen = new Set([...this.#seen].slice(-most));
    this.#show(quantity(time_s, 's'), level, remedy ? `${text}. Remedy: ${remedy}.` : text);
  }

  /** What the page itself has seen, with the time of day. */
  note(level, text) {
    this.#show(new Date().toLocaleTimeString('en-GB'), level, text);
  }

  #show(when, level, text) {
    const list = byId('events');
    list.prepend(element('li', { class: level }, element('span', { class: 'when', text: when }),
      element('span', { class: 'level', text: `${signs[level] ?? ''} ${level}` }), element('span', { text })));
    while (list.childElementCount > most) list.lastElementChild.remove();
  }
}
