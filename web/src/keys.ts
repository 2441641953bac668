// The keyboard, wherever no field wants it.
import { showSection } from './dock';
import { moveBy, stopExplaining } from './explain';
import { saveHere } from './files';
import { pan, turn, zoom } from './gestures';
import { besideIndirect } from './light_panel';
import { setOption } from './option_control';
import { viewNames } from './scene';
import { toggleSplit } from './split';
import { explained, explaining, hand, helpOpen, honours, lamp, redo, scene, undo } from './state';
import { fitHere, setView } from './view_panel';

const turnStep = Math.PI / 36;
const zoomStep = 1.1;
const panStep = 0.05; // of the picture's height

const arrows: Record<string, [number, number]> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, -1],
  ArrowDown: [0, 1],
};

function focusAxis(axis: string): void {
  showSection('lamp');
  requestAnimationFrame(() => document.getElementById('lamp-' + axis)?.focus());
}

function toggle(option: string, on: string): void {
  if (!honours(option)) return;
  const to = scene.value?.[option] === on ? 'off' : on;
  setOption(option, to, '', option === 'indirect' ? besideIndirect(to) : []);
}

const pressed: Record<string, () => void> = {
  l: () => {
    const count = scene.value?.light.length ?? 0;
    if (count > 0) lamp.value = (lamp.value + 1) % count;
  },
  m: () => {
    hand.value = hand.value === 'orbit' ? 'lamp' : 'orbit';
  },
  x: () => focusAxis('x'),
  y: () => focusAxis('y'),
  z: () => focusAxis('z'),
  s: () => toggle('shadows', 'on'),
  i: () => toggle('indirect', 'transport'),
  e: () => (explaining.value ? stopExplaining() : moveBy(0, 0)),
  f: fitHere,
  o: () => document.querySelector<HTMLInputElement>('[data-testid=open-file]')?.click(),
  '/': toggleSplit,
  '?': () => {
    helpOpen.value = !helpOpen.value;
  },
  '+': () => zoom(1 / zoomStep),
  '=': () => zoom(1 / zoomStep),
  '-': () => zoom(zoomStep),
};

function withControl(event: KeyboardEvent): boolean {
  const key = event.key.toLowerCase();
  if (key === 'z') (event.shiftKey ? redo : undo)();
  else if (key === 'y') redo();
  else if (key === 's') saveHere('png');
  else return false;
  return true;
}

function withArrow(event: KeyboardEvent): boolean {
  const arrow = arrows[event.key];
  if (!arrow || !(event.target as Element).matches('.picture')) return false;
  const [dx, dy] = arrow;
  if (explained.value) {
    const by = event.shiftKey ? 20 : 1;
    moveBy(by * dx, by * dy);
  } else if (event.shiftKey) {
    pan(-panStep * dx, -panStep * dy, 1);
  } else {
    turn(turnStep * dx, turnStep * dy);
  }
  return true;
}

/** Escape closes the innermost thing; the browser closes menus itself. */
function escaped(): void {
  if (helpOpen.value) helpOpen.value = false;
  else stopExplaining();
}

function onKey(event: KeyboardEvent): void {
  if (event.defaultPrevented || event.altKey) return;
  if (event.ctrlKey || event.metaKey) {
    if (withControl(event)) event.preventDefault();
    return;
  }
  if (event.key === 'Escape') return escaped();
  const target = event.target as Element;
  const typing = target.matches('input:not([type=range], [type=checkbox], [type=radio]), select');
  if (typing) return;
  if (withArrow(event)) {
    event.preventDefault();
    return;
  }
  const view = viewNames[Number(event.key) - 1];
  const action = view ? () => setView(view) : pressed[event.key.toLowerCase()];
  if (!action) return;
  event.preventDefault();
  action();
}

export const listenToKeys = (): void => addEventListener('keydown', onKey);
