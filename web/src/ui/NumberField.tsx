import { useEffect, useId, useRef, useState, type KeyboardEvent, type PointerEvent, type ReactElement } from 'react';
import { format_field, parse_number } from '../core/format';
import { session } from './app';

export interface NumberFieldProps {
  label: string;
  value: number;
  unit?: string;
  digits?: number;
  /** Change of the value per pixel of scrubbing; an arrow key changes it by 5 steps. With Shift, the changes are a tenth as large. */
  step: number;
  min?: number;
  max?: number;
  /** Shows a slider from `min` to `max` next to the number. */
  slider?: boolean;
  title?: string;
  /** Called with each value while scrubbing; null: the scrub was cancelled, show the document's value. */
  on_preview?: (value: number | null) => void;
  /** Called once per edit, with the final value. */
  on_commit: (value: number) => void;
}

/** A number with its unit. Type it (Enter commits, Escape reverts), drag horizontally on the label (scrub), or move the slider. */
export function NumberField(props: NumberFieldProps): ReactElement {
  const { label, value, unit, digits = 2, step, min = -Infinity, max = Infinity, slider, title, on_preview, on_commit } = props;
  const id = useId();
  const [text, set_text] = useState<string | null>(null);
  const [scrubbed, set_scrubbed] = useState<number | null>(null);
  const scrub = useRef<{ x: number; value: number; now: number } | null>(null);
  const slid = useRef<number | null>(null);
  const input = useRef<HTMLInputElement>(null);
  const clamp = (v: number): number => Math.min(max, Math.max(min, Math.round(v * 1e6) / 1e6));
  const shown = scrubbed ?? value;

  useEffect(() => set_scrubbed(null), [value]);

  const commit = (v: number): void => {
    const next = clamp(v);
    set_text(null);
    if (next !== value) {
      set_scrubbed(next);
      on_commit(next);
    }
  };
  const commit_text = (): void => {
    if (text === null) return;
    const parsed = parse_number(text);
    if (parsed === null) set_text(null);
    else {
      const taken = clamp(parsed);
      const shown_unit = unit ? ` ${unit}` : '';
      if (Math.abs(taken - parsed) > 1e-6) session.notify(`${label}: ${format_field(parsed, digits + 1)}${shown_unit} is out of range. The value is now ${format_field(taken, digits + 1)}${shown_unit}, the ${parsed > max ? 'largest' : 'smallest'} possible.`);
      commit(parsed);
    }
  };
  const key = (event: KeyboardEvent): void => {
    if (event.key === 'Enter') {
      commit_text();
      input.current?.select();
    } else if (event.key === 'Escape') {
      set_text(null);
      input.current?.blur();
      event.stopPropagation();
    } else if (event.key === 'ArrowUp' || event.key === 'ArrowDown') {
      const size = step * (event.shiftKey ? 0.1 : 1) * (event.key === 'ArrowUp' ? 1 : -1) * 5;
      const base = (text !== null ? parse_number(text) : null) ?? shown;
      set_text(format_field(clamp(base + size), digits + 1));
      event.preventDefault();
    }
  };
  const scrub_start = (event: PointerEvent<HTMLElement>): void => {
    if (event.button !== 0) return;
    event.preventDefault();
    event.currentTarget.setPointerCapture(event.pointerId);
    scrub.current = { x: event.clientX, value: shown, now: shown };
  };
  const scrub_move = (event: PointerEvent): void => {
    const s = scrub.current;
    if (!s) return;
    const size = step * (event.shiftKey ? 0.1 : 1);
    const next = clamp(Math.round((s.value + (event.clientX - s.x) * size) / size) * size);
    if (next === s.now) return;
    s.now = next;
    set_scrubbed(next);
    on_preview?.(next);
  };
  const scrub_end = (): void => {
    const s = scrub.current;
    scrub.current = null;
    if (!s) return;
    if (s.now !== s.value) on_commit(s.now);
    else input.current?.focus();
  };
  const slider_end = (): void => {
    if (slid.current !== null) on_commit(slid.current);
    slid.current = null;
  };
  const scrub_cancel = (): void => {
    scrub.current = null;
    set_scrubbed(null);
    on_preview?.(null);
  };

  return (
    <div className="field" title={title}>
      <label htmlFor={id} className="scrub" onPointerDown={scrub_start} onPointerMove={scrub_move} onPointerUp={scrub_end} onPointerCancel={scrub_cancel}>
        {label}
      </label>
      <div className={slider ? 'field-value with-slider' : 'field-value'}>
        {slider && (
          <input
            type="range"
            aria-label={label}
            min={min}
            max={max}
            step={step}
            value={shown}
            style={{ '--fill': `${(100 * (shown - min)) / (max - min)}%` } as React.CSSProperties}
            onChange={(e) => {
              slid.current = clamp(Number(e.target.value));
              set_scrubbed(slid.current);
              on_preview?.(slid.current);
            }}
            onPointerUp={slider_end}
            onKeyUp={slider_end}
            onBlur={slider_end}
          />
        )}
        <span className="number">
          <input
            id={id}
            ref={input}
            type="text"
            inputMode="decimal"
            autoComplete="off"
            spellCheck={false}
            value={text ?? format_field(shown, digits)}
            onChange={(e) => set_text(e.target.value)}
            onFocus={(e) => e.target.select()}
            onBlur={commit_text}
            onKeyDown={key}
          />
          {unit && <span className="unit">{unit}</span>}
        </span>
      </div>
    </div>
  );
}

/** @param optional true: the text may be empty */
export function TextField({ label, value, on_commit, disabled, optional, title, placeholder }: { label: string; value: string; on_commit: (value: string) => void; disabled?: boolean; optional?: boolean; title?: string; placeholder?: string }): ReactElement {
  const id = useId();
  const [text, set_text] = useState<string | null>(null);
  const commit_text = (): void => {
    if (text !== null && (text.trim() || optional) && text !== value) on_commit(text.trim());
    set_text(null);
  };
  return (
    <div className="field">
      <label htmlFor={id}>{label}</label>
      <input
        id={id}
        className="text"
        value={text ?? value}
        disabled={disabled}
        title={title}
        placeholder={placeholder}
        spellCheck={false}
        onChange={(e) => set_text(e.target.value)}
        onBlur={commit_text}
        onKeyDown={(e) => {
          if (e.key === 'Enter') commit_text();
          if (e.key === 'Escape') {
            set_text(null);
            e.stopPropagation();
          }
        }}
      />
    </div>
  );
}

export function ChoiceField({ label, value, choices, on_commit, title }: { label: string; value: string; choices: [string, string][]; on_commit: (value: string) => void; title?: string }): ReactElement {
  const id = useId();
  return (
    <div className="field" title={title}>
      <label htmlFor={id}>{label}</label>
      <select id={id} value={value} onChange={(e) => on_commit(e.target.value)}>
        {choices.map(([key, text]) => (
          <option key={key} value={key}>
            {text}
          </option>
        ))}
      </select>
    </div>
  );
}

/** A choice of which all values are visible. @param choices value, text, and what it does */
export function SegmentsField<T extends string>({ label, value, choices, on_commit }: { label: string; value: T; choices: readonly (readonly [T, string, string])[]; on_commit: (value: T) => void }): ReactElement {
  const id = useId();
  return (
    <div className="field">
      <span id={id}>{label}</span>
      <div className="segments" role="group" aria-labelledby={id}>
        {choices.map(([key, text, title]) => (
          <button key={key} type="button" aria-pressed={key === value} title={title} onClick={() => key !== value && on_commit(key)}>
            {text}
          </button>
        ))}
      </div>
    </div>
  );
}

export function SwitchField({ label, value, on_commit, title, disabled }: { label: string; value: boolean; on_commit: (value: boolean) => void; title?: string; disabled?: boolean }): ReactElement {
  const id = useId();
  return (
    <div className="field" title={title}>
      <label htmlFor={id}>{label}</label>
      <button id={id} type="button" role="switch" className="switch" aria-checked={value} disabled={disabled} onClick={() => on_commit(!value)}>
        <span />
      </button>
    </div>
  );
}
