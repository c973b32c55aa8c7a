// Round after round past the same places: what is kept, what is spared, and what a restart knows.
#include <set>

#include <gtest/gtest.h>

#include "tests/services/loop_detector/made_up_places.hpp"

namespace fusion_slam {
namespace {

constexpr int kPlaces = 24;  // 1 m apart on a circle, a second each

class Rounds {
 public:
  explicit Rounds(const LoopDetectorConfig& config = {}) : detector_(robot(), config) {
    detector_.set_camera(camera_);
  }

  static RobotModel robot() {
    RobotModel robot;
    robot.has_camera = true;
    robot.has_lidar = false;
    robot.planar = false;
    robot.T_base_camera = from_xyz_rpy(0.2, 0.0, 0.3, -1.5707963, 0.0, -1.5707963);
    return robot;
  }

  static LoopKeyframe keyframe(std::int64_t id) {
    const CameraModel camera;
    LoopKeyframe keyframe =
        keyframe_at(id, see_place(make_place(static_cast<unsigned>(id % kPlaces), 150), camera,
                                  SE3::Identity(), static_cast<unsigned>(id)));
    keyframe.seq = id + 1000;
    keyframe.T_odom_base = pose(id);
    keyframe.previous_id = id - 1;
    if (id > 1) keyframe.T_previous_base = pose(id - 1).inverse() * pose(id);
    keyframe.covariance = Matrix6d::Identity() * 1e-6;
    return keyframe;
  }

  static SE3 pose(std::int64_t id) {
    const double a = 2.0 * M_PI * static_cast<double>(id % kPlaces) / kPlaces;
    const double r = kPlaces / (2.0 * M_PI);
    return from_xyz_rpy(r * std::cos(a), r * std::sin(a), 0, 0, 0, a);
  }

  std::vector<LoopCandidate> drive(std::int64_t rounds) {
    std::vector<LoopCandidate> all;
    for (const std::int64_t end = last_ + rounds * kPlaces; last_ < end;) {
      ++last_;
      for (LoopCandidate& candidate : detector_.add(keyframe(last_))) {
        if (candidate.accepted)
          for (const LoopMeasurement& loop : candidate.measurements) loops_.push_back(loop);
        all.push_back(std::move(candidate));
      }
      detector_.moved({NodeKind::kKeyframe, last_}, pose(last_));
      const KnownPlacesNews news = detector_.take_news();
      news_.retired.insert(news_.retired.end(), news.retired.begin(), news.retired.end());
      news_.known.insert(news_.known.end(), news.known.begin(), news.known.end());
    }
    return all;
  }

  // Another process, from what this one's journal holds.
  Rounds built_up_again() const {
    Rounds other;
    other.detector_.remember(news_);
    for (const LoopMeasurement& loop : loops_) other.detector_.remember(loop);
    for (std::int64_t id = 1; id <= last_; ++id) other.detector_.remember(keyframe(id));
    for (std::int64_t id = 1; id <= last_; ++id)
      other.detector_.moved({NodeKind::kKeyframe, id}, pose(id));
    other.last_ = last_;
    return other;
  }

  // What is noted now: then what comes is new.
  void write_down() {
    state_.clear();
    NoteWriter out(&state_);
    detector_.write(&out);
    loops_.clear();
    news_ = {};
    written_ = last_;
    needed_ = detector_.needed_keyframes();
  }

  // Another process, from what was written down and from the messages that were needed then or came
  // later.
  Rounds restored() const {
    Rounds other;
    NoteReader in(state_.data(), state_.size());
    EXPECT_TRUE(other.detector_.restore(&in));
    other.detector_.remember(news_);
    for (const LoopMeasurement& loop : loops_) other.detector_.remember(loop);
    for (std::int64_t id = 1; id <= last_; ++id)
      if (id > written_ || needed_.count(id + 1000) > 0) other.detector_.remember(keyframe(id));
    for (std::int64_t id = written_ + 1; id <= last_; ++id)
      other.detector_.moved({NodeKind::kKeyframe, id}, pose(id));
    other.last_ = last_;
    return other;
  }
  const std::vector<std::uint8_t>& state() const { return state_; }
  std::size_t needed() const { return needed_.size(); }

  LoopDetector& detector() { return detector_; }

 private:
  CameraModel camera_;
  LoopDetector detector_;
  std::int64_t last_ = 0;
  std::vector<LoopMeasurement> loops_;
  KnownPlacesNews news_;
  std::vector<std::uint8_t> state_;
  std::int64_t written_ = 0;
  std::set<std::int64_t> needed_;
};

void expect_the_same(Rounds* expected, Rounds* got) {
  EXPECT_EQ(got->detector().sizes().places, expected->detector().sizes().places);
  EXPECT_EQ(got->detector().sizes().keyframes, expected->detector().sizes().keyframes);
  EXPECT_EQ(got->detector().sizes().nodes, expected->detector().sizes().nodes);
  EXPECT_EQ(got->detector().counts().retired, expected->detector().counts().retired);
  const auto then = expected->drive(2);
  const auto now = got->drive(2);
  ASSERT_FALSE(then.empty());
  ASSERT_EQ(now.size(), then.size());
  for (std::size_t i = 0; i < now.size(); ++i) {
    EXPECT_EQ(now[i].from, then[i].from);
    EXPECT_EQ(now[i].to, then[i].to);
    EXPECT_EQ(now[i].accepted, then[i].accepted);
  }
  EXPECT_EQ(got->detector().sizes().places, expected->detector().sizes().places);
}

TEST(KnownPlaces, SeenFewTimesNothingGoesAndNothingIsSpared) {
  Rounds rounds;
  rounds.drive(4);
  EXPECT_EQ(rounds.detector().counts().retired, 0);
  EXPECT_EQ(rounds.detector().counts().nothing_new, 0);
  EXPECT_EQ(rounds.detector().sizes().keyframes, 4U * kPlaces);
}

TEST(KnownPlaces, WhatIsKeptGrowsWithTheAreaAndNotWithTime) {
  Rounds rounds;
  rounds.drive(9);
  const LoopDetector::Sizes then = rounds.detector().sizes();
  EXPECT_LE(then.places, 6U * kPlaces);  // three oldest, three newest
  EXPECT_GT(then.places, 5U * kPlaces);
  const std::int64_t accepted = rounds.detector().counts().accepted;
  rounds.drive(4);
  const LoopDetector::Sizes now = rounds.detector().sizes();
  EXPECT_LE(now.places, 6U * kPlaces);
  EXPECT_LE(now.keyframes, then.keyframes + 5);
  EXPECT_LE(now.nodes, then.nodes + 5);
  EXPECT_LT(now.edges, then.edges + 2 * kPlaces);
  // Where the way there is known well enough few closures are needed; but some are.
  EXPECT_GT(rounds.detector().counts().nothing_new, kPlaces);
  EXPECT_GT(rounds.detector().counts().accepted, accepted);
}

TEST(KnownPlaces, TheOldestAndTheNewestViewsStay) {
  Rounds rounds;
  rounds.drive(12);
  LoopDetectorConfig all;
  all.known.tells_nothing_m = 0.0;  // each closure is wanted
  Rounds eager(all);
  eager.drive(11);
  for (const LoopCandidate& loop : eager.drive(1)) {
    const std::int64_t round = (loop.from.id - 1) / kPlaces;
    EXPECT_TRUE(round < 3 || round > 6) << "round " << round;
    EXPECT_TRUE(loop.accepted) << loop.stages.back().reason;
  }
  EXPECT_EQ(eager.detector().counts().nothing_new, 0);
  EXPECT_GT(eager.detector().counts().accepted, rounds.detector().counts().accepted);
}

TEST(KnownPlaces, ARestartKnowsThemAsIfItHadNotBeen) {
  Rounds rounds;
  rounds.drive(9);
  Rounds again = rounds.built_up_again();
  expect_the_same(&rounds, &again);
}

TEST(KnownPlaces, ARestartGoesOnFromWhatWasWrittenDown) {
  for (const std::int64_t later : {0, 1, 3}) {  // rounds
    Rounds rounds;
    rounds.drive(9);
    rounds.write_down();
    EXPECT_LT(rounds.needed(), 9U * kPlaces);
    rounds.drive(later);
    Rounds again = rounds.restored();
    expect_the_same(&rounds, &again);
  }
}

TEST(KnownPlaces, ADamagedStateIsRefusedAndNothingIsKnown) {
  Rounds rounds;
  rounds.drive(2);
  rounds.write_down();
  const std::vector<std::uint8_t> state = rounds.state();
  for (std::size_t n = 0; n < state.size(); n += 1 + n / 50) {
    Rounds other;
    NoteReader in(state.data(), n);
    EXPECT_FALSE(other.detector().restore(&in)) << n << " bytes";
    EXPECT_EQ(other.detector().sizes().nodes, 0U);
    EXPECT_EQ(other.detector().sizes().edges, 0U);
  }
  std::vector<std::uint8_t> more = state;
  more.push_back(0);
  NoteReader in(more.data(), more.size());
  EXPECT_FALSE(Rounds().detector().restore(&in));
}

}  // namespace
}  // namespace fusion_slam
