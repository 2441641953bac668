// Keeps the server's picture and the page's state together.
import { batch, effect } from '@preact/signals';
import { usualFov } from './camera';
import { Connection } from './connection';
import { fit, fitAsked, fitTo } from './fit';
import type { Frame } from './frame';
import { begun } from './history';
import { tell } from './notes';
import {
  beginWith, bounds, connected, drawn, edited, frame, hello, history, inputs, keptState, lamp,
  peek, refining, surround,
} from './state';
import type { Layer, Scene } from './scene';

const settle_ms = 160;

type Painter = (header: Frame['header'], pictures: ImageBitmap[]) => void;
let paint: Painter = () => {};
export const paintWith = (painter: Painter): void => {
  paint = painter;
};

/** When what led to a frame happened, by the frame's number: for measuring. */
const asked = new Map<number, number>();
let newestDrawn = 0;
let newestAsked = 0;

export const connection = new Connection({
  onHello: (said) => {
    batch(() => {
      newestDrawn = 0;
      hello.value = said;
      inputs.value = said.inputs;
      bounds.value = said.bounds;
      if (history.value) return; // the server was away; the state is still here
      const kept = keptState(said.scene);
      if (kept) history.value = begun(kept);
      else start(said.scene);
    });
    wish();
  },
  onFrame: (arrived) => void show(arrived),
  onProgress: (progress) => {
    refining.value = progress;
  },
  onError: (message) => tell(message, 'error'),
  onConnected: (now) => {
    connected.value = now;
    refining.value = null;
    // What another server drew is no settled picture of this one.
    if (!now && frame.value) frame.value = { ...frame.value, settled: false };
  },
});

/**
 * Begins with a scene as the program would draw it, made for a window: what nobody asked for is
 * chosen here. The picture goes over into what surrounds it, and fills the window.
 */
export function start(scene: Scene): void {
  const inWindow = scene.background.every((v) => v === 0) ? { ...scene, background: surround() } : scene;
  if (scene.camera) return beginWith(inWindow);
  beginWith({ ...inWindow, camera: { view: 'front', projection: 'perspective', fov: usualFov } });
  fit();
}

async function show({ header, pictures }: Frame): Promise<void> {
  // Exactly the bytes that were sent: no colour management between here and the canvas.
  const decoded = await Promise.all(
    pictures.map((one) =>
      createImageBitmap(one, { colorSpaceConversion: 'none', premultiplyAlpha: 'none' }),
    ),
  );
  if (header.id > newestDrawn) {
    newestDrawn = header.id;
    batch(() => {
      // What was settled is not any more where something else has been asked for meanwhile.
      frame.value = { ...header, settled: header.settled && header.id === newestAsked };
      refining.value = null;
      // Better the last picture for a moment than one that jumps.
      if (fitTo(header)) return;
      paint(header, decoded);
      measure(header.id);
    });
  }
  for (const one of decoded) one.close();
}

/** One entry of the browser's user timings for each frame, from the event to the paint. */
function measure(id: number): void {
  const start = asked.get(id);
  for (const older of [...asked.keys()].filter((n) => n <= id)) asked.delete(older);
  if (start === undefined) return;
  requestAnimationFrame(() => performance.measure('isolux frame', { start, end: performance.now() }));
}

const shownLayers = (): Layer[] => {
  const now = edited.value;
  const show = peek.value ?? now?.show ?? 'picture';
  return now?.other ? [show, now.other] : [show];
};

let settling = 0;
let scheduled = false;

function send(settled: boolean, since: number): void {
  const scene = drawn.value;
  if (!scene) return;
  const id = connection.view({ scene, show: shownLayers(), light: lamp.value, settled });
  if (!id) return;
  newestAsked = id;
  asked.set(id, since);
  fitAsked(id);
}

/** Asks for the picture of what the state is now: soon, and when it stays so, exactly. */
export function wish(): void {
  const shown = frame.peek();
  if (shown?.settled) frame.value = { ...shown, settled: false }; // it is of what was before
  clearTimeout(settling);
  settling = window.setTimeout(() => send(true, performance.now()), settle_ms);
  if (scheduled) return;
  scheduled = true;
  const since = performance.now();
  // Several events between two frames of the display are one change.
  queueMicrotask(() => {
    scheduled = false;
    send(false, since);
  });
}

effect(() => {
  void [drawn.value, peek.value, edited.value?.show, edited.value?.other, lamp.value];
  if (connected.peek()) wish();
});
