// Two layers side by side.
import { computed } from '@preact/signals';
import type { Layer } from './scene';
import { edit, edited, scene } from './state';

export const hasIndirect = computed(() => (scene.value?.indirect ?? 'off') !== 'off');

export const isSplit = computed(() => edited.value?.other != null);

/** Whether the split is the one that shows what indirect light adds. */
export const comparesIndirect = computed(
  () => edited.value?.show === 'direct' && edited.value.other === 'picture',
);

export const splitInto = (show: Layer, other: Layer): void =>
  edit('', (now) => ({ ...now, show, other }));

const unsplit = (): void =>
  edit('', (now) => ({ ...now, show: comparesIndirect.value ? 'picture' : now.show, other: null }));

export const compareIndirect = (): void =>
  comparesIndirect.value ? unsplit() : splitInto('direct', 'picture');

/** With indirect light on, what it adds is what two halves are for. */
export function toggleSplit(): void {
  const show = edited.value?.show ?? 'picture';
  if (isSplit.value) unsplit();
  else if (hasIndirect.value && show === 'picture') compareIndirect();
  else splitInto(show, show === 'diffuse' ? 'picture' : 'diffuse');
}
