// A viewer that was started late hears what the loop detector said before.
#include "viz/web/loop_history.hpp"

#include <set>

#include <gtest/gtest.h>

#include "fusion_slam/loop_candidate_t.hpp"
#include "libs/bus/transport.hpp"
#include "tests/support/test_bus.hpp"

namespace fusion_slam {
namespace {

loop_candidate_t report(std::int64_t id) {
  loop_candidate_t message{};
  message.utime = id * 1'000;
  message.from_id = 1;
  message.to_id = id;
  return message;
}

TEST(LoopHistory, ALateListenerGetsTheReportsFromBefore) {
  auto transport = std::make_shared<Transport>("memq://");
  Bus detector(test_bus("loop_detector"), transport);
  for (int id = 1; id <= 1500; ++id) detector.publish("LOOP_CANDIDATE", report(id));
  Bus viewer(test_bus("viewer"), transport);
  std::set<std::int64_t> heard;
  std::size_t n = 0;
  viewer.subscribe<loop_candidate_t>("LOOP_CANDIDATE", Policy::kKeepAll,
                                     [&](const loop_candidate_t& m) {
                                       heard.insert(m.to_id);
                                       ++n;
                                     });
  LoopHistory history;
  detector.publish("LOOP_CANDIDATE", report(1501));
  for (int i = 0; i < 5000 && heard.size() < 1501; ++i) {
    if (i % 1000 == 0) history.hear(detector.status(), viewer);
    while (viewer.handle(2)) {
    }
  }
  EXPECT_EQ(heard.size(), 1501U);
  EXPECT_EQ(n, 1501U);  // each once
  const auto asked = viewer.published()["RESEND"];
  history.hear(detector.status(), viewer);
  EXPECT_EQ(viewer.published()["RESEND"], asked);
}

TEST(LoopHistory, WhoAnswersNothingIsAskedAFewTimesOnly) {
  auto transport = std::make_shared<Transport>("memq://");
  Bus viewer(test_bus("viewer"), transport);
  status_t status{};
  status.process = "loop_detector";
  status.pid = 7;
  channel_stats_t channel{};
  channel.channel = "LOOP_CANDIDATE";
  channel.published = 9;
  status.channels = {channel};
  LoopHistory history;
  for (int i = 0; i < 20; ++i) history.hear(status, viewer);
  EXPECT_EQ(viewer.published()["RESEND"], LoopHistory::kTries);
}

}  // namespace
}  // namespace fusion_slam
