// How soon the viewer shows indirect light by cached transport, over its socket: after a change of
// iso value, and while the lamp moves, with what each part takes. See bench/README.md.
//
//     node tests/web/run.mjs bench/first_light.mjs        JSON=1: an object in place of the tables
import { loadavg } from 'node:os';
import { openSocket } from '../tests/web/socket.mjs';
import { closeBrowser, openBrowser, openPage, startViewer } from '../tests/web/viewer.mjs';
import { quantile } from './quantile.mjs';

const size = [1024, 1024];
const isoValues = [220, 340, 460];
const pageWaits = 160; // ms without a change before the page asks for the settled frame
const lampMoves = 40;
const mostFrames = 30;
// Of the settled frame's indirect light, as shares: the mean is right, and so is what single pixels
// show but for blotches.
const isBelievable = ({ mean, off }) => Math.abs(mean - 1) < 0.1 && off < 0.25;
const parts = ['trace', 'indirect', 'light', 'encode'];
const median = (list) => quantile(list, 0.5);
const wait = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

const input = process.env.INPUT ?? 'example:ct-head';
const viewer = await startViewer(input);
await openBrowser();
const decoder = await openPage(viewer);
const socket = await openSocket(viewer);
let lastId = 0;

/** Asks for a frame; the frame, and when it was there. */
async function frameOf(scene, settled, show = ['picture']) {
  const id = ++lastId;
  socket.send({ type: 'view', id, scene, show, light: 0, settled });
  const frame = await socket.next('frame', 'error');
  if (frame.type === 'error') throw new Error(frame.message);
  const at = performance.now();
  socket.send({ type: 'ack', id });
  return { frame, at };
}

const scene = (iso, x = -120) => ({
  ...socket.hello.scene, size, shadows: 'on', indirect: 'transport', surface: [{ iso }],
  light: [{ kind: 'point', at: [x, -560, 260] }],
  camera: { eye: [-60, -620, 190], target: [118, -140, 80], fov: 24 },
});

/** The mean of one frame's greens, and how far they are from another's, as shares of the other's. */
const compared = (one, other) =>
  decoder.evaluate(async ([frames, width, height]) => {
    const greens = async ([base64, type]) => {
      const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
      const bitmap = await createImageBitmap(new Blob([bytes], { type }));
      const context = new OffscreenCanvas(width, height).getContext('2d');
      context.drawImage(bitmap, 0, 0, width, height);
      return context.getImageData(0, 0, width, height).data.filter((_, n) => n % 4 === 1);
    };
    const [a, b] = [await greens(frames[0]), await greens(frames[1])];
    const sum = b.reduce((total, value) => total + value, 0);
    return {
      mean: a.reduce((total, value) => total + value, 0) / sum,
      off: a.reduce((total, value, n) => total + Math.abs(value - b[n]), 0) / sum,
    };
  }, [[one, other].map(({ frame }) =>
    [frame.pictures.toString('base64'), frame.settled ? 'image/png' : 'image/jpeg']), ...size]);

/** A change is timed by the picture itself. On the way back the indirect light alone is looked at,
 * in frames one after the other as if a hand went on: the first that is believable. */
async function newIsoValues() {
  const rows = [];
  const alone = { ...scene(300), display: 'raw', exposure: 4 };
  await frameOf(scene(300), true);
  for (const iso of isoValues) {
    const begin = performance.now();
    const first = await frameOf(scene(iso), false);
    await wait(pageWaits);
    const settled = await frameOf(scene(iso), true);

    const backAt = performance.now();
    const frames = [];
    while (frames.length < mostFrames) frames.push(await frameOf(alone, false, ['indirect']));
    const whole = await frameOf(alone, true, ['indirect']);
    const found = [];
    for (const one of frames) found.push({ ms: one.at - backAt, ...await compared(one, whole) });
    rows.push({ iso, size: first.frame.size, first: first.at - begin, ...first.frame.ms,
                settled: settled.at - begin, share: found[0].mean,
                believable: found.find(isBelievable)?.ms ?? Infinity });
  }
  return rows;
}

async function movingLamp() {
  await frameOf(scene(300), true);
  const frames = [];
  for (let n = 0; n < lampMoves; ++n) {
    const begin = performance.now();
    const { frame, at } = await frameOf(scene(300, -120 + 4 * n), false);
    if (n >= 5) frames.push({ whole: at - begin, size: frame.size, ...frame.ms });
  }
  const row = { size: frames.at(-1).size };
  for (const part of ['whole', ...parts]) row[part] = median(frames.map((frame) => frame[part]));
  return { ...row, rate: 1000 / row.whole };
}

const load = loadavg()[0];
const report = { input, size, iso: await newIsoValues(), lamp: await movingLamp(), load };
if (process.env.JSON) {
  console.log(JSON.stringify(report, null, 1));
} else {
  const ms = (value) => value.toFixed(0);
  const share = (value) => (100 * value).toFixed(0) + ' %';
  console.log('| new iso value | first frame | at | trace | indirect | light | encode | settled frame | ' +
    'back at 300: the first shows of it | believable |');
  console.log('| ---: | ---: | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |');
  for (const row of report.iso) {
    console.log(`| ${row.iso} | ${ms(row.first)} ms | ${row.size.join('x')} | ` +
      parts.map((part) => ms(row[part])).join(' | ') +
      ` | ${ms(row.settled)} ms | ${share(row.share)} | ${ms(row.believable)} ms |`);
  }
  const { lamp } = report;
  console.log('\n| lamp moving | a frame | frames a second | trace | indirect | light | encode |');
  console.log('| --- | ---: | ---: | ---: | ---: | ---: | ---: |');
  console.log(`| ${lamp.size.join('x')} | ${ms(lamp.whole)} ms | ${lamp.rate.toFixed(1)} | ` +
    parts.map((part) => ms(lamp[part])).join(' | ') + ' |');
  console.log(`${input}, load average ${load.toFixed(2)} before, ${loadavg()[0].toFixed(2)} after`);
}
socket.close();
await closeBrowser();
await viewer.remove();
process.exit(0);
