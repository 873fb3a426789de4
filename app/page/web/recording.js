// The button that records a run, and what becomes of the recording.

import { byId, setText } from './dom.js';
import { count, quantity } from './format.js';

export class Recording {
  constructor(connection) {
    this.connection = connection;
    byId('record').addEventListener('click', () => this.#switch());
  }

  /** `controller`: the status of the controller; null if there is none. */
  show(controller) {
    const recording = controller?.recording;
    this.isOn = recording?.on ?? false;
    setText(byId('record'), this.isOn ? 'End recording' : 'Record');
    if (!this.answer) setText(byId('recording'), recordingText(recording));
    byId('recording').title = recording?.run ?? '';
    byId('recording').dataset.state = recording?.failure ? 'failed' : this.isOn ? 'on' : 'off';
  }

  async #switch() {
    const answer = await this.connection.ask({ do: 'command', command: { do: 'record', on: !this.isOn } });
    if (answer.ok) return;
    this.answer = answer.error;
    setText(byId('recording'), answer.error);
    setTimeout(() => (this.answer = undefined), 5000);
  }
}

/** "recording runs/run_...: 120,000 rows, 25.1 MB". */
export function recordingText(recording) {
  if (!recording?.run) return 'nothing is recorded';
  const lost = recording.rows_lost ? `, ${count(recording.rows_lost)} lost` : '';
  const end = recording.failure ? `; it ended: ${recording.failure}` : '';
  return `${recording.on ? 'recording' : 'recorded'} ${recording.run}: ${count(recording.rows)} rows, ${quantity(
    recording.bytes / 1e6,
    'MB',
    1,
  )}${lost}${end}`;
}
