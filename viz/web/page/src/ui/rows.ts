// A list whose rows stay the same elements while their texts change: a click, the keyboard's focus and what is unfolded survive.

export interface Row<T> {
  element: HTMLElement;
  update(item: T): void;
}

export class Rows<T> {
  private rows = new Map<string, Row<T>>();

  constructor(private root: HTMLElement, private make: (key: string) => Row<T>) {}

  render(items: [string, T][]): void {
    const keep = new Set(items.map(([key]) => key));
    for (const [key, row] of this.rows) {
      if (keep.has(key)) continue;
      row.element.remove();
      this.rows.delete(key);
    }
    items.forEach(([key, item], i) => {
      let row = this.rows.get(key);
      if (!row) this.rows.set(key, (row = this.make(key)));
      row.update(item);
      if (this.root.children[i] !== row.element) this.root.insertBefore(row.element, this.root.children[i] ?? null);
    });
  }
}
