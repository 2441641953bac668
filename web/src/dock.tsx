// The controls: at a desk a column of sections that fold, with all their headings always in sight; on
// a phone a sheet at the bottom that shows one of them.
import { effect, signal } from '@preact/signals';
import type { ComponentType } from 'preact';
import { ExplainPanel } from './explain_panel';
import { LampPanel, PlaceRow } from './lamp_panel';
import { LightPanel } from './light_panel';
import { SurfacePanel } from './surface_panel';
import { ViewPanel } from './view_panel';

type SectionId = 'lamp' | 'surface' | 'light' | 'view' | 'explain';

const sections: { id: SectionId; title: string; panel: ComponentType }[] = [
  { id: 'lamp', title: 'Lamp', panel: LampPanel },
  { id: 'surface', title: 'Surface', panel: SurfacePanel },
  { id: 'light', title: 'Light', panel: LightPanel },
  { id: 'view', title: 'View', panel: ViewPanel },
  { id: 'explain', title: 'Explain', panel: ExplainPanel },
];

const storageKey = 'isolux.open';

function kept(): SectionId[] {
  try {
    return JSON.parse(localStorage.getItem(storageKey) ?? 'null') ?? ['lamp', 'surface'];
  } catch {
    return ['lamp', 'surface'];
  }
}

const open = signal<SectionId[]>(kept());
/** The one that the sheet shows, and whether it shows any. */
const chosen = signal<SectionId>('lamp');
const raised = signal(false);

effect(() => {
  try {
    localStorage.setItem(storageKey, JSON.stringify(open.value));
  } catch {
    // A browser that keeps nothing begins as ever.
  }
});

const contentOf = (id: SectionId) => document.getElementById(`${id}-content`);

export function showSection(id: SectionId): void {
  if (!open.value.includes(id)) open.value = [...open.value, id];
  chosen.value = id;
  raised.value = true;
  // Once it has its height.
  requestAnimationFrame(() => contentOf(id)?.scrollIntoView({ block: 'start' }));
}

/** Whether the heading stands where its content is, and not at an edge of the dock for it. */
function isInPlace(heading: HTMLElement, content: HTMLElement): boolean {
  return Math.abs(heading.getBoundingClientRect().bottom - content.getBoundingClientRect().top) < 2;
}

function pressed(id: SectionId, heading: HTMLElement): void {
  const content = contentOf(id);
  if (open.value.includes(id) && content && isInPlace(heading, content)) {
    open.value = open.value.filter((one) => one !== id);
  } else {
    showSection(id);
  }
}

function Section({ id, title, panel: Panel, n }: (typeof sections)[number] & { n: number }) {
  const isOpen = open.value.includes(id);
  const classes = ['section', isOpen && 'open', id === chosen.value && 'chosen'].filter(Boolean);
  return (
    <section
      class={classes.join(' ')}
      id={`${id}-section`}
      aria-labelledby={`${id}-title`}
      style={{ '--before': n, '--after': sections.length - 1 - n }}
    >
      <h2>
        <button
          type="button"
          id={`${id}-title`}
          aria-expanded={isOpen}
          aria-controls={`${id}-content`}
          onClick={(event) => pressed(id, event.currentTarget)}
        >
          {title}
        </button>
      </h2>
      <div class="content" id={`${id}-content`}>
        <Panel />
      </div>
    </section>
  );
}

function Tabs() {
  return (
    <nav class="tabs" aria-label="Parts of the controls">
      {sections.map(({ id, title }) => {
        const isShown = raised.value && id === chosen.value;
        return (
          <button
            key={id}
            type="button"
            aria-pressed={isShown}
            onClick={() => {
              chosen.value = id;
              raised.value = !isShown;
            }}
          >
            {title}
          </button>
        );
      })}
    </nav>
  );
}

export function Dock() {
  return (
    <aside class={raised.value ? 'dock raised' : 'dock'} aria-label="Controls">
      <div class="first-row">
        <PlaceRow axis={0} id="lamp-x-first" />
      </div>
      <Tabs />
      <div class="sections">
        {sections.map((one, n) => (
          <Section key={one.id} {...one} n={n} />
        ))}
      </div>
    </aside>
  );
}
