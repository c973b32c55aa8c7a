package fusion_slam_spy;

import bot_core.planar_lidar_t;
import javax.swing.Action;
import javax.swing.JDesktopPane;
import lcm.spy.ChannelData;
import lcm.spy.SpyPlugin;

/** lcm-spy finds it on the class path and offers it for every channel of planar_lidar_t. */
public final class ScanPlugin implements SpyPlugin {
  @Override
  public boolean canHandle(long fingerprint) {
    return fingerprint == planar_lidar_t.LCM_FINGERPRINT;
  }

  @Override
  public Action getAction(JDesktopPane desktop, ChannelData channel) {
    return Network.action("Scan from above", channel.name, ScanView::new);
  }
}
