package fusion_slam_spy;

import fusion_slam.tile_t;
import javax.swing.Action;
import javax.swing.JDesktopPane;
import lcm.spy.ChannelData;
import lcm.spy.SpyPlugin;

/** lcm-spy finds it on the class path and offers it for every channel of tile_t. */
public final class GridPlugin implements SpyPlugin {
  @Override
  public boolean canHandle(long fingerprint) {
    return fingerprint == tile_t.LCM_FINGERPRINT;
  }

  @Override
  public Action getAction(JDesktopPane desktop, ChannelData channel) {
    return Network.action("Grid from above", channel.name, GridView::new);
  }
}
