/** Which nodes lie in a rectangle of the plane, without looking at all of them. */

export interface Box {
  x: number;
  y: number;
  width: number;
  height: number;
}

export const boxes_meet = (a: Box, b: Box): boolean => a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;

const cell = 800;

export class SpatialIndex<T extends Box> {
  private readonly cells = new Map<string, T[]>();
  constructor(items: Iterable<T>) {
    for (const item of items) this.each_cell(item, (key) => {
      const list = this.cells.get(key);
      if (list) list.push(item);
      else this.cells.set(key, [item]);
    });
  }
  private each_cell(box: Box, visit: (key: string) => void): void {
    for (let i = Math.floor(box.x / cell); i <= Math.floor((box.x + box.width) / cell); i++)
      for (let j = Math.floor(box.y / cell); j <= Math.floor((box.y + box.height) / cell); j++) visit(`${i},${j}`);
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
