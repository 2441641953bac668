// What the page knows. `edited` is what undo and redo walk through; all the rest comes from the
// server or is about the page itself.
import { batch, computed, effect, signal } from '@preact/signals';
import { poseOf, type Pose } from './camera';
import { withoutHidden } from './hidden';
import { linearOf } from './colors';
import type { Explanation, Hello, Progress } from './connection';
import type { FrameHeader } from './frame';
import { amended, begun, changed, type History, redone, undone } from './history';
import type {
  Bounds, InputReport, Layer, Light, Scene, Surface, Vec3, VolumeReport,
} from './scene';

export interface Edited {
  scene: Scene;
  /** Surfaces that are kept but not drawn, by their place in the scene. */
  hidden: number[];
  show: Layer;
  /** The other half of a split view. */
  other: Layer | null;
  /** Where the divider of a split view stands, as a share of the width. */
  divider: number;
}

export const hello = signal<Hello | null>(null);
export const inputs = signal<InputReport[]>([]);
export const bounds = signal<Bounds>({ center: [0, 0, 0], radius: 1 });
export const history = signal<History<Edited> | null>(null);
export const connected = signal(false);
export const frame = signal<FrameHeader | null>(null);
/** Device pixels of the picture's place in the page. */
export const pictureSize = signal<[number, number]>([0, 0]);
export const lamp = signal(0);
export const surface = signal(0);
/** How far the settled picture is, where it takes its time. */
export const refining = signal<Progress | null>(null);
/** A layer that is shown only while something is pointed at. */
export const peek = signal<Layer | null>(null);
export const explaining = signal(false);
export const explained = signal<Explanation | null>(null);
export const helpOpen = signal(false);
/** What a drag over the picture does: turn the scan, or take the lamp over the surface. */
export type Hand = 'orbit' | 'lamp';
export const hand = signal<Hand>('orbit');
/** Whether what is seen is to fill the window, until a hand zooms or moves it. */
export const isFitted = signal(false);
/** Whether a lamp is on its way: its distance is of interest then. */
export const lampMoves = signal(false);

export const edited = computed(() => history.value?.present ?? null);
export const scene = computed(() => edited.value?.scene ?? null);
export const light = computed(() => scene.value?.light[lamp.value]);
export const divider = computed(() => edited.value?.divider ?? 0.5);
export const reportOf = (name: string | undefined): InputReport | undefined =>
  inputs.value.find((input) => input.input === name);
/** The volume that lamps in voxels and new surfaces are about: the first, as everywhere. */
export const mainVolume = computed(() =>
  scene.value?.input.map(reportOf).find((one): one is VolumeReport => one?.kind === 'volume'),
);
export const honours = (option: string): boolean => option in (hello.value?.options ?? {});

/** The scene as the server is to draw it now. */
export const drawn = computed((): Scene | null => {
  const now = edited.value;
  const [width, height] = pictureSize.value;
  if (!now || !width || !height) return null;
  return { ...withoutHidden(now.scene, now.hidden, inputs.value), size: [width, height] };
});

export function edit(about: string, change: (now: Edited) => Edited): void {
  const now = history.value;
  if (!now) return;
  history.value = changed(now, change(now.present), about, performance.now());
}

export const editScene = (about: string, change: (scene: Scene) => Scene): void =>
  edit(about, (now) => ({ ...now, scene: change(now.scene) }));

/** Puts a better state in the place of the present one, without a step of its own. */
export function amend(change: (now: Edited) => Edited): void {
  if (history.value) history.value = amended(history.value, change(history.value.present));
}

let lampRests = 0;
const lampRest_ms = 1200;

/** A lamp's place has changed, by whatever hand. */
export function lampMoved(): void {
  lampMoves.value = true;
  clearTimeout(lampRests);
  lampRests = window.setTimeout(() => {
    lampMoves.value = false;
  }, lampRest_ms);
}

export function editLight(about: string, change: (light: Light) => Light, n = lamp.value): void {
  if (about === 'place') lampMoved();
  editScene(`light ${n} ${about}`, (old) => ({
    ...old,
    light: old.light.map((one, at) => (at === n ? change(one) : one)),
  }));
}

export const editSurface = (about: string, n: number, change: (surface: Surface) => Surface): void =>
  editScene(`surface ${n} ${about}`, (old) => ({
    ...old,
    surface: old.surface.map((one, at) => (at === n ? change(one) : one)),
  }));

export function pose(): Pose | undefined {
  const seen = frame.value;
  const document = scene.value?.camera;
  if (document?.eye && document.target && document.up) return document as Pose;
  return seen ? poseOf(document, seen.camera, bounds.value) : undefined;
}

export const editPose = (about: string, change: (pose: Pose) => Pose): void => {
  const now = pose();
  if (about === 'zoom' || about === 'pan') isFitted.value = false;
  if (now) editScene(about, (old) => ({ ...old, camera: change(now) }));
};

const walk = (step: (history: History<Edited>) => History<Edited>): void => {
  const now = history.value;
  if (!now) return;
  batch(() => {
    history.value = step(now);
    const left = history.value.present.scene;
    lamp.value = Math.max(0, Math.min(lamp.value, left.light.length - 1));
    surface.value = Math.max(0, Math.min(surface.value, left.surface.length - 1));
  });
};
export const undo = (): void => walk(undone);
export const redo = (): void => walk(redone);

/** The colour around the picture, which is also the picture's background to begin with. */
export const surround = (): Vec3 =>
  linearOf(getComputedStyle(document.documentElement).getPropertyValue('--surround').trim());

/** Begins anew with a scene: one step that can be undone, if there was one before. */
export function beginWith(start: Scene): void {
  const state: Edited = { scene: start, hidden: [], show: 'picture', other: null, divider: 0.5 };
  batch(() => {
    const now = history.value;
    history.value = now ? changed(now, state, '', performance.now()) : begun(state);
    lamp.value = 0;
    surface.value = 0;
    explained.value = null;
    isFitted.value = false;
  });
}

// The state outlives a reload of the page and a restart of the server, in this tab alone.
const storageKey = 'isolux';

interface Kept {
  edited: Edited;
  start: Scene;
}

export function keptState(start: Scene): Edited | undefined {
  try {
    const kept = JSON.parse(sessionStorage.getItem(storageKey) ?? 'null') as Kept | null;
    // A server that was started with something else means to show that.
    return kept && JSON.stringify(kept.start) === JSON.stringify(start) ? kept.edited : undefined;
  } catch {
    return undefined;
  }
}

effect(() => {
  const now = edited.value;
  const start = hello.value?.scene;
  if (now && start) sessionStorage.setItem(storageKey, JSON.stringify({ edited: now, start }));
});
