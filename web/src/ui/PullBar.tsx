/** Offers to keep the last pull of the user as an event, over the viewport. */
import { useEffect, type ReactElement } from 'react';
import { find_character } from '../core/document';
import { format_label } from '../core/format';
import { is_typing } from '../core/keymap';
import { keep_pull } from '../core/pulls';
import { session, useStudio } from './app';
import { Icon } from './icons';

/** Keeps the pull and selects its event. */
function keep(): void {
  void keep_pull(session).then((id) => id !== null && session.select({ kind: 'event', event: id }));
}

export function PullBar(): ReactElement | null {
  const pulled = useStudio((s) => s.pulled);
  const simulate = useStudio((s) => s.transport.mode === 'simulate');
  const character = useStudio((s) => (s.document && pulled ? find_character(s.document, pulled.character) : undefined));
  const link = useStudio((s) => (character && pulled ? s.mechanisms[character.mechanism]?.links[pulled.link] : undefined));
  const shown = simulate && pulled !== null && character !== undefined && link !== undefined;
  useEffect(() => {
    if (!shown) return;
    // Enter belongs to the control that has the focus; without one, it keeps the pull
    const down = (event: KeyboardEvent): void => {
      const target = event.target as HTMLElement;
      if (event.key !== 'Enter' || event.defaultPrevented || session.state.dialog !== 'none' || is_typing(target)) return;
      if (target !== document.body && !target.closest('.viewport')) return;
      if (target.tagName === 'BUTTON') return;
      event.preventDefault();
      keep();
    };
    window.addEventListener('keydown', down);
    return () => window.removeEventListener('keydown', down);
  }, [shown]);
  if (!shown) return null;
  const part = character.track.length === 0 && character.control.mode === 'passive' ? '' : `, ${format_label(link.label || link.name).toLowerCase()}`;
  return (
    <div className="pull-bar" role="status">
      <span>
        Pulled {character.name}{part} for {pulled.duration.toFixed(2)} s
      </span>
      <button type="button" className="primary" title="Repeat the pull at its time whenever the content runs  (Enter)" onClick={keep}>
        Keep as event <kbd>↵</kbd>
      </button>
      <button type="button" className="tool small" aria-label="Dismiss" title="Forget the offer; the pull stays in this simulation" onClick={() => session.set({ pulled: null })}>
        <Icon name="close" />
      </button>
    </div>
  );
}
