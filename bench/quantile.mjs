/** The value below which that share of a list lies. */
export const quantile = (list, share) =>
  [...list].sort((a, b) => a - b)[Math.floor(share * (list.length - 1))] ?? NaN;
