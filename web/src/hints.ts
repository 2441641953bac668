// What a newcomer is told over the picture, each line until it was done once.
import { signal } from '@preact/signals';

export type Hint = 'lamp' | 'explain' | 'surface';

const storageKey = 'isolux.done';

const read = (): Hint[] => {
  try {
    return JSON.parse(localStorage.getItem(storageKey) ?? '[]') as Hint[];
  } catch {
    return [];
  }
};

export const done = signal<Hint[]>(read());

function keep(list: Hint[]): void {
  done.value = list;
  try {
    localStorage.setItem(storageKey, JSON.stringify(list));
  } catch {
    // A browser that keeps nothing tells it again next time.
  }
}

export function used(hint: Hint): void {
  if (!done.value.includes(hint)) keep([...done.value, hint]);
}

export const usedAll = (): void => keep(['lamp', 'explain', 'surface']);
