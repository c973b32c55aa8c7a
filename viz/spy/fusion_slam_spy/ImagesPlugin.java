package fusion_slam_spy;

import bot_core.images_t;
import javax.swing.Action;
import javax.swing.JDesktopPane;
import lcm.spy.ChannelData;
import lcm.spy.SpyPlugin;

/** lcm-spy finds it on the class path and offers it for every channel of images_t. */
public final class ImagesPlugin implements SpyPlugin {
  @Override
  public boolean canHandle(long fingerprint) {
    return fingerprint == images_t.LCM_FINGERPRINT;
  }

  @Override
  public Action getAction(JDesktopPane desktop, ChannelData channel) {
    return Network.action("Colour and depth", channel.name, ImagesView::new);
  }
}
