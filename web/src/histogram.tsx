// How often each value stands in the volume, on a logarithmic scale, and where the surfaces cut it.
import { useRef } from 'preact/hooks';
import { hexOf } from './colors';
import { colorOf } from './materials';
import { shortNumber } from './numbers';
import type { Surface, VolumeReport } from './scene';
import { surface } from './state';
import { inputOf, nameOf } from './surface_panel';

const width = 300;
const height = 56;

function outline(histogram: number[]): string {
  const most = Math.log1p(Math.max(1, ...histogram));
  const step = width / histogram.length;
  const tops = histogram.map((count, n) => {
    const y = (height - (height - 4) * (Math.log1p(count) / most)).toFixed(1);
    return `L${(n * step).toFixed(1)} ${y}L${((n + 1) * step).toFixed(1)} ${y}`;
  });
  return `M0 ${height}${tops.join('')}L${width} ${height}Z`;
}

function Handle(props: {
  one: Surface;
  n: number;
  input: VolumeReport;
  valueAt: (clientX: number) => number;
  onMove: (iso: number) => void;
}) {
  const { one, n, input } = props;
  const range = input.max - input.min || 1;
  const iso = one.iso ?? 0;
  const share = Math.min(1, Math.max(0, (iso - input.min) / range));
  return (
    <div
      class={n === surface.value ? 'handle chosen' : 'handle'}
      role="slider"
      tabIndex={0}
      aria-label={`Iso value of surface ${n + 1}, ${nameOf(one)}`}
      aria-valuemin={input.min}
      aria-valuemax={input.max}
      aria-valuenow={iso}
      style={{ left: `${100 * share}%`, '--color': hexOf(colorOf(one, input)) }}
      onFocus={() => {
        surface.value = n;
      }}
      onPointerDown={(event) => {
        event.currentTarget.setPointerCapture(event.pointerId);
        surface.value = n;
      }}
      onPointerMove={(event) => {
        if (event.buttons) props.onMove(props.valueAt(event.clientX));
      }}
      onKeyDown={(event) => {
        const steps = { ArrowLeft: -1, ArrowRight: 1, ArrowDown: -1, ArrowUp: 1, PageDown: -10, PageUp: 10 }[
          event.key
        ];
        if (!steps) return;
        event.preventDefault();
        const by = (range / 400) * steps * (event.shiftKey ? 0.1 : 1);
        const fine = range > 100 ? Math.round : (v: number) => v;
        props.onMove(fine(Math.min(input.max, Math.max(input.min, iso + by))));
      }}
    />
  );
}

export function Histogram(props: {
  list: Surface[];
  input: VolumeReport;
  onMove: (n: number, iso: number) => void;
}) {
  const { input } = props;
  const place = useRef<HTMLDivElement>(null);
  const valueAt = (clientX: number): number => {
    const box = place.current!.getBoundingClientRect();
    const share = Math.min(1, Math.max(0, (clientX - box.left) / box.width));
    const value = input.min + share * (input.max - input.min);
    return input.max - input.min > 100 ? Math.round(value) : Number(value.toPrecision(4));
  };
  return (
    <div class="histogram">
      <div class="plot" ref={place}>
        <svg viewBox={`0 0 ${width} ${height}`} preserveAspectRatio="none" aria-hidden="true">
          <path d={outline(input.histogram)} />
        </svg>
        {props.list.map((one, n) =>
          inputOf(one) === input ? (
            <Handle
              key={n}
              one={one}
              n={n}
              input={input}
              valueAt={valueAt}
              onMove={(iso) => props.onMove(n, iso)}
            />
          ) : null,
        )}
      </div>
      <div class="ends">
        <span>{shortNumber(input.min)}</span>
        <span>{input.units ?? 'value'}</span>
        <span>{shortNumber(input.max)}</span>
      </div>
    </div>
  );
}
