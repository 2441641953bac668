// Numbers as people read them.

/** Three significant digits or whole numbers, with a real minus sign. */
export function shortNumber(value: number): string {
  const size = Math.abs(value);
  const text =
    size === 0 ? '0' : size >= 1000 ? String(Math.round(size)) : String(Number(size.toPrecision(3)));
  return (value < 0 && text !== '0' ? '−' : '') + text;
}

/** A fixed number of decimals, for columns. */
export const fixed = (value: number, decimals = 3): string =>
  (value < 0 ? '−' : '') + Math.abs(value).toFixed(decimals);
