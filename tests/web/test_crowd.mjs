// Many pages at once, and some that mean no good: nobody waits for another, and memory is bounded.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { connect } from 'node:net';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { ask, masked, openSocket, upgrade, withToken } from './socket.mjs';
import { isolux, patience, startViewer } from './viewer.mjs';

let viewer;
before(async () => {
  viewer = await startViewer('phantom:head,size=48');
});
after(() => viewer.remove());
const check = (name, work) => test(name, { timeout: 4 * patience }, work);

const scene = (size, x) => ({
  isolux_scene: 1,
  input: ['phantom:head,size=48'],
  size: [size, size],
  surface: [{ iso: 300 }],
  light: [{ kind: 'point', at: [x, -200, 100] }],
});
const view = (id, size, settled = false) => ({
  type: 'view', id, scene: scene(size, id % 100), show: ['picture'], light: 0, settled,
});

/** A page that drags its lamp without rest; `frames` counts. */
function dragging(page, size, goesOn) {
  const state = { frames: 0 };
  state.done = (async () => {
    for (let id = 1; goesOn(state.frames); ++id) {
      page.send(view(id, size));
      const frame = await page.next('frame');
      page.send({ type: 'ack', id: frame.id });
      state.frames += 1;
    }
  })();
  return state;
}

const memory_kb = () =>
  Number(/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${viewer.child.pid}/status`, 'utf8'))[1]);

check('eight pages at once get their frames in turn, also beside one with a larger picture', async () => {
  const wanted = 20;
  const pages = await Promise.all(Array.from({ length: 8 }, () => openSocket(viewer)));
  let goesOn = true;
  const all = pages.map((page, n) => dragging(page, n === 0 ? 1600 : 800, () => goesOn));
  while (Math.min(...all.map(({ frames }) => frames)) < wanted) {
    await new Promise((resolve) => setTimeout(resolve, 5));
  }
  goesOn = false;
  const frames = all.map((one) => one.frames);
  await Promise.all(all.map(({ done }) => done));
  for (const page of pages) page.close();
  // Whose answer is a little late may miss a turn, now and then.
  assert.ok(Math.max(...frames) <= 1.5 * wanted, `frames: ${frames}`);
});

check('one that asks without rest gets no more turns than one that drags', async () => {
  const wanted = 30;
  const page = await openSocket(viewer);
  const greedy = await openSocket(viewer);
  let greedyFrames = 0;
  let goesOn = true;
  const flood = (async () => {
    for (let id = 1; goesOn; ++id) {
      greedy.send(view(id, 300));
      greedy.send({ type: 'explain', id: 1e6 + id, scene: scene(300, 0), pixel: [80, 80] });
      await new Promise((resolve) => setTimeout(resolve, 4)); // within the rate
    }
  })();
  const acknowledge = async () => {
    const frame = await greedy.next('frame');
    greedy.send({ type: 'ack', id: frame.id });
    greedyFrames += 1;
    if (goesOn) void acknowledge();
  };
  void acknowledge();
  await dragging(page, 300, (frames) => frames < wanted).done;
  const got = greedyFrames;
  goesOn = false;
  await flood;
  page.close();
  greedy.close();
  assert.ok(got <= 1.5 * wanted, `${got} beside ${wanted}`);
});

check('one that asks and does not read cannot grow the memory', async () => {
  const { socket } = await ask(viewer, '/socket', upgrade(viewer));
  socket.on('error', () => {});
  socket.pause();
  const closed = new Promise((resolve) => socket.on('close', resolve));
  const before = memory_kb();
  // Each is answered with an error that repeats the 200 kB: 500 of them would be 100 MB.
  const large = { ...scene(64, 0), display: 'a'.repeat(200_000) };
  for (let id = 1; id <= 1000 && !socket.destroyed; ++id) {
    socket.write(masked(JSON.stringify({ type: 'describe', id, scene: large })));
    await new Promise((resolve) => setTimeout(resolve, 2));
  }
  const grown = memory_kb() - before;
  socket.destroy();
  await closed;
  assert.ok(grown < 120_000, `${grown} kB`);
});

check('connections that say nothing make way for those that do', async () => {
  // The server keeps 128.
  const silent = Array.from({ length: 200 }, (_, n) => {
    const socket = connect(viewer.port, '127.0.0.1');
    socket.on('error', () => {});
    if (n % 2) socket.write('GET / HTTP/1.1\r\nHost: 127'); // half a request
    return socket;
  });
  await Promise.all(silent.map((socket) => new Promise((resolve) => socket.on('connect', resolve))));
  const page = await openSocket(viewer);
  page.send(view(1, 64));
  assert.equal((await page.next('frame')).id, 1);
  page.close();
  for (const socket of silent) socket.destroy();
});

check('a settled picture that is stopped never comes', async () => {
  const page = await openSocket(viewer);
  page.send(view(1, 4000, true));
  if ((await page.next('progress', 'frame')).type === 'frame') return; // too fast to be stopped
  page.send({ type: 'stop', id: 2 });
  page.send({ type: 'pick', id: 3, at: [0.5, 0.5] });
  await page.next('picked');
  assert.equal(page.has('frame'), false);
  page.send(view(4, 64, true));
  assert.equal((await page.next('frame')).id, 4);
  page.close();
});

check('long work tells how far it is, and what nobody waits for any more is not done', async () => {
  const file = join(tmpdir(), `isolux-crowd-${process.pid}.nrrd`);
  isolux('convert', 'phantom:sphere,size=9', file);
  const body = readFileSync(file);
  const slow = ask(viewer, '/save', {
    method: 'POST',
    headers: withToken(viewer, { 'X-Isolux-Work': 'slow' }),
    body: JSON.stringify({ scene: scene(3000, 0), format: 'png' }),
  });
  const told = await ask(viewer, '/progress', {
    method: 'POST', headers: withToken(viewer, { 'X-Isolux-Work': 'slow' }),
  });
  assert.match(told.body.toString(), /^\{"label":"[^"]+","share":[\d.]+\}$|^null$/);
  const left = connect(viewer.port, '127.0.0.1');
  left.write(
    `POST /open?name=left.nrrd HTTP/1.1\r\nHost: 127.0.0.1:${viewer.port}\r\nOrigin: ${viewer.origin}\r\n` +
      `Authorization: Bearer ${viewer.token}\r\nContent-Length: ${body.length}\r\n\r\n`,
  );
  await new Promise((resolve) => left.write(body, resolve));
  left.destroy();
  const stayed = ask(viewer, '/open?name=stayed.nrrd', { method: 'POST', headers: withToken(viewer), body });
  assert.equal((await slow).status, 200);
  assert.equal((await stayed).status, 200);
  const page = await openSocket(viewer);
  page.close();
  const open = page.hello.inputs.map(({ input }) => input);
  assert.deepEqual(open, ['phantom:head,size=48', 'stayed.nrrd']);
});
