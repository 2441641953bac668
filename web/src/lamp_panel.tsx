import { Choice, ColorField, Menu, MenuItem, NumberRow } from './controls';
import {
  inSpace, ofKind, placeOf, placeStep, pointAt, presets, sliderRange, type Space, spaceOf, withPlace,
} from './lamps';
import type { Light, Vec3 } from './scene';
import { bounds, editLight, editScene, frame, lamp, light, mainVolume, scene } from './state';
import { tidy } from './vectors';

const axes = ['x', 'y', 'z'] as const;
const axisHints: Record<Space, [string, string, string]> = {
  mm: ['towards the patient’s left', 'towards the back', 'towards the head'],
  voxel: ['voxel index i', 'voxel index j', 'voxel index k'],
  camera: ['to the right in the picture', 'up in the picture', 'towards you'],
};

/** One axis of the chosen lamp's place; x is what the lecture moves. */
export function PlaceRow({ axis, id }: { axis: 0 | 1 | 2; id: string }) {
  const document = light.value;
  if (!document) return null;
  const [low, high] = sliderRange(document, axis, bounds.value, mainVolume.value);
  const space = spaceOf(document);
  const directional = document.kind === 'directional';
  const place = placeOf(document);
  return (
    <NumberRow
      id={id}
      warm
      open
      label={axes[axis]}
      name={`Lamp ${lamp.value + 1}, ${axes[axis]}`}
      hint={axisHints[space][axis]}
      value={place[axis]}
      low={low}
      high={high}
      step={placeStep(document, bounds.value)}
      unit={directional ? '' : space === 'voxel' ? 'vx' : 'mm'}
      usual={tidy((low + high) / 2)}
      onChange={(value) =>
        editLight('place', (old) => {
          const moved = [...placeOf(old)] as Vec3;
          moved[axis] = value;
          // A direction of no length points nowhere.
          return moved.some((v) => v !== 0) || old.kind === 'point' ? withPlace(old, moved) : old;
        })
      }
    />
  );
}

const spaces: { value: Space; label: string; hint: string }[] = [
  { value: 'mm', label: 'mm', hint: 'millimetres in the patient' },
  { value: 'voxel', label: 'voxel', hint: 'voxel indices, as in the lecture' },
  { value: 'camera', label: 'camera', hint: 'fixed to the camera: goes with the view' },
];

function addLight(one: Light): void {
  editScene('', (old) => ({ ...old, light: [...old.light, one] }));
  lamp.value = (scene.value?.light.length ?? 1) - 1;
}

function removeLight(n: number): void {
  editScene('', (old) => ({ ...old, light: old.light.filter((_, at) => at !== n) }));
  lamp.value = Math.max(0, n - 1);
}

const newLamp = (): Light => pointAt(bounds.value, [0.6, -0.9, 0.4]);

function Lamps({ lights }: { lights: Light[] }) {
  return (
    <ul class="lamps" aria-label="Lamps">
      {lights.map((one, n) => (
        <li key={n}>
          <button
            type="button"
            class="lamp-button"
            aria-pressed={n === lamp.value}
            onClick={() => {
              lamp.value = n;
            }}
          >
            Lamp {n + 1}
          </button>
          <ColorField
            name={`Colour of lamp ${n + 1}`}
            value={one.color}
            onChange={(color) => editLight('color', (old) => ({ ...old, color }), n)}
          />
        </li>
      ))}
    </ul>
  );
}

export function LampPanel() {
  const lights = scene.value?.light ?? [];
  const document = light.value;
  const volume = mainVolume.value;
  const camera = frame.value?.camera;
  const reference = document?.reference ?? 1000;
  const step = document ? placeStep(document, bounds.value) : 1;
  const inverseSquare = document?.falloff === 'inverse-square';
  return (
    <>
      {document && (
        <>
          <PlaceRow axis={0} id="lamp-x" />
          <PlaceRow axis={1} id="lamp-y" />
          <PlaceRow axis={2} id="lamp-z" />
          <NumberRow
            warm
            open
            label="intensity"
            name={`Intensity of lamp ${lamp.value + 1}`}
            hint="a factor on its colour; may exceed 1"
            value={document.intensity}
            low={0}
            high={4}
            step={0.05}
            usual={1}
            onChange={(value) =>
              editLight('intensity', (old) => ({ ...old, intensity: Math.max(0, value) }))
            }
          />
          <div class="line">
            <Choice
              name="Kind of lamp"
              value={document.kind}
              choices={[
                { value: 'point', label: 'point', hint: 'shines from a place' },
                { value: 'directional', label: 'directional', hint: 'from far away, like the sun' },
              ]}
              onChange={(kind) =>
                camera &&
                editLight('', (old) => ofKind(old, kind, bounds.value, volume, camera))
              }
            />
            <Choice
              name="Where its numbers count"
              value={spaceOf(document)}
              choices={spaces.filter(({ value }) => volume || value !== 'voxel')}
              onChange={(space) =>
                camera && editLight('', (old) => inSpace(old, space, volume, camera))
              }
            />
          </div>
          {document.kind === 'point' && (
            <div class="line">
              <label class="check" title="weaker with the square of the distance">
                <input
                  type="checkbox"
                  checked={inverseSquare}
                  onChange={() =>
                    editLight('', (old) => {
                      const { reference: _reference, ...rest } = old;
                      return inverseSquare
                        ? { ...rest, falloff: 'none' }
                        : { ...rest, falloff: 'inverse-square', reference: tidy(bounds.value.radius) };
                    })
                  }
                />
                falloff with distance
              </label>
            </div>
          )}
          {inverseSquare && (
            <NumberRow
              warm
              open
              label="full at"
              name="Distance of full intensity"
              hint="where the intensity is as it says"
              value={reference}
              low={step}
              high={tidy(4 * bounds.value.radius)}
              step={step}
              unit="mm"
              onChange={(value) =>
                editLight('reference', (old) => ({ ...old, reference: Math.max(0.001, value) }))
              }
            />
          )}
        </>
      )}
      {!document && <p class="hint">No lamp: light comes from the eye, as a headlight.</p>}
      <Lamps lights={lights} />
      <div class="line">
        <button type="button" onClick={() => addLight(newLamp())}>
          Add
        </button>
        {document && (
          <>
            <button type="button" onClick={() => addLight(document)}>
              Duplicate
            </button>
            <button type="button" onClick={() => removeLight(lamp.value)}>
              Remove
            </button>
          </>
        )}
        <Menu label="Presets">
          {presets.filter((one) => volume || !one.needsVolume).map((preset) => (
            <MenuItem
              key={preset.name}
              hint={preset.hint}
              onChoose={() => {
                editScene('', (old) => ({ ...old, light: preset.lights(bounds.value, volume) }));
                lamp.value = 0;
              }}
            >
              {preset.name}
            </MenuItem>
          ))}
        </Menu>
      </div>
      {lights.length > 1 && (
        <p class="hint">Press L for the next lamp; X, Y or Z, then arrows, move it.</p>
      )}
    </>
  );
}
