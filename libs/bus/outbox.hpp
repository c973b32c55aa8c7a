// What a process has sent, kept so that it can be sent again: the latest messages of each channel
// (by number) and the newest tile of each key. Pure data structure; not thread-safe (the Bus locks
// around it).
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "fusion_slam/resend_t.hpp"
#include "fusion_slam/tile_index_t.hpp"
#include "libs/tiles/tile.hpp"

namespace fusion_slam {

class Outbox {
 public:
  using Bytes = std::vector<std::uint8_t>;

  std::int64_t next_seq(
      const std::string& channel) const;  // what the next message will be numbered

  // Records that message number next_seq() was sent.
  void sent(const std::string& channel, const Bytes& bytes);
  void sent_tile(const std::string& channel, const TileKey& key, std::int64_t revision,
                 const Bytes& bytes);

  void forget(const std::string& channel);  // the latest messages; numbers and tiles stay
  std::vector<Bytes> tiles(const std::string& channel) const;  // the newest of each key

  // Numbers up to and including `last` are not given to anything: the end of a journal is lost, and
  // with it what had them. Nothing happens when `last` has been reached.
  void skip_to(const std::string& channel, std::int64_t last);

  // What is still here of the latest messages, by number; and the numbers up to `last` that were
  // never given, as last -> first.
  using Recent = std::deque<std::pair<std::int64_t, Bytes>>;
  const Recent& recent(const std::string& channel);
  std::map<std::int64_t, std::int64_t> never_given(const std::string& channel, std::int64_t last);
  // An earlier process gave the numbers up to `last`, but for these.
  void was_given(const std::string& channel, std::int64_t last,
                 const std::map<std::int64_t, std::int64_t>& never_given);

  // Records a message that is never asked for again (STATUS and the like): counted, not kept.
  void sent_once(const std::string& channel, std::size_t size_bytes);

  // Notes what is asked for and is still here. What waits already is not noted twice: requests,
  // however many and whoever sends them, cost no more than what there is to send.
  void request(const resend_t& request);
  // Numbers that were asked for since the last call and were never given, as RESEND says it: from
  // and to as negative numbers.
  std::vector<resend_t> take_never_given();
  // Takes the message that was noted first; nothing when none waits.
  std::optional<std::pair<std::string, Bytes>> take_requested();

  // The full list of tiles of each channel that has any, in parts that fit a datagram.
  std::vector<tile_index_t> indexes() const;

  std::map<std::string, std::int64_t> counts() const;  // messages sent by channel
  std::int64_t bytes(const std::string& channel) const;

 private:
  struct StoredTile {
    std::int64_t revision = 0;
    Bytes bytes;
  };
  struct Channel {
    std::int64_t count = 0;
    std::int64_t bytes = 0;
    Recent recent;
    std::map<std::int64_t, std::int64_t> never_given;  // last -> first
    std::size_t recent_bytes = 0;
    std::map<TileKey, StoredTile> tiles;
  };
  // One message: by number, or (number 0) the newest of a tile.
  using Wanted = std::tuple<std::string, std::int64_t, TileKey>;
  const Bytes* find(const Wanted& wanted) const;

  std::map<std::string, Channel> channels_;
  std::deque<Wanted> wanted_;
  std::set<Wanted> is_wanted_;
  std::map<std::string, std::set<std::int64_t>> never_given_;  // asked for: last of each range
};

}  // namespace fusion_slam
