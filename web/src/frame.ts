import type { Vec3 } from './scene';

export interface FrameCamera {
  eye: Vec3;
  right: Vec3;
  up: Vec3;
  back: Vec3;
  half_height: number;
  orthographic: boolean;
}

export interface Legend {
  low: number;
  high: number;
  unit: string;
  colors: Vec3[]; // bytes
}

export interface FrameHeader {
  id: number;
  settled: boolean;
  size: [number, number];
  type: string;
  lengths: number[];
  legends: (Legend | null)[];
  camera: FrameCamera;
  /** Where surfaces are met: left, top, right and bottom in shares of the picture. */
  seen: [number, number, number, number] | null;
  /** Of what is seen, the point nearest to the chosen lamp, and how many mm away it is. */
  foot: { position: Vec3; distance: number } | null;
  lights: { point: boolean; place: Vec3 }[];
  ms: { trace: number; light: number; encode: number };
  counters: Record<'skip_structure' | 'visibility' | 'shadows' | 'lighting' | 'display', number>;
}

export interface Frame {
  header: FrameHeader;
  pictures: Blob[];
}

/** Four bytes of length, a JSON header, and the pictures whose lengths it tells. */
export function parseFrame(bytes: ArrayBuffer): Frame {
  const headerLength = new DataView(bytes).getUint32(0, true);
  const text = new TextDecoder().decode(new Uint8Array(bytes, 4, headerLength));
  const header = JSON.parse(text) as FrameHeader;
  let at = 4 + headerLength;
  const pictures = header.lengths.map((length) => {
    const blob = new Blob([new Uint8Array(bytes, at, length)], { type: header.type });
    at += length;
    return blob;
  });
  return { header, pictures };
}
