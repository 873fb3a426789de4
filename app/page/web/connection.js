// The WebSocket to the server: requests with answers, messages to listeners, and reconnection after a loss.

const shortestPause_ms = 300;
const longestPause_ms = 4000;
const silence_ms = 6000; // then the connection is dead: a status arrives five times a second
const answerTime_ms = 10_000;

export class Connection {
  #url;
  #socket = null;
  #listeners = new Map();
  #asked = new Map();
  #nextId = 1;
  #pause_ms = shortestPause_ms;
  #heard_ms = 0;

  constructor(url) {
    this.#url = url;
    setInterval(() => this.#watch(), 1000);
  }

  /** Types: `open`, `closed`, `rows` (an ArrayBuffer) and the types of the server's messages. */
  on(type, listener) {
    if (!this.#listeners.has(type)) this.#listeners.set(type, []);
    this.#listeners.get(type).push(listener);
  }

  get isOpen() {
    return this.#socket?.readyState === WebSocket.OPEN;
  }

  connect() {
    const socket = new WebSocket(this.#url);
    this.#socket = socket;
    this.#heard_ms = performance.now();
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => {
      this.#pause_ms = shortestPause_ms;
      this.#tell('open');
    };
    socket.onmessage = ({ data }) => this.#take(data);
    socket.onclose = () => this.#lost(socket);
  }

  /** Returns the server's answer, or an answer without `ok` if none arrives. Never throws. */
  ask(request, patience_ms = answerTime_ms) {
    if (!this.isOpen) return Promise.resolve({ ok: false, error: 'not connected to the server of the page' });
    const id = this.#nextId++;
    return new Promise((resolve) => {
      const late = setTimeout(() => {
        this.#asked.delete(id);
        resolve({ ok: false, error: `no answer within ${patience_ms / 1000} s` });
      }, patience_ms);
      this.#asked.set(id, (answer) => {
        clearTimeout(late);
        resolve(answer);
      });
      this.#socket.send(JSON.stringify({ ...request, id }));
    });
  }

  #take(data) {
    this.#heard_ms = performance.now();
    if (data instanceof ArrayBuffer) return this.#tell('rows', data);
    const message = JSON.parse(data);
    if (message.type !== 'answer') return this.#tell(message.type, message);
    this.#asked.get(message.id)?.(message);
    this.#asked.delete(message.id);
  }

  #tell(type, message) {
    for (const listener of this.#listeners.get(type) ?? []) listener(message);
  }

  #lost(socket) {
    if (socket !== this.#socket) return;
    this.#socket = null;
    for (const answer of this.#asked.values()) answer({ ok: false, error: 'the connection was lost' });
    this.#asked.clear();
    this.#tell('closed');
    setTimeout(() => this.connect(), this.#pause_ms);
    this.#pause_ms = Math.min(2 * this.#pause_ms, longestPause_ms);
  }

  /** Closes a connection without messages, which is dead even if the browser does not report it (suspend, cable). */
  #watch() {
    const socket = this.#socket;
    if (!socket || performance.now() - this.#heard_ms < silence_ms) return;
    socket.onmessage = socket.onclose = socket.onopen = null;
    socket.close();
    this.#lost(socket);
  }
}
