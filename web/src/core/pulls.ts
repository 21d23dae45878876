/** Pulls of the user that become events of the scenario. */
import type { PulledEvent } from './protocol';
import type { Session } from './session';

const shortest_pull = 0.03; // s; a shorter one is a click

export const is_pull = (event: PulledEvent): boolean => event.duration >= shortest_pull;

/**
 * Makes the last pull of the user an event of the scenario: from now on it is repeated at its time. The event and the pull give the same
 * motion, so the pull is removed from the inputs of the simulation. @returns the event's id, or null if there is no pull or the service refused
 */
export async function keep_pull(session: Session): Promise<string | null> {
  const { pulled, document, mechanisms } = session.state;
  const mechanism = document?.characters.find((c) => c.id === pulled?.character)?.mechanism;
  const link = mechanism && pulled ? mechanisms[mechanism]?.links[pulled.link]?.name : undefined;
  if (!pulled || link === undefined) return null;
  session.set({ pulled: null });
  const { character, point, time, duration, path } = pulled;
  const id = session.fresh_id('e');
  await session.ask({ op: 'forget_pull', time }).catch(() => undefined); // fails if the simulation was restarted since: nothing to forget
  return (await session.edit({ type: 'event.add', event: { id, type: 'pull', time, duration, character, link, point, path } })) ? id : null;
}
