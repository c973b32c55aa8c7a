package fusion_slam_spy;

import bot_core.image_t;
import bot_core.images_t;
import java.awt.Color;
import java.awt.Graphics2D;
import java.awt.RenderingHints;
import java.awt.image.BufferedImage;
import java.io.ByteArrayInputStream;
import java.io.IOException;
import java.util.Locale;
import javax.imageio.ImageIO;
import lcm.lcm.LCMDataInputStream;

/** An images_t: colour and, beside it, depth from near (warm) to far (cold). */
final class ImagesView implements View {
  private static final float FAR_MM = 6000.0f;
  private static final int MOST_PIXELS = 1 << 24;

  private BufferedImage color;
  private BufferedImage depth;
  private double known; // share of depth pixels that have a value

  @Override
  public void take(LCMDataInputStream message) throws IOException {
    images_t images = new images_t(message);
    for (int i = 0; i < images.n_images; ++i) {
      image_t image = images.images[i];
      if (image.width <= 0 || image.height <= 0 || (long) image.width * image.height > MOST_PIXELS)
        throw new IOException("an image of " + image.width + " x " + image.height);
      short type = images.image_types[i];
      if (type == images_t.LEFT) {
        color = ImageIO.read(new ByteArrayInputStream(image.data));
      } else if (type == images_t.DEPTH_MM_ZIPPED) {
        depth = picture(Inflate.exactly(image.data, 2 * image.width * image.height), image);
      } else if (type == images_t.DEPTH_MM) {
        if (image.data.length != 2 * image.width * image.height) throw new IOException("cut");
        depth = picture(image.data, image);
      }
    }
  }

  private BufferedImage picture(byte[] mm, image_t image) {
    BufferedImage out = new BufferedImage(image.width, image.height, BufferedImage.TYPE_INT_RGB);
    int valued = 0;
    for (int i = 0; i < image.width * image.height; ++i) {
      int z = (mm[2 * i] & 0xFF) | (mm[2 * i + 1] & 0xFF) << 8;
      if (z == 0) continue;
      ++valued;
      float far = Math.min(1.0f, z / FAR_MM);
      out.setRGB(i % image.width, i / image.width, Color.HSBtoRGB(0.05f + 0.6f * far, 0.75f, 1.0f - 0.55f * far));
    }
    known = (double) valued / (image.width * image.height);
    return out;
  }

  @Override
  public void paint(Graphics2D g, int width, int height) {
    g.setRenderingHint(
        RenderingHints.KEY_INTERPOLATION, RenderingHints.VALUE_INTERPOLATION_BILINEAR);
    boolean beside = width > height;
    draw(g, color, 0, 0, beside ? width / 2 : width, beside ? height : height / 2);
    draw(g, depth, beside ? width / 2 : 0, beside ? 0 : height / 2,
        beside ? width / 2 : width, beside ? height : height / 2);
  }

  private static void draw(Graphics2D g, BufferedImage image, int x, int y, int width, int height) {
    if (image == null) return;
    double scale =
        Math.min((double) width / image.getWidth(), (double) height / image.getHeight());
    int w = (int) (scale * image.getWidth());
    int h = (int) (scale * image.getHeight());
    g.drawImage(image, x + (width - w) / 2, y + (height - h) / 2, w, h, null);
  }

  @Override
  public String facts() {
    String text = color == null ? "no colour" : color.getWidth() + " x " + color.getHeight();
    return depth == null
        ? text + ", no depth"
        : text + String.format(Locale.ROOT, ", depth at %.0f %% of the pixels (red near, blue 6 m)", 100 * known);
  }
}
