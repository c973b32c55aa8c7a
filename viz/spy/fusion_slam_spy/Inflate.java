package fusion_slam_spy;

import java.io.IOException;
import java.util.zip.DataFormatException;
import java.util.zip.Inflater;

/** zlib streams of a known length. */
final class Inflate {
  private Inflate() {}

  /** Throws IOException unless the stream holds exactly `length` bytes. */
  static byte[] exactly(byte[] data, int length) throws IOException {
    Inflater inflater = new Inflater();
    try {
      inflater.setInput(data);
      byte[] out = new byte[length];
      int done = 0;
      while (done < length) {
        int n = inflater.inflate(out, done, length - done);
        if (n == 0) throw new IOException("only " + done + " of " + length + " bytes");
        done += n;
      }
      if (inflater.inflate(new byte[1]) != 0) throw new IOException("more than " + length + " bytes");
      return out;
    } catch (DataFormatException error) {
      throw new IOException(error);
    } finally {
      inflater.end();
    }
  }
}
