package fusion_slam_spy;

import java.awt.Graphics2D;
import java.io.IOException;
import lcm.lcm.LCMDataInputStream;

/** Draws the newest message of a channel. take() and paint() are called under one lock. */
interface View {
  /** A message arrived (network thread). Throws IOException when it can't be decoded. */
  void take(LCMDataInputStream message) throws IOException;

  /** Draws into width x height pixels (Swing thread). */
  void paint(Graphics2D graphics, int width, int height);

  /** One line about what is shown. */
  String facts();
}
