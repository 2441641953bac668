// Where lamps are: in millimetres, in voxels, or fixed to the camera; and their usual set-ups.
import type { FrameCamera } from './frame';
import { type Bounds, type Light, newLight, type Vec3, type VolumeReport } from './scene';
import { add, dot, length, normalize, rounded, scale, subtract, toStep } from './vectors';

export type Space = 'mm' | 'voxel' | 'camera';

export const spaceOf = (light: Light): Space =>
  light.attach === 'camera' ? 'camera' : light.space === 'index' ? 'voxel' : 'mm';

export const placeOf = (light: Light): Vec3 =>
  (light.kind === 'point' ? light.at : light.to) ?? [0, 0, 1];

export function withPlace(light: Light, place: Vec3): Light {
  const { at: _at, to: _to, ...rest } = light;
  return light.kind === 'point' ? { ...rest, at: place } : { ...rest, to: place };
}

type Columns = VolumeReport['world_from_index'];

const combined = ([i, j, k]: Columns, v: Vec3): Vec3 =>
  add(add(scale(v[0], i), scale(v[1], j)), scale(v[2], k));

function solved([i, j, k]: Columns, v: Vec3): Vec3 {
  const cross = (a: Vec3, b: Vec3): Vec3 => [
    a[1] * b[2] - a[2] * b[1],
    a[2] * b[0] - a[0] * b[2],
    a[0] * b[1] - a[1] * b[0],
  ];
  const det = dot(i, cross(j, k));
  return [dot(v, cross(j, k)) / det, dot(v, cross(k, i)) / det, dot(v, cross(i, j)) / det];
}

/** A lamp's place in world space (a direction for directional lamps). */
export function worldPlace(light: Light, volume: VolumeReport | undefined, camera: FrameCamera): Vec3 {
  const place = placeOf(light);
  const point = light.kind === 'point';
  if (light.attach === 'camera') {
    const v = add(
      add(scale(place[0], camera.right), scale(place[1], camera.up)),
      scale(place[2], camera.back),
    );
    return point ? add(camera.eye, v) : v;
  }
  return light.space === 'index' && volume ? placeOf(worldOfIndex(light, volume)) : place;
}

/** A lamp told in voxels, told in millimetres. */
export function worldOfIndex(light: Light, volume: VolumeReport): Light {
  const v = combined(volume.world_from_index, placeOf(light));
  const { input: _input, ...rest } = light;
  const place = light.kind === 'point' ? add(v, volume.world_from_index[3]) : v;
  return withPlace({ ...rest, space: 'world' }, place);
}

/** The lamp put at a place in world space, told in its own space. */
export function atWorldPlace(light: Light, world: Vec3, volume: VolumeReport | undefined, camera: FrameCamera): Light {
  const point = light.kind === 'point';
  if (light.attach === 'camera') {
    const v = point ? subtract(world, camera.eye) : world;
    return withPlace(light, rounded([dot(v, camera.right), dot(v, camera.up), dot(v, camera.back)]));
  }
  if (light.space === 'index' && volume) {
    const v = point ? subtract(world, volume.world_from_index[3]) : world;
    return withPlace(light, rounded(solved(volume.world_from_index, v)));
  }
  return withPlace(light, rounded(world));
}

/** How finely a lamp's numbers step: whole millimetres or voxels, finer where all is smaller. */
export function placeStep(light: Light, bounds: Bounds): number {
  if (light.kind === 'directional') return 0.01;
  return spaceOf(light) === 'voxel' ? 1 : 10 ** Math.min(0, Math.floor(Math.log10(bounds.radius)) - 2);
}

/** The lamp put where a hand has put it, in short numbers. */
export function atHandPlace(
  light: Light,
  world: Vec3,
  volume: VolumeReport | undefined,
  camera: FrameCamera,
  bounds: Bounds,
): Light {
  const placed = atWorldPlace(light, world, volume, camera);
  return withPlace(placed, toStep(placeOf(placed), placeStep(light, bounds) / 10));
}

/** The same lamp, its place told in another space. */
export function inSpace(light: Light, space: Space, volume: VolumeReport | undefined, camera: FrameCamera): Light {
  const world = worldPlace(light, volume, camera);
  const { input: _input, ...rest } = light;
  const moved: Light = {
    ...rest,
    space: space === 'voxel' ? 'index' : 'world',
    attach: space === 'camera' ? 'camera' : 'world',
  };
  return atWorldPlace(moved, world, volume, camera);
}

/** A point becomes the direction to it from the middle, and a direction a point out there. */
export function ofKind(
  light: Light,
  kind: Light['kind'],
  bounds: Bounds,
  volume: VolumeReport | undefined,
  camera: FrameCamera,
): Light {
  if (light.kind === kind) return light;
  const world = worldPlace(light, volume, camera);
  const { falloff: _falloff, reference: _reference, ...rest } = light;
  const changed: Light = { ...rest, kind, falloff: 'none' };
  const moved =
    kind === 'directional'
      ? normalize(subtract(world, bounds.center))
      : add(bounds.center, scale(1.05 * bounds.radius, normalize(world)));
  return atWorldPlace(changed, length(moved) > 0 ? moved : [0, 0, 1], volume, camera);
}

/** Where a lamp's slider begins and ends along an axis. */
export function sliderRange(light: Light, axis: number, bounds: Bounds, volume: VolumeReport | undefined): [number, number] {
  if (light.kind === 'directional') return [-1, 1];
  const space = spaceOf(light);
  const far = 1.5 * bounds.radius;
  if (space === 'camera') return axis === 2 ? [-6 * bounds.radius, far] : [-2 * far, 2 * far];
  if (space === 'voxel') {
    const n = volume?.dims[axis] ?? 1;
    return [-Math.round(n / 2), Math.round((3 * n) / 2)];
  }
  const center = bounds.center[axis] ?? 0;
  const [low, , high] = toStep([center - far, 0, center + far], placeStep(light, bounds));
  return [low, high];
}

export interface Preset {
  name: string;
  hint: string;
  lights: (bounds: Bounds, volume: VolumeReport | undefined) => Light[];
  /** It tells places in voxels. */
  needsVolume?: true;
}

/** A point lamp that far from the middle, in radii of everything. */
export const pointAt = (bounds: Bounds, from: Vec3, more: Partial<Light> = {}): Light => ({
  ...newLight,
  at: toStep(add(bounds.center, scale(bounds.radius, from)), placeStep(newLight, bounds)),
  ...more,
});

export const presets: Preset[] = [
  {
    name: 'Lecture',
    hint: 'a point lamp at voxel (0, 0, nz/2): move x and watch',
    needsVolume: true,
    lights: (_bounds, volume) => [
      { ...newLight, space: 'index', at: [0, 0, Math.floor((volume?.dims[2] ?? 2) / 2)] },
    ],
  },
  {
    name: 'Headlight',
    hint: 'from the eye, wherever it goes',
    lights: () => [{ ...newLight, kind: 'directional', to: [0, 0, 1], attach: 'camera' }],
  },
  {
    name: 'Three-point',
    hint: 'a warm key, a cool fill, a rim from behind',
    lights: (bounds) => [
      pointAt(bounds, [-0.9, -1.1, 0.7], { color: [1, 0.86, 0.7], intensity: 0.9 }),
      pointAt(bounds, [1.2, -0.9, 0.1], { color: [0.62, 0.76, 1], intensity: 0.35 }),
      pointAt(bounds, [0.5, 1.2, 0.9], { intensity: 0.6 }),
    ],
  },
  {
    name: 'Raking',
    hint: 'along the surface, from the side: brings out relief',
    lights: () => [{ ...newLight, kind: 'directional', to: [-1, -0.12, 0.1] }],
  },
];
