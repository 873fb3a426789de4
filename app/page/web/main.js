// Connects the parts of the page: the connection, the row stores, the views and the keys.

import { Access } from './access.js';
import { CaptureView } from './captures.js';
import { Connection } from './connection.js';
import { Cursors } from './cursors.js';
import { byId, openDialog, setText } from './dom.js';
import { ControllerNotice, EventList } from './events.js';
import { rowsOfStore, saveCsv, savePng, wordsOf } from './export.js';
import { quantity } from './format.js';
import { startDialogs, startKeyboard, startTabs } from './keyboard.js';
import { LiveView } from './live_view.js';
import { ResponseView } from './response.js';
import { RowStore, rowsOfMessage, shiftOfTwin } from './row_store.js';
import { Recording, StatusView } from './status_view.js';
import { Steering } from './steering.js';
import { startTheme } from './theme.js';
import { rowsBetween, traceOfAxis } from './trace.js';

const fullRate_Hz = 1000;
const hiddenRate_Hz = 50; // sufficient for a hidden page
const slow_ms = 200; // between two updates of texts

const connection = new Connection(`${location.protocol === 'https:' ? 'wss' : 'ws'}://${location.host}/socket`);
let twinShift_s = 0;
let isShiftFound = false; // false: the newest rows of both streams count as simultaneous
const streams = { controller: null, twin: null, twinShift_s: () => twinShift_s };
const derived = {
  error_um: { unit: 'um', value: (columns, at) => columns.get('reference_um')[at] - columns.get('position_um')[at] },
};

startTheme();
const events = new EventList();
const access = new Access(connection);
const view = new LiveView(streams);
const cursors = new Cursors(view);
const status = new StatusView(errorsOf);
const captures = new CaptureView(connection, streams);
const steering = new Steering(connection, access);
const recording = new Recording(connection);
const response = new ResponseView(connection, streams, captures);
const notice = new ControllerNotice(connection, access, events);
startDialogs();
startKeyboard({
  stop: () => access.stop(),
  pause: () => view.setPaused(!view.isPaused),
  capture: () => captures.captureNow(),
  help: () => openDialog('help-dialog'),
  zoomIn: () => view.zoomBy(0.5),
  zoomOut: () => view.zoomBy(2),
  zoomReset: () => view.showAll(),
});
startTabs((panel) => {
  if (panel === 'steering') steering.refresh();
  if (panel === 'response') response.refresh();
  if (panel === 'capture') captures.redraw();
});

// ---- the connection

let isNoted = true; // true: the events contain the present connection

function tellConnection(state, text) {
  byId('connection').dataset.state = state;
  setText(byId('connection'), text);
}

connection.on('open', () => {
  tellConnection('connected', 'connected');
  isNoted = false;
  sendRate();
  steering.refresh();
});
connection.on('closed', () => {
  if (byId('connection').dataset.state === 'connected') events.note('warning', 'the page lost its server');
  tellConnection('lost', 'not connected; reconnecting');
});
connection.on('hello', ({ program, config, source, exposed, page }) => {
  events.ownName = `page ${page}`;
  setText(byId('program'), program);
  setText(byId('config'), config);
  document.title = `${config} - ${program}`;
  byId('source').hidden = source !== 'demo' && !exposed;
  setText(
    byId('source'),
    [source === 'demo' ? 'simulation' : '', exposed ? 'open to the network' : ''].filter(Boolean).join(', '),
  );
});
connection.on('stream', ({ name, greeting, reason }) => {
  if (name === 'controller') tellOfController(greeting, reason);
  if (!greeting) return;
  if (streams[name]?.fits(greeting)) {
    if (name === 'controller') settingChanged(); // the controller may have restarted with another file
    return streams[name].begin(greeting);
  }
  view.setPaused(false);
  streams[name] = new RowStore(greeting, name === 'controller' ? derived : {});
  if (name === 'controller') {
    status.begin(greeting);
    captures.begin(greeting);
    steering.begin(greeting);
    response.begin(greeting);
    showReferences(greeting);
  }
  view.rebuild();
});

/** Shows the reference curves of the controller's models behind the loops. */
async function showReferences(greeting) {
  const answers = await Promise.all(greeting.axes.map(({ name }) => connection.ask({ do: 'curves', axis: name })));
  view.loop.setReferences(answers.map((answer, axis) => ({ ...answer, axis })).filter(({ ok }) => ok));
}

let settingsLater;
/** Updates the settings and the model, only once if many settings change at once. */
function settingChanged() {
  clearTimeout(settingsLater);
  settingsLater = setTimeout(() => {
    steering.refresh();
    if (streams.controller) showReferences(streams.controller.greeting);
  }, slow_ms);
}

connection.on('rows', (buffer) => {
  const kind = new Uint32Array(buffer, 0, 1)[0];
  const store = kind === 2 ? streams.twin : streams.controller;
  if (!store) return;
  const message = rowsOfMessage(buffer, store.names.length);
  if (kind === 3) return captures.take(message);
  store.append(message);
});
connection.on('status', (message) => {
  status.show(message);
  recording.show(message.controller);
  if (isNoted) return;
  isNoted = true;
  events.note('info', 'the page is connected'); // after the older events, which the server sends first
});
connection.on('event', (message) => {
  events.add(message, streams.controller?.offset_s ?? 0, !isNoted);
  if (isNoted && message.key) settingChanged();
});
connection.on('capture', (message) => captures.announce(message));

function tellOfController(greeting, reason) {
  if (greeting) {
    notice.found();
    return tellConnection('connected', 'connected');
  }
  tellConnection('waiting', 'connected, no controller');
  captures.disarmed('no controller');
  notice.lost(reason);
}

access.changed = () => steering.refresh();

const sendRate = () => connection.ask({ do: 'view', rate_Hz: document.hidden ? hiddenRate_Hz : fullRate_Hz });
document.addEventListener('visibilitychange', () => connection.isOpen && sendRate());

// ---- the charts

/** Returns RMS and peak of an axis's error over the shown time. */
function errorsOf(axis) {
  const rows = view.stores.controller?.axes[axis];
  if (!rows) return { rms_um: NaN, peak_um: NaN };
  const trace = traceOfAxis(rows, 'error_um');
  const [begin, end] = rowsBetween(trace, ...view.range);
  let [sum, number, peak] = [0, 0, 0];
  for (let row = begin; row < end; ++row) {
    const error = trace.values[row & trace.mask];
    if (error !== error) continue;
    sum += error * error;
    peak = Math.max(peak, Math.abs(error));
    ++number;
  }
  return number ? { rms_um: Math.sqrt(sum / number), peak_um: peak } : { rms_um: NaN, peak_um: NaN };
}

byId('export-csv').addEventListener('click', () => {
  const store = view.stores.controller;
  if (!store) return setText(byId('export-answer'), 'there are no rows yet');
  const columns = [...store.units].map(([name, unit]) => ({
    name,
    unit: unit === 'drive' ? store.unitOf(name, 0) : unit,
  }));
  const number = saveCsv('live', columns, rowsOfStore(store, ...view.range), wordsOf(store.greeting));
  setText(byId('export-answer'), `${number} rows`);
});
byId('export-png').addEventListener('click', () => {
  const when = quantity(view.range[1] - (view.stores.controller?.offset_s ?? 0), 's');
  savePng(view.charts, `${byId('config').textContent}, to ${when}, ${new Date().toLocaleString('en-GB')}`);
});

const frames = new Float64Array(120); // times of the last frames
let frameNumber = 0;
let drawing_ms = 0; // drawing time of a frame, smoothed
let slowAt_ms = 0;
let twinAt_ms = 0;

function frame(now_ms) {
  frames[frameNumber++ % frames.length] = now_ms;
  const begin_ms = performance.now();
  view.frame();
  drawing_ms += 0.05 * (performance.now() - begin_ms - drawing_ms);
  if (now_ms - slowAt_ms > slow_ms) {
    slowAt_ms = now_ms;
    view.showValues();
    cursors.show();
  }
  if (now_ms - twinAt_ms > 2000 && streams.twin && streams.controller) {
    twinAt_ms = now_ms;
    const found_s = shiftOfTwin(streams.controller, streams.twin);
    const apart_s = streams.controller.newest_s - streams.twin.newest_s;
    if (found_s !== null) twinShift_s = found_s;
    else if (!isShiftFound && Number.isFinite(apart_s)) twinShift_s = apart_s;
    isShiftFound ||= found_s !== null;
  }
  requestAnimationFrame(frame);
}
requestAnimationFrame(frame);
connection.connect();

/** For benchmarks and tests of the page. */
window.hystcanPage = {
  framesPerSecond() {
    const number = Math.min(frameNumber, frames.length);
    if (number < 2) return 0;
    const newest = frames[(frameNumber - 1) % frames.length];
    const oldest = frames[(frameNumber - number) % frames.length];
    return (1000 * (number - 1)) / (newest - oldest);
  },
  get drawingMs() {
    return drawing_ms;
  },
  get firstPlotMs() {
    return view.firstPlotMs;
  },
  get paused() {
    return view.isPaused;
  },
  rows: (axis) => streams.controller?.received[axis] ?? 0,
  latest: (axis) => streams.controller?.latest(axis) ?? null,
  get lostRows() {
    return streams.controller?.lost ?? 0;
  },
  get captures() {
    return captures.captures.length;
  },
  /** Returns an axis's points in the loop chart: lists of drives and positions; with delay 0, one row gives a point. */
  loopPoints: (axis, delay_s) => view.loop.pointsOf(axis, delay_s),
  loopReference: (axis) => view.loop.referenceOf(axis),
};
