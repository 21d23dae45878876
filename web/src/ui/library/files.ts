/** Files of a drop, those in dropped folders too. */

const most = 500;

async function of_entry(entry: FileSystemEntry, out: File[]): Promise<void> {
  if (out.length >= most) return;
  if (entry.isFile) {
    const file = await new Promise<File | null>((resolve) => (entry as FileSystemFileEntry).file(resolve, () => resolve(null)));
    if (file) out.push(file);
    return;
  }
  const reader = (entry as FileSystemDirectoryEntry).createReader();
  for (;;) {
    const some = await new Promise<FileSystemEntry[]>((resolve) => reader.readEntries(resolve, () => resolve([])));
    if (some.length === 0) return;
    for (const inner of some) await of_entry(inner, out);
  }
}

/** The transfer must be read before the event is over: call it in the handler, not later. */
export async function files_of(transfer: DataTransfer): Promise<File[]> {
  const plain = [...transfer.files];
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry?.() ?? null).filter((e): e is FileSystemEntry => e !== null);
  if (!entries.some((e) => e.isDirectory)) return plain;
  const out: File[] = [];
  for (const entry of entries) await of_entry(entry, out);
  return out;
}
