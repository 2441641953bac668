// The picture's place: two canvases for the halves of a split view, and what is drawn over them.
import { useEffect, useRef } from 'preact/hooks';
import { followGestures } from './gestures';
import { Legends } from './legend';
import { Overlay } from './overlay';
import { paintWith } from './server';
import { divider, edit, edited, hand, pictureSize } from './state';

const mostPixels = 1 << 24;

function draw(canvas: HTMLCanvasElement, picture: ImageBitmap): void {
  if (canvas.width !== picture.width || canvas.height !== picture.height) {
    canvas.width = picture.width;
    canvas.height = picture.height;
  }
  canvas.getContext('2d', { alpha: false })?.drawImage(picture, 0, 0);
}

/** Device pixels, so that one pixel of the picture is one of the display. */
function observeSize(place: HTMLElement): () => void {
  const observer = new ResizeObserver(([entry]) => {
    const box = place.getBoundingClientRect();
    const pixels = (css: number, exact: number | undefined) => {
      const near = css * devicePixelRatio;
      return exact !== undefined && Math.abs(exact - near) <= 1 ? exact : Math.round(near);
    };
    const exact = entry?.devicePixelContentBoxSize?.[0];
    const width = pixels(box.width, exact?.inlineSize);
    const height = pixels(box.height, exact?.blockSize);
    const fit = Math.min(1, Math.sqrt(mostPixels / Math.max(1, width * height)));
    pictureSize.value = [Math.floor(width * fit), Math.floor(height * fit)];
  });
  try {
    observer.observe(place, { box: 'device-pixel-content-box' });
  } catch {
    observer.observe(place); // Safari
  }
  return () => observer.disconnect();
}

const split = (at: number): void =>
  edit('divider', (now) => ({ ...now, divider: Math.min(0.98, Math.max(0.02, at)) }));

function Divider() {
  const move = (event: PointerEvent) => {
    if (!event.buttons) return;
    const box = (event.currentTarget as HTMLElement).parentElement?.getBoundingClientRect();
    if (box) split((event.clientX - box.left) / box.width);
  };
  const percent = Math.round(100 * divider.value);
  return (
    <div
      class="divider"
      role="separator"
      tabIndex={0}
      aria-label="Where the picture is split"
      aria-orientation="vertical"
      aria-valuenow={percent}
      style={{ left: `${100 * divider.value}%` }}
      onPointerDown={(event) => {
        event.stopPropagation();
        event.currentTarget.setPointerCapture(event.pointerId);
      }}
      onPointerMove={move}
      onKeyDown={(event) => {
        const step = { ArrowLeft: -0.02, ArrowRight: 0.02 }[event.key];
        if (!step) return;
        event.preventDefault();
        event.stopPropagation();
        split(divider.value + step);
      }}
    >
      <span class="grip" />
    </div>
  );
}

export function Picture() {
  const place = useRef<HTMLDivElement>(null);
  const left = useRef<HTMLCanvasElement>(null);
  const right = useRef<HTMLCanvasElement>(null);
  useEffect(() => {
    paintWith((_, pictures) => {
      if (left.current && pictures[0]) draw(left.current, pictures[0]);
      if (right.current && pictures[1]) draw(right.current, pictures[1]);
    });
    const stop = [observeSize(place.current!), followGestures(place.current!)];
    return () => stop.forEach((one) => one());
  }, []);
  const isSplit = edited.value?.other != null;
  return (
    <div
      class={hand.value === 'lamp' ? 'picture with-lamp' : 'picture'}
      ref={place}
      tabIndex={0}
      role="application"
      aria-label="The picture. Arrow keys turn it, with Shift they move it, plus and minus zoom, question mark for help"
    >
      <canvas ref={left} />
      <canvas
        ref={right}
        hidden={!isSplit}
        style={{ clipPath: `inset(0 0 0 ${100 * divider.value}%)` }}
      />
      <Overlay />
      {isSplit && <Divider />}
      <Legends />
    </div>
  );
}
