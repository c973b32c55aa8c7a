#include "libs/camera/packed_depth.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "libs/camera/depth_guess.hpp"
#include "libs/compression/rans.hpp"
#include "libs/compression/zlib_bytes.hpp"

namespace fusion_slam {
namespace {

constexpr std::uint8_t kVersion = 1;
constexpr std::size_t kHeaderBytes = 5;  // version, CRC-32
// Symbols: 0 ... 60 are -30 ... 30 beside the guess, then "no depth" and "further off", which is
// followed by the rank itself.
constexpr int kFurthest = 30;
constexpr int kNone = 2 * kFurthest + 1;
constexpr int kFar = kNone + 1;
constexpr int kSymbols = kFar + 1;
constexpr int kLowBits = 8;  // of a rank, which goes in two pieces

int bits_of(int highest_rank) {
  int bits = 1;
  while (highest_rank >> bits != 0) ++bits;
  return bits;
}

void put_number(std::uint32_t number, Bytes* out) {  // seven bits a byte, low first
  for (; number >= 0x80; number >>= 7) out->push_back(static_cast<std::uint8_t>(number | 0x80));
  out->push_back(static_cast<std::uint8_t>(number));
}

class Source {
 public:
  Source(const Bytes& bytes, std::size_t at) : bytes_(bytes), at_(at) {}
  std::uint32_t byte() { return at_ < bytes_.size() ? bytes_[at_++] : (good = false, 0); }
  std::uint32_t number() {
    std::uint32_t value = 0;
    for (int shift = 0; shift < 28; shift += 7) {
      const std::uint32_t next = byte();
      value |= (next & 0x7F) << shift;
      if (next < 0x80) return value;
    }
    return good = false, 0;
  }
  const std::uint8_t* rest() const { return bytes_.data() + at_; }
  std::size_t rest_bytes() const { return bytes_.size() - at_; }

  bool good = true;

 private:
  const Bytes& bytes_;
  std::size_t at_;
};

// The depths that occur, ascending; [0] is 0, no depth.
std::vector<std::uint16_t> values_of(const cv::Mat& depth_mm) {
  std::vector<std::uint8_t> occurs(65536, 0);
  for (int v = 0; v < depth_mm.rows; ++v) {
    const auto* row = depth_mm.ptr<std::uint16_t>(v);
    for (int u = 0; u < depth_mm.cols; ++u) occurs[row[u]] = 1;
  }
  std::vector<std::uint16_t> values{0};
  for (std::size_t d = 1; d < occurs.size(); ++d)
    if (occurs[d] != 0) values.push_back(static_cast<std::uint16_t>(d));
  return values;
}

struct Coded {
  std::uint8_t context, symbol;
};

struct Pixels {
  std::vector<Coded> coded;
  std::vector<std::uint16_t> far;  // ranks of those that are further off
};

// Upper and lower half are coded for themselves, so that a processor can read both at a time: each
// pixel waits for the one before it.
std::array<cv::Mat, 2> halves(const cv::Mat& image) {
  const int upper = (image.rows + 1) / 2;
  return {image.rowRange(0, upper), image.rowRange(upper, image.rows)};
}

Pixels look_at(const cv::Mat& depth_mm, const std::vector<std::uint16_t>& rank_of,
               int highest_rank) {
  Pixels pixels;
  pixels.coded.reserve(depth_mm.total());
  DepthGuess guesses(depth_mm.cols, highest_rank);
  for (int v = 0; v < depth_mm.rows; ++v) {
    const auto* depths = depth_mm.ptr<std::uint16_t>(v);
    DepthGuess::Row row = guesses.begin_row();
    for (int u = 0; u < depth_mm.cols; ++u) {
      const int rank = rank_of[depths[u]];
      const DepthGuess::Guess guess = row.guess();
      int symbol = rank == 0 ? kNone : rank - guess.rank + kFurthest;
      if (rank != 0 && (symbol < 0 || symbol >= kNone)) {
        symbol = kFar;
        pixels.far.push_back(static_cast<std::uint16_t>(rank));
      }
      pixels.coded.push_back(
          {static_cast<std::uint8_t>(guess.context), static_cast<std::uint8_t>(symbol)});
      row.put(rank, guess);
    }
  }
  return pixels;
}

std::array<Pixels, 2> look_at(const cv::Mat& depth_mm, const std::vector<std::uint16_t>& values) {
  std::vector<std::uint16_t> rank_of(65536, 0);
  for (std::size_t i = 0; i < values.size(); ++i)
    rank_of[values[i]] = static_cast<std::uint16_t>(i);
  const int highest_rank = static_cast<int>(values.size()) - 1;
  const std::array<cv::Mat, 2> half = halves(depth_mm);
  return {look_at(half[0], rank_of, highest_rank), look_at(half[1], rank_of, highest_rank)};
}

struct Range {
  std::uint16_t start = 0, frequency = 0;
};
using Tables = std::array<std::array<Range, kSymbols>, kDepthContexts>;

// Writes them, too: of each context the first symbol, how many from there on, their frequencies.
Tables tables_of(const std::array<Pixels, 2>& pixels, Bytes* out) {
  std::vector<std::vector<std::uint32_t>> counts(kDepthContexts,
                                                 std::vector<std::uint32_t>(kSymbols, 0));
  for (const Pixels& half : pixels)
    for (const Coded& pixel : half.coded) ++counts[pixel.context][pixel.symbol];
  Tables tables{};
  for (std::size_t c = 0; c < kDepthContexts; ++c) {
    const std::vector<std::uint16_t> frequencies = rans_frequencies(counts[c]);
    int first = 0, last = kSymbols - 1;
    while (first < kSymbols && frequencies[static_cast<std::size_t>(first)] == 0) ++first;
    while (last > first && frequencies[static_cast<std::size_t>(last)] == 0) --last;
    out->push_back(static_cast<std::uint8_t>(first));
    if (first == kSymbols) continue;
    out->push_back(static_cast<std::uint8_t>(last - first + 1));
    std::uint16_t start = 0;
    for (auto s = static_cast<std::size_t>(first); s <= static_cast<std::size_t>(last); ++s) {
      put_number(frequencies[s], out);
      tables[c][s] = {start, frequencies[s]};
      start = static_cast<std::uint16_t>(start + frequencies[s]);
    }
  }
  return tables;
}

Bytes coded(const Pixels& pixels, const Tables& tables, int bits) {
  const int low_bits = std::min(bits, kLowBits);
  RansEncoder stream;  // last pixel first
  auto far = pixels.far.rbegin();
  for (auto pixel = pixels.coded.rbegin(); pixel != pixels.coded.rend(); ++pixel) {
    if (pixel->symbol == kFar) {
      if (bits > low_bits) stream.put_bits(*far >> low_bits, bits - low_bits);
      stream.put_bits(*far++ & ((1U << low_bits) - 1), low_bits);
    }
    const Range range = tables[pixel->context][pixel->symbol];
    stream.put(range.start, range.frequency);
  }
  Bytes out;
  stream.finish(&out);
  return out;
}

// The same for reading: the symbol that each of [0, kRansOne) belongs to in a context, and its
// place. A context that does not occur has only ranges of frequency 0.
struct ReadTables {
  std::vector<std::uint8_t> symbols = std::vector<std::uint8_t>(kDepthContexts * kRansOne, 0);
  Tables ranges{};
};

bool read_tables(Source* source, ReadTables* tables) {
  for (std::size_t c = 0; c < kDepthContexts; ++c) {
    const std::uint32_t first = source->byte();
    if (first == kSymbols) continue;
    const std::uint32_t n = source->byte();
    if (!source->good || first + n > kSymbols) return false;
    std::uint32_t start = 0;
    for (std::uint32_t s = first; s < first + n; ++s) {
      const std::uint32_t frequency = source->number();
      if (!source->good || frequency > kRansOne - start) return false;
      tables->ranges[c][s] = {static_cast<std::uint16_t>(start),
                              static_cast<std::uint16_t>(frequency)};
      std::fill_n(tables->symbols.begin() + static_cast<std::ptrdiff_t>(c * kRansOne + start),
                  frequency, static_cast<std::uint8_t>(s));
      start += frequency;
    }
    if (start != kRansOne) return false;
  }
  return true;
}

bool read_values(Source* source, std::vector<std::uint16_t>* values) {
  const std::uint32_t n = source->number();
  if (!source->good || n > 65535) return false;
  std::uint32_t value = 0;
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t step = source->number();
    value += step;
    if (!source->good || step == 0 || value > 65535) return false;
    values->push_back(static_cast<std::uint16_t>(value));
  }
  return true;
}

// One half of an image while it is read.
struct Reading {
  RansDecoder stream;
  DepthGuess guesses;
};

// What is the same for all pixels.
struct Known {
  const ReadTables& tables;
  const std::vector<std::uint16_t>& values;
  int highest_rank, bits, low_bits;

  // The next pixel's depth, mm; false when the bytes are damaged.
  bool read(RansDecoder* stream, DepthGuess::Row* row, std::uint16_t* depth_mm) const {
    const DepthGuess::Guess guess = row->guess();
    const auto context = static_cast<std::size_t>(guess.context);
    const int symbol = tables.symbols[context * kRansOne + stream->peek()];
    const Range range = tables.ranges[context][static_cast<std::size_t>(symbol)];
    if (range.frequency == 0) return false;
    stream->take(stream->peek() - range.start, range.frequency);
    int rank = guess.rank + symbol - kFurthest;
    if (symbol >= kNone) {
      rank = 0;
      if (symbol == kFar) {
        rank = static_cast<int>(stream->take_bits(low_bits));
        if (bits > low_bits)
          rank |= static_cast<int>(stream->take_bits(bits - low_bits) << low_bits);
      }
    }
    if (rank < (symbol == kNone ? 0 : 1) || rank > highest_rank) return false;
    *depth_mm = values[static_cast<std::size_t>(rank)];
    row->put(rank, guess);
    return true;
  }
};

bool read_row(const Known& known, Reading* half, cv::Mat* depth_mm, int v) {
  auto* depths = depth_mm->ptr<std::uint16_t>(v);
  DepthGuess::Row row = half->guesses.begin_row();
  for (int u = 0; u < depth_mm->cols; ++u)
    if (!known.read(&half->stream, &row, depths + u)) return false;
  return true;
}

// A row of each half, pixel by pixel in turn.
bool read_rows(const Known& known, Reading* upper, Reading* lower, std::array<cv::Mat, 2>* image,
               int v) {
  auto* depths = (*image)[0].ptr<std::uint16_t>(v);
  auto* others = (*image)[1].ptr<std::uint16_t>(v);
  DepthGuess::Row row = upper->guesses.begin_row(), other = lower->guesses.begin_row();
  RansDecoder stream = upper->stream, second = lower->stream;
  for (int u = 0; u < (*image)[0].cols; ++u)
    if (!known.read(&stream, &row, depths + u) || !known.read(&second, &other, others + u))
      return false;
  upper->stream = stream;
  lower->stream = second;
  return true;
}

bool read_pixels(Source source, const ReadTables& tables, const std::vector<std::uint16_t>& values,
                 cv::Mat* depth_mm) {
  const std::size_t first = source.number();
  if (!source.good || first > source.rest_bytes()) return false;
  const int highest = static_cast<int>(values.size()) - 1, bits = bits_of(highest);
  const Known known{tables, values, highest, bits, std::min(bits, kLowBits)};
  Reading upper{RansDecoder(source.rest(), first), DepthGuess(depth_mm->cols, highest)};
  Reading lower{RansDecoder(source.rest() + first, source.rest_bytes() - first),
                DepthGuess(depth_mm->cols, highest)};
  std::array<cv::Mat, 2> image = halves(*depth_mm);
  for (int v = 0; v < image[0].rows; ++v)
    if (!(v < image[1].rows ? read_rows(known, &upper, &lower, &image, v)
                            : read_row(known, &upper, &image[0], v)))
      return false;
  return upper.stream.at_end() && lower.stream.at_end();
}

}  // namespace

Bytes encode_packed_depth(const cv::Mat& depth_mm) {
  if (depth_mm.type() != CV_16UC1 || depth_mm.empty() || depth_mm.cols > kMaxImageSide ||
      depth_mm.rows > kMaxImageSide)
    throw std::invalid_argument("encode_packed_depth: not a depth image");
  const std::vector<std::uint16_t> values = values_of(depth_mm);
  const std::array<Pixels, 2> pixels = look_at(depth_mm, values);
  Bytes out(kHeaderBytes, 0);
  put_number(static_cast<std::uint32_t>(values.size() - 1), &out);
  for (std::size_t i = 1; i < values.size(); ++i)
    put_number(static_cast<std::uint32_t>(values[i] - values[i - 1]), &out);
  const Tables tables = tables_of(pixels, &out);

  const int bits = bits_of(static_cast<int>(values.size()) - 1);
  const Bytes upper = coded(pixels[0], tables, bits), lower = coded(pixels[1], tables, bits);
  put_number(static_cast<std::uint32_t>(upper.size()), &out);
  out.insert(out.end(), upper.begin(), upper.end());
  out.insert(out.end(), lower.begin(), lower.end());

  const std::uint32_t crc = crc32_of(out.data() + kHeaderBytes, out.size() - kHeaderBytes);
  out[0] = kVersion;
  for (std::size_t i = 0; i < 4; ++i) out[1 + i] = static_cast<std::uint8_t>(crc >> (8 * i));
  return out;
}

std::optional<cv::Mat> decode_packed_depth(const Bytes& bytes, int width_px, int height_px,
                                           std::string* why) {
  if (width_px <= 0 || height_px <= 0 || width_px > kMaxImageSide || height_px > kMaxImageSide)
    return *why = "packed depth: sides must be 1 to " + std::to_string(kMaxImageSide) + " px",
           std::nullopt;
  if (bytes.size() < kHeaderBytes) return *why = "packed depth is cut short", std::nullopt;
  if (bytes[0] != kVersion)
    return *why = "packed depth is of version " + std::to_string(bytes[0]) + ", known is " +
                  std::to_string(kVersion) + ": a newer program made it",
           std::nullopt;
  std::uint32_t crc = 0;
  for (std::size_t i = 0; i < 4; ++i) crc |= static_cast<std::uint32_t>(bytes[1 + i]) << (8 * i);
  Source source(bytes, kHeaderBytes);
  std::vector<std::uint16_t> values{0};
  ReadTables tables;
  cv::Mat depth_mm;
  bool good = crc == crc32_of(source.rest(), source.rest_bytes()) &&
              read_values(&source, &values) && read_tables(&source, &tables);
  if (good) {
    depth_mm.create(height_px, width_px, CV_16UC1);
    good = read_pixels(source, tables, values, &depth_mm);
  }
  if (!good) return *why = "packed depth is damaged or of another size", std::nullopt;
  return depth_mm;
}

}  // namespace fusion_slam
