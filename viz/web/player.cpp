#include "viz/web/player.hpp"

#include <algorithm>
#include <chrono>
#include <iostream>

#include "viz/web/session_replay.hpp"

namespace fusion_slam {
namespace {

using Clock = std::chrono::steady_clock;
using Json = nlohmann::ordered_json;

constexpr auto kStep = std::chrono::milliseconds(33);
constexpr auto kTickPeriod = std::chrono::milliseconds(500);

double seconds(std::int64_t us) { return 1e-6 * static_cast<double>(us); }

}  // namespace

Player::Player(std::filesystem::path log, ItemStore& store, ViewerState& state)
    : log_(std::move(log)), store_(store), state_(state), thread_([this] { work(); }) {}

Player::~Player() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void Player::handle(const Request& request) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (request.verb == "play") playing_ = true;
    if (request.verb == "pause") playing_ = false;
    if (request.verb == "speed") speed_ = request.value;
    if (request.verb == "seek") seek_s_ = request.value;
  }
  changed_.notify_all();
}

bool Player::failed() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return failed_;
}

void Player::tell_loading(double fraction) {
  store_.put(Topic::kTime, "player",
             to_text({{"ready", false}, {"file", log_.string()}, {"loaded", fraction}}));
}

void Player::tell(const SessionReplay& session) {
  Json closures = Json::array();
  for (const std::int64_t utime_us : session.closures_us())
    closures.push_back(seconds(utime_us - session.first_us()));
  const std::lock_guard<std::mutex> lock(mutex_);
  store_.put(Topic::kTime, "player",
             to_text({{"ready", true},
                      {"file", log_.string()},
                      {"first_utime", session.first_us()},
                      {"duration_s", seconds(session.last_us() - session.first_us())},
                      {"position_s", seconds(position_us_ - session.first_us())},
                      {"playing", playing_},
                      {"speed", speed_},
                      {"closures_s", closures},
                      {"damage", session.damage()}}));
}

void Player::work() {
  try {
    tell_loading(0.0);
    SessionReplay session(log_, [this](double fraction) {
      tell_loading(fraction);
      const std::lock_guard<std::mutex> lock(mutex_);
      return !stopping_;
    });
    if (session.events() > 0) play(session);
  } catch (const std::exception& error) {
    std::cerr << "viewer: " << error.what() << std::endl;
    state_.notice("error", error.what());
    store_.put(Topic::kTime, "player",
               to_text({{"ready", false}, {"file", log_.string()}, {"problem", error.what()}}));
    const std::lock_guard<std::mutex> lock(mutex_);
    failed_ = true;
  }
}

void Player::play(SessionReplay& session) {
  position_us_ = session.last_us();
  state_.begin_at(session.first_us());
  session.go_to(position_us_, state_);
  state_.tick();
  auto last = Clock::now();
  auto last_tick = last;
  for (;;) {
    tell(session);
    std::int64_t target_us = position_us_;
    {
      std::unique_lock<std::mutex> lock(mutex_);
      const auto asked = [this] { return stopping_ || seek_s_.has_value(); };
      if (playing_)
        changed_.wait_for(lock, kStep, asked);
      else
        changed_.wait_for(lock, kTickPeriod, [&] { return asked() || playing_; });
      if (stopping_) return;
      const auto now = Clock::now();
      const double dt_s = std::chrono::duration<double>(now - last).count();
      last = now;
      if (seek_s_) {
        target_us = session.first_us() + static_cast<std::int64_t>(1e6 * *seek_s_);
        seek_s_.reset();
      } else if (playing_) {
        if (position_us_ >= session.last_us()) target_us = session.first_us();  // play again
        // After a pause or a long seek time goes on from here.
        target_us += static_cast<std::int64_t>(1e6 * std::min(dt_s, 0.25) * speed_);
        if (target_us >= session.last_us()) playing_ = false;
      }
    }
    target_us = std::clamp(target_us, session.first_us(), session.last_us());
    const bool moved = target_us != position_us_;
    const bool jumped = target_us < position_us_ || target_us > position_us_ + 2'000'000;
    if (moved) session.go_to(target_us, state_);
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      position_us_ = target_us;
    }
    if (jumped || Clock::now() - last_tick > kTickPeriod) {
      state_.tick();
      last_tick = Clock::now();
    }
  }
}

}  // namespace fusion_slam
