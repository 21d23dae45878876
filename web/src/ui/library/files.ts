/** Reads the files of a drop, including those in dropped folders. */

const max_files = 500; // maximum number of files taken from a drop that contains folders

async function collect(entry: FileSystemEntry, out: File[]): Promise<void> {
  if (out.length >= max_files) return;
  if (entry.isFile) {
    const file = await new Promise<File | null>((resolve) => (entry as FileSystemFileEntry).file(resolve, () => resolve(null)));
    if (file) out.push(file);
    return;
  }
  const reader = (entry as FileSystemDirectoryEntry).createReader();
  for (;;) {
    const batch = await new Promise<FileSystemEntry[]>((resolve) => reader.readEntries(resolve, () => resolve([])));
    if (batch.length === 0) return;
    for (const inner of batch) await collect(inner, out);
  }
}

/** Files of a drop; at most 500 if the drop contains a folder. Call it in the event handler: the browser clears `transfer` afterwards. */
export async function files_of(transfer: DataTransfer): Promise<File[]> {
  const plain = [...transfer.files];
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry?.() ?? null).filter((e): e is FileSystemEntry => e !== null);
  if (!entries.some((e) => e.isDirectory)) return plain;
  const out: File[] = [];
  for (const entry of entries) await collect(entry, out);
  return out;
}
