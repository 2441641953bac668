import { ColorField, NumberRow } from './controls';
import { OptionControl } from './option_control';
import type { Scene, Vec3 } from './scene';
import { compareIndirect, comparesIndirect, hasIndirect } from './split';
import { editScene, scene } from './state';
import { add, largest, scale } from './vectors';

/** What Ia is where the scene does not say: the sum of the lights' intensities. */
const ownAmbient = (now: Scene): Vec3 =>
  now.light.length === 0
    ? [1, 1, 1]
    : now.light.reduce<Vec3>((sum, one) => add(sum, scale(one.intensity, one.color)), [0, 0, 0]);

function Ambient({ now }: { now: Scene }) {
  const value = now.ambient ?? ownAmbient(now);
  const strength = largest(value);
  const color = strength > 0 ? scale(1 / strength, value) : ([1, 1, 1] as Vec3);
  const set = (ambient: Vec3) => editScene('ambient', (old) => ({ ...old, ambient }));
  return (
    <>
      <label class="check" title="the sum of the lamps’ intensities, as in the lecture">
        <input
          type="checkbox"
          checked={now.ambient === undefined}
          onChange={(event) => {
            const own = event.currentTarget.checked;
            editScene('', ({ ambient: _ambient, ...rest }) => (own ? rest : { ...rest, ambient: value }) as Scene);
          }}
        />
        ambient light follows the lamps
      </label>
      <div class="with-color">
        <NumberRow
          label="Ia ambient"
          hint="light that is taken to come evenly from everywhere; ka says how much of it is sent on"
          value={strength}
          low={0}
          high={4}
          step={0.05}
          open
          usual={largest(ownAmbient(now))}
          onChange={(v) => set(scale(Math.max(0, v), color))}
        />
        <ColorField name="Colour of the ambient light" value={color} onChange={(c) => set(scale(strength, c))} />
      </div>
    </>
  );
}

/** Options of indirect light that have no meaning beside a method of it. */
export function besideIndirect(method: unknown): string[] {
  if (method === 'path') return ['indirect-memory'];
  const ofPaths = ['spp', 'error', 'seed', 'denoise'];
  return method === 'off' ? ['bounces', 'indirect-memory', ...ofPaths] : ofPaths;
}

export function LightPanel() {
  const now = scene.value;
  if (!now) return null;
  const mirrors = now.surface.some((one) => one.kr?.some((v) => v > 0));
  const indirect = hasIndirect.value;
  return (
    <>
      <OptionControl name="shadows" label="shadows" />
      <Ambient now={now} />
      {mirrors && <OptionControl name="mirror-depth" label="mirrors" usualHigh={8} />}
      <OptionControl name="indirect" label="indirect" drops={besideIndirect} />
      {indirect && <OptionControl name="bounces" label="bounces" usual={2} usualHigh={8} />}
      {indirect && (
        <div class="line">
          <button type="button" aria-pressed={comparesIndirect.value} title="two halves with a divider"
            onClick={compareIndirect}>
            Split: direct | with indirect
          </button>
        </div>
      )}
      {now.indirect === 'path' && <OptionControl name="spp" label="samples" usual={64} usualHigh={1024} />}
    </>
  );
}
