/** Edits of a circuit. Each is a pure function of a view and returns one serialisable command, or null if nothing changes. */
export { snap, type CircuitCommand } from './batch';
export { connect, disconnect, insert_delay } from './wires';
export { add_lsi, first_fit, move, remove, rename, set_lsi, set_parameter, set_value, type Selection } from './lsis';
export { add_note, set_note, set_probe, toggle_probe } from './annotations';
export { remove_own_pin, rename_own_pin } from './own_pins';
export { copy, paste, read_clip, type Clip } from './clipboard';
export { group, ungroup } from './group';
