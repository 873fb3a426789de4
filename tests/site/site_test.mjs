// The site of scripts/site in a browser that reaches no other host: site_test.mjs FOLDER, by tests/page/run.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { createInterface } from 'node:readline';
import { after, before, test } from 'node:test';

import { openPage, startBrowser, until } from '../page/support.mjs';

const folder = process.argv[2];
let server, site, browser;
before(async () => {
  server = spawn('python3', ['-u', '-m', 'http.server', '0', '--bind', '127.0.0.1', '--directory', folder],
    { stdio: ['ignore', 'pipe', 'ignore'] });
  const [line] = await once(createInterface(server.stdout), 'line');
  site = { url: /\((http:.*)\)/.exec(line)[1] };
  browser = await startBrowser();
});
after(async () => {
  await browser?.close();
  server.kill();
});

// What is not on this machine goes to a proxy that does not exist.
const open = (options) => openPage(browser, site, { proxy: { server: 'http://127.0.0.1:1', bypass: '127.0.0.1' }, ...options });

for (const word of ['rings', 'backlash'])
  test(`The search for "${word}" finds the page on troubles`, async () => {
    const page = await open();
    // Typed, not clicked: a click waits for two frames of an element at rest, and a busy browser may draw none.
    await page.locator('.md-search__input').pressSequentially(word);
    await until('a result on troubles', () => page.locator('.md-search-result__link[href*="docs/troubleshooting"]').count());
    assert.deepEqual(page.problems, []);
    await page.context().close();
  });

test('Every page sets its formulas, fits a narrow screen and asks no other host', async () => {
  const page = await open({ viewport: { width: 400, height: 700 } });
  // The index of the search takes most of the time of a page, and is not looked at here.
  await page.route('**/search_index.json', (route) => route.fulfill({ json: { config: { lang: ['en'] }, docs: [] } }));
  const links = await page.locator('.md-nav--primary a.md-nav__link').evaluateAll((all) => all.map((link) => link.href));
  const pages = [...new Set(links.map((link) => link.split('#')[0]))];
  assert.ok(pages.length > 40, `${pages.length} pages`);
  for (const url of pages) {
    await page.goto(url, { waitUntil: 'domcontentloaded' });
    const [unset, width] = await page.evaluate(() => [
      [...document.querySelectorAll('.arithmatex')].filter((one) => !one.querySelector('.katex')).map((one) => one.textContent),
      document.documentElement.scrollWidth]);
    assert.deepEqual(unset, [], url);
    assert.ok(width <= 400, `${url} is ${width} pixels wide`);
    assert.deepEqual(page.problems, [], url);
  }
});
