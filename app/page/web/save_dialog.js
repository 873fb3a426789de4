// Save and Undo save: both show first what the configuration file would get.

import { byId, element, openDialog, setText } from './dom.js';

const ways = {
  save: {
    title: 'Save to the configuration file',
    text: (kept) =>
      'The file gets these lines. Comments and everything else stay. ' +
      `The file as it is now is kept beside it as ${kept}; Undo save brings it back.`,
    done: (kept) => `the file is written; the former one is ${kept}`,
  },
  undo_save: {
    title: 'Undo save',
    text: (kept) =>
      `The file gets these lines: it becomes what ${kept} holds, and the controller takes it over. ` +
      'What was set here and not saved is lost. ' +
      `The file as it is now is kept as ${kept}: a second Undo save brings it back.`,
    done: (kept) => `the former file is in force again; what it replaced is ${kept}`,
  },
};

export class SaveDialog {
  /** `told(answer, words)` is called when the file is written. */
  constructor(connection, told) {
    this.connection = connection;
    this.told = told;
    byId('save').addEventListener('click', () => this.#open('save'));
    byId('undo-save').addEventListener('click', () => this.#open('undo_save'));
    byId('save-confirm').addEventListener('click', () => this.#confirm());
  }

  async #open(way) {
    const answer = await this.connection.ask({ do: way });
    this.way = way;
    this.digest = answer.digest;
    setText(byId('save-title'), ways[way].title);
    setText(byId('save-answer'), answer.ok ? '' : answer.error);
    setText(byId('save-text'), answer.ok ? ways[way].text(answer.kept) : '');
    byId('save-diff').replaceChildren(
      ...(answer.diff ?? '').split('\n').map((text) =>
        element('span', {
          class: text.startsWith('+') ? 'added' : text.startsWith('-') ? 'removed' : '',
          text: `${text}\n`,
        }),
      ),
    );
    byId('save-confirm').disabled = !answer.ok || !answer.digest;
    openDialog('save-dialog');
  }

  async #confirm() {
    const answer = await this.connection.ask({ do: this.way, digest: this.digest });
    if (!answer.ok) return setText(byId('save-answer'), answer.error);
    byId('save-dialog').close();
    const { kept, not_applied: trouble } = answer;
    if (trouble)
      this.told({ error: `the former file is restored, but the controller has not taken it over: ${trouble}` });
    else this.told(answer, ways[this.way].done(kept));
  }
}
