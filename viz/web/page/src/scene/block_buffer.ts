// Millions of points or boxes whose number changes tile by tile: pages of a fixed size, cut into blocks. A changed tile
// rewrites its own blocks and nothing else. Holes cost no drawing worth the name: their elements are empty.

export interface Span {
  page: number;
  block: number;
}

export interface PageStore {
  addPage(page: number): void;
  // Elements [from, from + count) of a page become empty.
  erase(page: number, from: number, count: number): void;
}

export class BlockBuffer {
  readonly pageSize: number;
  private held = new Map<string, Span[]>();
  private free: Span[] = [];
  private pages = 0;
  private counts = new Map<string, number>();
  private sum = 0;

  constructor(private store: PageStore, readonly blockSize: number, private blocksPerPage: number) {
    this.pageSize = blockSize * blocksPerPage;
  }

  // Room for n elements under a key; what it had before is given up. `write` gets runs of elements to fill:
  // source index, count, page, first element in the page.
  replace(key: string, n: number, write: (source: number, count: number, page: number, to: number) => void): void {
    const spans = this.held.get(key) ?? [];
    const needed = Math.ceil(n / this.blockSize);
    while (spans.length > needed) {
      const span = spans.pop() as Span;
      this.store.erase(span.page, span.block * this.blockSize, this.blockSize);
      this.free.push(span);
    }
    while (spans.length < needed) spans.push(this.take());
    for (let i = 0; i < needed; i++) {
      const span = spans[i];
      const count = Math.min(this.blockSize, n - i * this.blockSize);
      const to = span.block * this.blockSize;
      write(i * this.blockSize, count, span.page, to);
      if (count < this.blockSize) this.store.erase(span.page, to + count, this.blockSize - count);
    }
    this.sum += n - (this.counts.get(key) ?? 0);
    if (needed > 0) {
      this.held.set(key, spans);
      this.counts.set(key, n);
    } else {
      this.held.delete(key);
      this.counts.delete(key);
    }
  }

  clear(): void {
    this.held.clear();
    this.counts.clear();
    this.free = [];
    this.pages = 0;
    this.sum = 0;
  }

  get total(): number {
    return this.sum;
  }

  private take(): Span {
    if (this.free.length === 0) {
      const page = this.pages++;
      this.store.addPage(page);
      for (let block = this.blocksPerPage - 1; block >= 0; block--) this.free.push({ page, block });
    }
    return this.free.pop() as Span;
  }
}
