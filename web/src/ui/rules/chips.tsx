/** Chips: the editable words of a rule's sentence. Each lists only values that fit. */
import { useEffect, useState, type ReactElement } from 'react';
import { format_field, parse_number } from '../../core/format';
import { key_name } from '../../core/rules';

/** Hue of a chip: that of the pin type that the word stands for. */
export type Hue = 'event' | 'contacts' | 'scalar' | 'motion' | 'joints' | 'vector' | 'plain';

/** @param compact true: shows an arrow instead of the value */
export function ChoiceChip({ label, hue, value, choices, on_commit, compact = false }: { label: string; hue: Hue; compact?: boolean; value: string; choices: readonly (readonly [string, string])[]; on_commit: (value: string) => void }): ReactElement {
  const shown = choices.some(([key]) => key === value) ? choices : [...choices, [value, value] as const];
  return (
    <select className={compact ? 'chip compact' : 'chip'} data-hue={hue} aria-label={label} title={label} value={value} onChange={(e) => on_commit(e.target.value)}>
      {shown.map(([key, text]) => (
        <option key={key} value={key}>{text}</option>
      ))}
    </select>
  );
}

export function NumberChip({ label, hue = 'scalar', value, unit, digits = 2, min = -Infinity, max = Infinity, on_commit }: { label: string; hue?: Hue; value: number; unit: string; digits?: number; min?: number; max?: number; on_commit: (value: number) => void }): ReactElement {
  const [text, set_text] = useState<string | null>(null);
  const shown = text ?? format_field(value, digits);
  const commit = (): void => {
    const parsed = text === null ? null : parse_number(text);
    set_text(null);
    if (parsed === null) return;
    const next = Math.min(max, Math.max(min, parsed));
    if (next !== value) on_commit(next);
  };
  return (
    <span className="chip number-chip" data-hue={hue} title={label}>
      <input
        aria-label={label}
        inputMode="decimal"
        autoComplete="off"
        size={Math.max(1, shown.length)}
        value={shown}
        onChange={(e) => set_text(e.target.value)}
        onFocus={(e) => e.target.select()}
        onBlur={commit}
        onKeyDown={(e) => {
          if (e.key === 'Enter') e.currentTarget.blur();
          if (e.key === 'Escape') {
            set_text(null);
            e.stopPropagation();
          }
        }}
      />
      <span>{unit}</span>
    </span>
  );
}

/** A key of the keyboard. A click waits for the key; Escape keeps the old one. */
export function KeyChip({ value, on_commit }: { value: string; on_commit: (code: string) => void }): ReactElement {
  const [waiting, set_waiting] = useState(false);
  useEffect(() => {
    if (!waiting) return;
    const down = (event: KeyboardEvent): void => {
      event.preventDefault();
      event.stopPropagation();
      set_waiting(false);
      if (event.code !== 'Escape' && event.code !== '') on_commit(event.code);
    };
    const leave = (): void => set_waiting(false);
    window.addEventListener('keydown', down, true);
    window.addEventListener('pointerdown', leave, true);
    return () => {
      window.removeEventListener('keydown', down, true);
      window.removeEventListener('pointerdown', leave, true);
    };
  }, [waiting, on_commit]);
  return (
    <button type="button" className="chip" data-hue="event" data-waiting={waiting} aria-label={waiting ? 'Press the new key; Escape keeps the old one' : `Key ${key_name(value)}; change it`} title="Click, then press the key" onClick={() => set_waiting(true)}>
      {waiting ? 'press a key' : key_name(value)}
    </button>
  );
}
