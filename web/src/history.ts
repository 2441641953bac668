// Undo and redo: whole states, which are cheap since nothing in them is ever changed in place.

export interface History<State> {
  past: State[];
  present: State;
  future: State[];
  /** What the last change was about, and when, so that a drag is one step. */
  about: string;
  at: number;
}

const oneStep_ms = 900;
const mostSteps = 500;

export const begun = <State>(present: State): History<State> => ({
  past: [],
  present,
  future: [],
  about: '',
  at: 0,
});

export function changed<State>(
  history: History<State>,
  present: State,
  about: string,
  now: number,
): History<State> {
  const goesOn = about !== '' && about === history.about && now - history.at < oneStep_ms;
  const past = goesOn ? history.past : [...history.past, history.present].slice(-mostSteps);
  return { past, present, future: [], about, at: now };
}

/** The present state is replaced; the step that led to it now leads to the new one. */
export const amended = <State>(history: History<State>, present: State): History<State> => ({
  ...history,
  present,
});

export function undone<State>(history: History<State>): History<State> {
  const present = history.past.at(-1);
  if (present === undefined) return history;
  const future = [history.present, ...history.future];
  return { past: history.past.slice(0, -1), present, future, about: '', at: 0 };
}

export function redone<State>(history: History<State>): History<State> {
  const [present, ...future] = history.future;
  if (present === undefined) return history;
  return { past: [...history.past, history.present], present, future, about: '', at: 0 };
}
