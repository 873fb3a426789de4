// The page comes back by itself when its server does.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';

import { openPage, seesTheLoopRun, startBrowser, startDemo, until } from './support.mjs';

let demo, browser, page;
before(async () => {
  demo = await startDemo();
  browser = await startBrowser();
  page = await openPage(browser, demo);
  await seesTheLoopRun(page);
});
after(async () => {
  await browser.close();
  await demo.stop();
});

const connection = () => page.textContent('#connection');
const rows = () => page.evaluate(() => window.hystcanPage.rows(0));

test('A killed server is shown, and after its restart the rows go on', async () => {
  const connected = await connection();
  await demo.stop('SIGKILL');
  await until('the page says that the connection is lost', async () => (await connection()) !== connected);
  const before = await rows();
  demo = await startDemo({ port: demo.port });
  await until('the page is connected again', async () => (await connection()) === connected);
  await until('more rows', async () => (await rows()) > before + 200);
});
