// The hand on the picture: turn, move, zoom, put the lamp on the surface, ask about a pixel.
import { orbited, panned, zoomed } from './camera';
import { askAbout } from './explain';
import { atHandPlace } from './lamps';
import { used } from './hints';
import { connection } from './server';
import { bounds, editLight, editPose, frame, hand, light, mainVolume } from './state';
import { add, scale } from './vectors';

const radiansAcross = Math.PI; // a drag over the picture's smaller side
const clickSlack_px = 4;
const lampHeight = 0.35; // of a lamp over the surface, in radii of what is shown

export const turn = (across: number, down: number): void =>
  editPose('turn', (pose) => orbited(pose, across, down));

export const zoom = (factor: number, x = 0, y = 0, height = 1): void =>
  editPose('zoom', (pose) => zoomed(pose, factor, x, y, height, bounds.value));

export const pan = (dx: number, dy: number, height: number): void =>
  editPose('pan', (pose) => panned(pose, dx, dy, height));

let picking = false;
let next: [number, number] | null = null; // where the hand has gone meanwhile

/** Puts the lamp over what is seen at (x, y), in shares of the picture. */
async function lampOver(x: number, y: number): Promise<void> {
  if (x < 0 || x >= 1 || y < 0 || y >= 1) return;
  if (picking) {
    next = [x, y];
    return;
  }
  picking = true;
  try {
    const picked = await connection.pick([x, y]);
    const camera = frame.value?.camera;
    if (!picked.hit || !camera || !light.value) return;
    used('surface');
    const { position, normal } = picked;
    editLight('place', (old) =>
      atHandPlace(
        old,
        old.kind === 'point' ? add(position, scale(lampHeight * bounds.value.radius, normal)) : normal,
        mainVolume.value,
        camera,
        bounds.value,
      ),
    );
  } catch {
    // The connection was cut: the next move asks again.
  } finally {
    picking = false;
    const there = next;
    next = null;
    if (there) void lampOver(...there);
  }
}

const movesLamp = (event: PointerEvent): boolean => event.shiftKey || hand.value === 'lamp';

/** Follows pointers and the wheel on the picture; gives back how to stop. */
export function followGestures(place: HTMLElement): () => void {
  const pointers = new Map<number, PointerEvent>();
  let travelled = 0;
  let mostPointers = 0;

  const box = () => place.getBoundingClientRect();
  const share = (event: MouseEvent): [number, number] => {
    const { left, top, width, height } = box();
    return [(event.clientX - left) / width, (event.clientY - top) / height];
  };
  const fromMiddle = (x: number, y: number): [number, number] => {
    const { left, top, width, height } = box();
    return [x - left - width / 2, y - top - height / 2];
  };

  const onDown = (event: PointerEvent) => {
    if ((event.target as Element).closest('.divider, .lamp, button')) return;
    place.setPointerCapture(event.pointerId);
    if (pointers.size === 0) travelled = mostPointers = 0;
    pointers.set(event.pointerId, event);
    mostPointers = Math.max(mostPointers, pointers.size);
    if (event.shiftKey && event.button === 0) void lampOver(...share(event));
  };

  const onMove = (event: PointerEvent) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const dx = event.clientX - before.clientX;
    const dy = event.clientY - before.clientY;
    const other = [...pointers.values()].find((one) => one.pointerId !== event.pointerId);
    pointers.set(event.pointerId, event);
    travelled += Math.hypot(dx, dy);
    if (travelled < clickSlack_px && !event.shiftKey) return;
    const { width, height } = box();
    if (other) {
      const spread = (one: PointerEvent) =>
        Math.hypot(one.clientX - other.clientX, one.clientY - other.clientY);
      pan(dx / 2, dy / 2, height);
      const middle = fromMiddle(
        (event.clientX + other.clientX) / 2,
        (event.clientY + other.clientY) / 2,
      );
      zoom(spread(before) / Math.max(1, spread(event)), ...middle, height);
    } else if (event.buttons & 2 || event.buttons & 4) {
      pan(dx, dy, height);
    } else if (movesLamp(event)) {
      void lampOver(...share(event));
    } else {
      const perPixel = radiansAcross / Math.min(width, height);
      turn(dx * perPixel, dy * perPixel);
    }
  };

  const onUp = (event: PointerEvent) => {
    if (!pointers.delete(event.pointerId) || event.type === 'pointercancel') return;
    const isClick = travelled < clickSlack_px && mostPointers === 1 && event.button === 0;
    if (!isClick || event.shiftKey) return;
    if (movesLamp(event)) void lampOver(...share(event));
    else askAbout(...share(event));
  };

  const onWheel = (event: WheelEvent) => {
    event.preventDefault();
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1;
    // A pinch on a touchpad comes as a wheel with Ctrl, in smaller steps.
    const strength = event.ctrlKey ? 0.01 : 0.0015;
    const factor = Math.exp(strength * event.deltaY * lines);
    zoom(factor, ...fromMiddle(event.clientX, event.clientY), box().height);
  };

  const noMenu = (event: Event) => event.preventDefault();
  const abort = new AbortController();
  const { signal } = abort;
  place.addEventListener('pointerdown', onDown, { signal });
  place.addEventListener('pointermove', onMove, { signal });
  place.addEventListener('pointerup', onUp, { signal });
  place.addEventListener('pointercancel', onUp, { signal });
  place.addEventListener('wheel', onWheel, { passive: false, signal });
  place.addEventListener('contextmenu', noMenu, { signal });
  return () => abort.abort();
}
