/** A context menu: actions for the element under the pointer. */
import { Fragment, useEffect, useLayoutEffect, useRef, type ReactElement } from 'react';

export interface MenuItem {
  label: string;
  key?: string;
  run: () => void;
  disabled?: boolean;
  title?: string;
  /** A second line under the label. */
  detail?: string;
  /** A separator line is drawn above this item. */
  apart?: boolean;
}

/** @param x, y position in px: relative to the containing element, or with `over` relative to the window and above all panels */
export function Menu({ x, y, items, close, over = false, label }: { x: number; y: number; items: MenuItem[]; close: () => void; over?: boolean; label?: string }): ReactElement {
  const element = useRef<HTMLDivElement>(null);
  useLayoutEffect(() => {
    const menu = element.current;
    if (!over || !menu) return;
    const place = (): void => {
      menu.style.left = `${Math.max(4, Math.min(x, window.innerWidth - menu.offsetWidth - 4))}px`;
      menu.style.top = `${Math.max(4, Math.min(y, window.innerHeight - menu.offsetHeight - 4))}px`;
    };
    place();
    window.addEventListener('resize', place);
    return () => window.removeEventListener('resize', place);
  }, [over, x, y]);
  // a closed menu returns the focus to the element that had it before; otherwise the page would receive the keys instead of the panel
  useEffect(() => {
    const before = document.activeElement as HTMLElement | null;
    return () => {
      if (!document.activeElement || document.activeElement === document.body) before?.focus({ preventScroll: true });
    };
  }, []);
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
      className={over ? 'menu over' : 'menu'}
      role="menu"
      aria-label={label}
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
        <Fragment key={item.label}>
          {item.apart && <hr />}
          <button
            type="button"
            role="menuitem"
            disabled={item.disabled}
            title={item.title}
            onClick={() => {
              close();
              item.run();
            }}
          >
            <span>
              {item.label}
              {item.detail && <small>{item.detail}</small>}
            </span>
            {item.key && <kbd>{item.key}</kbd>}
          </button>
        </Fragment>
      ))}
    </div>
  );
}
