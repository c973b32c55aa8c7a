// A layer of one kind of thing in pages of equal size, one draw call a page; a map's tiles come, change and go in it.
import { type BufferAttribute, type BufferGeometry, Group } from "three";
import { BlockBuffer, type PageStore } from "./block_buffer";

// attributes: the first places a thing.
export interface Page {
  geometry: BufferGeometry;
  attributes: BufferAttribute[];
}

export abstract class PagedLayer implements PageStore {
  readonly group = new Group();
  protected buffer: BlockBuffer;
  protected pages: Page[] = [];

  // erased: the number that hides a thing when its first attribute is filled with it.
  constructor(block: number, blocks: number, private readonly erased: number) {
    this.buffer = new BlockBuffer(this, block, blocks);
  }

  abstract addPage(page: number): void;

  remove(key: string): void {
    this.buffer.replace(key, 0, () => undefined);
  }

  clear(): void {
    this.buffer.clear();
    for (const page of this.pages) page.geometry.dispose();
    this.pages = [];
    this.group.clear();
  }

  get total(): number {
    return this.buffer.total;
  }

  erase(page: number, from: number, count: number): void {
    const { array, itemSize } = this.pages[page].attributes[0];
    array.fill(this.erased, itemSize * from, itemSize * (from + count));
    this.touch(page, from, count);
  }

  // What has changed goes to the graphics card with the next frame.
  protected touch(page: number, from: number, count: number): void {
    for (const attribute of this.pages[page].attributes) {
      attribute.addUpdateRange(attribute.itemSize * from, attribute.itemSize * count);
      attribute.needsUpdate = true;
    }
  }
}
