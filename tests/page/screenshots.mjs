// screenshots.mjs FOLDER: see scripts/screenshots.
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';

import { openPage, seesTheLoopRun, startBrowser, startDemo, until } from './support.mjs';

const folder = process.argv[2];
const demo = await startDemo();
const browser = await startBrowser();
const blank = await browser.newPage();
for (const colorScheme of ['light', 'dark'])
  for (const width of [1400, 400]) {
    const page = await openPage(browser, demo, { colorScheme, viewport: { width, height: 700 }, isAtFullRate: true });
    await seesTheLoopRun(page);
    await page.selectOption('#window-seconds', '1');
    // The hysteresis loop is closed after one period of the reference.
    await until('five seconds of rows', () => page.evaluate(() => window.hystcanPage.rows(0) > 2500));
    const file = join(folder, `page-${colorScheme}-${width}.png`);
    const picture = await withFewerColours(await page.screenshot());
    writeFileSync(file, picture);
    console.log(`${file}: ${Math.round(picture.length / 1000)} kB`);
    await page.context().close();
  }
await browser.close();
await demo.stop();

/** Sixteen steps per colour keep the PNG small and suffice for lines and letters. */
async function withFewerColours(png) {
  const url = await blank.evaluate(async (source) => {
    const image = new Image();
    image.src = source;
    await image.decode();
    const canvas = document.createElement('canvas');
    [canvas.width, canvas.height] = [image.width, image.height];
    const context = canvas.getContext('2d');
    context.drawImage(image, 0, 0);
    const pixels = context.getImageData(0, 0, canvas.width, canvas.height);
    pixels.data.forEach((value, at) => (pixels.data[at] = 17 * Math.round(value / 17)));
    context.putImageData(pixels, 0, 0);
    return canvas.toDataURL('image/png');
  }, `data:image/png;base64,${png.toString('base64')}`);
  return Buffer.from(url.slice(url.indexOf(',') + 1), 'base64');
}
