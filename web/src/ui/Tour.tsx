/** The tour for the first start: a few steps, each shown beside the part of the page that it explains. It never blocks the page. */
import { useEffect, useLayoutEffect, useRef, useState, type KeyboardEvent, type ReactElement } from 'react';
import { card_place, tour_steps, type Box } from '../core/tour';
import { page, usePage, useStudio } from './app';

interface Place {
  part: Box;
  card: { left: number; top: number };
}

const tour_key = 'ugoki.tour';

/** Shows the tour if this browser has not shown it before. */
export function begin_first_tour(): void {
  try {
    if (localStorage.getItem(tour_key) === null) page.setState({ tour: 0 });
  } catch {
    // without local storage the tour would be shown at every start
  }
}

export function end_tour(): void {
  page.setState({ tour: null });
  try {
    localStorage.setItem(tour_key, 'done');
  } catch {
    // see above
  }
}

export function Tour(): ReactElement | null {
  const at = usePage((s) => s.tour);
  const open = useStudio((s) => s.document !== null && s.dialog === 'none');
  const card = useRef<HTMLDivElement>(null);
  const next = useRef<HTMLButtonElement>(null);
  const [place, set_place] = useState<Place | null>(null);
  const step = at === null ? undefined : tour_steps[at];
  const shown = step !== undefined && open;
  const placed = place !== null; // before, the card is hidden and cannot take the focus

  useLayoutEffect(() => {
    if (!shown) return undefined;
    const put = (): void => {
      const box = [...document.querySelectorAll(step.part)].map((e) => e.getBoundingClientRect()).find((b) => b.width > 0);
      const own = card.current?.getBoundingClientRect();
      if (!own) return;
      const part = box ?? new DOMRect(window.innerWidth / 2, window.innerHeight / 2, 0, 0);
      set_place({ part: { left: part.left, top: part.top, width: part.width, height: part.height }, card: card_place(part, own, { width: window.innerWidth, height: window.innerHeight }) });
    };
    put();
    const late = setTimeout(put, 300); // panels take their final size shortly after the start
    window.addEventListener('resize', put);
    return () => {
      clearTimeout(late);
      window.removeEventListener('resize', put);
    };
  }, [shown, step]);
  useEffect(() => {
    if (!shown) return undefined;
    const before = document.activeElement as HTMLElement | null;
    next.current?.focus({ preventScroll: true });
    return () => {
      if (page.getState().tour === null && before?.isConnected) before.focus({ preventScroll: true });
    };
  }, [shown, at, placed]);

  if (!shown || at === null) return null;
  const last = at === tour_steps.length - 1;
  const go = (to: number): void => (to >= tour_steps.length ? end_tour() : page.setState({ tour: Math.max(0, to) }));
  const keys = (event: KeyboardEvent): void => {
    if (event.key === 'Escape') end_tour();
    else if (event.key === 'ArrowRight') go(Math.min(at + 1, tour_steps.length - 1));
    else if (event.key === 'ArrowLeft') go(at - 1);
    else if (event.key === 'Enter' || event.key === ' ' || event.key === 'Tab') return event.stopPropagation();
    else return;
    event.preventDefault();
    event.stopPropagation();
  };
  return (
    <>
      {place && place.part.width > 0 && <div className="tour-part" aria-hidden="true" style={place.part} />}
      <div ref={card} className="tour" role="dialog" aria-labelledby="tour-title" aria-describedby="tour-text" style={place?.card ?? { left: 0, top: 0, visibility: 'hidden' }} onKeyDown={keys}>
        <strong id="tour-title">{step.title}</strong>
        <p id="tour-text">{step.text}</p>
        <div className="tour-row">
          <span className="tour-count">{at + 1} of {tour_steps.length}</span>
          {!last && <button type="button" onClick={end_tour}>End the tour</button>}
          {at > 0 && <button type="button" onClick={() => go(at - 1)}>Back</button>}
          <button ref={next} type="button" className="primary" onClick={() => go(at + 1)}>{last ? 'Done' : 'Next'}</button>
        </div>
      </div>
    </>
  );
}
