// What the page says about the controller as a whole: whether it is there, how it ended, and how it begins again.

import { byId, element, setText } from './dom.js';

export class ControllerNotice {
  #startCommand = '';
  #isDemo = false;
  #stopSent = false;

  constructor(connection, access, events) {
    this.events = events;
    this.access = access;
    connection.on('hello', ({ source, start_command: command }) => {
      this.#startCommand = command ?? '';
      this.#isDemo = source === 'demo';
    });
    access.stopped = (isDone, error) => this.#tellOfStop(isDone, error);
  }

  /** The controller is there. */
  found() {
    const place = byId('stream-message');
    if (place.textContent) this.events.note('info', 'the controller is there');
    if (this.#stopSent) setText(byId('stop-message'), '');
    this.#stopSent = false;
    place.replaceChildren();
  }

  lost(reason = '') {
    if (this.#stopSent) setText(byId('stop-message'), 'Stopped: the controller has ended.');
    this.events.note('warning', `no controller: ${reason}`);
    byId('stream-message').replaceChildren(
      this.#stopSent ? '' : `There is no controller: ${reason}. `,
      'The charts keep what has come. ',
      ...(this.#isDemo
        ? this.#waysToStartAgain()
        : ['The page connects when it starts: ', element('code', { text: this.#startCommand })]),
    );
  }

  #waysToStartAgain() {
    const answer = element('span', { class: 'refusal', role: 'status' });
    const start = async () => {
      setText(answer, '');
      const told = await this.access.startAgain();
      if (!told.ok) setText(answer, ` It does not start: ${told.error}`);
    };
    return [element('button', { id: 'start-again', type: 'button', text: 'Start again', onclick: start }), answer];
  }

  #tellOfStop(isDone, error) {
    const told = {
      true: 'Stop is under way: every axis ramps down to its safe drive and is switched off. Then the controller ends.',
      false: `Stop has failed: ${error}. Run "hystcan ctl stop", or switch the amplifiers off.`,
      null: 'Stop is sent.',
    }[String(isDone)];
    setText(byId('stop-message'), told);
    if (isDone !== null) this.events.note(isDone ? 'warning' : 'error', told);
    this.#stopSent ||= isDone === true;
  }
}
