/** The script of exported pages (player/template.html): the engine and the content are inside the page. */
import { start } from './page';

start();
