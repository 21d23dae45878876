/** A spatial index: finds the nodes in a rectangle of the plane without testing all nodes. */

export interface Box {
  x: number;
  y: number;
  width: number;
  height: number;
}

/** True if two boxes overlap. */
export const boxes_meet = (a: Box, b: Box): boolean => a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;

const cell = 800; // edge length of a cell, px: so that a few nodes, which are 160 ... 280 px wide, fit side by side
const row = 1 << 20; // maximum number of cells in a row; the key of cell (i, j) is i + j * row

/** Items by the cells of a uniform grid that they overlap. */
export class SpatialIndex<T extends Box> {
  private readonly cells: Map<number, T[]>;
  constructor(items: Iterable<T>, cells = new Map<number, T[]>()) {
    this.cells = cells;
    for (const item of items) this.each_cell(item, (key) => {
      const list = this.cells.get(key);
      if (list) list.push(item);
      else this.cells.set(key, [item]);
    });
  }
  /** A new index without the items `removed` and with the items `added`; this index is not changed. */
  replaced(removed: readonly T[], added: readonly T[]): SpatialIndex<T> {
    const cells = new Map(this.cells);
    const copied = new Set<number>(); // keys of the cells whose list this index and the new index no longer share
    const dropped = new Set(removed);
    for (const item of [...removed, ...added]) this.each_cell(item, (key) => {
      if (copied.has(key)) return;
      copied.add(key);
      cells.set(key, (cells.get(key) ?? []).filter((t) => !dropped.has(t)));
    });
    return new SpatialIndex(added, cells);
  }
  private each_cell(box: Box, visit: (key: number) => void): void {
    for (let i = Math.floor(box.x / cell); i <= Math.floor((box.x + box.width) / cell); i++)
      for (let j = Math.floor(box.y / cell); j <= Math.floor((box.y + box.height) / cell); j++) visit(i + j * row);
  }
  /** Items that overlap `box`, each once. */
  find(box: Box): T[] {
    const found = new Set<T>();
    const cell_count = (box.width / cell + 2) * (box.height / cell + 2);
    const collect = (list: readonly T[]): void => {
      for (const item of list) if (boxes_meet(item, box)) found.add(item);
    };
    if (cell_count > this.cells.size) for (const list of this.cells.values()) collect(list);
    else this.each_cell(box, (key) => collect(this.cells.get(key) ?? []));
    return [...found];
  }
}
