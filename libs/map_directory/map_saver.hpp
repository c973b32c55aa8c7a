// Makes a map directory of a session's messages: the journal (all that is needed to go on), the
// composed maps, the effective configuration, the manifest. It appears whole or not at all.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "libs/eventlog/event.hpp"
#include "libs/eventlog/writer.hpp"
#include "libs/map_directory/atomic_directory.hpp"
#include "libs/map_directory/manifest.hpp"
#include "libs/map_directory/session_graph.hpp"
#include "libs/session/session_collector.hpp"

namespace fusion_slam {

struct MapSaveOptions {
  bool images = true;         // KEYFRAME_IMAGE: without it a merge has no dense map of this part
  std::int64_t sessions = 1;  // recordings joined in it
};

// Channels that the journal holds, in full or (tiles, GRAPH) their newest state.
bool is_journal_channel(const std::string& channel);

// One thread at a time.
class MapSaver {
 public:
  // Throws std::runtime_error: the place can't be written, or holds something that is no map.
  MapSaver(const std::filesystem::path& target, const MapSaveOptions& options);

  // A message of the session, in the order they came. Other channels than the journal's, repeats
  // and what can't be decoded are left out.
  void add(const LogEvent& event);

  // Writes everything and puts the directory in its place. Throws std::runtime_error: there was no
  // GRAPH or no ROBOT_MODEL, the session only localised in another map, the disk is full. `target`
  // is then what it was before.
  MapSummary finish();

  std::int64_t undecodable() const { return undecodable_; }

 private:
  void write(std::int64_t timestamp_us, const std::string& channel,
             const std::vector<std::uint8_t>& bytes);
  void add_tile(const LogEvent& event);
  void write_state();
  bool is_repeat(const LogEvent& event);

  std::filesystem::path target_;
  MapSaveOptions options_;
  AtomicDirectory directory_;
  LogWriter journal_;
  SessionCollector collector_;
  SessionGraph graph_;
  std::map<std::pair<std::string, TileKey>, tile_t> tiles_;
  std::map<std::string, std::set<std::int64_t>> seqs_;
  std::set<std::string> models_;  // ROBOT_MODEL, CAMERA_MODEL: the first stands
  MapSummary summary_;
  std::int64_t newest_us_ = 0;  // log time
  std::int64_t undecodable_ = 0;
  bool localised_ = false;
};

// All of a session.lcmlog, or of the one in a run's directory; a session whose end is missing is
// taken as far as it goes. Throws std::runtime_error as above, or when there is no such log.
MapSummary save_session(const std::filesystem::path& session, const std::filesystem::path& target,
                        const MapSaveOptions& options);

// Throws std::runtime_error when something other than a map (or an empty directory) is there.
void check_is_map_or_nothing(const std::filesystem::path& target);

}  // namespace fusion_slam
