// The last events of the server and of the page itself; and whether the controller runs, how it ended, and how to
// restart it.

import { byId, element, setText } from './dom.js';
import { quantity } from './format.js';

const most = 200;
const signs = { info: '\u2139', warning: '\u26a0', error: '\u25b2' };

export class EventList {
  #seen = new Set();
  ownName = ''; // "page 3": the server's name for this page

  /** `run` identifies the controller's run; `mayRepeat`: the server sends its last events after a connection. */
  add({ time_s, axis, level, text, remedy, by }, run, mayRepeat) {
    const key = `${run} ${time_s} ${axis} ${by} ${text}`;
    if (mayRepeat && this.#seen.has(key)) return;
    this.#seen.add(key);
    if (this.#seen.size > 2 * most) this.#seen = new Set([...this.#seen].slice(-most));
    const who = by ? `${by === this.ownName ? 'this page' : by}: ` : '';
    this.#show(quantity(time_s, 's'), level, remedy ? `${text}. Remedy: ${remedy}.` : `${who}${text}`);
  }

  /** Adds an event detected by the page itself, with the time of day. */
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

export class ControllerNotice {
  #startCommand = '';
  #isDemo = false;
  #stopSent = false;
  #reason = element('span'); // shows why there is no controller

  constructor(connection, access, events) {
    this.events = events;
    this.access = access;
    connection.on('hello', ({ source, start_command: command }) => {
      this.#startCommand = command ?? '';
      this.#isDemo = source === 'demo';
    });
    access.stopped = (isDone, error) => this.#tellOfStop(isDone, error);
  }

  /** Called when the controller runs. */
  found() {
    const place = byId('stream-message');
    if (place.textContent) this.events.note('info', 'the controller is connected');
    if (this.#stopSent) setText(byId('stop-message'), '');
    this.#stopSent = false;
    place.replaceChildren();
  }

  /** Called when the controller ended or the reason changed. Keeps the button, which may be pressed, and its answer. */
  lost(reason = '') {
    if (this.#stopSent) setText(byId('stop-message'), 'Stopped: the controller has ended.');
    this.events.note('warning', `no controller: ${reason}`);
    setText(this.#reason, this.#stopSent ? '' : `No controller is connected: ${reason}. `);
    const place = byId('stream-message');
    if (place.hasChildNodes()) return;
    place.append(
      this.#reason,
      'The charts keep the received data. ',
      ...(this.#isDemo
        ? this.#waysToStartAgain()
        : ['The page connects as soon as it starts: ', element('code', { text: this.#startCommand })]),
    );
  }

  #waysToStartAgain() {
    const answer = element('span', { class: 'refusal', role: 'status' });
    const start = async () => {
      setText(answer, '');
      const result = await this.access.startAgain();
      if (!result.ok) setText(answer, ` The start failed: ${result.error}`);
    };
    return [element('button', { id: 'start-again', type: 'button', text: 'Start again', onclick: start }), answer];
  }

  #tellOfStop(isDone, error) {
    const result = {
      true: 'Stopping: every axis ramps down to its safe drive and is disabled. Then the controller ends.',
      false: `Stop failed: ${error}. Run "hystcan ctl stop", or switch the amplifiers off.`,
      null: 'Stop was sent.',
    }[String(isDone)];
    setText(byId('stop-message'), result);
    if (isDone !== null) this.events.note(isDone ? 'warning' : 'error', result);
    this.#stopSent ||= isDone === true;
  }
}
