import { createRoot } from 'react-dom/client';
import 'dockview/dist/styles/dockview.css';
import '@fontsource-variable/inter/wght.css';
import './styles.css';
import './panels.css';
import './film/film.css';
import './library/library.css';
import './motion/motion.css';
import './posing/posing.css';
import { App } from './App';
import { code_of } from '../core/access';
import { draft_key } from '../core/state';
import { register_commands } from './actions';
import { surfaces_ready } from '../view/body_surface';
import { access, session } from './app';
import { expose_hook } from './hook';

register_commands();
expose_hook();
// subscribed before any component, so that the document has the new theme's colours when canvases read them to redraw
const show_theme = (): void => {
  const { theme } = session.state;
  if (document.documentElement.dataset.theme !== theme) document.documentElement.dataset.theme = theme;
};
try {
  if (localStorage.getItem(draft_key) === 'on') session.set({ view: { ...session.state.view, draft: true } });
} catch {
  // pages without storage
}
show_theme();
session.store.subscribe(show_theme);
const root = createRoot(document.getElementById('root')!);
// if the address printed by `ugoki studio` is opened in a tab that already shows the studio, only the fragment changes: reload the page
addEventListener('hashchange', () => {
  if (code_of(location.hash) !== null) location.reload();
});
/** Shown instead of the studio if the service does not accept this page. */
const refused = (
  <p className="refused" role="alert">
    This page has no access to the studio. Open the complete address that <code>ugoki studio</code> printed last.
  </p>
);
void Promise.all([access.enter(), surfaces_ready]).then(([entry]) => {
  if (entry === 'refused') return root.render(refused);
  root.render(<App />);
  session.start();
  // a lost connection may mean that the studio was restarted with another key
  session.store.subscribe((state, before) => {
    if (state.connection !== 'lost' || state.retry_at === before.retry_at) return;
    void access.check().then((now) => {
      if (now === 'refused') session.refuse();
    });
  });
});
