// What the page shows is what the program says elsewhere.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import {
  closeBrowser, downloaded, isolux, openBrowser, patience, pixels, program, savedScene, settled, startViewer,
  withPage,
} from './viewer.mjs';

let viewer;
let folder;
before(async () => {
  folder = mkdtempSync(join(tmpdir(), 'isolux-web-files-'));
  viewer = await startViewer('phantom:head,size=48');
  await openBrowser();
});
after(async () => {
  await closeBrowser();
  await viewer.remove();
  rmSync(folder, { recursive: true, force: true });
});
const check = (name, work, options) =>
  test(name, { timeout: 4 * patience }, () => withPage(viewer, name, work, options));

check('the settled picture has the very pixels of isolux render', async (page) => {
  // Something else than the beginning: turned, nearer, another iso value and lamp.
  await page.locator('.picture').press('ArrowLeft');
  await page.locator('.picture').press('ArrowUp');
  await page.locator('.picture').press('+');
  await page.getByRole('slider', { name: /^Iso value of surface 1/ }).press('PageDown');
  await page.locator('#lamp-x').press('PageUp');
  await settled(page);
  const shown = await pixels(page);
  const scene = await savedScene(page);
  isolux('render', '--scene', scene, '-o', join(folder, 'same.png'));
  assert.deepEqual(shown, await pixels(page, readFileSync(join(folder, 'same.png'))));
  assert.ok(shown.bright > 1000, 'there is a head in the picture');
});

check('a saved picture is the file that isolux render writes', async (page) => {
  const picture = await downloaded(page, async () => {
    await page.getByRole('button', { name: /^Save/ }).click();
    await page.getByLabel('Width in pixels').fill('64');
    await page.getByLabel('Height in pixels').fill('48');
    await page.locator('.menu-line').getByRole('button', { name: 'Save' }).click();
  });
  const scene = await savedScene(page);
  const document = JSON.parse(readFileSync(scene, 'utf8'));
  const size = ['--size', '64x48'];
  assert.ok(document.size[0] > 64);
  isolux('render', '--scene', scene, ...size, '-o', join(folder, 'saved.png'));
  assert.ok(readFileSync(picture).equals(readFileSync(join(folder, 'saved.png'))));
});

check('a click tells the numbers of isolux explain', async (page) => {
  const box = await page.locator('.picture').boundingBox();
  await page.mouse.click(box.x + 0.5 * box.width, box.y + 0.4 * box.height);
  const pixel = /Pixel (\d+), (\d+)/.exec(await page.getByTestId('explained-pixel').textContent());
  const scene = await savedScene(page);
  const why = JSON.parse(
    isolux('explain', '--scene', scene, '--json', '--pixel', `${pixel[1]},${pixel[2]}`),
  );
  assert.ok(why.hit);
  const rows = await page.locator('.terms tbody tr').allInnerTexts();
  const numbers = Object.fromEntries(
    rows.map((row) => {
      const [name, ...values] = row.split(/\s+/);
      return [name, values.map((value) => Number(value.replace('−', '-')))];
    }),
  );
  const near = (shown, told) =>
    shown.forEach((value, c) => assert.ok(Math.abs(value - told[c]) <= 0.0005 + 1e-9));
  near(numbers.ambient, why.ambient);
  near(numbers.diffuse, why.lights[0].diffuse);
  near(numbers.specular, why.lights[0].specular);
  near(numbers.total, why.total);
  assert.match(await page.locator('.cosines').innerText(),
    new RegExp('cos θ = ' + why.lights[0].cos_theta.toFixed(3).replace('-', '−')));
  await page.locator('.katex').first().waitFor();
  assert.equal(await page.locator('.katex-error').count(), 0);
  assert.deepEqual(await page.locator('.vector text').allTextContents(), ['l', 'r', 'n', 'e']);
});

check('a click beside the head says that nothing is met', async (page) => {
  const box = await page.locator('.picture').boundingBox();
  await page.mouse.click(box.x + 8, box.y + box.height / 2);
  await page.getByText('No surface is met here').waitFor();
});

check('pointing at a term shows it alone', async (page) => {
  const box = await page.locator('.picture').boundingBox();
  await page.mouse.click(box.x + 0.5 * box.width, box.y + 0.4 * box.height);
  await page.getByRole('button', { name: 'specular', exact: true }).hover();
  await page.locator('.legend').getByText('Specular alone').waitFor();
  await page.mouse.move(box.x + 8, box.y + 8);
  await page.locator('.legend').waitFor({ state: 'detached' });
});

check('a split view shows two layers, and its divider moves', async (page) => {
  await page.keyboard.press('/');
  await page.getByLabel('Right half of the split').selectOption('cos-theta');
  await settled(page);
  assert.deepEqual(await page.locator('.legend').allInnerTexts().then((all) =>
    all.map((text) => text.split('\n')[0])), ['Picture', 'cos θ (n · l)']);
  const divider = page.getByRole('separator');
  const box = await divider.boundingBox();
  await page.mouse.move(box.x + box.width / 2, 300);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 2 + 80, 300, { steps: 4 });
  await page.mouse.up();
  const moved = await divider.boundingBox();
  assert.ok(Math.abs(moved.x - box.x - 80) < 2);
  await page.keyboard.press('Control+z'); // the divider
  assert.ok(Math.abs((await divider.boundingBox()).x - box.x) < 2);
  await page.keyboard.press('Control+z'); // the other layer
  await page.keyboard.press('Control+z'); // the split
  assert.equal(await divider.count(), 0);
});

check('shadows, mirrors and what is seen through a surface are those of isolux render', async (page) => {
  await page.getByRole('button', { name: 'Add surface' }).click(); // the skin, about the bone
  await page.getByRole('slider', { name: 'opacity' }).press('PageDown');
  await page.getByRole('slider', { name: 'kr mirror', exact: true }).press('PageUp');
  await page.locator('.picture').press('s');
  await settled(page);
  const shown = await pixels(page);
  const scene = await savedScene(page);
  const document = JSON.parse(readFileSync(scene, 'utf8'));
  assert.equal(document.shadows, 'on');
  assert.ok(document.surface[1].opacity < 1 && document.surface[1].kr[0] > 0);
  isolux('render', '--scene', scene, '-o', join(folder, 'layers.png'));
  assert.deepEqual(shown, await pixels(page, readFileSync(join(folder, 'layers.png'))));
  await page.locator('.picture').press('e');
  const layers = page.locator('.explain table').first().locator('tbody tr');
  await layers.nth(1).waitFor();
  await page.locator('.picture').press('Escape');
});

check('the copied command makes the very file that is saved', async (page) => {
  await page.context().grantPermissions(['clipboard-read', 'clipboard-write']);
  await page.locator('.picture').press('ArrowLeft');
  await page.locator('#lamp-x').press('PageUp');
  await page.getByRole('button', { name: /^Save/ }).click();
  await page.getByRole('button', { name: /^Copy as command/ }).click();
  await page.getByText('Copied the command').waitFor();
  const command = await page.evaluate(() => navigator.clipboard.readText());
  const done = spawnSync('sh', ['-c', command.replace(/^isolux /, `'${program}' `)], { cwd: folder });
  assert.equal(done.status, 0, String(done.stderr));
  const picture = await downloaded(page, () => page.keyboard.press('Control+s'));
  assert.ok(readFileSync(picture).equals(readFileSync(join(folder, 'picture.png'))));
});
