// What is drawn over the picture: lamps that can be dragged, and the vectors of an explanation.
import type { ComponentChildren } from 'preact';
import { projected, type ScreenPoint, unprojected } from './camera';
import { atHandPlace, placeOf } from './lamps';
import { used } from './hints';
import { shortNumber } from './numbers';
import type { Vec3 } from './scene';
import {
  bounds, drawn, editLight, explained, frame, lamp, lampMoves, mainVolume, pictureSize, scene,
} from './state';
import { add, cross, dot, length, normalize, scale, subtract, turned } from './vectors';

const percent = (share: number): string => `${100 * share}%`;
const clamp = (share: number): number => Math.min(0.97, Math.max(0.03, share));

const aspect = (): number => {
  const [width, height] = pictureSize.value;
  return width / Math.max(1, height);
};

/** Where the handle of lamp number `n` is: directional lamps stand on a sphere round everything. */
function handlePlace(n: number): Vec3 | undefined {
  const one = frame.value?.lights[n];
  if (!one) return undefined;
  const { center, radius } = bounds.value;
  return one.point ? one.place : add(center, scale(0.9 * radius, normalize(one.place)));
}

/** From the lamp to what it is nearest to, of what is seen; or towards the middle. */
function LampLine({ x, y }: { x: number; y: number }) {
  const camera = frame.value?.camera;
  const foot = frame.value?.foot;
  if (!camera) return null;
  const seen = foot && projected(camera, aspect(), foot.position);
  const middle = projected(camera, aspect(), bounds.value.center) ?? { x: 0.5, y: 0.5 };
  const end = seen || { x: x + 0.55 * (middle.x - x), y: y + 0.55 * (middle.y - y) };
  return (
    <>
      {['lamp-line-under', 'lamp-line'].map((kind) => (
        <line key={kind} class={kind} x1={percent(x)} y1={percent(y)} x2={percent(end.x)} y2={percent(end.y)} />
      ))}
      {seen && (
        <svg x={percent(seen.x)} y={percent(seen.y)}>
          <circle class="lamp-foot-under" r="4" />
          <circle class="lamp-foot" r="4" />
        </svg>
      )}
      {foot && lampMoves.value && (
        <text class="lamp-distance" x={percent((x + end.x) / 2)} y={percent((y + end.y) / 2)}>
          {shortNumber(foot.distance)} mm
        </text>
      )}
    </>
  );
}

function Lamp({ n }: { n: number }) {
  const document = scene.value?.light[n];
  const camera = frame.value?.camera;
  const place = handlePlace(n);
  if (!document || !camera || !place) return null;
  const seen = projected(camera, aspect(), place);
  if (!seen) return null;
  const x = clamp(seen.x);
  const y = clamp(seen.y);
  const chosen = n === lamp.value;
  const isFar = x !== seen.x || y !== seen.y;

  const drag = (begin: PointerEvent) => {
    begin.stopPropagation();
    begin.preventDefault();
    lamp.value = n;
    used('lamp');
    const handle = begin.currentTarget as SVGElement;
    handle.setPointerCapture(begin.pointerId);
    const box = handle.closest('.picture')!.getBoundingClientRect();
    // From where it really is, though the handle may stand at the picture's edge.
    const start: ScreenPoint = isFar ? { ...seen, x, y } : seen;
    const move = (event: PointerEvent) => {
      const point = {
        x: start.x + (event.clientX - begin.clientX) / box.width,
        y: start.y + (event.clientY - begin.clientY) / box.height,
        depth: start.depth,
      };
      const world = unprojected(camera, aspect(), point);
      const volume = mainVolume.value;
      const { center } = bounds.value;
      editLight('place', (old) =>
        old.kind === 'point'
          ? atHandPlace(old, world, volume, camera, bounds.value)
          : atHandPlace(old, normalize(subtract(world, center)), volume, camera, bounds.value), n);
    };
    handle.addEventListener('pointermove', move);
    handle.addEventListener('lostpointercapture', () =>
      handle.removeEventListener('pointermove', move), { once: true });
  };

  const at = placeOf(document).map((v) => Math.round(v * 10) / 10).join(', ');
  return (
    <>
      {chosen && <LampLine x={x} y={y} />}
      <svg class={chosen ? 'lamp chosen' : 'lamp'} x={percent(x)} y={percent(y)} onPointerDown={drag}>
        <title>{`Lamp ${n + 1} at ${at}: drag me`}</title>
        <circle class="touch" r="22" />
        <circle class="halo" r="17" />
        <path class="rays" d="M0-10.5V-14M0 10.5V14M-10.5 0H-14M10.5 0H14M-7.4-7.4l-2.5-2.5M7.4 7.4l2.5 2.5M-7.4 7.4l-2.5 2.5M7.4-7.4l2.5-2.5" />
        <circle class="sun" r="6" />
      </svg>
    </>
  );
}

function Arrow({ from, to, name, kind }: { from: ScreenPoint; to: ScreenPoint; name: string; kind: string }) {
  const dx = (to.x - from.x) * aspect();
  const dy = to.y - from.y;
  const angle = (Math.atan2(dy, dx) * 180) / Math.PI;
  const shown = Math.hypot(dx, dy) > 0.012;
  const reach = 1 + 0.03 / Math.max(0.05, Math.hypot(dx, dy));
  return (
    <g class={'vector ' + kind}>
      <line class="under" x1={percent(from.x)} y1={percent(from.y)} x2={percent(to.x)} y2={percent(to.y)} />
      <line x1={percent(from.x)} y1={percent(from.y)} x2={percent(to.x)} y2={percent(to.y)} />
      {shown && (
        <svg x={percent(to.x)} y={percent(to.y)}>
          <path d="M1 0L-9-4.5V4.5z" transform={`rotate(${angle})`} />
        </svg>
      )}
      <text
        x={percent(from.x + (to.x - from.x) * reach)}
        y={percent(from.y + (to.y - from.y) * reach)}
        dy={dy < 0 ? '-0.2em' : '0.9em'}
      >
        {name}
      </text>
    </g>
  );
}

/** Points of the arc from unit vector a to unit vector b round p. */
function arc(p: Vec3, a: Vec3, b: Vec3, radius: number): Vec3[] {
  const axis = cross(a, b);
  if (length(axis) < 1e-6) return [];
  const angle = Math.acos(Math.min(1, Math.max(-1, dot(a, b))));
  const steps = 24;
  return Array.from({ length: steps + 1 }, (_, n) =>
    add(p, scale(radius, turned(a, normalize(axis), (angle * n) / steps))),
  );
}

/** Rays from the places that send most of the first bounce, the wider the more it is. */
function Senders() {
  const camera = frame.value?.camera;
  const why = explained.value;
  const seen = camera && why?.hit && projected(camera, aspect(), why.position);
  if (!seen) return null;
  const senders = why.first_bounce?.senders ?? [];
  const most = senders[0]?.share ?? 1;
  return (
    <g class="senders">
      {senders.map(({ position, share }, n) => {
        const from = projected(camera, aspect(), position);
        if (!from) return null;
        const line = { x1: percent(from.x), y1: percent(from.y), x2: percent(seen.x), y2: percent(seen.y) };
        const width = 1 + 2.5 * (share / most);
        return (
          <g key={n}>
            <line class="under" {...line} stroke-width={width + 2} />
            <line {...line} stroke-width={width} />
            <svg x={line.x1} y={line.y1}>
              <circle r="7" />
              <text dy="0.35em">{n + 1}</text>
            </svg>
          </g>
        );
      })}
    </g>
  );
}

function Vectors() {
  const camera = frame.value?.camera;
  const why = explained.value;
  if (!camera || !why?.hit) return null;
  const see = (p: Vec3) => projected(camera, aspect(), p);
  const p = why.position;
  const seen = see(p);
  if (!seen) return null;
  // Long enough to read at any zoom.
  const reach = 0.34 * camera.half_height * (camera.orthographic ? 1 : seen.depth);
  const tip = (v: Vec3, by = 1) => see(add(p, scale(by * reach, v)));
  const of = why.lights[Math.min(lamp.value, why.lights.length - 1)];
  const parts: ComponentChildren[] = [];
  const arrow = (v: Vec3, name: string, kind: string) => {
    const to = tip(v);
    if (to) parts.push(<Arrow key={name} from={seen} to={to} name={name} kind={kind} />);
  };
  const angle = (a: Vec3, b: Vec3, by: number, name: string, kind: string) => {
    const points = arc(p, a, b, by * reach).map(see);
    if (points.length === 0 || points.some((one) => !one)) return;
    const [w, h] = pictureSize.value;
    const k = 1000 / Math.max(1, h);
    const text = points
      .map((one) => `${(one!.x * w * k).toFixed(1)},${(one!.y * h * k).toFixed(1)}`)
      .join(' ');
    const middle = points[points.length >> 1]!;
    parts.push(
      <svg key={name} viewBox={`0 0 ${w * k} 1000`} preserveAspectRatio="none" width="100%" height="100%">
        <polyline class={'arc ' + kind} points={text} />
      </svg>,
      <text key={name + 'name'} class={'arc-name ' + kind} x={percent(middle.x)} y={percent(middle.y)}>
        {name}
      </text>,
    );
  };
  if (of) {
    angle(why.normal, of.to_light, 0.45, 'θ', 'theta');
    angle(of.reflected, why.to_eye, 0.3, 'φ', 'phi');
    arrow(of.to_light, 'l', 'l');
    arrow(of.reflected, 'r', 'r');
  }
  arrow(why.normal, 'n', 'n');
  arrow(why.to_eye, 'e', 'e');
  return (
    <g class="vectors">
      {parts}
      <svg x={percent(seen.x)} y={percent(seen.y)}>
        <circle class="point" r="3.5" />
      </svg>
    </g>
  );
}

/** The pixel asked about, where nothing was met. */
function Missed() {
  const why = explained.value;
  const size = drawn.value?.size;
  if (!why || why.hit || !size) return null;
  return (
    <svg x={percent((why.pixel[0] + 0.5) / size[0])} y={percent((why.pixel[1] + 0.5) / size[1])}>
      <path class="missed" d="M-6-6L6 6M-6 6L6-6" />
    </svg>
  );
}

export function Overlay() {
  const lights = scene.value?.light ?? [];
  return (
    <svg class="overlay" aria-hidden="true">
      {lights.map((_, n) => (
        <Lamp key={n} n={n} />
      ))}
      <Senders />
      <Vectors />
      <Missed />
    </svg>
  );
}
