package fusion_slam_spy;

import fusion_slam.tile_t;
import java.awt.Graphics2D;
import java.awt.RenderingHints;
import java.awt.image.BufferedImage;
import java.io.IOException;
import java.util.Locale;
import java.util.TreeMap;
import lcm.lcm.LCMDataInputStream;

/**
 * Grid tiles (docs/tiles.md) put together. Of submaps, which each have a frame of their own, the
 * newest is shown. Voxels and clouds are shown as the tiles they cover.
 */
final class GridView implements View {
  private static final int UNKNOWN = 0xE6E8EC;
  private static final int FREE = 0xFFFFFF;
  /** By provenance: none, LiDAR, camera, both, conflict (Okabe & Ito 2008). */
  private static final int[] OCCUPIED = {0x222C3C, 0x0072B2, 0xD55E00, 0x222C3C, 0xCC79A7};

  private static final int CELLS = 64;
  private static final int MOST_TILES = 1 << 16;

  private final TreeMap<Long, BufferedImage> tiles = new TreeMap<>();
  private long submap;
  private double tile_m = 3.2;

  @Override
  public void take(LCMDataInputStream message) throws IOException {
    tile_t tile = new tile_t(message);
    if (tile.submap_id != submap) {
      tiles.clear();
      submap = tile.submap_id;
    }
    tile_m = tile.resolution_m * tile.size_cells;
    long key = ((long) tile.y << 32) ^ (tile.x & 0xFFFFFFFFL);
    if (tile.encoding == tile_t.EMPTY) tiles.remove(key);
    else if (tiles.size() < MOST_TILES || tiles.containsKey(key)) tiles.put(key, picture(tile));
  }

  private static BufferedImage picture(tile_t tile) throws IOException {
    BufferedImage out = new BufferedImage(CELLS, CELLS, BufferedImage.TYPE_INT_RGB);
    boolean fused = tile.encoding == tile_t.GRID_FUSED;
    boolean grid = fused || tile.encoding == tile_t.GRID_PROBABILITY;
    int n = CELLS * CELLS;
    byte[] cells = grid ? Inflate.exactly(tile.data, fused ? 2 * n : n) : null;
    for (int i = 0; i < n; ++i) {
      int value = grid ? cells[i] & 0xFF : 255;
      int source = fused ? Math.min(OCCUPIED.length - 1, cells[n + i] & 0xFF) : 0;
      double probability = (value - 1) / 254.0;
      int rgb =
          value == 0 ? UNKNOWN : probability > 0.65 ? OCCUPIED[source]
              : probability < 0.25 ? FREE : UNKNOWN;
      out.setRGB(i % CELLS, CELLS - 1 - i / CELLS, rgb);
    }
    return out;
  }

  @Override
  public void paint(Graphics2D g, int width, int height) {
    if (tiles.isEmpty()) return;
    int x0 = Integer.MAX_VALUE, y0 = Integer.MAX_VALUE;
    int x1 = Integer.MIN_VALUE, y1 = Integer.MIN_VALUE;
    for (long key : tiles.keySet()) {
      x0 = Math.min(x0, (int) key);
      x1 = Math.max(x1, (int) key);
      y0 = Math.min(y0, (int) (key >> 32));
      y1 = Math.max(y1, (int) (key >> 32));
    }
    double edge = Math.min(width / (x1 - (double) x0 + 1), height / (y1 - (double) y0 + 1));
    g.setRenderingHint(
        RenderingHints.KEY_INTERPOLATION, RenderingHints.VALUE_INTERPOLATION_NEAREST_NEIGHBOR);
    for (long key : tiles.keySet()) {
      double x = ((int) key - (double) x0) * edge;
      double y = ((double) y1 - (int) (key >> 32)) * edge;
      g.drawImage(tiles.get(key), (int) x, (int) y, (int) (x + edge) - (int) x,
          (int) (y + edge) - (int) y, null);
    }
  }

  @Override
  public String facts() {
    return String.format(
        Locale.ROOT, "%d tiles of %.2f m%s; occupied: blue LiDAR, orange camera, dark both",
        tiles.size(), tile_m, submap == 0 ? "" : ", submap " + submap);
  }
}
