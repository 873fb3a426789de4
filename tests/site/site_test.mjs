// The site of scripts/site in a browser without access to other hosts: site_test.mjs FOLDER, by
// tests/page/run.
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

// Requests to other machines are sent to a proxy that does not exist.
const open = (options) => openPage(browser, site, { proxy: { server: 'http://127.0.0.1:1', bypass: '127.0.0.1' }, ...options });

for (const [word, found] of [['rings', 'troubleshooting/rings'], ['backlash', 'troubleshooting/backlash'],
  ['lag', 'troubleshooting/lags'], ['drift', 'troubleshooting/drifts'], ['oscilloscope', 'lab_files'],
  ['oscilloscope', 'first_day'], ['DAQ card', 'analogue']])
  test(`The search for "${word}" finds ${found}`, async () => {
    const page = await open();
    // The text is typed, not clicked: a click waits for two frames of a resting element, and a busy browser
    // may draw none.
    const input = page.locator('.md-search__input');
    await input.pressSequentially(word);
    await until(`a result in ${found}`, async () => {
      if (await page.locator(`.md-search-result__link[href*="docs/${found}"]`).count()) return true;
      await input.press('End'); // the search reads the input at a key; it may have missed the word
      return false;
    });
    assert.deepEqual(page.problems, []);
    await page.context().close();
  });

/** Returns the texts whose contrast with their background is below 4.5 (WCAG 2, level AA), with the contrast. */
function faintTexts() {
  const channels = (colour) => (([r, g, b, a = 1]) => ({ r, g, b, a }))(colour.match(/[\d.]+/g).map(Number));
  const over = (top, below) => ({ a: 1, ...Object.fromEntries(['r', 'g', 'b'].map((c) => [c, top.a * top[c] + (1 - top.a) * below[c]])) });
  const behind = (element) => {
    if (!element) return { r: 255, g: 255, b: 255, a: 1 };
    const own = channels(getComputedStyle(element).backgroundColor);
    return own.a === 1 ? own : over(own, behind(element.parentElement));
  };
  const linear = (c) => (c / 255 <= 0.04045 ? c / 255 / 12.92 : ((c / 255 + 0.055) / 1.055) ** 2.4);
  const luminance = ({ r, g, b }) => 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
  const faint = new Map();
  for (const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT); texts.nextNode();) {
    const element = texts.currentNode.parentElement;
    const text = texts.currentNode.data.trim();
    if (!text || element.closest('script, style, .headerlink, .md-search, .katex') || !element.checkVisibility({ visibilityProperty: true, opacityProperty: true })) continue;
    const ground = behind(element);
    const [one, other] = [luminance(over(channels(getComputedStyle(element).color), ground)), luminance(ground)];
    const contrast = (Math.max(one, other) + 0.05) / (Math.min(one, other) + 0.05);
    if (contrast < 4.5) faint.set(`${element.tagName} ${element.className}`, `${contrast.toFixed(2)}: ${text.slice(0, 40)}`);
  }
  return [...faint].map((each) => each.join(' '));
}

for (const colorScheme of ['light', 'dark'])
  test(`No text is faint on a ${colorScheme} ground`, async () => {
    const page = await open({ colorScheme });
    for (const name of ['index', 'docs/first_day', 'docs/commands/run', 'docs/theory/model', 'docs/evidence']) {
      await page.goto(`${site.url}${name}.html`, { waitUntil: 'domcontentloaded' });
      const scheme = colorScheme === 'dark' ? 'slate' : 'default';
      await until('the colours', () => page.evaluate((wanted) => document.body.dataset.mdColorScheme === wanted, scheme));
      await page.addStyleTag({ content: '*, ::before, ::after { transition: none !important; animation: none !important }' });
      assert.deepEqual(await page.evaluate(faintTexts), [], name);
    }
    await page.context().close();
  });

test('Every page renders its formulas, fits a narrow screen and contacts no other host', async () => {
  const page = await open({ viewport: { width: 400, height: 700 } });
  // Loading the search index takes most of the time of a page, and is not examined here.
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
