// What goes over plain HTTP: files, in both directions.
import { token } from './connection';
import type { Bounds, InputReport, Scene } from './scene';

export interface Opened {
  scene: Scene;
  bounds: Bounds;
  inputs: InputReport[];
}

/** Sends a file to be opened. `onProgress` hears the share that has arrived; `signal` ends it. */
export function openFile(
  file: File,
  onProgress: (share: number) => void,
  signal: AbortSignal,
): Promise<Opened> {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest(); // fetch does not tell how far an upload is
    request.open('POST', '/open?name=' + encodeURIComponent(file.name));
    request.setRequestHeader('Authorization', 'Bearer ' + token);
    request.upload.onprogress = (event) => onProgress(event.loaded / Math.max(1, event.total));
    request.onload = () => {
      if (request.status === 200) resolve(JSON.parse(request.responseText) as Opened);
      else reject(new Error(request.responseText.trim()));
    };
    request.onerror = () => reject(new Error(file.name + ': the connection was cut; drop it again'));
    request.onabort = () => reject(new DOMException('cancelled', 'AbortError'));
    signal.addEventListener('abort', () => request.abort());
    request.send(file);
  });
}

export async function savedPicture(
  scene: Scene,
  format: 'png' | 'exr',
  signal: AbortSignal,
): Promise<Blob> {
  const reply = await fetch('/save', {
    method: 'POST',
    headers: { Authorization: 'Bearer ' + token },
    body: JSON.stringify({ scene, format }),
    signal,
  });
  if (!reply.ok) throw new Error((await reply.text()).trim());
  return reply.blob();
}

export function download(blob: Blob, name: string): void {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}
