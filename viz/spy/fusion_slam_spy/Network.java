package fusion_slam_spy;

import java.awt.event.ActionEvent;
import java.util.function.Supplier;
import javax.swing.AbstractAction;
import javax.swing.Action;
import lcm.lcm.LCM;

/** The LCM network that all views listen on. */
final class Network {
  private static LCM lcm;
  private static int opened; // windows so far; Swing thread

  private Network() {}

  static synchronized void set(LCM chosen) {
    lcm = chosen;
  }

  static synchronized LCM get() {
    return lcm != null ? lcm : LCM.getSingleton();
  }

  /** What lcm-spy puts in the menu of a channel. */
  static Action action(String name, String channel, Supplier<View> view) {
    return new AbstractAction(name) {
      @Override
      public void actionPerformed(ActionEvent event) {
        ViewFrame.open(get(), channel, view.get(), opened++);
      }
    };
  }
}
