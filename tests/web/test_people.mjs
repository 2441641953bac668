// For everyone: by keyboard alone, on a phone, with a screen reader, in either theme.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { after, before, test } from 'node:test';
import {
  closeBrowser, isolux, openBrowser, patience, phone, pixels, savedScene, settled, startViewer, withPage,
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

check('on a phone the x slider is always there, and the controls open over the picture', async (page) => {
  const x = page.locator('#lamp-x-first');
  assert.ok(await x.isVisible());
  assert.equal(await page.locator('.sections').isVisible(), false);
  await page.getByRole('button', { name: 'View', exact: true }).tap();
  assert.ok(await page.getByRole('button', { name: 'left' }).isVisible());
  assert.ok(await x.isVisible());
  await page.locator('.picture').press('/');
  for (const control of await page.locator('button:visible, select:visible, input:visible').all()) {
    const { x: left, width } = await control.boundingBox();
    assert.ok(left >= 0 && left + width <= 390, `nothing sticks out: ${await control.innerText()}`);
  }
  await page.locator('.picture').press('/');
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

const fingersOn = async (page) => {
  const touch = await page.context().newCDPSession(page);
  return (type, ...points) =>
    touch.send('Input.dispatchTouchEvent', { type, touchPoints: points.map(([x, y]) => ({ x, y })) });
};
const lampPlace = (page) =>
  page.evaluate(() => JSON.parse(sessionStorage.getItem('isolux')).edited.scene.light[0].at);

check('on a phone one finger takes the lamp over the surface when told so', async (page) => {
  const fingers = await fingersOn(page);
  const box = await page.locator('.picture').boundingBox();
  const [cx, cy] = [box.x + box.width / 2, box.y + box.height / 2];
  const slide = async () => {
    await fingers('touchStart', [cx, cy]);
    for (let n = 1; n <= 5; ++n) await fingers('touchMove', [cx + 8 * n, cy]);
    await fingers('touchEnd');
    await settled(page);
  };
  const [lamp, eye] = [await lampPlace(page), await camera(page)];
  await page.getByRole('radio', { name: 'Move lamp' }).check({ force: true });
  await slide();
  const moved = await lampPlace(page);
  assert.notDeepEqual(moved, lamp);
  assert.deepEqual(await camera(page), eye);
  await page.getByRole('radio', { name: 'Orbit' }).check({ force: true });
  await slide();
  assert.deepEqual(await lampPlace(page), moved);
  assert.notDeepEqual(await camera(page), eye);
}, phone);

check('two fingers move and zoom, about the point between them', async (page) => {
  const fingers = await fingersOn(page);
  const box = await page.locator('.picture').boundingBox();
  const [cx, cy] = [box.x + box.width / 2, box.y + box.height / 2];
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

/** How much of the picture's width or height the head takes, whichever is more. */
const filledShare = (page) => page.evaluate(() => {
  const canvas = document.querySelector('.picture canvas');
  const { width, height } = canvas;
  const { data } = canvas.getContext('2d').getImageData(0, 0, width, height);
  const different = (x, y) => data[4 * (y * width + x)] !== data[0];
  const columns = [...Array(width).keys()].filter((x) => [...Array(height).keys()].some((y) => different(x, y)));
  const rows = [...Array(height).keys()].filter((y) => [...Array(width).keys()].some((x) => different(x, y)));
  return Math.max((columns.at(-1) - columns[0]) / width, (rows.at(-1) - rows[0]) / height);
});

check('the head fills the window at the start, whatever its shape, until a hand zooms', async (page) => {
  for (const shape of [{ width: 1200, height: 500 }, { width: 800, height: 900 }]) {
    await page.setViewportSize(shape);
    await settled(page);
    await settled(page); // once it has been moved
    const largest = await filledShare(page);
    assert.ok(Math.abs(largest - 0.9) < 0.03, `${largest} of ${JSON.stringify(shape)}`);
  }
  await page.locator('.picture').press('-');
  await settled(page);
  const zoomed = await filledShare(page);
  assert.ok(zoomed < 0.86);
  await page.setViewportSize({ width: 800, height: 700 });
  await settled(page);
  await settled(page);
  assert.ok((await filledShare(page)) < 0.89);
  await page.getByRole('button', { name: 'Fit', exact: true }).click();
  await settled(page);
  assert.ok((await filledShare(page)) > 0.87);
});

check('on a phone the head fills what the open controls leave of the picture', async (page) => {
  await page.getByRole('button', { name: 'Surface', exact: true }).tap();
  await settled(page);
  await settled(page);
  const box = await page.locator('.picture').boundingBox();
  assert.ok(box.height > 0.4 * phone.viewport.height, `${box.height}`);
  assert.ok((await filledShare(page)) > 0.87);
}, phone);

check('an explanation stays with its point when the window changes its shape', async (page) => {
  const box = await page.locator('.picture').boundingBox();
  await page.mouse.click(box.x + 0.4 * box.width, box.y + 0.4 * box.height);
  const where = async () => {
    const text = await page.getByTestId('explained-pixel').textContent();
    const [, x, y] = /Pixel (\d+), (\d+)/.exec(text);
    const scene = await savedScene(page);
    return JSON.parse(isolux('explain', '--scene', scene, '--json', '--pixel', `${x},${y}`)).position;
  };
  const before = await where();
  await page.setViewportSize({ width: 1100, height: 600 });
  await settled(page);
  await settled(page);
  const now = await where();
  before.forEach((v, n) => assert.ok(Math.abs(v - now[n]) < 2, `${before} ${now}`)); // a pixel or so
});

check('all headings of the controls are in sight at a desk, and what was folded stays so', async (page) => {
  const names = ['Lamp', 'Surface', 'Light', 'View', 'Explain'];
  const heading = (name) => page.getByRole('heading', { name, level: 2 }).getByRole('button');
  await heading('Light').click();
  await heading('View').click(); // more than there is room for
  for (const scrolled of [0, 250, 1000]) {
    await page.locator('.sections').evaluate((one, y) => one.scrollTo(0, y), scrolled);
    for (const name of names) {
      const box = await heading(name).boundingBox();
      assert.ok(box.y >= 44 && box.y + box.height <= 900, `${name} ${box.y}`);
    }
  }
  await page.locator('.sections').evaluate((one) => one.scrollTo(0, 0));
  await heading('Lamp').click();
  const states = () => Promise.all(names.map((name) => heading(name).getAttribute('aria-expanded')));
  const folded = ['false', 'true', 'true', 'true', 'false'];
  assert.deepEqual(await states(), folded);
  await page.reload();
  await settled(page);
  assert.deepEqual(await states(), folded);
}, { viewport: { width: 1440, height: 900 } });

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
    for (const name of ['Light', 'View']) await page.getByRole('button', { name, exact: true }).click();
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
