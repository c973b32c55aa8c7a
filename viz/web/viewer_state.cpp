#include "viz/web/viewer_state.hpp"

#include <algorithm>
#include <cmath>

#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"
#include "viz/web/protocol.hpp"

namespace fusion_slam {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostHalfKeyframes = 8;
constexpr std::int64_t kMostNotices = 20;

// The colour image of a frame when a browser can show it as it is.
const bot_core::image_t* colour_of(const bot_core::images_t& message) {
  for (std::size_t i = 0; i < message.images.size() && i < message.image_types.size(); ++i)
    if (message.image_types[i] == bot_core::images_t::LEFT &&
        message.images[i].pixelformat == bot_core::image_t::PIXEL_FORMAT_MJPEG)
      return &message.images[i];
  return nullptr;
}

std::string_view view(const std::vector<std::uint8_t>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

ViewerState::ViewerState(ItemStore& store, Clock clock)
    : store_(store),
      clock_(std::move(clock)),
      graph_(store),
      health_(store),
      truth_(store),
      session_(std::make_unique<SessionCollector>()) {}

void ViewerState::note_sensor(const std::string& channel, std::int64_t utime_us,
                              std::size_t size_bytes) {
  if (first_us_ == 0) first_us_ = utime_us;
  newest_us_ = std::max(newest_us_, utime_us);
  health_.on_input(channel, utime_us, size_bytes, now_us());
}

// f64 utime (us), then the JPEG.
void ViewerState::on(const std::string& channel, const bot_core::images_t& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  note_sensor(channel, message.utime, static_cast<std::size_t>(message.getEncodedSize()));
  session_->on_camera(message);
  if (message.utime >= camera_us_ && message.utime < camera_us_ + kCameraPeriod_us) return;
  const bot_core::image_t* colour = colour_of(message);
  if (colour == nullptr) return;
  camera_us_ = message.utime;
  ByteWriter out;
  out.f64(static_cast<double>(message.utime)).bytes(view(colour->data));
  store_.put(Topic::kCamera, "", out.take());
}

// f64 utime (us), pose T_map_base of that time, then n times f32 x, y, z of end points in base.
void ViewerState::on(const std::string& channel, const bot_core::planar_lidar_t& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  note_sensor(channel, message.utime, static_cast<std::size_t>(message.getEncodedSize()));
  session_->on_lidar(message);
  std::string why;
  const auto scan = from_message(message, &why);
  if (!scan || !robot_) return;
  ByteWriter out;
  out.f64(static_cast<double>(message.utime)).pose(T_map_base_);
  for (std::size_t i = 0; i < scan->ranges_m.size(); ++i) {
    const double range_m = scan->ranges_m[i];
    if (!(range_m >= robot_->lidar.range_min_m && range_m <= robot_->lidar.range_max_m)) continue;
    const double angle_rad = scan->rad0 + static_cast<double>(i) * scan->radstep;
    const Eigen::Vector3d p =
        robot_->T_base_lidar *
        Eigen::Vector3d(range_m * std::cos(angle_rad), range_m * std::sin(angle_rad), 0.0);
    out.f32(p.x()).f32(p.y()).f32(p.z());
  }
  store_.put(Topic::kScan, "", out.take());
}

void ViewerState::on(const std::string& channel, const bot_core::pose_t& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto T = from_message(message);
  if (!T) return;
  const bool truth = channel == "GROUND_TRUTH";
  if (truth) {
    session_->on_ground_truth(message);
    const SE3 T_base_reference = robot_ ? robot_->T_base_reference() : SE3::Identity();
    truth_.on_truth(message.utime, *T * T_base_reference.inverse());
    newest_us_ = std::max(newest_us_, message.utime);
    // A recording without services has no other pose to show.
    if (const auto newest = truth_.newest(); newest && !has_pose_)
      put_pose("truth", message.utime, *newest, pose_estimate_t::OK, "", 0.0);
    return;
  }
  note_sensor(channel, message.utime, static_cast<std::size_t>(message.getEncodedSize()));
}

void ViewerState::on(const std::string&, const camera_model_t& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  session_->on_camera_model(message);
}

void ViewerState::on(const std::string&, const robot_model_t& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  session_->on_robot_model(message);
  std::string why;
  const auto robot = from_message(message, &why);
  if (!robot) return;
  robot_ = robot;
  const auto& T = robot->T_base_camera;
  const Eigen::Quaterniond q(T.linear());
  const Eigen::Vector3d lidar = robot->T_base_lidar.translation();
  store_.put(Topic::kRobot, "",
             to_text({{"name", robot->name},
                      {"has_lidar", robot->has_lidar},
                      {"has_camera", robot->has_camera},
                      {"has_odometry", robot->has_odometry},
                      {"planar", robot->planar},
                      {"resolution_m", robot->map_resolution_m},
                      {"height_m", robot->robot_height_m},
                      {"lidar", {lidar.x(), lidar.y(), lidar.z()}},
                      {"camera",
                       {T.translation().x(), T.translation().y(), T.translation().z(), q.w(), q.x(),
                        q.y(), q.z()}}}));
}

void ViewerState::on(const std::string& channel, const pose_estimate_t& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (channel == "VISUAL_POSE") return session_->on_visual_pose(message);
  if (channel == "LIDAR_POSE") return session_->on_lidar_pose(message);
  if (channel == "LOCALIZATION") return put_localization(message);
  if (!reset_.passes(message.utime)) return;
  session_->on_pose(message);
  const auto T_map_base = from_message(message.T_frame_base);
  if (!T_map_base) return;
  has_pose_ = true;
  T_map_base_ = *T_map_base;
  const double step_m = (T_map_base_.translation() - T_map_path_.translation()).norm();
  if (step_m > 0.05) {  // below that a standing robot's noise would add up
    if (step_m < 1.0 && path_m_ >= 0.0) path_m_ += step_m;
    T_map_path_ = T_map_base_;
  }
  const double sigma_m = std::sqrt(std::max(0.0, message.covariance[0] + message.covariance[7]));
  put_pose("slam", message.utime, *T_map_base, message.state, message.reason, sigma_m);
}

// Where the robot is in a saved map, and how that is known; the localizer says it.
void ViewerState::put_localization(const pose_estimate_t& message) {
  const auto T_map_base = from_message(message.T_frame_base);
  const bool somewhere =
      message.state == pose_estimate_t::OK || message.state == pose_estimate_t::WEAK;
  const char* const state = message.state == pose_estimate_t::OK     ? "localized"
                            : message.state == pose_estimate_t::WEAK ? "candidate"
                                                                     : "unknown";
  // "LOCALIZED: why" on the wire.
  const std::size_t colon = message.reason.find(": ");
  Json json = {
      {"utime", message.utime},
      {"state", state},
      {"reason", colon == std::string::npos ? message.reason : message.reason.substr(colon + 2)},
      {"fix_utime", message.fix_utime},
      {"score_percent", message.n_matched}};
  if (somewhere && T_map_base) {
    const Eigen::Vector3d t = T_map_base->translation();
    const Eigen::Matrix3d R = T_map_base->linear();
    json["t"] = {t.x(), t.y(), t.z()};
    json["yaw"] = std::atan2(R(1, 0), R(0, 0));
    json["sigma_m"] = std::sqrt(std::max(0.0, message.covariance[0] + message.covariance[7]));
  }
  store_.put(Topic::kPose, "localization", to_text(json));
}

void ViewerState::put_pose(const std::string& source, std::int64_t utime_us, const SE3& T_map_base,
                           int state, const std::string& reason, double sigma_m) {
  T_map_base_ = T_map_base;
  const Eigen::Quaterniond q(T_map_base.linear());
  const Eigen::Vector3d t = T_map_base.translation();
  const char* const names[] = {"unknown", "ok", "weak", "lost"};
  store_.put(Topic::kPose, "",
             to_text({{"utime", utime_us},
                      {"source", source},
                      {"state", names[state >= 0 && state <= 3 ? state : 0]},
                      {"reason", reason},
                      {"t", {t.x(), t.y(), t.z()}},
                      {"q", {q.w(), q.x(), q.y(), q.z()}},
                      {"sigma_m", sigma_m}}));
}

// n times f32 u, v (px), f32 depth (m, 0: unknown), f32 1 when the feature is a point of the map.
void ViewerState::on(const std::string&, const keyframe_t& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!reset_.passes(message.utime)) return;
  graph_.on_keyframe(message);
  ByteWriter out;
  for (std::size_t i = 0; i < message.u_px.size(); ++i)
    out.f32(message.u_px[i])
        .f32(message.v_px[i])
        .f32(message.depth_m[i])
        .f32(message.landmark_id[i] > 0 ? 1.0 : 0.0);
  keyframes_[message.id].features = out.take();
  put_keyframe(message.id);
}

void ViewerState::on(const std::string&, const keyframe_image_t& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const bot_core::image_t* colour = colour_of(message.images);
  if (colour == nullptr) return;
  KeyframeParts& parts = keyframes_[message.id];
  parts.jpeg = view(colour->data);
  parts.utime_us = message.utime;
  parts.width = colour->width;
  parts.height = colour->height;
  put_keyframe(message.id);
}

// f64 utime (us), u32 id, u32 width, u32 height (px), u32 n features, features, JPEG.
void ViewerState::put_keyframe(std::int64_t id) {
  const auto parts = keyframes_.find(id);
  if (!parts->second.jpeg.empty() && !parts->second.features.empty()) {
    const KeyframeParts& k = parts->second;
    ByteWriter out;
    out.f64(static_cast<double>(k.utime_us)).u32(static_cast<std::uint32_t>(id));
    out.u32(static_cast<std::uint32_t>(k.width)).u32(static_cast<std::uint32_t>(k.height));
    out.u32(static_cast<std::uint32_t>(k.features.size() / 16)).bytes(k.features).bytes(k.jpeg);
    store_.put(Topic::kKeyframe, "", out.take());
    keyframes_.erase(keyframes_.begin(), std::next(parts));
  }
  while (keyframes_.size() > kMostHalfKeyframes) keyframes_.erase(keyframes_.begin());
}

void ViewerState::on(const std::string&, const lidar_node_t& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (reset_.passes(message.utime)) graph_.on_lidar_node(message);
}

void ViewerState::on(const std::string&, const graph_t& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  session_->on_graph(message);
  graph_.on_graph(message);
  aligned_ = false;
}

void ViewerState::on(const std::string&, const loop_candidate_t& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (reset_.passes(message.utime)) graph_.on_candidate(message);
}

void ViewerState::on(const std::string& channel, const constraint_t& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (channel == "CONSTRAINT" && reset_.passes(message.utime)) graph_.on_constraint(message);
}

void ViewerState::on(const std::string&, const status_t& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  session_->on_status(message);
  health_.on_status(message, now_us());
}

void ViewerState::on(const std::string&, const procman_lcm::deputy_info_t& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  Json commands = Json::array();
  for (const procman_lcm::cmd_status_t& command : message.cmds)
    commands.push_back({{"name", command.cmd.command_id},
                        {"group", command.cmd.group},
                        {"pid", command.pid},
                        {"exit_code", command.exit_code},
                        {"cpu", command.cpu_usage},
                        {"memory_bytes", command.mem_rss_bytes}});
  for (const LabCommand& command : lab_.commands) {
    const bool known = std::any_of(message.cmds.begin(), message.cmds.end(), [&](const auto& one) {
      return one.cmd.command_id == command.spec.id;
    });
    if (known || command.deputy != message.deputy_id) continue;
    commands.push_back({{"name", command.spec.id},
                        {"group", command.spec.group},
                        {"pid", 0},
                        {"exit_code", 0},
                        {"cpu", 0.0},
                        {"memory_bytes", 0}});
  }
  store_.put(Topic::kDeputy, message.deputy_id,
             to_text({{"deputy", message.deputy_id},
                      {"cpu", message.cpu_load},
                      {"memory_total_bytes", message.phys_mem_total_bytes},
                      {"memory_free_bytes", message.phys_mem_free_bytes},
                      {"commands", commands}}));
}

// The robot, its sensors and the processes are what they were; the map and all that lies in it
// goes.
void ViewerState::on(const std::string&, const command_t& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!reset_.asks(message)) return;
  clear_map();
  auto session = std::make_unique<SessionCollector>();
  session->begin_like(*session_);
  session_ = std::move(session);
}

void ViewerState::on_tile(const std::string& channel, const Tile& tile) {
  static const std::map<std::string, Topic> kTopicOf{{"GRID_FUSED", Topic::kGridFused},
                                                     {"GRID_LIDAR", Topic::kGridLidar},
                                                     {"GRID_VISUAL", Topic::kGridVisual},
                                                     {"OCTOMAP", Topic::kOctomap},
                                                     {"CLOUD", Topic::kCloud}};
  const auto topic = kTopicOf.find(channel);
  if (topic == kTopicOf.end() || tile.key.submap_id != 0) return;
  const std::lock_guard<std::mutex> lock(mutex_);
  session_->on_tile(channel, tile);
  bool good = true;
  if (topic->second == Topic::kGridFused) good = grid_.on_tile(GridView::Layer::kFused, tile);
  if (topic->second == Topic::kGridLidar) good = grid_.on_tile(GridView::Layer::kLidar, tile);
  if (topic->second == Topic::kGridVisual) good = grid_.on_tile(GridView::Layer::kVisual, tile);
  const std::string key = std::to_string(tile.key.x) + "," + std::to_string(tile.key.y) + "," +
                          std::to_string(tile.key.z);
  if (!good)
    ++damaged_;
  else if (tile.encoding == TileEncoding::kEmpty)
    store_.remove(topic->second, key);
  else
    store_.put(topic->second, key, encode_tile(tile));
}

void ViewerState::tick() {
  const std::lock_guard<std::mutex> lock(mutex_);
  health_.tick(now_us());
  if (!aligned_) truth_.align(graph_.nodes());
  aligned_ = true;
  std::int64_t keyframes = 0;
  std::int64_t lidar_nodes = 0;
  for (const auto& [id, node] : graph_.nodes())
    ++(id.kind == NodeKind::kKeyframe ? keyframes : lidar_nodes);
  store_.put(Topic::kTime, "session",
             to_text({{"utime", newest_us_},
                      {"first_utime", begin_us_ != 0 ? begin_us_ : first_us_},
                      {"path_m", path_m_},
                      {"keyframes", keyframes},
                      {"lidar_nodes", lidar_nodes},
                      {"loops_closed", graph_.loops_closed()},
                      {"area_m2", grid_.known_area_m2()},
                      {"damaged_tiles", damaged_}}));
}

void ViewerState::set_lab(LabConfig lab) {
  const std::lock_guard<std::mutex> lock(mutex_);
  lab_ = std::move(lab);
}

void ViewerState::begin_at(std::int64_t utime_us) {
  const std::lock_guard<std::mutex> lock(mutex_);
  begin_us_ = utime_us;
}

void ViewerState::clear() {
  const std::lock_guard<std::mutex> lock(mutex_);
  store_.clear();
  clear_map();
  health_.clear();
  session_ = std::make_unique<SessionCollector>();
  robot_.reset();
  reset_ = ResetGate("viewer");
  newest_us_ = first_us_ = camera_us_ = 0;
  has_pose_ = false;
}

void ViewerState::clear_map() {
  for (const Topic topic : {Topic::kPose, Topic::kScan, Topic::kKeyframe, Topic::kGridFused,
                            Topic::kGridLidar, Topic::kGridVisual, Topic::kOctomap, Topic::kCloud})
    store_.remove_all(topic);
  graph_.clear();
  grid_.clear();
  truth_.clear();
  keyframes_.clear();
  T_map_base_ = T_map_path_ = SE3::Identity();
  aligned_ = true;
  path_m_ = 0.0;
}

void ViewerState::notice(const std::string& level, const std::string& text) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const std::int64_t number = ++notices_;
  store_.put(Topic::kNotice, std::to_string(number),
             to_text({{"number", number}, {"level", level}, {"text", text}}));
  if (number > kMostNotices) store_.remove(Topic::kNotice, std::to_string(number - kMostNotices));
}

SessionResult ViewerState::save(const std::filesystem::path& directory) const {
  std::unique_ptr<SessionCollector> copy;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    copy = std::make_unique<SessionCollector>(*session_);
  }
  return copy->write(directory);
}

std::string ViewerState::cell_json(double x_m, double y_m) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto cell = grid_.at(x_m, y_m);
  if (!cell) return R"({"known":false})";
  const auto or_null = [](const std::optional<double>& p) { return p ? Json(*p) : Json(); };
  const char* const sensors[] = {"none", "lidar", "camera", "both", "conflict"};
  return to_text({{"known", true},
                  {"cell", {cell->cell_x, cell->cell_y}},
                  {"resolution_m", cell->resolution_m},
                  {"fused", or_null(cell->fused)},
                  {"lidar", or_null(cell->lidar)},
                  {"visual", or_null(cell->visual)},
                  {"provenance", sensors[static_cast<int>(cell->provenance)]},
                  {"first_utime", cell->first_seen_us},
                  {"changed_utime", cell->last_changed_us},
                  {"changes", cell->changes}});
}

std::int64_t ViewerState::session_utime_us() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return newest_us_;
}

bool ViewerState::has_model() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return robot_.has_value();
}

}  // namespace fusion_slam
