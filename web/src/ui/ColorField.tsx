import { useEffect, useId, useRef, type ReactElement } from 'react';

/** A colour field. Colours are previewed while the browser's colour picker is open, and committed once when it closes. */
export function ColorField({ label, value, on_preview, on_commit, title }: { label: string; value: string; on_preview?: (value: string) => void; on_commit: (value: string) => void; title?: string }): ReactElement {
  const id = useId();
  const input = useRef<HTMLInputElement>(null);
  const committed = useRef(value);
  useEffect(() => {
    const element = input.current;
    if (!element) return;
    const now = (): void => on_preview?.(element.value);
    const changed = (): void => {
      if (element.value !== committed.current) on_commit((committed.current = element.value));
    };
    element.addEventListener('input', now);
    element.addEventListener('change', changed);
    return () => {
      element.removeEventListener('input', now);
      element.removeEventListener('change', changed);
    };
  });
  useEffect(() => {
    if (input.current && input.current !== document.activeElement) committed.current = value;
    if (input.current) input.current.value = value;
  }, [value]);
  return (
    <div className="field" title={title}>
      <label htmlFor={id}>{label}</label>
      <span className="color-value">
        <input ref={input} id={id} type="color" className="color" defaultValue={value} />
        <output>{value.toUpperCase()}</output>
      </span>
    </div>
  );
}
