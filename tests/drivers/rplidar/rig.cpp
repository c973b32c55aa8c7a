#include "tests/drivers/rplidar/rig.hpp"

#include <cstdlib>
#include <stdexcept>
#include <utility>

#include "tests/drivers/rplidar/turns.hpp"

namespace fusion_slam {

RplidarRig::RplidarRig(const std::string& model, VirtualWorld world, RplidarConfig config)
    : model_(model), world_(std::move(world)), config_(std::move(config)) {
  std::string name = (std::filesystem::temp_directory_path() / "rplidar-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot make " + name);
  folder_ = name;
  port_ = folder_ / "port";
}

RplidarRig::~RplidarRig() {
  stop();
  device_.reset();
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

void RplidarRig::plug_in() {
  VirtualRplidarOptions options;
  options.link = port_;
  options.model = model_;
  options.world = world_;
  device_ = std::make_unique<VirtualRplidar>(options);
}

void RplidarRig::start() {
  if (config_.port.empty()) config_.port = port_.string();
  RplidarEvents events;
  events.on_turn = [this](const Revolution& turn) {
    add({{}, "", false, wrong_beams(turn, world_), 1.0 / turn.period_s});
  };
  events.on_trouble = [this](const std::string& why, bool) { add({{}, why, false, 0, 0.0}); };
  events.on_well = [this](const std::string& what) { add({{}, what, true, 0, 0.0}); };
  driver_ = std::make_unique<RplidarDriver>(config_, events);
  stop_ = false;
  thread_ = std::thread([this] { driver_->run(stop_); });
}

void RplidarRig::stop() {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
}

void RplidarRig::add(Entry entry) {
  entry.when = std::chrono::steady_clock::now();
  const std::lock_guard<std::mutex> lock(mutex_);
  diary_.push_back(std::move(entry));
  changed_.notify_all();
}

RplidarRig::Diary RplidarRig::diary() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return diary_;
}

bool RplidarRig::wait(const std::function<bool(const Diary&)>& done) {
  std::unique_lock<std::mutex> lock(mutex_);
  return changed_.wait_for(lock, std::chrono::seconds(20), [&] { return done(diary_); });
}

bool RplidarRig::wait_for_text(const std::string& part, std::size_t from) {
  return wait([&](const Diary& diary) {
    for (std::size_t i = from; i < diary.size(); ++i)
      if (diary[i].text.find(part) != std::string::npos) return true;
    return false;
  });
}

bool RplidarRig::wait_for_turns(int n, std::size_t from) {
  return wait([&](const Diary& diary) {
    int turns = 0;
    for (std::size_t i = from; i < diary.size(); ++i) turns += diary[i].text.empty() ? 1 : 0;
    return turns >= n;
  });
}

}  // namespace fusion_slam
