// The last events: those of the server, and those of the page itself.

import { byId, element } from './dom.js';
import { quantity } from './format.js';

const most = 200;
const signs = { info: '\u2139', warning: '\u26a0', error: '\u25b2' };

export class EventList {
  #seen = new Set();
  ownName = ''; // "page 3": how the server calls this page

  /** `run` tells the runs of the controller apart; `mayRepeat`: the server sends its last events after a connection. */
  add({ time_s, axis, level, text, remedy, by }, run, mayRepeat) {
    const key = `${run} ${time_s} ${axis} ${by} ${text}`;
    if (mayRepeat && this.#seen.has(key)) return;
    this.#seen.add(key);
    if (this.#seen.size > 2 * most) this.#seen = new Set([...this.#seen].slice(-most));
    const who = by ? `${by === this.ownName ? 'this page' : by}: ` : '';
    this.#show(quantity(time_s, 's'), level, remedy ? `${text}. Remedy: ${remedy}.` : `${who}${text}`);
  }

  /** What the page itself has seen, with the time of day. */
  note(level, text) {
    this.#show(new Date().toLocaleTimeString('en-GB'), level, text);
  }

  #show(when, level, text) {
    const list = byId('events');
    list.prepend(
      element(
        'li',
        { class: level },
        element('span', { class: 'when', text: when }),
        element('span', { class: 'level', text: `${signs[level] ?? ''} ${level}` }),
        element('span', { text }),
      ),
    );
    while (list.childElementCount > most) list.lastElementChild.remove();
  }
}
