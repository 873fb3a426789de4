// Keys, dialogs and tabs.

import { byId, openDialog } from './dom.js';

const takesText = (target) => target.closest?.('input:not([type=checkbox]), select, textarea') !== null;
const takesSpace = (target) => target.closest?.('button, summary, input, select, a, [role=tab]') !== null;

/** `actions`: stop, pause, capture, help. */
export function startKeyboard(actions) {
  addEventListener('keydown', (event) => {
    if (event.key === 'Escape') {
      event.preventDefault(); // it stops the stage and closes nothing
      event.stopPropagation();
      if (!event.repeat) actions.stop();
      return;
    }
    if (event.ctrlKey || event.altKey || event.metaKey || takesText(event.target)) return;
    if (document.querySelector('dialog[open]')) return;
    if (event.key === ' ' && takesSpace(event.target)) return;
    const action = { ' ': actions.pause, c: actions.capture, '?': actions.help }[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  }, { capture: true });
}

export function startDialogs() {
  for (const dialog of document.querySelectorAll('dialog')) {
    dialog.querySelector('button.close').addEventListener('click', () => dialog.close());
  }
  byId('help').addEventListener('click', () => openDialog('help-dialog'));
}

/** `shown(panel)` is called with the id of the panel. */
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
