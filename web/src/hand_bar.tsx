// What a drag over the picture does, and the way back to all of it: within one tap of the picture.
import { Choice } from './controls';
import { type Hand, hand } from './state';
import { fitHere } from './view_panel';

const hands: { value: Hand; label: string; hint: string }[] = [
  { value: 'orbit', label: 'Orbit', hint: 'a drag turns the scan (M)' },
  { value: 'lamp', label: 'Move lamp', hint: 'a drag takes the lamp over the surface (M, or Shift)' },
];

export function HandBar() {
  return (
    <div class="hand-bar">
      <Choice
        name="What a drag does"
        value={hand.value}
        choices={hands}
        onChange={(value) => {
          hand.value = value;
        }}
      />
      <button type="button" title="fill the window with what is seen (F)" onClick={fitHere}>
        Fit
      </button>
    </div>
  );
}
