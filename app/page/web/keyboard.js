// Keys, dialogs and tabs.

import { byId, openDialog, setText } from './dom.js';

const twice_ms = 1000; // a second Esc within this time stops

const textFieldOf = (target) => target.closest?.('input:not([type=checkbox]), select, textarea') ?? null;
const takesSpace = (target) => (target.closest?.('button, summary, input, select, a, [role=tab]') ?? null) !== null;
const openDialogs = () => [...document.querySelectorAll('dialog[open]')];
const isStop = ({ key, ctrlKey, shiftKey, altKey, metaKey }) =>
  key.toLowerCase() === 'x' && ctrlKey && shiftKey && !altKey && !metaKey;

/** `actions`: stop, pause, capture, help, zoomIn, zoomOut, zoomReset. */
export function startKeyboard(actions) {
  const esc = new EscapeKey(actions.stop);
  const keys = {
    ' ': actions.pause,
    c: actions.capture,
    '?': actions.help,
    '+': actions.zoomIn,
    '=': actions.zoomIn, // same key without Shift on many keyboards
    '-': actions.zoomOut,
    0: actions.zoomReset,
  };
  const takes = (event) => {
    event.preventDefault();
    event.stopPropagation();
    return !event.repeat;
  };
  addEventListener(
    'keydown',
    (event) => {
      if (event.isComposing) return;
      if (isStop(event)) return void (takes(event) && actions.stop());
      if (event.key === 'Escape') return void (takes(event) && esc.press(event));
      esc.forget();
      if (event.ctrlKey || event.altKey || event.metaKey || textFieldOf(event.target)) return;
      if (openDialogs().length) return;
      if (event.key === ' ' && takesSpace(event.target)) return;
      const action = keys[event.key];
      if (!action) return;
      event.preventDefault();
      action();
    },
    { capture: true },
  );
}

/** Esc closes an open dialog, or leaves a field, which gets the event `leave`. Otherwise, pressing Esc twice stops. */
class EscapeKey {
  #last_ms = -Infinity;

  constructor(stop) {
    this.stop = stop;
    addEventListener('pointerdown', () => this.forget(), { capture: true });
  }

  /** Called for an action between two Esc, which then do not count as a pair. */
  forget() {
    this.#last_ms = -Infinity;
    this.#say('');
  }

  press({ target, timeStamp }) {
    const dialog = openDialogs().at(-1);
    const field = textFieldOf(target);
    if (dialog) return dialog.close();
    if (field) {
      field.dispatchEvent(new Event('leave'));
      return field.blur();
    }
    const isSecond = timeStamp - this.#last_ms <= twice_ms;
    this.#last_ms = isSecond ? -Infinity : timeStamp;
    this.#say(isSecond ? '' : 'Press Esc again within a second to stop');
    if (isSecond) this.stop();
  }

  #say(text) {
    clearTimeout(this.silence);
    setText(byId('key-message'), text);
    this.silence = setTimeout(() => setText(byId('key-message'), ''), twice_ms);
  }
}

export function startDialogs() {
  for (const dialog of document.querySelectorAll('dialog')) {
    dialog.querySelector('button.close').addEventListener('click', () => dialog.close());
  }
  byId('help').addEventListener('click', () => openDialog('help-dialog'));
  // The bar grows if a notice appears or its text needs another line.
  const bar = document.querySelector('.top');
  new ResizeObserver(() => {
    document.documentElement.style.setProperty('--top', `${bar.offsetHeight + 8}px`);
  }).observe(bar);
}

/** Calls `shown(panel)` with the id of the panel. */
export function startTabs(shown) {
  const tabs = [...document.querySelectorAll('[role=tab]')];
  const choose = (chosen) => {
    for (const tab of tabs) {
      tab.setAttribute('aria-selected', String(tab === chosen));
      tab.tabIndex = tab === chosen ? 0 : -1;
      byId(tab.getAttribute('aria-controls')).hidden = tab !== chosen;
    }
    shown(chosen.getAttribute('aria-controls'));
  };
  tabs.forEach((tab, at) => {
    tab.addEventListener('click', () => choose(tab));
    tab.addEventListener('keydown', ({ key }) => {
      const to = { ArrowRight: at + 1, ArrowLeft: at + tabs.length - 1, Home: 0, End: tabs.length - 1 }[key];
      if (to === undefined) return;
      choose(tabs[to % tabs.length]);
      tabs[to % tabs.length].focus();
    });
  });
}
