// The main job: the lamp moves, and the picture follows.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import {
  closeBrowser, counters, openBrowser, patience, pixels, settled, startViewer, withPage,
} from './viewer.mjs';

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
  test(name, { timeout: 2 * patience }, () => withPage(viewer, name, work, options));

const frameNumber = async (page) => Number(await page.locator('.status').getAttribute('data-frame'));

check('the x slider relights the picture without tracing a ray', async (page) => {
  const before = await pixels(page);
  const counted = await counters(page);
  const frame = await frameNumber(page);
  await page.locator('#lamp-x').focus();
  for (let n = 0; n < 20; ++n) await page.keyboard.press('PageUp');
  await settled(page, frame);
  const now = await counters(page);
  assert.equal(now.visibility, counted.visibility);
  assert.equal(now.skip_structure, counted.skip_structure);
  assert.ok(now.lighting > counted.lighting);
  assert.notEqual((await pixels(page)).checksum, before.checksum);
});

check('the sun in the picture can be dragged', async (page) => {
  const x = page.getByLabel('Lamp 1, x, as a number').last();
  const before = Number(await x.inputValue());
  const box = await page.locator('.lamp .halo').boundingBox();
  const [cx, cy] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(cx, cy);
  await page.mouse.down();
  await page.mouse.move(cx + 60, cy + 20, { steps: 5 });
  await page.mouse.up();
  await settled(page);
  // From the front, right in the picture is +x (the patient's left).
  assert.ok(Number(await x.inputValue()) > before + 5);
  const moved = await page.locator('.lamp .halo').boundingBox();
  assert.ok(Math.abs(moved.x - box.x - 60) < 3 && Math.abs(moved.y - box.y - 20) < 3);
});

check('with Shift the lamp moves over the surface', async (page) => {
  const place = async () =>
    Promise.all(['x', 'y', 'z'].map((axis) =>
      page.getByLabel(`Lamp 1, ${axis}, as a number`).last().inputValue()));
  const before = await place();
  const box = await page.locator('.picture').boundingBox();
  await page.keyboard.down('Shift');
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 2 + 10, box.y + box.height / 2, { steps: 3 });
  await page.mouse.up();
  await page.keyboard.up('Shift');
  await settled(page);
  assert.notDeepEqual(await place(), before);
});

check('when told so, a drag without Shift moves the lamp and a click puts it there', async (page) => {
  const kept = () => page.evaluate(() => {
    const { scene } = JSON.parse(sessionStorage.getItem('isolux')).edited;
    return [scene.light[0].at, scene.camera];
  });
  const [lamp, camera] = await kept();
  const box = await page.locator('.picture').boundingBox();
  const [cx, cy] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.keyboard.press('m');
  await page.mouse.move(cx, cy);
  await page.mouse.down();
  await page.mouse.move(cx + 40, cy, { steps: 5 });
  await page.mouse.up();
  await settled(page);
  const [dragged, sameCamera] = await kept();
  assert.notDeepEqual(dragged, lamp);
  assert.deepEqual(sameCamera, camera);
  await page.mouse.click(cx - 40, cy);
  await settled(page);
  assert.notDeepEqual((await kept())[0], dragged);
  assert.equal(await page.getByTestId('explained-pixel').count(), 0);
  await page.keyboard.press('m');
  await page.mouse.click(cx, cy);
  await page.getByTestId('explained-pixel').waitFor();
});

check('lamps are added, turned into voxels and removed, and each step is undone', async (page) => {
  const lamps = page.locator('.lamps li');
  await page.getByRole('button', { name: 'Add', exact: true }).click();
  assert.equal(await lamps.count(), 2);
  const x = page.getByLabel('Lamp 2, x, as a number').last();
  const mm = Number(await x.inputValue());
  await page.getByRole('radio', { name: 'voxel' }).check();
  // The phantom has 48 voxels over 255 mm, centred on the origin: i = (x + 127.5) * 47 / 255.
  assert.ok(Math.abs(Number(await x.inputValue()) - ((mm + 127.5) * 47) / 255) < 1e-3);
  await page.getByRole('button', { name: 'Remove', exact: true }).click();
  assert.equal(await lamps.count(), 1);
  await page.keyboard.press('Control+z');
  assert.equal(await lamps.count(), 2);
  await page.keyboard.press('Control+z');
  await page.keyboard.press('Control+z');
  assert.equal(await lamps.count(), 1);
  await page.keyboard.press('Control+Shift+z');
  assert.equal(await lamps.count(), 2);
});

check('the lecture preset puts the lamp at voxel (0, 0, nz/2)', async (page) => {
  await page.getByRole('button', { name: 'Presets' }).click();
  await page.getByRole('button', { name: /^Lecture/ }).click();
  for (const [axis, value] of [['x', '0'], ['y', '0'], ['z', '24']]) {
    assert.equal(await page.getByLabel(`Lamp 1, ${axis}, as a number`).last().inputValue(), value);
  }
});

check('Shift makes a slider ten times finer, and Backspace resets it', async (page) => {
  const intensity = page.getByLabel('Intensity of lamp 1', { exact: true });
  const field = page.getByLabel('Intensity of lamp 1, as a number');
  const box = await intensity.boundingBox();
  const at = (share) => [box.x + 8 + share * (box.width - 16), box.y + box.height / 2];
  await page.mouse.move(...at(0.25)); // intensity 1 of 4
  await page.mouse.down();
  await page.keyboard.down('Shift');
  await page.mouse.move(...at(0.75), { steps: 4 });
  await page.mouse.up();
  await page.keyboard.up('Shift');
  const fine = Number(await field.inputValue());
  assert.ok(fine > 1.05 && fine < 1.5, `${fine} is about a tenth of the way from 1 to 3`);
  await intensity.press('Backspace');
  assert.equal(await field.inputValue(), '1');
});

check('while a lamp moves, its distance from what is seen stands beside it', async (page) => {
  const distance = page.locator('.lamp-distance');
  await page.locator('#lamp-y').press('PageDown');
  await distance.waitFor();
  const before = Number((await distance.textContent()).replace(' mm', ''));
  for (let n = 0; n < 3; ++n) await page.locator('#lamp-y').press('PageDown'); // away from the face
  await settled(page);
  assert.ok(Number((await distance.textContent()).replace(' mm', '')) > before + 5);
  await distance.waitFor({ state: 'detached' });
});
