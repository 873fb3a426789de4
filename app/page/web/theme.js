// Light or dark, and the colours of lines: the set of Okabe and Ito, which colour-blind people can distinguish.

import { byId } from './dom.js';

const light = {
  ink: '#1c2429',
  faint: '#5b666d',
  grid: '#e1e5e8',
  paper: '#ffffff',
  reference: '#59636a',
  lines: ['#0072b2', '#d55e00', '#009e73', '#cc79a7', '#e69f00', '#56b4e9', '#000000'],
};
const dark = {
  ink: '#e4e9ec',
  faint: '#a3afb6',
  grid: '#2b343a',
  paper: '#161c20',
  reference: '#b4bec4',
  lines: ['#56b4e9', '#e69f00', '#009e73', '#cc79a7', '#f0e442', '#d55e00', '#ffffff'],
};
/** Dashes of lines in the order of `lines`, so that no information depends only on colour. */
export const dashes = [[], [9, 4], [2, 3], [12, 3, 2, 3], [5, 5], [2, 6], [14, 4]];

const scheme = matchMedia('(prefers-color-scheme: dark)');
const listeners = [];
const chosen = () => byId('theme').value;

export const palette = () => ((chosen() === 'auto' ? scheme.matches : chosen() === 'dark') ? dark : light);
export const line = (index) => palette().lines[index % palette().lines.length];

export function onThemeChange(listener) {
  listeners.push(listener);
}

export function startTheme() {
  byId('theme').value = localStorage.getItem('theme') ?? 'auto';
  const apply = () => {
    document.documentElement.dataset.theme = chosen();
    localStorage.setItem('theme', chosen());
    listeners.forEach((listener) => listener());
  };
  byId('theme').addEventListener('change', apply);
  scheme.addEventListener('change', apply);
  apply();
}
