// Makes what is seen fill the window: the eye moves by what a frame tells of where surfaces are met.
import { effect } from '@preact/signals';
import { fitShare, fitted } from './camera';
import type { FrameHeader } from './frame';
import type { CameraDocument } from './scene';
import { amend, bounds, isFitted, pictureSize, pose, scene } from './state';

const mostRounds = 4;
const nearEnough = 0.02;

/** Frames that are still to be looked at, and the first that may be: earlier ones show other views. */
let rounds = 0;
let firstFrame = 0;
/** The camera that it is about: where another takes its place, the hand has gone on. */
let about: CameraDocument | undefined;
/** For which size of the picture. */
let size: [number, number] | undefined;

/** From the next frame on that is asked for. It is part of the step that led here. */
export function fit(): void {
  rounds = mostRounds;
  firstFrame = Infinity;
  isFitted.value = true;
}

const sizeRests_ms = 200;
let sizeRests = 0;

// A window of another shape is filled anew, once it keeps that shape.
effect(() => {
  const now = pictureSize.value;
  clearTimeout(sizeRests);
  sizeRests = window.setTimeout(() => {
    if (!isFitted.value || now === size) return;
    amend((old) => ({ ...old, scene: { ...old.scene } })); // asks for a frame to be looked at
    fit();
  }, sizeRests_ms);
});

/** A frame of this number was asked for. */
export function fitAsked(id: number): void {
  if (rounds === 0 || firstFrame !== Infinity) return;
  firstFrame = id;
  about = scene.value?.camera;
  size = pictureSize.value;
}

/** Moves the eye where that brings more into the window. Whether it did: the frame is outdated. */
export function fitTo(header: FrameHeader): boolean {
  if (rounds === 0 || header.id < firstFrame) return rounds > 0;
  if (scene.value?.camera !== about) {
    rounds = 0;
    return false;
  }
  rounds -= 1;
  const now = pose();
  const part = header.seen;
  if (!now || !part) {
    rounds = 0;
    return false;
  }
  const [left, top, right, bottom] = part;
  const touches = left === 0 || top === 0 || right === 1 || bottom === 1;
  const fills = Math.max(right - left, bottom - top);
  const off = Math.max(Math.abs(left + right - 1), Math.abs(top + bottom - 1)) / 2;
  if (!touches && Math.abs(fills - fitShare) < nearEnough && off < nearEnough) {
    rounds = 0;
    return false;
  }
  const [width, height] = header.size;
  const better = fitted(now, part, width, height, bounds.value);
  amend((old) => ({ ...old, scene: { ...old.scene, camera: better } }));
  firstFrame = Infinity;
  return true;
}
