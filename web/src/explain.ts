// Asking why a pixel has its colour, and asking again when the scene changes.
import { effect } from '@preact/signals';
import { used } from './hints';
import { tellError } from './notes';
import { connection } from './server';
import { drawn, explained, explaining } from './state';

let asking = false;
let again = false;
let at: [number, number] | null = null; // in shares of the picture

/** At (x, y), in shares of the picture's width and height. */
export function askAbout(x: number, y: number): void {
  at = [Math.min(0.9999, Math.max(0, x)), Math.min(0.9999, Math.max(0, y))];
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
  asking = true;
  try {
    const [width, height] = scene.size;
    const reply = await connection.explain(scene, [
      Math.floor(at[0] * width),
      Math.floor(at[1] * height),
    ]);
    if (at) explained.value = reply;
  } catch (error) {
    tellError(error);
  } finally {
    asking = false;
    if (again) {
      again = false;
      void ask();
    }
  }
}

effect(() => {
  if (drawn.value && at) void ask();
});
