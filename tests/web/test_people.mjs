// For everyone: by keyboard alone, on a phone, with a screen reader, in either theme.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { after, before, test } from 'node:test';
import {
  closeBrowser, openBrowser, patience, pixels, settled, startViewer, withPage,
} from './viewer.mjs';

const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');

let viewer;
before(async () => {
  viewer = await startViewer('phantom:head,size=48');
  await openBrowser();
});
after(async () => {
  await closeBrowser();
  await viewer.remove();
});
const check = (name, work, options) =>
  test(name, { timeout: 4 * patience }, () => withPage(viewer, name, work, options));

check('everything can be done by keyboard alone', async (page) => {
  const keys = page.keyboard;
  page.on('filechooser', () => {}); // from here on, so that the browser surely tells of it
  const first = await pixels(page);
  await keys.press('x');
  assert.equal(await page.evaluate(() => document.activeElement.id), 'lamp-x');
  const x = page.getByLabel('Lamp 1, x, as a number').last();
  const before = Number(await x.inputValue());
  for (let n = 0; n < 5; ++n) await keys.press('ArrowRight');
  assert.equal(Number(await x.inputValue()), before + 5);
  await keys.press('e');
  const pixel = await page.getByTestId('explained-pixel').textContent();
  await page.locator('.picture').focus();
  await keys.press('ArrowDown');
  await page.waitForFunction(
    (old) => document.querySelector('[data-testid=explained-pixel]').textContent !== old, pixel);
  await keys.press('Escape');
  await page.getByText('Click a pixel of the picture').waitFor();
  await keys.press('4');
  await settled(page);
  assert.notEqual((await pixels(page)).checksum, first.checksum);
  await keys.press('Control+z');
  await keys.press('Control+z');
  await settled(page);
  assert.deepEqual(await pixels(page), first);
  const [saved] = await Promise.all([page.waitForEvent('download'), keys.press('Control+s')]);
  assert.equal(saved.suggestedFilename(), 'isolux.png');
  await keys.press('?');
  await page.getByRole('heading', { name: 'Hands and keys' }).waitFor();
  await keys.press('Escape');
  await page.getByRole('heading', { name: 'Hands and keys' }).waitFor({ state: 'hidden' });
  const [chooser] = await Promise.all([page.waitForEvent('filechooser'), keys.press('o')]);
  assert.ok(chooser);
});

check('Tab reaches every control in the order in which it is seen', async (page) => {
  const order = [];
  for (let n = 0; n < 60; ++n) {
    await page.keyboard.press('Tab');
    order.push(await page.evaluate(() => {
      const at = document.activeElement;
      return at.getAttribute('aria-label') ?? at.textContent;
    }));
  }
  const at = (name) => order.findIndex((one) => one.startsWith(name));
  const wanted = ['Scan: ', 'Show', 'Split', 'Save', 'The picture', 'Lamp 1, x', 'Lamp 1, y', 'Iso value'];
  for (const name of wanted) assert.ok(at(name) >= 0, `${name} in ${order}`);
  assert.deepEqual(wanted.map(at), wanted.map(at).sort((a, b) => a - b));
});

const phone = {
  viewport: { width: 390, height: 844 }, deviceScaleFactor: 3, hasTouch: true, isMobile: true,
};

check('on a phone the x slider is always there, and the controls open over the picture', async (page) => {
  const x = page.locator('#lamp-x-first');
  assert.ok(await x.isVisible());
  assert.equal(await page.locator('.sections').isVisible(), false);
  await page.getByRole('button', { name: 'View', exact: true }).tap();
  assert.ok(await page.getByRole('button', { name: 'left' }).isVisible());
  assert.ok(await x.isVisible());
  const width = await page.evaluate(() => document.documentElement.scrollWidth);
  assert.equal(width, 390, 'nothing sticks out');
  await settled(page);
  const { size } = await pixels(page);
  assert.equal(size[0], 3 * 390, 'a pixel of the picture is one of the display');
  const before = await pixels(page);
  await page.getByRole('button', { name: 'left' }).tap();
  await settled(page);
  assert.notEqual((await pixels(page)).checksum, before.checksum);
}, phone);

for (const [name, options] of [
  ['dark', { colorScheme: 'dark' }],
  ['light', { colorScheme: 'light' }],
  ['on a phone', phone],
]) {
  check(`a screen reader finds names, roles and contrast everywhere (${name})`, async (page) => {
    for (const part of ['light', 'view']) {
      await page.evaluate((id) => {
        document.querySelector(`#${id}-section`).open = true;
      }, part);
    }
    await page.keyboard.press('e');
    await page.getByTestId('explained-pixel').waitFor({ state: 'attached' });
    await page.keyboard.press('/');
    await settled(page);
    await page.evaluate(axe);
    const { violations } = await page.evaluate(() => window.axe.run());
    const said = violations.map((one) =>
      `${one.id}: ${one.help}\n${one.nodes.map((node) => '  ' + node.target + ' ' + node.failureSummary).join('\n')}`);
    assert.equal(said.join('\n'), '');
  }, options);
}
