// What the viewer knows, as items that browsers hold copies of: newest value only, each change
// numbered. A browser is no more than a cursor into these numbers, so a slow one skips what has
// been replaced meanwhile, costs no memory, and nobody waits for it ("state, not history"). Knows
// neither LCM nor HTTP. Any thread.
#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

namespace fusion_slam {

// In the order in which they are sent when a browser lags: what is small and changes first. The
// numbers are on the wire (docs/viewer.md).
enum class Topic : std::uint8_t {
  kTime = 0,
  kNotice = 1,
  kRobot = 2,
  kPose = 3,
  kHealth = 4,
  kInput = 5,
  kDeputy = 6,
  kScan = 7,
  kLoop = 8,
  kNodes = 9,
  kTruth = 10,
  kGridFused = 11,
  kGridLidar = 12,
  kGridVisual = 13,
  kKeyframe = 14,
  kCamera = 15,
  kOctomap = 16,
  kCloud = 17,
};
constexpr std::size_t kTopics = 18;
using TopicSet = std::bitset<kTopics>;

struct Item {
  Topic topic = Topic::kTime;
  std::string key;
  std::shared_ptr<const std::string> payload;  // nullptr: it is gone
};

// What one browser has. Default: nothing.
struct Cursor {
  std::uint64_t epoch = 0;
  std::array<std::uint64_t, kTopics> seen{};
};

class ItemStore {
 public:
  // An equal payload is no change.
  void put(Topic topic, const std::string& key, std::string payload);
  void remove(Topic topic, const std::string& key);
  // All items of one topic.
  void remove_all(Topic topic);
  // Everything: browsers throw away what they hold (a replay went back, the map was reset).
  void clear();

  // The next items that this cursor lacks, in order of topic and change, and moves the cursor on.
  // Stops behind the item with which the sizes reach max_bytes, so one item always fits. An epoch
  // other than the cursor's makes it start anew.
  std::vector<Item> next(Cursor* cursor, const TopicSet& wanted, std::size_t max_bytes) const;
  // Forgets that a topic was sent: the browser wants it again.
  static void rewind(Cursor* cursor, Topic topic) {
    cursor->seen[static_cast<std::size_t>(topic)] = 0;
  }

  std::shared_ptr<const std::string> find(Topic topic, const std::string& key) const;
  std::size_t size(Topic topic) const;  // items that are not gone

 private:
  struct Entry {
    std::uint64_t version = 0;
    std::shared_ptr<const std::string> payload;
  };
  struct Shelf {
    std::map<std::string, Entry> items;
    std::map<std::uint64_t, const std::string*> by_version;  // into the keys of items
    std::size_t alive = 0;
  };
  void set(Shelf& shelf, const std::string& key, std::shared_ptr<const std::string> payload);
  const Shelf& shelf(Topic topic) const { return shelves_[static_cast<std::size_t>(topic)]; }
  Shelf& shelf(Topic topic) { return shelves_[static_cast<std::size_t>(topic)]; }

  mutable std::mutex mutex_;
  std::uint64_t epoch_ = 1;
  std::uint64_t version_ = 0;
  std::array<Shelf, kTopics> shelves_;
};

}  // namespace fusion_slam
