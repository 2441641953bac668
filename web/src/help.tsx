import { useEffect, useRef } from 'preact/hooks';
import { helpOpen, honours } from './state';

const hands: [string, string][] = [
  ['drag', 'turn the scan'],
  ['right-drag, two fingers', 'move it'],
  ['wheel, pinch', 'zoom at the pointer'],
  ['drag a sun', 'move that lamp'],
  ['Shift-drag, or Move lamp and drag', 'take the lamp over the surface'],
  ['click, tap', 'explain that pixel'],
  ['Shift on a slider', 'finer'],
  ['double-click, Backspace', 'reset a number'],
];

const keys = (): [string, string][] => [
  ['1 … 6', 'front, back, left, right, top, bottom'],
  ['arrows, + −', 'turn and zoom, with the picture in focus'],
  ['Shift+arrows', 'move it'],
  ['F', 'fit it to the window'],
  ['L', 'next lamp'],
  ['M', 'a drag turns the scan, or moves the lamp'],
  ['X Y Z, then arrows', 'move the lamp'],
  ...(honours('shadows') ? ([['S', 'shadows']] as [string, string][]) : []),
  ...(honours('indirect') ? ([['I', 'indirect light']] as [string, string][]) : []),
  ['E, then arrows', 'explain a pixel'],
  ['/', 'split view'],
  ['Ctrl+Z, Ctrl+Shift+Z', 'undo, redo'],
  ['Ctrl+S', 'save the picture'],
  ['O', 'open a file'],
  ['Esc', 'close what is open'],
];

function Rows({ title, rows }: { title: string; rows: [string, string][] }) {
  return (
    <section>
      <h3>{title}</h3>
      <dl>
        {rows.map(([what, does]) => (
          <div key={what}>
            <dt>{what}</dt>
            <dd>{does}</dd>
          </div>
        ))}
      </dl>
    </section>
  );
}

export function Help() {
  const dialog = useRef<HTMLDialogElement>(null);
  const open = helpOpen.value;
  useEffect(() => {
    if (open && !dialog.current?.open) dialog.current?.show();
    if (!open) dialog.current?.close();
  }, [open]);
  const close = () => {
    helpOpen.value = false;
  };
  return (
    <dialog class="help" ref={dialog} aria-labelledby="help-title" onClose={close}>
      <div class="help-head">
        <h2 id="help-title">Hands and keys</h2>
        <button type="button" onClick={close}>
          Close
        </button>
      </div>
      <div class="help-body">
        <Rows title="Hands" rows={hands} />
        <Rows title="Keys" rows={keys()} />
      </div>
    </dialog>
  );
}
