// Who may not speak to the server, and what it bears.
import assert from 'node:assert/strict';
import { connect } from 'node:net';
import { after, before, test } from 'node:test';
import { ask as askOf, masked, upgrade as upgradeOf, withToken as tokenOf } from './socket.mjs';
import { patience, startViewer } from './viewer.mjs';

let viewer;
before(async () => {
  viewer = await startViewer('phantom:sphere');
});
after(() => viewer.remove());
const check = (name, work) => test(name, { timeout: 4 * patience }, work);

const ask = (path, options) => askOf(viewer, path, options);
const upgrade = (over) => upgradeOf(viewer, over);
const withToken = (over) => tokenOf(viewer, over);

async function serves() {
  const reply = await ask('/');
  assert.equal(reply.status, 200);
  const { status, socket } = await ask('/socket', upgrade());
  assert.equal(status, 101);
  const hello = await new Promise((resolve) => socket.once('data', resolve));
  assert.match(hello.toString('latin1'), /"type":"hello"/);
  socket.destroy();
}

check('the right token, host and origin open the socket', serves);

check('a wrong token, no token, and a cross-site origin do not', async () => {
  const wrong = '0'.repeat(64);
  for (const over of [
    { 'Sec-WebSocket-Protocol': `isolux.1, ${wrong}` },
    { 'Sec-WebSocket-Protocol': 'isolux.1' },
    { 'Sec-WebSocket-Protocol': `isolux.1, ${viewer.token.slice(0, -1)}` },
    { Origin: 'http://evil.example' },
    { Origin: 'null' },
    { Origin: `http://127.0.0.1:${viewer.port + 1}` },
  ]) {
    assert.equal((await ask('/socket', upgrade(over))).status, 403, JSON.stringify(over));
  }
});

check('a foreign host name that points here is turned away (DNS rebinding)', async () => {
  for (const host of ['evil.example', `evil.example:${viewer.port}`, '127.0.0.1.evil.example']) {
    const headers = { Host: host };
    assert.equal((await ask('/', { headers })).status, 421, host);
    const origin = { Host: host, Origin: `http://${host}` };
    assert.equal((await ask('/socket', upgrade(origin))).status, 421, host);
  }
});

check('behind a tunnel the port is another one, which is well', async () => {
  const over = { Host: 'localhost:9999', Origin: 'http://localhost:9999' };
  const { status, socket } = await ask('/socket', upgrade(over));
  assert.equal(status, 101);
  socket.destroy();
});

check('saving and opening want the token and the origin', async () => {
  for (const path of ['/save', '/open?name=a.nrrd']) {
    for (const headers of [
      {},
      { Origin: viewer.origin },
      { Authorization: `Bearer ${viewer.token}` },
      withToken({ Origin: 'http://evil.example' }),
      withToken({ Authorization: 'Bearer x' }),
    ]) {
      assert.equal((await ask(path, { method: 'POST', headers, body: '{}' })).status, 403);
    }
  }
});

check('no path reaches the disk', async () => {
  for (const path of ['/../../etc/passwd', '/%2e%2e/etc/passwd', '/etc/passwd', '//etc/passwd',
    '/assets/../../etc/passwd', '/view-token']) {
    assert.equal((await ask(path)).status, 404, path);
  }
  const scene = { isolux_scene: 1, input: ['/etc/passwd'], surface: [{ iso: 0 }] };
  const reply = await ask('/save', {
    method: 'POST', headers: withToken(), body: JSON.stringify({ scene, format: 'png' }),
  });
  assert.equal(reply.status, 422);
  assert.match(reply.body.toString(), /^\/etc\/passwd: is not open here; /);
});

check('the page allows no script, style or frame but its own, and tells nobody of its URL', async () => {
  const { headers, body } = await ask('/');
  const policy = headers['content-security-policy'];
  assert.match(policy, /default-src 'none'/);
  assert.match(policy, /frame-ancestors 'none'/);
  assert.doesNotMatch(policy, /unsafe|\*/);
  assert.equal(headers['referrer-policy'], 'no-referrer');
  assert.equal(headers['x-content-type-options'], 'nosniff');
  assert.ok(body.length > 0);
  assert.equal(viewer.log, '', 'nothing was logged, the token least of all');
});

check('other methods, long headers and no HTTP at all are turned away', async () => {
  assert.equal((await ask('/', { method: 'DELETE' })).status, 405);
  for (const bytes of ['GET / HTTP/1.1\r\nX: ' + 'a'.repeat(100_000), '\0'.repeat(5000), 'GET\r\n\r\n']) {
    const socket = connect(viewer.port, '127.0.0.1');
    socket.on('error', () => {});
    socket.write(bytes);
    await new Promise((resolve) => socket.on('close', resolve));
  }
  await serves();
});

check('10000 random messages, broken frames and half-open sockets leave it serving', async () => {
  let seed = 1;
  const random = (below) => {
    seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
    return Math.floor((seed / 2 ** 32) * below);
  };
  const words = ['"type"', '"view"', '"ack"', '"explain"', '"pick"', '"id"', '"scene"', '{', '}', '[', ']',
    ':', ',', '1e999', '-1', 'null', 'true', '"isolux_scene"', '"size"', '[1,1]', '"show"', '\u0000', '"é'];
  const real = [
    '{"type":"ack","id":1}',
    '{"type":"pick","id":1,"at":[0.5,0.5]}',
    '{"type":"view","id":2,"scene":{"isolux_scene":1,"input":["phantom:sphere"],"size":[8,8]},' +
      '"show":["picture"],"light":0,"settled":true}',
    '{"type":"describe","id":3,"scene":{"isolux_scene":1,"input":["phantom:sphere"]}}',
  ];
  const message = () => {
    if (random(3) === 0) return Array.from({ length: random(12) }, () => words[random(words.length)]).join('');
    const text = [...real[random(real.length)]];
    for (let n = random(4); n > 0; --n) text[random(text.length)] = words[random(words.length)];
    return text.join('');
  };
  const deep = '['.repeat(100_000);
  for (let connection = 0; connection < 10; ++connection) {
    const { socket } = await ask('/socket', upgrade());
    socket.on('error', () => {});
    const closed = new Promise((resolve) => socket.on('close', resolve));
    if (connection % 2 === 0) socket.resume(); // the others ask and never read
    for (let n = 0; n < 1000; ++n) socket.write(masked(message(), random(20) === 0 ? 2 : 1));
    socket.write(masked(deep));
    if (connection % 3 === 0) socket.write(Buffer.from([0xff, 0xff, 0xff, 0xff, 0xff]));
    if (connection % 3 === 1) socket.end();
    setTimeout(() => socket.destroy(), 500);
    await closed;
  }
  await serves();
});

check('a client that floods is let go, and others are served meanwhile', async () => {
  const { socket } = await ask('/socket', upgrade());
  socket.on('error', () => {});
  socket.resume();
  const closed = new Promise((resolve) => socket.on('close', resolve));
  for (let n = 0; n < 5000; ++n) socket.write(masked('{"type":"ack","id":1}'));
  await closed;
  await serves();
});

check('a message over the limit ends the conversation', async () => {
  const { socket } = await ask('/socket', upgrade());
  socket.on('error', () => {});
  socket.resume();
  const closed = new Promise((resolve) => socket.on('close', resolve));
  socket.write(masked('"' + 'a'.repeat(300 << 10) + '"'));
  await closed;
  await serves();
});
