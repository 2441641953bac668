// Speaking to a viewer without a browser: requests with any headers, and a page's WebSocket.
import { request } from 'node:http';

/** The whole answer to a request with any headers. */
export function ask(viewer, path, { method = 'GET', headers = {}, body } = {}) {
  return new Promise((resolve, reject) => {
    const asked = request({ port: viewer.port, host: '127.0.0.1', path, method, headers }, (reply) => {
      const parts = [];
      reply.on('data', (part) => parts.push(part));
      reply.on('end', () =>
        resolve({ status: reply.statusCode, headers: reply.headers, body: Buffer.concat(parts) }));
    });
    asked.on('upgrade', (reply, socket, head) => {
      socket.unshift(head);
      resolve({ status: reply.statusCode, headers: reply.headers, socket });
    });
    asked.on('error', reject);
    asked.end(body);
  });
}

export const upgrade = (viewer, over = {}) => ({
  headers: {
    Host: `127.0.0.1:${viewer.port}`,
    Origin: viewer.origin,
    Connection: 'Upgrade',
    Upgrade: 'websocket',
    'Sec-WebSocket-Version': '13',
    'Sec-WebSocket-Key': 'AAAAAAAAAAAAAAAAAAAAAA==',
    'Sec-WebSocket-Protocol': `isolux.1, ${viewer.token}`,
    ...over,
  },
});
export const withToken = (viewer, over = {}) => ({
  Authorization: `Bearer ${viewer.token}`,
  Origin: viewer.origin,
  ...over,
});

/** A masked WebSocket frame, as a browser would send it. */
export function masked(payload, opcode = 1) {
  const body = Buffer.from(payload);
  const head = [0x80 | opcode];
  if (body.length < 126) head.push(0x80 | body.length);
  else if (body.length < 65536) head.push(0x80 | 126, body.length >> 8, body.length & 255);
  else head.push(0x80 | 127, 0, 0, 0, 0, ...[24, 16, 8, 0].map((s) => (body.length >> s) & 255));
  return Buffer.concat([Buffer.from([...head, 0, 0, 0, 0]), body]);
}

/** A page's conversation: messages as objects, frames as their headers with type "frame"
 * and the bytes of their pictures. */
export async function openSocket(viewer) {
  const { socket } = await ask(viewer, '/socket', upgrade(viewer));
  socket.on('error', () => {});
  let bytes = Buffer.alloc(0);
  const arrived = [];
  const waiting = [];
  const wake = () => waiting.splice(0).forEach((one) => one());
  socket.on('data', (part) => {
    bytes = Buffer.concat([bytes, part]);
    for (let message; (message = takeMessage()); wake()) arrived.push(message);
  });
  const takeMessage = () => {
    if (bytes.length < 2) return undefined;
    const short = bytes[1] & 127;
    const head = short === 126 ? 4 : short === 127 ? 10 : 2;
    if (bytes.length < head) return undefined;
    const length = head === 2 ? short : head === 4 ? bytes.readUInt16BE(2) : Number(bytes.readBigUInt64BE(2));
    if (bytes.length < head + length) return undefined;
    const opcode = bytes[0] & 15;
    const body = bytes.subarray(head, head + length);
    bytes = bytes.subarray(head + length);
    if (opcode === 1) return JSON.parse(body.toString());
    if (opcode === 2) {
      const pictures = 4 + body.readUInt32LE(0);
      return { ...JSON.parse(body.subarray(4, pictures).toString()), type: 'frame', pictures: body.subarray(pictures) };
    }
    return { type: 'control' };
  };
  const page = {
    socket,
    send: (message) => socket.write(masked(JSON.stringify(message))),
    /** The next message of one of these types. */
    next: async (...types) => {
      while (true) {
        const at = arrived.findIndex(({ type }) => types.includes(type));
        if (at >= 0) return arrived.splice(at, 1)[0];
        await new Promise((resolve) => waiting.push(resolve));
      }
    },
    /** Whether one has come that was not taken yet. */
    has: (type) => arrived.some((message) => message.type === type),
    close: () => socket.destroy(),
  };
  page.hello = await page.next('hello');
  return page;
}
