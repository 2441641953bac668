// What goes over plain HTTP: files, in both directions.
import { token } from './connection';
import type { Bounds, InputReport, Scene } from './scene';

export interface Opened {
  scene: Scene;
  bounds: Bounds;
  inputs: InputReport[];
}

/** What is sent to be opened: a file, or several that were packed into a tar. */
export interface Sent {
  bytes: Blob;
  name: string;
  isPacked: boolean;
}

/** Hears which part of the work is under way, and the share of it that is done. */
export type Hear = (share: number, label: string) => void;

const look_ms = 250;

const newName = (): string => Array.from(crypto.getRandomValues(new Uint32Array(4))).join('-');

const headersFor = (work: string): Record<string, string> => ({
  Authorization: 'Bearer ' + token,
  'X-Isolux-Work': work,
});

/** Asks how far the work of that name is until `over` ends it. */
async function watch(work: string, hear: Hear, over: AbortSignal): Promise<void> {
  while (!over.aborted) {
    await new Promise((resolve) => setTimeout(resolve, look_ms));
    if (over.aborted) return;
    const reply = await fetch('/progress', { method: 'POST', headers: headersFor(work), signal: over })
      .then((one) => one.json() as Promise<{ label: string; share: number } | null>)
      .catch(() => null);
    if (reply && !over.aborted) hear(reply.share, reply.label);
  }
}

/** Sends what is to be opened; the server reads it. `signal` ends either. */
export function openFile(sent: Sent, hear: Hear, signal: AbortSignal): Promise<Opened> {
  const work = newName();
  const over = new AbortController();
  const opened = new Promise<Opened>((resolve, reject) => {
    const request = new XMLHttpRequest(); // fetch does not tell how far an upload is
    request.open('POST', '/open?name=' + encodeURIComponent(sent.name));
    for (const [name, value] of Object.entries(headersFor(work))) request.setRequestHeader(name, value);
    request.setRequestHeader('Content-Type', sent.isPacked ? 'application/x-tar' : 'application/octet-stream');
    request.upload.onprogress = ({ loaded, total }) => hear(loaded / Math.max(1, total), 'sending');
    request.upload.onload = () => void watch(work, hear, over.signal);
    request.onload = () => {
      if (request.status === 200) resolve(JSON.parse(request.responseText) as Opened);
      else reject(new Error(request.responseText.trim()));
    };
    request.onerror = () => reject(new Error(sent.name + ': the connection was cut; drop it again'));
    request.onabort = () => reject(new DOMException('cancelled', 'AbortError'));
    signal.addEventListener('abort', () => request.abort());
    request.send(sent.bytes);
  });
  return opened.finally(() => over.abort());
}

export async function savedPicture(
  scene: Scene,
  format: 'png' | 'exr',
  hear: Hear,
  signal: AbortSignal,
): Promise<Blob> {
  const work = newName();
  const over = new AbortController();
  void watch(work, hear, over.signal);
  try {
    const body = JSON.stringify({ scene, format });
    const reply = await fetch('/save', { method: 'POST', headers: headersFor(work), body, signal });
    if (!reply.ok) throw new Error((await reply.text()).trim());
    return await reply.blob();
  } finally {
    over.abort();
  }
}

export function download(blob: Blob, name: string): void {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}
