/** The script ugoki-player.js: the element <ugoki-player src="content.ugx"> for any page. The script contains the engine. */
import { set_engine_bytes, start } from './page';
import { engine_of } from './payload';

const engine = '@UGOKI_ENGINE@'; // replaced by player/build.mjs
set_engine_bytes(async () => engine_of(engine));
start();
