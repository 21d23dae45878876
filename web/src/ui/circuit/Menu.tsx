/** The menu of the right button: what can be done with what is under it. */
import { useEffect, useRef, type ReactElement } from 'react';

export interface MenuItem {
  label: string;
  key?: string;
  run: () => void;
  disabled?: boolean;
}

export function Menu({ x, y, items, close }: { x: number; y: number; items: MenuItem[]; close: () => void }): ReactElement {
  const element = useRef<HTMLDivElement>(null);
  useEffect(() => {
    element.current?.querySelector<HTMLElement>('button:not(:disabled)')?.focus();
    const outside = (event: PointerEvent): void => {
      if (!element.current?.contains(event.target as Node)) close();
    };
    window.addEventListener('pointerdown', outside, true);
    return () => window.removeEventListener('pointerdown', outside, true);
  }, [close]);
  return (
    <div
      ref={element}
      className="circuit-menu"
      role="menu"
      style={{ left: x, top: y }}
      onKeyDown={(e) => {
        e.stopPropagation();
        const all = [...(element.current?.querySelectorAll<HTMLElement>('button:not(:disabled)') ?? [])];
        const at = all.indexOf(document.activeElement as HTMLElement);
        if (e.key === 'ArrowDown') all[(at + 1) % all.length]?.focus();
        else if (e.key === 'ArrowUp') all[(at - 1 + all.length) % all.length]?.focus();
        else if (e.key === 'Escape' || e.key === 'Tab') close();
        else return;
        e.preventDefault();
      }}
    >
      {items.map((item) => (
        <button
          key={item.label}
          type="button"
          role="menuitem"
          disabled={item.disabled}
          onClick={() => {
            close();
            item.run();
          }}
        >
          <span>{item.label}</span>
          {item.key && <kbd>{item.key}</kbd>}
        </button>
      ))}
    </div>
  );
}
