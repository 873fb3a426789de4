// Properties of every width and colour scheme, and for users of a screen reader.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { openPage, seesTheLoopRun, startDemoWithPage, until } from './support.mjs';

const { demo, browser } = await startDemoWithPage();

const background = (page) => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
/** Returns values of 0..255 from "rgb(r, g, b)". */
const brightness = (colour) => {
  const [r, g, b] = colour.match(/[\d.]+/g).map(Number);
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
};

for (const width of [360, 400, 700, 1400])
  test(`At ${width} px nothing scrolls sideways and Stop is in sight`, async () => {
    const page = await openPage(browser, demo, { viewport: { width, height: 800 } });
    await seesTheLoopRun(page);
    const widths = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
    assert.ok(widths[0] <= widths[1], `${widths[0]} px of content in ${widths[1]} px`);
    await page.evaluate(() => scrollTo(0, document.documentElement.scrollHeight));
    const box = await page.locator('#stop').boundingBox();
    assert.ok(box.y >= 0 && box.y + box.height <= 800, 'Stop scrolls away');
    assert.ok(box.x >= 0 && box.x + box.width <= width, 'Stop is cut');
    await page.context().close();
  });

/** Waits until the help is between the bar and the end of the window: it follows the bar with a delay of one frame. */
async function isBetweenBarAndEnd(page, height) {
  await until(`the help begins below the bar and ends within ${height} px`, async () => {
    const [bar, top, end] = await page.evaluate(() => {
      const box = document.getElementById('help-dialog').getBoundingClientRect();
      return [document.querySelector('.top').getBoundingClientRect().bottom, box.top, box.bottom];
    });
    return end > top && top >= bar && end <= height;
  });
}

for (const width of [400, 1400])
  test(`At ${width} px a dialog is below the bar, also when that grows, and ends within the window`, async () => {
    const page = await openPage(browser, demo, { viewport: { width, height: 800 } });
    await seesTheLoopRun(page);
    await page.click('#help');
    await isBetweenBarAndEnd(page, 800);
    await page.locator('.top').evaluate((bar) => bar.append(Object.assign(document.createElement('p'), { textContent: 'more' })));
    await isBetweenBarAndEnd(page, 800);
    await page.context().close();
  });

test('At 1400 x 900 loop, tracking, state and Stop are visible without scrolling', async () => {
  const page = await openPage(browser, demo);
  await seesTheLoopRun(page);
  for (const id of ['loop-chart', 'tracking-chart', 'axis-0-state', 'stop']) {
    const box = await page.locator(`#${id}`).boundingBox();
    assert.ok(box && box.y >= 0 && box.y + box.height <= 900, `#${id} ends at ${box?.y + box?.height} px`);
  }
  await page.context().close();
});

test('The scheme of the system decides, and the switch changes it', async () => {
  const dark = await openPage(browser, demo, { colorScheme: 'dark' });
  const light = await openPage(browser, demo, { colorScheme: 'light' });
  assert.ok(brightness(await background(dark)) < 80, await background(dark));
  assert.ok(brightness(await background(light)) > 180, await background(light));
  await light.selectOption('#theme', 'dark');
  assert.equal(await background(light), await background(dark));
  await dark.context().close();
  await light.context().close();
});

test('Every control has an accessible name, every chart a role and a label', async () => {
  const page = await openPage(browser, demo);
  await seesTheLoopRun(page);
  const nameless = await page.evaluate(() => {
    const textOf = (ids) => ids.split(/\s+/).map((id) => document.getElementById(id)?.textContent ?? '').join(' ');
    const nameOf = (element) =>
      (element.getAttribute('aria-label') ??
        (element.hasAttribute('aria-labelledby') ? textOf(element.getAttribute('aria-labelledby')) : null) ??
        ([...(element.labels ?? [])].map((label) => label.textContent).join(' ') ||
          (/^(BUTTON|A|SUMMARY)$/.test(element.tagName) ? element.textContent : '') ||
          element.title)).trim();
    const controls = document.querySelectorAll(
      'button, input:not([type=hidden]), select, textarea, a[href], summary, [role=button], [role=tab], [tabindex="0"]');
    return [...controls].filter((element) => !nameOf(element)).map((element) => element.outerHTML.slice(0, 120));
  });
  assert.deepEqual(nameless, []);
  for (const id of ['loop-chart', 'tracking-chart', 'error-chart', 'drive-chart']) {
    const image = page.locator(`#${id}[role=img], #${id} [role=img]`).first();
    assert.ok((await image.getAttribute('aria-label'))?.length > 0, id);
  }
  await page.context().close();
});

test('Tables have headers, dialogs have names, faults and connection are live regions', async () => {
  const page = await openPage(browser, demo);
  await seesTheLoopRun(page);
  const wrong = await page.evaluate(() => [
    ...[...document.querySelectorAll('table')].filter((table) => table.querySelector('td') && !table.querySelector('th'))
      .map((table) => `a table without th: ${table.outerHTML.slice(0, 100)}`),
    ...[...document.querySelectorAll('dialog')]
      .filter((dialog) => !dialog.hasAttribute('aria-label') && !dialog.hasAttribute('aria-labelledby'))
      .map((dialog) => `dialog ${dialog.id} without a name`),
    ...['connection'].filter((id) => !document.getElementById(id).closest('[aria-live], [role=status], [role=alert]')),
    ...(document.querySelector('[aria-live=assertive], [role=alert]') ? [] : ['no live region for faults']),
    ...(document.documentElement.lang ? [] : ['no language']),
  ]);
  assert.deepEqual(wrong, []);
  await page.context().close();
});
