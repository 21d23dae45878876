// Growth of a measured memory by a straight line through all samples, so that one sample at an unlucky moment decides nothing.

/** Slope of the straight line through equally spaced `values` (least squares), per sample; 0 for fewer than two values. */
export function slope(values) {
  const middle = (values.length - 1) / 2;
  const mean = values.reduce((sum, v) => sum + v, 0) / values.length;
  const spread = values.reduce((sum, _v, i) => sum + (i - middle) ** 2, 0);
  return spread > 0 ? values.reduce((sum, v, i) => sum + (i - middle) * (v - mean), 0) / spread : 0;
}

/** Rise of that line from the first to the last sample. */
export const rise = (values) => slope(values) * (values.length - 1);
