// The answers of the server by plain HTTP, without a browser.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import http from 'node:http';
import { dirname } from 'node:path';
import { after, before, test } from 'node:test';

import { copyOfConfig, startDemo } from './support.mjs';

let demo;
before(async () => {
  demo = await startDemo();
});
after(() => demo.stop());

/** Returns status, headers and text of the answer to a request with these headers. */
function ask(path, headers = {}) {
  return new Promise((done, fail) => {
    const request = http.request({ host: '127.0.0.1', port: demo.port, path, headers, agent: false });
    request.on('response', (response) => {
      let text = '';
      response.on('data', (part) => (text += part));
      response.on('end', () => done({ status: response.statusCode, headers: response.headers, text }));
    });
    request.on('error', fail);
    request.end();
  });
}

const own = () => `127.0.0.1:${demo.port}`;

test('A busy address names the option that changes it', () => {
  const config = copyOfConfig();
  for (const [words, option] of [[['demo', '--page', own()], '--page'], [['page', config, '--listen', own()], '--listen']]) {
    const { status, stderr } = spawnSync(process.env.HYSTCAN, words, { cwd: dirname(config), encoding: 'utf8' });
    assert.equal(status, 1, stderr);
    assert.ok(stderr.includes(`${own()}: Address already in use; set another address with ${option}\n`), stderr);
  }
});

test('The page has a content security policy without other hosts', async () => {
  const answer = await ask('/');
  assert.equal(answer.status, 200);
  assert.match(answer.headers['content-type'], /^text\/html/);
  assert.match(answer.headers['content-security-policy'], /default-src 'none'/);
  assert.doesNotMatch(answer.headers['content-security-policy'], /unsafe|https?:|\*/);
});

test('The metrics are OpenMetrics text on request', async () => {
  const answer = await ask('/metrics', { Accept: 'application/openmetrics-text;version=1.0.0' });
  assert.equal(answer.status, 200);
  assert.match(answer.headers['content-type'], /^application\/openmetrics-text/);
  assert.match(answer.text, /^# (HELP|TYPE) hystcan_/m);
  assert.match(answer.text, /# EOF\n$/);
});

test('The demo refuses an address reachable by other machines, and names its own', () => {
  const { status, stderr } = spawnSync(process.env.HYSTCAN, ['demo', '--page', '0.0.0.0:0'], { encoding: 'utf8' });
  assert.equal(status, 2);
  assert.match(stderr, /--page 0\.0\.0\.0.*this machine only.*ssh -L 8080:localhost:8080.*hystcan page has --listen and --expose/s);
});

const promtool = spawnSync('promtool', ['--version']).status === 0;
test('Prometheus reads the metrics', { skip: promtool ? false : 'promtool is not installed' }, async () => {
  const { text } = await ask('/metrics', { Host: own() });
  const checked = spawnSync('promtool', ['check', 'metrics'], { input: text, encoding: 'utf8' });
  assert.equal(checked.status, 0, checked.stdout + checked.stderr);
});
