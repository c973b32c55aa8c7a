// kill -9 at any moment of a save leaves a whole map: the old one or the new one.
#include <csignal>
#include <ctime>

#include <sys/wait.h>
#include <unistd.h>

#include "libs/map_directory/map_reader.hpp"
#include "tests/libs/map_directory/session_log.hpp"

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;

std::int64_t now_us() {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return time.tv_sec * 1'000'000LL + time.tv_nsec / 1000;
}

void wait_us(std::int64_t duration_us) {
  timespec time{duration_us / 1'000'000, duration_us % 1'000'000 * 1000};
  nanosleep(&time, nullptr);
}

// A child that saves; killed after so long. True: it had finished before.
bool save_and_kill(const fs::path& session, const fs::path& map, std::int64_t after_us) {
  const pid_t child = fork();
  if (child == 0) {
    try {
      save_session(session, map, {});
    } catch (...) {
      _exit(3);
    }
    _exit(0);
  }
  wait_us(after_us);
  kill(child, SIGKILL);
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  if (WIFSIGNALED(status)) return false;
  EXPECT_EQ(WEXITSTATUS(status), 0);
  return true;
}

TEST(MapSaverKilled, LeavesTheOldMapOrTheNew) {
  const fs::path place = scratch();
  const fs::path one = write_session(place / "one", 0.9), two = write_session(place / "two", 0.1);
  const fs::path map = place / "map";
  save_session(two, map, {});
  const auto files_two = contents(map);
  const std::int64_t started_us = now_us();
  save_session(one, map, {});
  const std::int64_t duration_us = now_us() - started_us;
  const auto files_one = contents(map);
  ASSERT_NE(files_one, files_two);

  constexpr int kKills = 40;
  int killed = 0;
  for (int n = 0; n < kKills; ++n) {
    // Alternately the other session, so that a finished save shows; moments over a whole save.
    const bool to_two = n % 2 == 0;
    killed += save_and_kill(to_two ? two : one, map, duration_us * 6 / 5 * n / kKills) ? 0 : 1;
    const auto files = contents(map);
    ASSERT_TRUE(files == files_one || files == files_two) << "after kill " << n;
    ASSERT_NO_THROW(read_state(MapReader(map))) << "after kill " << n;
  }
  EXPECT_GT(killed, 0);
  save_session(one, map, {});  // and nothing of the dead stays behind
  std::size_t beside = 0;
  for (const auto& entry : fs::directory_iterator(place))
    beside += entry.path().filename().string().find(".partial-") != std::string::npos ? 1 : 0;
  EXPECT_EQ(beside, 0U);
  EXPECT_EQ(contents(map), files_one);
}

}  // namespace
}  // namespace fusion_slam
