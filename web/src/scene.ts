// The scene document, as docs/manual.md tells it; the page's state and the server's picture are made
// of the same words. The server sends it with every default written out.

export type Vec3 = [number, number, number];

/** What a mesh leaves out is as its file has it; an isosurface has everything. */
export interface Surface {
  iso?: number;
  input?: number;
  ka?: Vec3;
  kd?: Vec3;
  ks?: Vec3;
  kr?: Vec3;
  shininess?: number;
  opacity?: number;
}

export interface Light {
  kind: 'point' | 'directional';
  at?: Vec3;
  to?: Vec3;
  color: Vec3;
  intensity: number;
  space: 'world' | 'index';
  input?: number;
  attach: 'world' | 'camera';
  falloff: 'none' | 'inverse-square';
  reference?: number;
}

export type ViewName = 'front' | 'back' | 'left' | 'right' | 'top' | 'bottom';
export const viewNames: ViewName[] = ['front', 'back', 'left', 'right', 'top', 'bottom'];

export interface CameraDocument {
  view?: ViewName;
  eye?: Vec3;
  target?: Vec3;
  up?: Vec3;
  projection: 'perspective' | 'orthographic';
  fov?: number;
  height?: number;
}

export interface Scene {
  isolux_scene: 1;
  input: string[];
  size: [number, number];
  surface: Surface[];
  light: Light[];
  ambient?: Vec3;
  camera?: CameraDocument;
  display: 'srgb' | 'raw';
  exposure: number;
  background: Vec3;
  [other: string]: unknown; // options that the page has no control for are carried along
}

/** What the server says of an opened input. */
export type InputReport = VolumeReport | MeshReport;

export interface VolumeReport {
  kind: 'volume';
  input: string;
  format: string;
  dims: Vec3;
  spacing: Vec3;
  min: number;
  max: number;
  units?: string;
  modality?: string;
  notes: string[];
  histogram: number[];
  suggested_iso: number[];
  suggested_iso_names: string[];
  /** Three columns and the offset: index -> mm. */
  world_from_index: [Vec3, Vec3, Vec3, Vec3];
}

export interface MeshReport {
  kind: 'mesh';
  input: string;
  format: string;
  triangles: number;
  colors: boolean;
  materials: { ka: Vec3; kd: Vec3; ks: Vec3; shininess: number; texture?: [number, number] }[];
  notes: string[];
}

/** A row of the program's table of options. */
export interface Option {
  sentence: string;
  unit: string;
  choices: string[];
  low: number | null;
  high: number | null;
  default?: unknown;
}

export interface Bounds {
  center: Vec3;
  radius: number;
}

/** A layer that can be shown, as the server calls it. */
export type Layer = string;

const layerNames: Record<string, string> = {
  picture: 'Picture',
  ambient: 'Ambient alone',
  diffuse: 'Diffuse alone',
  specular: 'Specular alone',
  indirect: 'Indirect alone',
  mirror: 'Mirror alone',
  direct: 'Direct only',
  'cos-theta': 'cos θ (n · l)',
  'cos-phi': 'cos φ (r · e)',
  normal: 'Normals',
  depth: 'Depth',
};
export const layerName = (layer: Layer): string => layerNames[layer] ?? layer;

export const newLight: Light = {
  kind: 'point',
  color: [1, 1, 1],
  intensity: 1,
  space: 'world',
  attach: 'world',
  falloff: 'none',
};

export const newSurface: Required<Omit<Surface, 'iso' | 'input'>> = {
  ka: [0.1, 0.1, 0.1],
  kd: [0.8, 0.8, 0.8],
  ks: [0.3, 0.3, 0.3],
  kr: [0, 0, 0],
  shininess: 40,
  opacity: 1,
};
