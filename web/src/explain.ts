// Asking why a point has its colour, and asking again when the scene or the view changes.
import { effect } from '@preact/signals';
import { projected } from './camera';
import type { FrameHeader } from './frame';
import { used } from './hints';
import { tellError } from './notes';
import type { Scene, Vec3 } from './scene';
import { connection } from './server';
import { drawn, explained, explaining, frame } from './state';

let asking = false;
let again = false;
let at: [number, number] | null = null; // in shares of the picture
/** The point that was asked about, which other views show elsewhere. */
let point: Vec3 | null = null;
/** What the last answer is about. */
let known: { scene: Scene; pixel: string } | null = null;

/** At (x, y), in shares of the picture's width and height. */
export function askAbout(x: number, y: number): void {
  at = [Math.min(0.9999, Math.max(0, x)), Math.min(0.9999, Math.max(0, y))];
  point = null;
  explaining.value = true;
  used('explain');
  void ask();
}

/** Moves by whole pixels, or begins in the middle. */
export function moveBy(dx: number, dy: number): void {
  const [width, height] = drawn.value?.size ?? [1, 1];
  if (at) askAbout(at[0] + dx / width, at[1] + dy / height);
  else askAbout(0.5, 0.5);
}

export function stopExplaining(): void {
  at = null;
  point = null;
  known = null;
  explaining.value = false;
  explained.value = null;
}

async function ask(): Promise<void> {
  const scene = drawn.value;
  if (!scene || !at) return;
  if (asking) {
    again = true;
    return;
  }
  const [width, height] = scene.size;
  const pixel: [number, number] = [Math.floor(at[0] * width), Math.floor(at[1] * height)];
  if (known?.scene === scene && known.pixel === pixel.join()) return;
  asking = true;
  known = { scene, pixel: pixel.join() };
  try {
    const reply = await connection.explain(scene, pixel);
    if (at) explained.value = reply;
    if (at && reply.hit) point ??= reply.position;
  } catch (error) {
    known = null;
    tellError(error);
  } finally {
    asking = false;
    if (again) {
      again = false;
      void ask();
    }
  }
}

/** Follows the point to where a frame shows it. */
function follow({ camera, size }: FrameHeader): void {
  const seen = point && projected(camera, size[0] / size[1], point);
  if (at && seen && seen.x >= 0 && seen.x < 1 && seen.y >= 0 && seen.y < 1) at = [seen.x, seen.y];
}

effect(() => {
  const shown = frame.value;
  if (!drawn.value || !at) return;
  if (shown) follow(shown);
  void ask();
});
