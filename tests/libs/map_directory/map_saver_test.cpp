#include "libs/map_directory/map_saver.hpp"

#include "libs/map_directory/map_reader.hpp"
#include "tests/libs/map_directory/session_log.hpp"

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;

TEST(MapSaver, SavesASession) {
  const fs::path place = scratch();
  write_session(place / "run");
  const MapSummary summary = save_session(place / "run", place / "map", {});
  EXPECT_EQ(summary.robot, "test robot");
  EXPECT_TRUE(summary.has_lidar);
  EXPECT_FALSE(summary.has_camera);
  EXPECT_EQ(summary.lidar_nodes, 2);  // one came twice
  EXPECT_EQ(summary.submaps, 1);
  EXPECT_EQ(summary.first_utime_us, kSessionUs + 1);
  EXPECT_EQ(summary.last_utime_us, kSessionUs + 2);
  for (const char* name : {"manifest.json", "journal.lcmlog", "configuration.yaml", "map.pgm",
                           "map.yaml", "lidar_map.pgm", "trajectory.tum"})
    EXPECT_TRUE(fs::exists(place / "map" / name)) << name;
}

TEST(MapSaver, KeepsTheNewestState) {
  const fs::path place = scratch();
  save_session(write_session(place / "run"), place / "map", {});
  const MapReader reader(place / "map");
  const MapState state = read_state(reader);
  ASSERT_EQ(state.graph.nodes().size(), 2U);
  EXPECT_DOUBLE_EQ(state.graph.T_map_nodes().at({NodeKind::kLidar, 2}).translation().x(), 1.5);
  const Tile submap = from_message(state.tiles.at("SUBMAP").at({1, 0, 0, 0}));
  EXPECT_EQ(submap.revision, 2);
  EXPECT_EQ((*decode_grid_tile(submap))[0], cell_from_probability(0.9));
  std::map<std::string, int> count;
  reader.for_each([&](const LogEvent& event) { ++count[event.channel]; });
  EXPECT_EQ(count, (std::map<std::string, int>{{"GRAPH", 1},
                                               {"GRID_LIDAR", 1},
                                               {"LIDAR_NODE", 2},
                                               {"LIDAR_POSE", 2},
                                               {"ROBOT_MODEL", 1},
                                               {"SUBMAP", 1}}));
}

TEST(MapSaver, SameSessionSameBytes) {
  const fs::path place = scratch();
  const fs::path session = write_session(place / "run");
  save_session(session, place / "a", {});
  save_session(session, place / "b", {});
  EXPECT_EQ(contents(place / "a"), contents(place / "b"));
}

TEST(MapSaver, TakesASessionThatIsCutOff) {
  const fs::path place = scratch();
  const fs::path session = write_session(place / "run");
  fs::resize_file(session, fs::file_size(session) - 20);
  save_session(session, place / "map", {});
  EXPECT_DOUBLE_EQ(read_state(MapReader(place / "map"))
                       .graph.T_map_nodes()
                       .at({NodeKind::kLidar, 2})
                       .translation()
                       .x(),
                   1.0);
}

TEST(MapSaver, SaysWhatTheSessionLost) {
  const fs::path place = scratch();
  EXPECT_TRUE(save_session(write_session(place / "whole"), place / "map", {}).lost.empty());
  {
    LogWriter writer(place / "gap.lcm");
    RobotModel robot;
    robot.has_lidar = true;
    log(&writer, 1, "ROBOT_MODEL", to_message(robot, kSessionUs));
    log(&writer, 2, "LIDAR_NODE", node_of(2, 0.0));  // number 1 is missing, as are 3 and 4
    log(&writer, 3, "LIDAR_NODE", node_of(5, 1.0));
    log(&writer, 4, "GRAPH", graph_of(1, 2, 0.0));
    writer.close();
  }
  const MapSummary summary = save_session(place / "gap.lcm", place / "gap", {});
  EXPECT_EQ(summary.lost, (std::map<std::string, std::int64_t>{{"LIDAR_NODE", 3}}));
}

TEST(MapSaver, RefusesWhatIsNoMap) {
  const fs::path place = scratch();
  const fs::path session = write_session(place / "run");
  fs::create_directory(place / "documents");
  std::ofstream(place / "documents/thesis") << "years of work";
  const std::string error = error_of([&] { save_session(session, place / "documents", {}); });
  EXPECT_NE(error.find("something other than a map"), std::string::npos) << error;
  EXPECT_EQ(read_bytes(place / "documents/thesis"), "years of work");
  EXPECT_NE(error_of([&] {
              save_session(session, place / "documents/thesis", {});
            }).find("something other than a map"),
            std::string::npos);
  fs::create_directory(place / "empty");
  EXPECT_NO_THROW(save_session(session, place / "empty", {}));
}

TEST(MapSaver, RefusesSessionsWithoutAMap) {
  const fs::path place = scratch();
  EXPECT_NE(error_of([&] {
              save_session(place / "none", place / "map", {});
            }).find("there is no such file"),
            std::string::npos);
  {
    LogWriter writer(place / "sensors.lcm");
    log(&writer, 1, "LIDAR", to_message(LaserScan{}));
    writer.close();
  }
  EXPECT_NE(error_of([&] {
              save_session(place / "sensors.lcm", place / "map", {});
            }).find("holds no GRAPH"),
            std::string::npos);
  {
    LogWriter writer(place / "damaged.lcm");
    writer.write(1, "GRAPH", std::vector<std::uint8_t>{1, 2, 3, 4, 5, 6, 7, 8, 9});
    writer.close();
  }
  EXPECT_NE(error_of([&] {
              save_session(place / "damaged.lcm", place / "map", {});
            }).find("another version"),
            std::string::npos);
  EXPECT_FALSE(fs::exists(place / "map"));
}

}  // namespace
}  // namespace fusion_slam
