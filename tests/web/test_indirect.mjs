// Light that surfaces send to each other: switched on, followed, compared, stopped and explained.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import {
  closeBrowser, counters, isolux, openBrowser, patience, phone, pixels, savedScene, settled, startViewer,
  withPage,
} from './viewer.mjs';

let viewer;
before(async () => {
  viewer = await startViewer('phantom:head,size=24', '--shadows', 'on');
  await openBrowser();
});
after(async () => {
  await closeBrowser();
  await viewer.remove();
});
const check = (name, work, options) =>
  test(name, { timeout: 4 * patience }, () => withPage(viewer, name, work, options));

const openLight = (page) => page.getByRole('button', { name: 'Light', exact: true }).click();

/** What `isolux render` makes of a scene document. */
function rendered(document) {
  const [scene, picture] = [join(viewer.state, 'scene.json'), join(viewer.state, 'picture.png')];
  writeFileSync(scene, JSON.stringify(document));
  isolux('render', '--scene', scene, '-o', picture);
  return readFileSync(picture);
}

/** The same, of the scene that the page has now. */
const documentOf = async (page) => JSON.parse(readFileSync(await savedScene(page), 'utf8'));

check('a lamp dragged through indirect light settles into the very pixels of isolux render', async (page) => {
  const without = await pixels(page);
  await page.locator('.picture').press('i');
  await openLight(page);
  await page.getByRole('slider', { name: 'bounces' }).press('ArrowRight'); // 2 and one more
  await settled(page);
  const before = await counters(page);
  const box = await page.locator('.lamp .halo').boundingBox();
  await page.mouse.move(box.x + 17, box.y + 17);
  await page.mouse.down();
  await page.mouse.move(box.x + 77, box.y + 57, { steps: 8 });
  await page.mouse.up();
  await settled(page);
  const now = await counters(page);
  assert.ok(now.indirect > before.indirect);
  const shown = await pixels(page);
  assert.notEqual(shown.checksum, without.checksum);
  const document = await documentOf(page);
  assert.equal(document.indirect, 'transport');
  assert.equal(document.bounces, 3);
  assert.deepEqual(shown, await pixels(page, rendered(document)));
});

check('the split that indirect light offers shows what lamps send alone beside all light', async (page) => {
  await page.locator('.picture').press('i');
  await openLight(page);
  await page.getByRole('button', { name: 'Split: direct | with indirect' }).click();
  await settled(page);
  assert.deepEqual(await page.locator('.legend').allInnerTexts(), ['Direct only', 'With indirect']);
  const document = await documentOf(page);
  const { indirect: _, bounces: __, ...rest } = document;
  const direct = rendered({ ...rest, indirect: 'off', ambient: [0, 0, 0] });
  assert.deepEqual(await pixels(page), await pixels(page, direct));
  const whole = rendered(document);
  assert.deepEqual(await pixels(page, undefined, 1), await pixels(page, whole));
  await page.locator('.picture').press('/');
  await settled(page);
  assert.equal(await page.locator('.legend').count(), 0);
  assert.deepEqual(await pixels(page), await pixels(page, whole));
  await page.locator('.picture').press('/'); // with indirect light on, the same split again
  assert.equal(await page.locator('.legend').count(), 2);
  await page.locator('.picture').press('i');
  await settled(page);
  assert.equal((await documentOf(page)).indirect, 'off');
});

/** Asks for more paths than anybody waits for. */
async function beginLongRefinement(page) {
  await openLight(page);
  await page.getByRole('radio', { name: 'path' }).check({ force: true });
  const samples = page.getByLabel('samples, as a number');
  await samples.fill('500');
  await samples.press('Enter');
  await page.locator('.refining progress').waitFor();
}

check('paths tell how far they are and stop when told to', async (page) => {
  await beginLongRefinement(page);
  assert.match(await page.locator('.refining').innerText(), /following light \d+ %/);
  await page.getByRole('button', { name: 'Stop' }).click();
  await page.getByText('coarse: refining was stopped').waitFor();
  await page.getByRole('button', { name: 'Go on' }).click();
  await page.locator('.refining progress').waitFor();
  await page.locator('.picture').press('i'); // off: what comes next is drawn as ever
  await settled(page);
});

check('on a phone the way of a picture and its end are in sight and under the thumb', async (page) => {
  await beginLongRefinement(page);
  const stop = page.getByRole('button', { name: 'Stop' });
  const box = await stop.boundingBox();
  assert.ok(box.height >= 40 && box.width >= 40, JSON.stringify(box));
  assert.ok(await page.locator('.refining progress').isVisible());
  await stop.tap(); // which fails where anything lies over it
  await page.locator('.refining progress').waitFor({ state: 'detached' });
  await page.getByRole('radio', { name: 'off' }).check({ force: true });
  await settled(page);
}, phone);

check('an explanation names and draws the places that isolux explain names', async (page) => {
  await page.locator('.picture').press('i');
  await settled(page);
  const box = await page.locator('.picture').boundingBox();
  await page.mouse.click(box.x + 0.52 * box.width, box.y + 0.62 * box.height);
  const pixel = /Pixel (\d+), (\d+)/.exec(await page.getByTestId('explained-pixel').textContent());
  const { first_bounce: first } = JSON.parse(
    isolux('explain', '--scene', await savedScene(page), '--json', '--pixel', `${pixel[1]},${pixel[2]}`),
  );
  const rows = page.locator('.senders-table tbody tr');
  assert.equal(await rows.count(), first.senders.length);
  assert.ok(first.senders.length > 0);
  const shares = await rows.locator('td:last-child').allInnerTexts();
  shares.forEach((text, n) => {
    assert.ok(Math.abs(Number(text.replace(' %', '')) / 100 / first.senders[n].share - 1) < 0.01, text);
  });
  assert.equal(await page.locator('.senders circle').count(), first.senders.length);
});
