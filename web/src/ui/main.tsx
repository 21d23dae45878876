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
document.documentElement.dataset.theme = session.state.theme;
createRoot(document.getElementById('root')!).render(<App />);
session.start();
