/** Asks whether a native program may carry the libraries of LSIs (native code) that its content uses. */
import type { ReactElement } from 'react';
import { export_as } from './actions';
import { session, useStudio } from './app';
import { Backdrop } from './dialogs';

const close = (): void => session.set({ dialog: 'none' });

export function CarryDialog(): ReactElement {
  const libraries = useStudio((s) => s.used_libraries);
  const one = libraries.length === 1;
  const carry = (): void => {
    close();
    void export_as('native-lsis', '');
  };
  return (
    <Backdrop label="Carry libraries along" top>
      <form
        className="save-as carry"
        onSubmit={(e) => {
          e.preventDefault();
          carry();
        }}
      >
        <h2>Carry {one ? 'this library' : 'these libraries'} along?</h2>
        <p className="taken">
          The content uses LSIs of {one ? 'an installed library' : 'installed libraries'}. The program runs elsewhere only if it carries {one ? 'its' : 'their'} native
          code, which then has all rights of whoever starts the program. Carry only code that you trust and may pass on.
        </p>
        <ul>
          {libraries.map((library) => (
            <li key={library.name}>
              <strong>{library.name}</strong>
              <span>{Math.max(1, Math.round(library.bytes / 1000))} kB</span>
              <code title="SHA-256 of the file">{library.sha256}</code>
            </li>
          ))}
        </ul>
        <div className="actions">
          <button type="button" onClick={close}>Cancel</button>
          <button type="submit" className="primary" autoFocus>Carry along and export</button>
        </div>
      </form>
    </Backdrop>
  );
}
