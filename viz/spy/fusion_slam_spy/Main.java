package fusion_slam_spy;

import java.util.ArrayList;
import java.util.List;
import lcm.lcm.LCM;
import lcm.spy.Spy;

/** lcm-spy with our types and plug-ins, and windows that can be asked for on the command line. */
public final class Main {
  private static final String USAGE =
      "usage: fusion-slam spy [--lcm-url URL] [--view CHANNEL ...]\n"
          + "  lcm-spy with Fusion-SLAM's types. A channel of scans, images or tiles also has a picture:\n"
          + "  in its menu (right button), or at once by --view LIDAR --view CAMERA --view GRID_FUSED";

  private Main() {}

  private static View viewOf(String channel) {
    if (channel.contains("LIDAR") && !channel.startsWith("GRID")) return new ScanView();
    if (channel.contains("CAMERA")) return new ImagesView();
    return new GridView();
  }

  public static void main(String[] arguments) throws Exception {
    String url = System.getenv("LCM_DEFAULT_URL");
    List<String> views = new ArrayList<>();
    for (int i = 0; i < arguments.length; ++i) {
      String word = arguments[i];
      boolean more = i + 1 < arguments.length;
      if (word.equals("--help") || word.equals("-h")) {
        System.out.println(USAGE);
        return;
      } else if ((word.equals("--lcm-url") || word.equals("-l")) && more) {
        url = arguments[++i];
      } else if (word.startsWith("--lcm-url=")) {
        url = word.substring("--lcm-url=".length());
      } else if (word.equals("--view") && more) {
        views.add(arguments[++i]);
      } else {
        System.err.println("spy: what is " + word + "?\n" + USAGE);
        System.exit(2);
      }
    }
    Network.set(url == null || url.isEmpty() ? LCM.getSingleton() : new LCM(url));
    new Spy(url == null || url.isEmpty() ? null : url);
    for (int i = 0; i < views.size(); ++i)
      ViewFrame.open(Network.get(), views.get(i), viewOf(views.get(i)), i);
  }
}
