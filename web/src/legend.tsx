// How to read false colours: a strip of them with its two ends.
import { comparesIndirect, hasIndirect } from './split';
import { divider, edited, frame, peek } from './state';
import { layerName, type Layer } from './scene';
import type { Legend as LegendData } from './frame';
import { shortNumber } from './numbers';

/** Beside what lamps send alone, the picture is what indirect light makes of it. */
const nameOf = (layer: Layer): string =>
  layer === 'picture' && comparesIndirect.value && hasIndirect.value ? 'With indirect' : layerName(layer);

function Legend({ layer, legend, at }: { layer: Layer; legend: LegendData | null; at: string }) {
  const colors = legend?.colors.map((c) => `rgb(${c.join(' ')})`).join(', ');
  const unit = legend?.unit ? ' ' + legend.unit : '';
  return (
    <div class={'legend ' + at}>
      <span>{nameOf(layer)}</span>
      {legend && (
        <span class="scale">
          {shortNumber(legend.low)}
          {unit}
          <span class="strip" style={{ background: `linear-gradient(to right, ${colors})` }} />
          {shortNumber(legend.high)}
          {unit}
        </span>
      )}
      {layer === 'normal' && <span class="scale">red x · green y · blue z, from −1 to 1</span>}
    </div>
  );
}

export function Legends() {
  const now = edited.value;
  const legends = frame.value?.legends ?? [];
  if (!now) return null;
  const shown = peek.value ?? now.show;
  if (!now.other) {
    return shown === 'picture' ? null : <Legend layer={shown} legend={legends[0] ?? null} at="left" />;
  }
  return (
    <>
      {divider.value > 0.12 && <Legend layer={shown} legend={legends[0] ?? null} at="left" />}
      {divider.value < 0.88 && <Legend layer={now.other} legend={legends[1] ?? null} at="right" />}
    </>
  );
}
