/** Which nodes lie in a rectangle of the plane, without looking at all of them. */

export interface Box {
  x: number;
  y: number;
  width: number;
  height: number;
}

export const boxes_meet = (a: Box, b: Box): boolean => a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;

const cell = 800;
const row = 1 << 20; // cells in a row: keys are numbers

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
  /** Another index, without the items `left` and with those that `come`; this one stays as it is. */
  replaced(left: readonly T[], come: readonly T[]): SpatialIndex<T> {
    const cells = new Map(this.cells);
    const own = new Set<number>();
    const gone = new Set(left);
    for (const item of [...left, ...come]) this.each_cell(item, (key) => {
      if (own.has(key)) return;
      own.add(key);
      cells.set(key, (cells.get(key) ?? []).filter((t) => !gone.has(t)));
    });
    return new SpatialIndex(come, cells);
  }
  private each_cell(box: Box, visit: (key: number) => void): void {
    for (let i = Math.floor(box.x / cell); i <= Math.floor((box.x + box.width) / cell); i++)
      for (let j = Math.floor(box.y / cell); j <= Math.floor((box.y + box.height) / cell); j++) visit(i + j * row);
  }
  /** Each item once. */
  find(box: Box): T[] {
    const found = new Set<T>();
    const across = (box.width / cell + 2) * (box.height / cell + 2);
    const look = (list: readonly T[]): void => {
      for (const item of list) if (boxes_meet(item, box)) found.add(item);
    };
    if (across > this.cells.size) for (const list of this.cells.values()) look(list);
    else this.each_cell(box, (key) => look(this.cells.get(key) ?? []));
    return [...found];
  }
}
