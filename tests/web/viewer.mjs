// A viewer under test and a browser to look at it with.
import { spawn, spawnSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { chromium } from 'playwright-core';

const root = join(dirname(fileURLToPath(import.meta.url)), '../..');
export const program = process.env.ISOLUX ?? join(root, 'build/release/isolux');
export const shared = process.env.SHARED ?? join(root, '../shared');
const failures = join(root, 'build/web-failures');

/** A bound against hanging; a frame of these small scenes takes a fraction of a second. */
export const patience = 15_000;

/** A running `isolux view`: its url, origin, port and token, and how to end it. */
export async function startViewer(...words) {
  const state = mkdtempSync(join(tmpdir(), 'isolux-web-'));
  const viewer = { words, state, log: '', stop: () => {} };
  process.on('exit', () => viewer.child?.kill('SIGKILL')); // whatever went wrong
  await begin(viewer);
  viewer.remove = async () => {
    await viewer.stop();
    rmSync(state, { recursive: true, force: true });
  };
  return viewer;
}

/** Starts the program of a viewer that was stopped, at the same port. */
export async function begin(viewer) {
  const port = viewer.port ? ['--port', viewer.port] : [];
  const child = spawn(program, ['view', '--no-open', ...port, ...viewer.words], {
    env: { ...process.env, XDG_STATE_HOME: viewer.state },
    stdio: ['ignore', 'pipe', 'pipe'],
  });
  child.stderr.on('data', (text) => (viewer.log += text));
  viewer.url = await new Promise((resolve, reject) => {
    let said = '';
    child.stdout.on('data', (text) => {
      said += text;
      if (said.includes('\n')) resolve(said.trim());
    });
    child.on('exit', () => reject(new Error('isolux view ended: ' + viewer.log)));
  });
  const { origin, port: at, hash } = new URL(viewer.url);
  Object.assign(viewer, { child, origin, port: Number(at), token: hash.slice(1) });
  viewer.stop = (signal = 'SIGINT') =>
    new Promise((resolve) => {
      if (child.exitCode !== null || child.signalCode !== null) return resolve(child.exitCode);
      child.on('exit', (status) => resolve(status));
      child.kill(signal);
    });
}

let browser;
export async function openBrowser() {
  const found = spawnSync('sh', ['-c', 'command -v chromium'], { encoding: 'utf8' });
  browser = await chromium.launch({
    executablePath: found.stdout.trim(),
    args: ['--no-sandbox'], // as root, and in containers
    timeout: patience,
  });
}
export const closeBrowser = () => browser?.close();

/** A page with a settled picture. What the page itself complains of is kept in page.complaints. */
export async function openPage(viewer, options = {}) {
  const context = await browser.newContext({ viewport: { width: 800, height: 600 }, ...options });
  const page = await context.newPage();
  page.setDefaultTimeout(patience);
  page.complaints = [];
  page.on('pageerror', (error) => page.complaints.push(error.message));
  page.on('console', (said) => {
    const isNetwork = said.text().includes('WebSocket connection'); // a server that is away
    if (said.type() === 'error' && !isNetwork) page.complaints.push(said.text());
  });
  await page.goto(viewer.url);
  await settled(page);
  return page;
}

/** Waits until the lossless picture of the state as it is now is on the page. */
export async function settled(page, after = 0) {
  await page.waitForTimeout(250); // longer than the page waits before it asks for that picture
  await page.waitForSelector('.status[data-settled=true]', { state: 'attached' });
  await page.waitForFunction(
    (id) => Number(document.querySelector('.status').dataset.frame) > id, after);
}

export const counters = async (page) =>
  JSON.parse(await page.locator('.status').getAttribute('data-counters'));

/** Runs `work(page)`, keeps a screenshot if it fails, and closes the page. */
export async function withPage(viewer, name, work, options) {
  const page = await openPage(viewer, options);
  try {
    await work(page);
    if (page.complaints.length > 0) throw new Error(page.complaints.join('\n'));
  } catch (error) {
    mkdirSync(failures, { recursive: true });
    const path = join(failures, name.replace(/\W+/g, '_') + '.png');
    await page.screenshot({ path }).catch(() => {});
    error.message += `\n(screenshot: ${path})`;
    throw error;
  } finally {
    await page.context().close();
  }
}

export const phone = {
  viewport: { width: 390, height: 844 }, deviceScaleFactor: 3, hasTouch: true, isMobile: true,
};

/** The picture as it stands in the page (of a split, half 0 or 1), or of a PNG file's bytes: size, a
 * checksum of its pixels, and how many of them are bright. */
export const pixels = (page, png, half = 0) =>
  page.evaluate(async ([base64, n]) => {
    let canvas = document.querySelectorAll('.picture canvas')[n];
    if (base64) {
      const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
      const blob = new Blob([bytes], { type: 'image/png' });
      const bitmap = await createImageBitmap(blob, { colorSpaceConversion: 'none' });
      canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
      canvas.getContext('2d').drawImage(bitmap, 0, 0);
    }
    const { width, height } = canvas;
    const { data } = canvas.getContext('2d').getImageData(0, 0, width, height);
    const digest = new Uint8Array(await crypto.subtle.digest('SHA-256', data));
    return {
      size: [width, height],
      checksum: [...digest].join(' '),
      bright: data.filter((value, n) => n % 4 === 0 && value > 100).length,
    };
  }, [png?.toString('base64'), half]);

/** The scene as the page has it now, written to a file. */
export const savedScene = (page) =>
  downloaded(page, async () => {
    await page.getByRole('button', { name: /^Save/ }).click();
    await page.getByRole('button', { name: /^The scene as a file/ }).click();
  });

/** What the page saves when `choose` is done: the path of the file. */
export async function downloaded(page, choose) {
  const [download] = await Promise.all([page.waitForEvent('download'), choose()]);
  return download.path();
}

export function isolux(...words) {
  const done = spawnSync(program, words.map(String), { encoding: 'utf8' });
  if (done.status !== 0) throw new Error(done.stderr);
  return done.stdout;
}
