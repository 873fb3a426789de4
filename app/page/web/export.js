// Exports CSV with every digit, and the visible charts as one picture.

import { download } from './dom.js';
import { palette } from './theme.js';
import { rowAt } from './trace.js';

const most = 1_000_000; // maximum lines of one file
const stamp = () => new Date().toISOString().slice(0, 19).replaceAll(':', '-');

/** Returns a function for each column with words: it converts the number in a row to the word of `controller --csv`. */
export function wordsOf({ axes, states, faults, limits }) {
  const wordIn = (words) => (at) => words?.[at] ?? at;
  return {
    axis: wordIn(axes.map(({ name }) => name)),
    state: wordIn(states),
    fault: wordIn(faults),
    limits: (bits) => (limits ? limits.filter((_, bit) => bits & (1 << bit)).join('+') : bits),
  };
}

/** `columns`: list of {name, unit}; `rows`: an iterable of lists of numbers. NaN becomes an empty field. */
export function saveCsv(name, columns, rows, words) {
  const makers = columns.map(({ name: column }) => words[column] ?? ((value) => value));
  const field = (value, at) => (Number.isNaN(value) ? '' : makers[at](value));
  const head = columns.map(({ name: word, unit }) => (unit ? `${word} [${unit}]` : word)).join(',');
  const parts = [`${head}\n`];
  for (const row of rows) {
    if (parts.length > most) break;
    parts.push(`${Array.from(row, field).join(',')}\n`);
  }
  download(`hystcan-${name}-${stamp()}.csv`, new Blob(parts, { type: 'text/csv' }));
  return parts.length - 1;
}

/** Returns the rows of all axes of a store between two times, as received from the controller. */
export function* rowsOfStore(store, from_s, to_s) {
  for (const axis of store.axes) {
    const columns = [...store.units.keys()].map((name) => axis.columns.get(name));
    const timeAt = [...store.units.keys()].indexOf('time_s');
    for (let row = rowAt(axis, from_s); row < axis.end && axis.time[row & axis.mask] <= to_s; ++row) {
      const values = columns.map((column) => column[row & axis.mask]);
      values[timeAt] -= store.offset_s;
      yield values;
    }
  }
}

/** Returns a PNG of the charts with titles and legends, in the layout of the screen. */
export async function savePng(charts, title) {
  const ratio = devicePixelRatio;
  const boxes = charts.map(({ host }) => host.getBoundingClientRect());
  const left = Math.min(...boxes.map((box) => box.left));
  const top = Math.min(...boxes.map((box) => box.top));
  const headline = 28;
  const canvas = document.createElement('canvas');
  canvas.width = (Math.max(...boxes.map((box) => box.right)) - left) * ratio;
  canvas.height = (Math.max(...boxes.map((box) => box.bottom)) - top + headline) * ratio;
  const context = canvas.getContext('2d');
  context.scale(ratio, ratio);
  context.fillStyle = palette().paper;
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.fillStyle = palette().ink;
  context.font = 'bold 14px system-ui, sans-serif';
  context.fillText(title, 8, 19);
  for (const chart of charts) {
    paintLegend(context, chart.legend, left, top - headline);
    const picture = chart.plot.querySelector('canvas');
    const box = picture.getBoundingClientRect();
    context.drawImage(picture, box.left - left, box.top - top + headline, box.width, box.height);
  }
  const blob = await new Promise((done) => canvas.toBlob(done, 'image/png'));
  download(`hystcan-charts-${stamp()}.png`, blob);
}

/** Draws the legend as on the screen: its title, and swatch, label and value of each line. */
function paintLegend(context, legend, left, top) {
  const text = (part, x, y) => {
    const style = getComputedStyle(part);
    context.font = `${style.fontWeight} ${style.fontSize} system-ui, sans-serif`;
    context.fillStyle = palette().ink;
    context.fillText(
      [...part.childNodes]
        .map(({ textContent }) => textContent)
        .join(' ')
        .trim(),
      x - left,
      y - top,
    );
  };
  const [title, ...keys] = legend.children;
  text(title, title.getBoundingClientRect().left, title.getBoundingClientRect().bottom - 4);
  for (const key of keys) {
    const box = key.getBoundingClientRect();
    const canvas = key.querySelector('canvas');
    const picture = canvas?.getBoundingClientRect();
    if (canvas) context.drawImage(canvas, picture.left - left, picture.top - top, picture.width, picture.height);
    text(key, canvas ? picture.right + 5 : box.left, box.bottom - 4);
  }
}
