// The token, the writer's role, and Stop.

import { byId, openDialog, setText } from './dom.js';

const tokenKey = 'hystcan token';
const stopPatience_ms = 3000;

export class Access {
  role = 'free';
  isAuthorised = false;
  #waiting = null; // resolves when the token dialog closes

  constructor(connection) {
    this.connection = connection;
    this.changed = () => {};
    this.stopped = () => {};
    connection.on('open', () => this.#sendStoredToken());
    connection.on('closed', () => this.#take({ role: 'free', authorised: false }));
    connection.on('writer', (message) => this.#take(message));
    byId('take-control').addEventListener('click', () => this.#takeOrRelease());
    byId('stop').addEventListener('click', () => this.stop());
    byId('token-form').addEventListener('submit', (event) => {
      event.preventDefault();
      this.#tryToken(byId('token').value.trim());
    });
    byId('token-dialog').addEventListener('close', () => this.#finish(this.isAuthorised));
    byId('take-over').addEventListener('click', () => {
      byId('take-over-dialog').close();
      this.#askForRole(true);
    });
  }

  get mayWrite() {
    return this.isAuthorised && this.role === 'yours';
  }

  /** Stops the stage. If the page has no token, requests it first. */
  async stop() {
    const { connection } = this;
    if (!connection.isOpen) return this.stopped(false, 'the page is not connected to its server');
    if (!(await this.#hasToken('Stop needs the token. The stage stops as soon as the token is accepted.'))) return;
    this.stopped(null, '');
    const answer = await connection.ask({ do: 'stop' }, stopPatience_ms);
    this.stopped(answer.ok, answer.error ?? '');
  }

  /** Restarts the demo. If the page has no token, requests it first. Returns the server's answer. */
  async startAgain() {
    if (!(await this.#hasToken('Restarting the demo needs the token.')))
      return { ok: false, error: 'this request needs the token' };
    return this.connection.ask({ do: 'start' });
  }

  async #takeOrRelease() {
    if (this.role === 'yours') return void (await this.connection.ask({ do: 'release_writer' }));
    if (!(await this.#hasToken('Changing settings and moving the stage need the token.'))) return;
    if (this.role === 'taken') return openDialog('take-over-dialog');
    await this.#askForRole(false);
  }

  async #askForRole(isForced) {
    const answer = await this.connection.ask(isForced ? { do: 'take_writer', force: true } : { do: 'take_writer' });
    setText(byId('role-answer'), answer.ok ? '' : answer.error);
    if (!answer.ok && !isForced && this.role === 'taken') openDialog('take-over-dialog');
  }

  /** Requests the token if the page has not sent it yet. */
  #hasToken(why) {
    if (this.isAuthorised) return true;
    setText(byId('token-why'), why);
    setText(byId('token-answer'), '');
    byId('token').value = '';
    openDialog('token-dialog');
    byId('token').focus();
    return new Promise((resolve) => {
      this.#finish(false); // closes an earlier question
      this.#waiting = resolve;
    });
  }

  async #tryToken(token) {
    if (!token) return setText(byId('token-answer'), 'Enter the token.');
    setText(byId('token-answer'), 'checking ...');
    const answer = await this.connection.ask({ do: 'token', token });
    if (!answer.ok) return setText(byId('token-answer'), answer.error);
    sessionStorage.setItem(tokenKey, token);
    this.isAuthorised = true;
    byId('token-dialog').close();
    this.#finish(true);
  }

  #finish(isGiven) {
    this.#waiting?.(isGiven);
    this.#waiting = null;
  }

  async #sendStoredToken() {
    const token = sessionStorage.getItem(tokenKey);
    if (!token) return;
    const answer = await this.connection.ask({ do: 'token', token });
    if (!answer.ok && this.connection.isOpen) sessionStorage.removeItem(tokenKey);
  }

  #take({ role, authorised }) {
    this.role = role;
    this.isAuthorised = authorised;
    const words = { yours: 'this page controls', taken: 'another page controls', free: 'read only' };
    setText(byId('role'), words[role] ?? role);
    setText(byId('take-control'), role === 'yours' ? 'Release' : 'Take control');
    for (const fields of document.querySelectorAll('fieldset.writes')) fields.disabled = !this.mayWrite;
    for (const hint of document.querySelectorAll('.write-hint')) hint.hidden = this.mayWrite;
    this.changed();
  }
}
