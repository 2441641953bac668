import { type Frame, parseFrame } from './frame';
import type { Bounds, InputReport, Layer, Option, Scene, Vec3 } from './scene';

export interface Hello {
  version: string;
  scene: Scene;
  bounds: Bounds;
  inputs: InputReport[];
  /** Those that this version honours, by name; of a record's fields as "surface.kr". */
  options: Record<string, Option>;
  layers: Layer[];
}

/** How far the settled picture is. */
export interface Progress {
  label: string;
  share: number;
}

export interface ViewWish {
  scene: Scene;
  show: Layer[];
  light: number;
  settled: boolean;
}

export interface Picked {
  hit: boolean;
  position: Vec3;
  normal: Vec3;
}

export interface LightExplanation {
  to_light: Vec3;
  reflected: Vec3;
  distance: number;
  cos_theta: number;
  cos_phi: number;
  falloff: number;
  visibility: number;
  diffuse: Vec3;
  specular: Vec3;
}

/** One of the surfaces that a pixel shows, nearest first; its terms before they are weighted. */
export interface ExplainedLayer {
  surface: number;
  opacity: number;
  weight: number;
  total: Vec3;
}

/** A place that sends light to the point, and the share of the first bounce that comes from it. */
export interface Sender {
  surface: number;
  position: Vec3;
  share: number;
}

export interface Explanation {
  pixel: [number, number];
  hit: boolean;
  surface: number;
  position: Vec3;
  normal: Vec3;
  to_eye: Vec3;
  ambient: Vec3;
  ambient_light: Vec3;
  lights: LightExplanation[];
  layers: ExplainedLayer[];
  indirect: Vec3;
  /** With indirect light: what each bounce adds to E, and where the first one comes from. */
  bounces?: Vec3[];
  first_bounce?: { light: number; sky: number; senders: Sender[] };
  mirror: Vec3;
  background: Vec3;
  total: Vec3;
  display: Vec3;
  /** Where something was met: the nearest layer's coefficients at that point. */
  material?: { ka: Vec3; kd: Vec3; ks: Vec3; shininess: number };
}

export interface Described {
  scene: Scene;
  command: string;
}

export interface Listener {
  onHello(hello: Hello): void;
  onFrame(frame: Frame): void;
  onProgress(progress: Progress): void;
  onError(message: string): void;
  onConnected(connected: boolean): void;
}

/** The token stands behind the URL's #, which no browser sends to any server. */
export const token = location.hash.slice(1);

const longestWait_ms = 4000;

/** The conversation with the server. Comes back by itself when it was cut. */
export class Connection {
  private socket: WebSocket | undefined;
  private lastId = 0;
  private wait_ms = 250;
  private readonly waiting = new Map<
    number,
    { resolve: (reply: never) => void; reject: (why: Error) => void }
  >();

  constructor(private readonly listener: Listener) {
    this.open();
    // A laptop that wakes up, or comes back into the network, need not wait.
    addEventListener('online', () => this.socket?.readyState === WebSocket.CLOSED && this.open());
  }

  /** Asks for a picture; the next wish takes its place if it has not been begun. Its number. */
  view(wish: ViewWish): number {
    return this.send({ type: 'view', ...wish });
  }

  /** The settled picture that is being drawn is not wanted any more. */
  stop(): void {
    this.send({ type: 'stop' });
  }

  explain(scene: Scene, pixel: [number, number]): Promise<Explanation> {
    return this.ask({ type: 'explain', scene, pixel });
  }

  pick(at: [number, number]): Promise<Picked> {
    return this.ask({ type: 'pick', at });
  }

  describe(scene: Scene): Promise<Described> {
    return this.ask({ type: 'describe', scene });
  }

  private open(): void {
    const url = location.origin.replace(/^http/, 'ws') + '/socket';
    const socket = new WebSocket(url, ['isolux.1', token]);
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => {
      this.wait_ms = 250;
      this.listener.onConnected(true);
    };
    socket.onmessage = ({ data }) => this.receive(data as string | ArrayBuffer);
    socket.onclose = () => {
      this.listener.onConnected(false);
      for (const { reject } of this.waiting.values()) reject(new Error('the connection was cut'));
      this.waiting.clear();
      setTimeout(() => this.open(), this.wait_ms);
      this.wait_ms = Math.min(longestWait_ms, 2 * this.wait_ms);
    };
    this.socket = socket;
  }

  private receive(data: string | ArrayBuffer): void {
    if (data instanceof ArrayBuffer) {
      const frame = parseFrame(data);
      this.socket?.send(JSON.stringify({ type: 'ack', id: frame.header.id }));
      this.listener.onFrame(frame);
      return;
    }
    const message = JSON.parse(data) as { type: string; id: number; message: string };
    if (message.type === 'hello') {
      this.listener.onHello(message as unknown as Hello);
      return;
    }
    if (message.type === 'progress') {
      this.listener.onProgress(message as unknown as Progress);
      return;
    }
    const asked = this.waiting.get(message.id);
    this.waiting.delete(message.id);
    if (message.type !== 'error') asked?.resolve(message as never);
    else if (asked) asked.reject(new Error(message.message));
    else this.listener.onError(message.message);
  }

  private ask<Reply>(message: object): Promise<Reply> {
    return new Promise((resolve, reject) => {
      const id = this.send(message);
      if (id) this.waiting.set(id, { resolve: resolve as (reply: never) => void, reject });
      else reject(new Error('isolux is not connected; it comes back by itself when it can'));
    });
  }

  /** The message's number; 0 where there is no connection. */
  private send(message: object): number {
    if (this.socket?.readyState !== WebSocket.OPEN) return 0;
    this.socket.send(JSON.stringify({ ...message, id: ++this.lastId }));
    return this.lastId;
  }
}
