// The Record button: a run on disk, started and ended from the page.
import assert from 'node:assert/strict';
import { existsSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';

import { startDemoWithPage, takeControl, until } from './support.mjs';

const { demo, page } = await startDemoWithPage();

const words = () => page.textContent('#recording');

test('Nothing is recorded, and no page without control can begin', async () => {
  await until('the state of the recording', async () => (await words()) === 'no recording');
  assert.ok(await page.locator('#record').isDisabled());
});

test('Record writes a run beside the controller and shows its path', async () => {
  await takeControl(page, demo);
  await page.click('#record');
  // A busy machine may lose rows; the text then counts them.
  const hasRows = /^recording \S+run_\S+: [\d,]+ rows, [\d.]*[1-9] MB(, [\d,]+ lost)?$/;
  await until('rows on the disk', async () => hasRows.test(await words()));
  const run = /recording (\S+):/.exec(await words())[1];
  assert.equal(await page.textContent('#record'), 'End recording');
  const { text, box, lines, frame } = await page.evaluate(() => {
    const words = document.getElementById('recording');
    const { right } = words.getBoundingClientRect();
    const column = document.querySelector('.states').getBoundingClientRect();
    return {
      text: words.title,
      box: { isWithin: right <= column.right && words.scrollWidth <= words.clientWidth },
      lines: [...words.querySelectorAll('.piece')].map((piece) => {
        const text = document.createRange();
        text.selectNodeContents(piece);
        return text.getClientRects().length; // a rectangle for each line
      }),
      frame: getComputedStyle(document.getElementById('record').closest('fieldset')).borderTopWidth,
    };
  });
  assert.equal(text, run, 'the whole path is in the title');
  assert.ok(box.isWithin, 'the path is cut off');
  assert.ok(lines.length > 2 && lines.every((number) => number === 1), `a name of the path is broken: ${lines}`);
  assert.equal(frame, '0px');
  await page.click('#record');
  await until('the end', async () => (await words()).startsWith(`recorded ${run}: `));
  await until('the summary', () => JSON.parse(readFileSync(join(run, 'run.json'))).ended !== '');
  assert.ok(existsSync(join(run, 'config', 'piezo.toml')));
  assert.match(readFileSync(join(run, 'cycles_0001.csv'), 'utf8'), /^# .*\ncycle,time_s,axis,state,/);
});
