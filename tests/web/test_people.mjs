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

const camera = (page) =>
  page.evaluate(() => JSON.parse(sessionStorage.getItem('isolux')).edited.scene.camera);

check('two fingers move and zoom, about the point between them', async (page) => {
  const touch = await page.context().newCDPSession(page);
  const box = await page.locator('.picture').boundingBox();
  const [cx, cy] = [box.x + box.width / 2, box.y + box.height / 2];
  const fingers = (type, ...points) =>
    touch.send('Input.dispatchTouchEvent', { type, touchPoints: points.map(([x, y]) => ({ x, y })) });
  const distance = ({ eye, target }) => Math.hypot(...eye.map((v, n) => v - target[n]));
  const before = await camera(page);
  await fingers('touchStart', [cx - 40, cy], [cx + 40, cy]);
  for (let n = 1; n <= 4; ++n) await fingers('touchMove', [cx - 40 - 10 * n, cy], [cx + 40 + 10 * n, cy]);
  await fingers('touchEnd');
  const zoomed = await camera(page);
  // From 80 to 160 pixels apart: twice as large, about the middle.
  assert.ok(Math.abs(distance(before) / distance(zoomed) - 2) < 0.02);
  zoomed.target.forEach((v, n) => assert.ok(Math.abs(v - before.target[n]) < 0.5));
  await fingers('touchStart', [cx - 40, cy], [cx + 40, cy]);
  for (let n = 1; n <= 4; ++n) await fingers('touchMove', [cx - 40, cy + 10 * n], [cx + 40, cy + 10 * n]);
  await fingers('touchEnd');
  const moved = await camera(page);
  assert.ok(Math.abs(distance(moved) / distance(zoomed) - 1) < 0.02);
  assert.ok(moved.target[2] > zoomed.target[2] + 1, 'the picture goes down, the eye up');
}, phone);

check('at the start the head fills the window, whatever its shape', async (page) => {
  const part = () => page.evaluate(() => {
    const canvas = document.querySelector('.picture canvas');
    const { width, height } = canvas;
    const { data } = canvas.getContext('2d').getImageData(0, 0, width, height);
    const different = (x, y) => data[4 * (y * width + x)] !== data[0];
    const columns = [...Array(width).keys()].filter((x) => [...Array(height).keys()].some((y) => different(x, y)));
    const rows = [...Array(height).keys()].filter((y) => [...Array(width).keys()].some((x) => different(x, y)));
    return [(columns.at(-1) - columns[0]) / width, (rows.at(-1) - rows[0]) / height];
  });
  for (const shape of [{ width: 1200, height: 500 }, { width: 800, height: 900 }]) {
    await page.setViewportSize(shape);
    await settled(page);
    await page.locator('.picture').press('1');
    await settled(page);
    const largest = Math.max(...(await part()));
    assert.ok(Math.abs(largest - 0.9) < 0.03, `${largest} of ${JSON.stringify(shape)}`);
  }
});

check('what a newcomer is told goes away once it was done, for good', async (page) => {
  const hints = page.locator('.hint-lines li');
  assert.equal(await hints.count(), 3);
  await page.locator('.picture').press('e');
  assert.equal(await hints.count(), 2);
  await page.reload();
  await settled(page);
  assert.equal(await hints.count(), 2);
  await page.getByRole('button', { name: 'Close these hints' }).click();
  assert.equal(await hints.count(), 0);
});

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
