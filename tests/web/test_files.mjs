// Opening, loading, going away and coming back.
import assert from 'node:assert/strict';
import { existsSync, mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import {
  begin, closeBrowser, isolux, openBrowser, openPage, patience, pixels, savedScene, settled, shared,
  startViewer, withPage,
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
  test(name, { timeout: 4 * patience, ...options }, () => withPage(viewer, name, work));

const open = (page, file) => page.getByTestId('open-file').setInputFiles(file);
const noShared = existsSync(join(shared, 'data')) ? false : 'the shared data is not here';

check('a good file is opened, drawn as isolux render draws it, and undone', async (page) => {
  const file = join(folder, 'ball.nii.gz');
  isolux('convert', 'phantom:sphere,size=33', file);
  await open(page, file);
  await page.getByRole('button', { name: 'Scan: ball.nii.gz' }).waitFor();
  await settled(page);
  const shown = await pixels(page);
  const scene = await savedScene(page);
  const document = JSON.parse(readFileSync(scene, 'utf8'));
  assert.deepEqual(document.input, ['ball.nii.gz']);
  document.input = [file];
  writeFileSync(join(folder, 'scene.json'), JSON.stringify(document));
  isolux('render', '--scene', join(folder, 'scene.json'), '-o', join(folder, 'ball.png'));
  assert.deepEqual(shown, await pixels(page, readFileSync(join(folder, 'ball.png'))));
  await page.keyboard.press('Control+z');
  await page.getByRole('button', { name: 'Scan: phantom:head,size=48' }).waitFor();
});

/** Whether the settled picture is that of isolux render, with `path` in place of what was dropped. */
async function isRenderedFrom(page, path) {
  await settled(page);
  const shown = await pixels(page);
  const document = JSON.parse(readFileSync(await savedScene(page), 'utf8'));
  document.input = [path];
  writeFileSync(join(folder, 'scene.json'), JSON.stringify(document));
  isolux('render', '--scene', join(folder, 'scene.json'), '-o', join(folder, 'rendered.png'));
  assert.deepEqual(shown, await pixels(page, readFileSync(join(folder, 'rendered.png'))));
  assert.ok(shown.bright > 1000, 'there is something in the picture');
}

check('loose DICOM slices are one scan, and so is a folder of them', async (page) => {
  const slices = join(shared, 'data/dicom/ct_head_slicer');
  const names = readdirSync(slices).sort();
  await open(page, names.map((name) => join(slices, name)));
  await page.getByRole('button', { name: `Scan: ${names[0]} and ${names.length - 1} more` }).waitFor();
  await isRenderedFrom(page, slices);
  await page.getByTestId('open-folder').setInputFiles(slices);
  await page.getByRole('button', { name: 'Scan: ct_head_slicer' }).waitFor();
  await isRenderedFrom(page, slices);
}, { skip: noShared });

check('a mesh with its materials is opened, drawn as isolux render draws it, and coloured', async (page) => {
  const meshes = join(shared, 'data/meshes');
  await open(page, ['cornell_box.obj', 'cornell_box.mtl'].map((name) => join(meshes, name)));
  await page.getByRole('button', { name: 'Scan: cornell_box.obj and 1 more' }).waitFor();
  await isRenderedFrom(page, join(meshes, 'cornell_box.obj'));
  await page.getByRole('slider', { name: 'kd diffuse', exact: true }).press('PageDown');
  await page.getByRole('button', { name: 'View', exact: true }).click();
  await page.getByRole('radio', { name: 'rasteriser' }).check();
  await isRenderedFrom(page, join(meshes, 'cornell_box.obj'));
  const changed = await pixels(page);
  await page.getByRole('button', { name: /^Back to the file/ }).click();
  await isRenderedFrom(page, join(meshes, 'cornell_box.obj'));
  assert.notEqual((await pixels(page)).checksum, changed.checksum);
}, { skip: noShared });

check('a slow upload shows how far it is, and can be cancelled', async (page) => {
  const network = await page.context().newCDPSession(page);
  await network.send('Network.enable');
  await network.send('Network.emulateNetworkConditions',
    { offline: false, latency: 0, downloadThroughput: -1, uploadThroughput: 50_000 });
  await open(page, { name: 'slow.nrrd', mimeType: '', buffer: Buffer.alloc(4_000_000) });
  const note = page.locator('.note.work');
  await note.getByText('Opening slow.nrrd: sending').waitFor();
  await note.getByRole('button', { name: 'Cancel' }).click();
  await note.waitFor({ state: 'detached' });
  assert.equal(await page.locator('.note.error').count(), 0);
  await page.getByRole('button', { name: 'Scan: phantom:head,size=48' }).waitFor();
});

check('a damaged file says what is wrong with it, and the picture stays', async (page) => {
  const before = await pixels(page);
  for (const bad of ['nifti/crash-1.nii', 'nrrd/test3dlist_origin.nhdr', 'dicom/badVR.dcm']) {
    await open(page, join(shared, 'data/bad', bad));
    const note = page.locator('.note.error').last();
    await note.waitFor();
    const text = await note.locator('span').innerText();
    assert.match(text, /^[^/]+: .+; .+$/, text);
    assert.doesNotMatch(text, /tmp/);
    await note.getByRole('button', { name: 'Close' }).click();
  }
  page.complaints = page.complaints.filter((said) => !said.includes('422') && !said.includes('400'));
  assert.deepEqual(await pixels(page), before);
}, { skip: noShared });

check('a saved scene is loaded again, and a wrong one is refused with the reason', async (page) => {
  await page.getByRole('button', { name: 'skin' }).click();
  const scene = await savedScene(page);
  await page.getByRole('button', { name: 'bone', exact: true }).click();
  await page.getByTestId('load-scene').setInputFiles(scene);
  await page.getByText(/^Loaded/).waitFor();
  assert.equal(await page.getByLabel('iso value, as a number').inputValue(), '-300');
  for (const [text, why] of [
    ['{', 'is not valid JSON'],
    ['{"isolux_scene": 1, "lihgt": []}', 'did you mean light'],
    ['{"isolux_scene": 1, "input": ["/etc/passwd"]}', 'is not open here'],
  ]) {
    const wrong = { name: 'wrong.json', mimeType: 'application/json', buffer: Buffer.from(text) };
    await page.getByTestId('load-scene').setInputFiles(wrong);
    await page.locator('.note.error').getByText(why).waitFor();
  }
  assert.equal(await page.getByLabel('iso value, as a number').inputValue(), '-300');
});

check('a page finds back to a server that was started again, with its state', async (page) => {
  await page.locator('#lamp-x').press('PageUp');
  const x = await page.getByLabel('Lamp 1, x, as a number').last().inputValue();
  await settled(page);
  const before = await pixels(page);
  assert.equal(await viewer.stop(), 0);
  await page.getByText('The server is away').waitFor();
  await begin(viewer);
  await settled(page);
  assert.equal(await page.getByLabel('Lamp 1, x, as a number').last().inputValue(), x);
  assert.deepEqual(await pixels(page), before);
  await page.reload();
  await settled(page);
  assert.equal(await page.getByLabel('Lamp 1, x, as a number').last().inputValue(), x);
  page.complaints = page.complaints.filter((said) => !said.includes('ERR_CONNECTION_REFUSED'));
});

check('two tabs have a state each', async (page) => {
  const other = await openPage(viewer);
  const before = await pixels(other);
  await page.locator('#lamp-x').press('PageUp');
  await settled(page);
  assert.notEqual((await pixels(page)).checksum, before.checksum);
  assert.deepEqual(await pixels(other), before);
  await other.context().close();
});
