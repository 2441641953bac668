import { done, type Hint, usedAll } from './hints';

const lines = (touch: boolean): { hint: Hint; what: string; does: string }[] => [
  { hint: 'lamp', what: 'Drag the sun', does: 'the light follows' },
  { hint: 'explain', what: touch ? 'Tap the picture' : 'Click the picture', does: 'see why that pixel has its colour' },
  { hint: 'surface', what: touch ? 'Move lamp, then drag' : 'Shift-drag', does: 'the lamp goes over the surface' },
];

export function HintLines() {
  const left = lines(matchMedia('(pointer: coarse)').matches).filter(({ hint }) => !done.value.includes(hint));
  if (left.length === 0) return null;
  return (
    <div class="hint-lines" role="note" aria-label="To begin with">
      <ul>
        {left.map(({ hint, what, does }) => (
          <li key={hint}>
            <b>{what}</b>: {does}
          </li>
        ))}
      </ul>
      <button type="button" aria-label="Close these hints" onClick={usedAll}>
        ×
      </button>
    </div>
  );
}
