package fusion_slam_spy;

import bot_core.planar_lidar_t;
import java.awt.BasicStroke;
import java.awt.Color;
import java.awt.Graphics2D;
import java.awt.geom.Ellipse2D;
import java.awt.geom.Line2D;
import java.io.IOException;
import java.util.Locale;
import lcm.lcm.LCMDataInputStream;

/** A planar_lidar_t from above: x (ahead) is up, y (left) is left, rings every few metres. */
final class ScanView implements View {
  private static final Color RING = new Color(0xDDE0E5);
  private static final Color TEXT = new Color(0x6A6F7A);
  private static final Color HIT = new Color(0x0072B2);
  private static final Color ROBOT = new Color(0xD55E00);

  private planar_lidar_t scan;
  private double shown_m = 1.0; // grows with the farthest return, shrinks slowly

  @Override
  public void take(LCMDataInputStream message) throws IOException {
    scan = new planar_lidar_t(message);
    double farthest_m = 1.0;
    for (float range : scan.ranges) if (isReturn(range)) farthest_m = Math.max(farthest_m, range);
    shown_m = Math.max(farthest_m, 0.98 * shown_m);
  }

  private static boolean isReturn(float range_m) {
    return range_m > 0.0f && range_m < 1000.0f; // false for nan
  }

  @Override
  public void paint(Graphics2D g, int width, int height) {
    double scale = 0.47 * Math.min(width, height) / shown_m;
    double x0 = 0.5 * width;
    double y0 = 0.5 * height;
    double ring_m = 0.5;
    while (shown_m / ring_m > 6.0) ring_m *= 2.0;
    for (double r = ring_m; r <= shown_m + ring_m; r += ring_m) {
      g.setColor(RING);
      g.draw(new Ellipse2D.Double(x0 - r * scale, y0 - r * scale, 2 * r * scale, 2 * r * scale));
      g.setColor(TEXT);
      g.drawString(String.format(Locale.ROOT, "%.1f m", r), (float) x0 + 3, (float) (y0 - r * scale - 2));
    }
    g.setColor(ROBOT);
    g.setStroke(new BasicStroke(2.0f));
    g.draw(new Line2D.Double(x0, y0, x0, y0 - 14));
    g.fill(new Ellipse2D.Double(x0 - 4, y0 - 4, 8, 8));
    if (scan == null) return;
    g.setColor(HIT);
    for (int i = 0; i < scan.nranges; ++i) {
      if (!isReturn(scan.ranges[i])) continue;
      double angle = scan.rad0 + (double) i * scan.radstep;
      double x = x0 - scan.ranges[i] * Math.sin(angle) * scale;
      double y = y0 - scan.ranges[i] * Math.cos(angle) * scale;
      g.fill(new Ellipse2D.Double(x - 1.6, y - 1.6, 3.2, 3.2));
    }
  }

  @Override
  public String facts() {
    if (scan == null) return "no scan yet";
    int returns = 0;
    for (float range : scan.ranges) if (isReturn(range)) ++returns;
    return String.format(
        Locale.ROOT, "%d beams, %d returns, step %.2f deg", scan.nranges, returns,
        Math.toDegrees(scan.radstep));
  }
}
