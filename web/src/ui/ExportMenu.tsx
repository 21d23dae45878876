/** The button at the right end of the top bar that lists everything that the project can be exported as. */
import { useState, type ReactElement } from 'react';
import { format_bytes } from '../core/library/words';
import { bytes_of_skins } from '../core/skins';
import { useStudio } from './app';
import { command_item } from './command_item';
import { Icon } from './icons';
import { Menu, type MenuItem } from './Menu';

export function ExportMenu(): ReactElement {
  const keymap = useStudio((s) => s.keymap);
  const characters = useStudio((s) => s.document?.characters);
  const mechanisms = useStudio((s) => s.mechanisms);
  const [at, set_at] = useState<{ x: number; y: number } | null>(null);
  const skins = bytes_of_skins(characters ?? [], mechanisms);
  const with_skins = (text: string): string => (skins > 0 ? `${text}; ${format_bytes(skins)} of skins` : text);
  const entry = (id: string, label: string, detail: string, apart = false): MenuItem => command_item(id, keymap, { label, detail, apart });
  const items: MenuItem[] = [
    entry('file.export_html', 'Web page', with_skins('one file, plays in a browser')),
    entry('file.export_native', 'Program', with_skins('for Linux, without a browser')),
    entry('file.export_picture', 'Picture', 'PNG of the view', true),
    entry('file.export_glb', 'glTF', with_skins('characters with the simulated motion'), true),
    entry('file.export_usda', 'USD', 'stage with the simulated motion'),
    entry('file.export_bvh', 'BVH', 'motion of the selected character'),
    entry('file.export_csv', 'Table', 'CSV of the simulated motion', true),
    entry('file.export_measures', 'Naturalness', 'CSV of all measures'),
  ];
  return (
    <>
      <button
        type="button"
        className="tool wide export-button"
        aria-haspopup="menu"
        aria-expanded={at !== null}
        aria-label="Export"
        title="Export as page, program, picture, glTF, USD, BVH or table"
        onClick={(e) => {
          const box = e.currentTarget.getBoundingClientRect();
          set_at({ x: box.right, y: box.bottom + 4 });
        }}
      >
        <Icon name="export" />
        <span>Export</span>
      </button>
      {at && <Menu x={at.x} y={at.y} items={items} close={() => set_at(null)} over label="Export" />}
    </>
  );
}
