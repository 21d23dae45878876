import { createRoot } from 'react-dom/client';
import 'dockview/dist/styles/dockview.css';
import './styles.css';
import './panels.css';
import './library/library.css';
import './motion/motion.css';
import { App } from './App';
import { register_commands } from './actions';
import { session } from './app';
import { expose_hook } from './hook';

register_commands();
expose_hook();
// subscribed before any component: canvases read the theme's colours from the document when they are redrawn
const show_theme = (): void => {
  const { theme } = session.state;
  if (document.documentElement.dataset.theme !== theme) document.documentElement.dataset.theme = theme;
};
show_theme();
session.store.subscribe(show_theme);
createRoot(document.getElementById('root')!).render(<App />);
session.start();
