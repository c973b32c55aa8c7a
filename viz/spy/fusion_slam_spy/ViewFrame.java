package fusion_slam_spy;

import java.awt.BorderLayout;
import java.awt.Color;
import java.awt.Dimension;
import java.awt.Graphics;
import java.awt.Graphics2D;
import java.awt.RenderingHints;
import java.awt.Toolkit;
import java.awt.event.WindowAdapter;
import java.awt.event.WindowEvent;
import java.io.IOException;
import java.util.regex.Pattern;
import javax.swing.BorderFactory;
import javax.swing.JFrame;
import javax.swing.JLabel;
import javax.swing.JPanel;
import javax.swing.SwingUtilities;
import javax.swing.Timer;
import lcm.lcm.LCM;
import lcm.lcm.LCMDataInputStream;
import lcm.lcm.LCMSubscriber;

/** A window that shows one channel, redrawn at most ten times a second. Listens while it is open. */
final class ViewFrame extends JFrame implements LCMSubscriber {
  private static final int REDRAW_MS = 100;
  private static final Color PAPER = new Color(0xFBFBFA);

  private final View view;
  private final String channel;
  private final JLabel line = new JLabel("no message yet");
  private final Timer timer;
  private long received;
  private long damaged;
  private boolean changed;

  ViewFrame(final LCM lcm, String channel, View view) {
    super(channel);
    this.view = view;
    this.channel = channel;
    final JPanel canvas =
        new JPanel() {
          @Override
          protected void paintComponent(Graphics graphics) {
            super.paintComponent(graphics);
            Graphics2D g = (Graphics2D) graphics;
            g.setRenderingHint(RenderingHints.KEY_ANTIALIASING, RenderingHints.VALUE_ANTIALIAS_ON);
            synchronized (ViewFrame.this) {
              ViewFrame.this.view.paint(g, getWidth(), getHeight());
            }
          }
        };
    canvas.setBackground(PAPER);
    canvas.setPreferredSize(new Dimension(640, 480));
    line.setBorder(BorderFactory.createEmptyBorder(4, 8, 4, 8));
    add(canvas, BorderLayout.CENTER);
    add(line, BorderLayout.SOUTH);
    pack();
    timer =
        new Timer(
            REDRAW_MS,
            event -> {
              synchronized (this) {
                if (!changed) return;
                changed = false;
                line.setText(
                    view.facts() + "   " + received + " messages"
                        + (damaged > 0 ? ", " + damaged + " damaged" : ""));
              }
              canvas.repaint();
            });
    timer.start();
    setDefaultCloseOperation(DISPOSE_ON_CLOSE);
    addWindowListener(
        new WindowAdapter() {
          @Override
          public void windowClosed(WindowEvent event) {
            lcm.unsubscribe(Pattern.quote(ViewFrame.this.channel), ViewFrame.this);
            timer.stop();
          }
        });
    lcm.subscribe(Pattern.quote(channel), this);
  }

  @Override
  public synchronized void messageReceived(LCM lcm, String from, LCMDataInputStream message) {
    changed = true;
    try {
      view.take(message);
      ++received;
    } catch (IOException | RuntimeException | OutOfMemoryError error) {
      ++damaged;
    }
  }

  /** `place`: windows stand side by side, then in rows, in the order of this number. */
  static void open(LCM lcm, String channel, View view, int place) {
    SwingUtilities.invokeLater(
        () -> {
          ViewFrame frame = new ViewFrame(lcm, channel, view);
          int columns =
              Math.max(1, Toolkit.getDefaultToolkit().getScreenSize().width / frame.getWidth());
          frame.setLocation(
              place % columns * frame.getWidth(), place / columns * frame.getHeight());
          frame.setVisible(true);
        });
  }
}
