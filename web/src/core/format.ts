/** Formatting of values for display, and parsing of typed numbers. */

/** A time in seconds as text: 3.42 → "00:03.42". */
export function format_time(seconds: number): string {
  const sign = seconds < 0 ? '-' : '';
  const hundredths = Math.round(Math.abs(seconds) * 100);
  const minutes = Math.floor(hundredths / 6000);
  const rest = hundredths - minutes * 6000;
  return `${sign}${String(minutes).padStart(2, '0')}:${String(Math.floor(rest / 100)).padStart(2, '0')}.${String(rest % 100).padStart(2, '0')}`;
}

/** At most `digits` decimals, without trailing zeros or a negative zero. */
export function format_number(value: number, digits = 2): string {
  if (!Number.isFinite(value)) return '–';
  const text = value.toFixed(digits);
  const trimmed = text.includes('.') ? text.replace(/0+$/, '').replace(/\.$/, '') : text;
  return trimmed === '-0' ? '0' : trimmed;
}

/** Text of a value for an input field: like `format_number`, but small values have three significant digits instead of becoming 0. */
export function format_field(value: number, digits = 2): string {
  const text = format_number(value, digits);
  return text === '0' && value !== 0 ? String(Number(value.toPrecision(3))) : text;
}

/** A label of the time ruler: "0", "1 s", "1:30". @param time, label_step in s */
export function format_ruler(time: number, label_step: number): string {
  const t = Math.round(time * 1000) / 1000;
  if (t === 0) return '0';
  if (Math.abs(t) >= 60) {
    const minutes = Math.floor(t / 60);
    return `${minutes}:${String(Math.round(t - minutes * 60)).padStart(2, '0')}`;
  }
  const digits = label_step >= 1 ? 0 : label_step >= 0.1 ? 1 : 2;
  return `${t.toFixed(digits)} s`;
}

/** Distance between two surfaces: "412 mm", "1.25 m"; a negative distance (penetration): "8 mm deep". */
export function format_gap(metres: number): string {
  if (metres < 0) return `${(-1000 * metres).toFixed(-metres < 0.0095 ? 1 : 0)} mm deep`;
  if (metres < 0.9995) return `${(1000 * metres).toFixed(metres < 0.0095 ? 1 : 0)} mm`;
  return `${metres.toFixed(2)} m`;
}

export const format_percent = (fraction: number, digits = 1): string => `${(fraction * 100).toFixed(digits)} %`;

/** A speed factor as text: "38×", "0.4×". */
export function format_factor(factor: number): string {
  if (!Number.isFinite(factor) || factor <= 0) return '–';
  return `${factor >= 10 ? factor.toFixed(0) : factor.toFixed(1)}×`;
}

/** A link's label for display: "forearm left" → "Left forearm". */
export function format_label(label: string): string {
  const side = /^(.*?)[\s_]+(left|right)$/i.exec(label.trim());
  const text = side ? `${side[2]!.toLowerCase()} ${side[1]}` : label.trim();
  return text.charAt(0).toUpperCase() + text.slice(1).replace(/_/g, ' ');
}

/** Joins facts for display, such as "Human 1.75 m · 62 DOF · 70 kg"; empty facts are omitted. */
export const join_facts = (facts: (string | undefined | false)[]): string => facts.filter(Boolean).join(' · ');

/**
 * The value of text typed into a numeric field: a number with decimal comma or point, or an arithmetic expression ("1.2+0.3", "90/2").
 * A unit at the end is ignored. Null if the text is not a number.
 */
export function parse_number(text: string): number | null {
  const cleaned = text.trim().replace(/,/g, '.').replace(/\u2212/g, '-').replace(/\s*(?:[a-z°%×][a-z°%×²\s/]*)$/i, '');
  if (!/^[-+0-9.*/ e()]+$/i.test(cleaned)) return null;
  const tokens = cleaned.match(/\d+\.?\d*(?:e[-+]?\d+)?|\.\d+|[-+*/]/gi);
  if (!tokens || tokens.join('') !== cleaned.replace(/\s/g, '')) return null;
  let at = 0;
  const factor = (): number => {
    const token = tokens[at++];
    if (token === '-') return -factor();
    if (token === '+') return factor();
    return token === undefined ? NaN : Number(token);
  };
  const product = (): number => {
    let value = factor();
    while (tokens[at] === '*' || tokens[at] === '/') value = tokens[at++] === '*' ? value * factor() : value / factor();
    return value;
  };
  let value = product();
  while (tokens[at] === '+' || tokens[at] === '-') value = tokens[at++] === '+' ? value + product() : value - product();
  return at === tokens.length && Number.isFinite(value) ? value : null;
}
