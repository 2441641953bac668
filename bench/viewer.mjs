// How long it takes in the viewer from a slider's event to the painted frame, in a headless
// Chromium on this machine, and what of that is the server's: see bench/README.md.
import { loadavg } from 'node:os';
import { quantile } from './quantile.mjs';
import { openSocket } from '../tests/web/socket.mjs';
import { closeBrowser, openBrowser, openPage, settled, startViewer } from '../tests/web/viewer.mjs';

const events = 300;
const pace = 16; // ms between two events: a mouse's
const effects = {
  'lamp': {},
  'lamp, shadows': { shadows: 'on' },
  'lamp, shadows, transport': { shadows: 'on', indirect: 'transport' },
};

/** What the server says that frames took while the lamp moves, in ms: of 1024 x 1024 pixels, or of
 * as many as it found time for. */
async function serverTimes(viewer, effect) {
  const page = await openSocket(viewer);
  const times = { light: [], encode: [], size: [] };
  for (let id = 1; id <= 45; ++id) {
    const lamp = { kind: 'point', at: [-200 + 5 * id, -400, 200] };
    const scene = { ...page.hello.scene, size: [1024, 1024], ...effect, light: [lamp] };
    page.send({ type: 'view', id, scene, show: ['picture'], light: 0, settled: id === 3 });
    const frame = await page.next('frame', 'error');
    if (frame.type === 'error') throw new Error(frame.message);
    page.send({ type: 'ack', id });
    if (id <= 5) continue; // made ready, links shot
    times.light.push(frame.ms.light);
    times.encode.push(frame.ms.encode);
    times.size = frame.size;
  }
  page.close();
  return times;
}

/** Drags the first slider to and fro; the page notes each frame that it paints. */
async function browserTimes(viewer, effect) {
  const page = await openPage(viewer, { viewport: { width: 1440, height: 900 } });
  for (const [key, value] of [['s', effect.shadows], ['i', effect.indirect]]) {
    if (!value) continue;
    await page.keyboard.press(key);
    await settled(page);
  }
  const slider = await page.locator('#lamp-x').boundingBox();
  const at = (n) => slider.x + slider.width * (0.5 + 0.3 * Math.sin(n / 40));
  const y = slider.y + slider.height / 2;
  await page.mouse.move(at(0), y);
  await page.mouse.down();
  await page.evaluate(() => performance.clearMeasures());
  const begin = performance.now();
  for (let n = 0; n < events; ++n) {
    await page.mouse.move(at(n), y);
    await page.waitForTimeout(Math.max(0, begin + (n + 1) * pace - performance.now()));
  }
  const seconds = (performance.now() - begin) / 1000;
  const painted = await page.evaluate(() =>
    performance.getEntriesByName('isolux frame').map((entry) => entry.duration));
  await page.mouse.up();
  const size = await page.evaluate(() => {
    const { width, height } = document.querySelector('.picture canvas');
    return `${width}x${height}`;
  });
  await page.context().close();
  return { painted, seconds, size };
}

const input = process.env.INPUT ?? 'example:ct-head';
const viewer = await startViewer(input);
await openBrowser();
console.log(`${input}, load average ${loadavg()[0].toFixed(2)}; ms`);
for (const [name, effect] of Object.entries(effects)) {
  const { light, encode, size: asked } = await serverTimes(viewer, effect);
  const { painted, seconds, size } = await browserTimes(viewer, effect);
  const text = (list, share) => quantile(list, share).toFixed(1);
  console.log(`${name}: server at ${asked.join('x')}: lighting ${text(light, 0.5)}, encoding ` +
    `${text(encode, 0.5)}; event to painted frame (${size}): p50 ${text(painted, 0.5)}, ` +
    `p95 ${text(painted, 0.95)}, ${(painted.length / seconds).toFixed(0)} frames a second`);
}
await closeBrowser();
await viewer.remove();
process.exit(0);
