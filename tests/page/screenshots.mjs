// screenshots.mjs FOLDER: see scripts/screenshots.
import { statSync } from 'node:fs';
import { join } from 'node:path';

import { openPage, seesTheLoopRun, startBrowser, startDemo, until } from './support.mjs';

const folder = process.argv[2];
const demo = await startDemo();
const browser = await startBrowser();
for (const colorScheme of ['light', 'dark'])
  for (const width of [1400, 400]) {
    const page = await openPage(browser, demo, { colorScheme, viewport: { width, height: 900 } });
    await seesTheLoopRun(page);
    // The hysteresis loop is closed after one period of the reference.
    await until('five seconds of rows', () => page.evaluate(() => window.hystcanPage.rows(0) > 2500));
    const file = join(folder, `page-${colorScheme}-${width}.png`);
    await page.screenshot({ path: file });
    console.log(`${file}: ${Math.round(statSync(file).size / 1000)} kB`);
    await page.context().close();
  }
await browser.close();
await demo.stop();
