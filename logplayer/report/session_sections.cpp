#include "logplayer/report/session_sections.hpp"

#include <cmath>

#include "libs/evaluation/association.hpp"
#include "libs/report/chart.hpp"
#include "libs/report/top_view.hpp"
#include "logplayer/loops/read_session.hpp"

namespace fusion_slam {
namespace {

constexpr double kNear_s = 0.25;  // a node without a pose that near is not drawn

std::string figure(const std::string& svg) { return "<figure>" + svg + "</figure>\n"; }

std::string chart(const SessionHistory& history, const std::string& title,
                  const std::string& y_label, double (*value)(const HealthPoint&)) {
  LineChart chart{title, "wall clock, s", y_label, {}, false};
  for (const auto& [process, points] : history.health) {
    Series series{process, {}};
    for (const HealthPoint& point : points) series.points.emplace_back(point.time_s, value(point));
    chart.series.push_back(std::move(series));
  }
  return figure(line_chart_svg(chart));
}

std::optional<Eigen::Vector2d> place_of(const NodeId& node, const SessionHistory& history,
                                        const Trajectory& way) {
  const auto utime = history.node_utime_us.find(node);
  if (utime == history.node_utime_us.end() || way.empty()) return std::nullopt;
  const double time_s = 1e-6 * static_cast<double>(utime->second);
  const StampedPose& pose = way[nearest_in_time(way, time_s)];
  if (std::fabs(pose.time_s - time_s) > kNear_s) return std::nullopt;
  return pose.T_world_body.translation().head<2>();
}

std::string name_of(const NodeId& id) {
  return (id.kind == NodeKind::kLidar ? "scan " : "keyframe ") + std::to_string(id.id);
}

std::string pose_text(const SE3& T) {
  const Eigen::Vector3d p = T.translation();
  const Eigen::Vector3d turn = log_so3(T.linear()) * 180.0 / M_PI;
  return number(p.x(), 3) + ", " + number(p.y(), 3) + ", " + number(p.z(), 3) + " m; turned " +
         number(turn.x(), 1) + ", " + number(turn.y(), 1) + ", " + number(turn.z(), 1) + " deg";
}

}  // namespace

Section process_section(const SessionHistory& history) {
  HtmlTable table{{"process", "latency p95, ms", "peak memory", "processor time, s"}, {}};
  for (const auto& [process, points] : history.health)
    table.rows.push_back({process, number(points.back().latency_ms_p95, 1),
                          bytes_text(points.back().peak_rss_bytes),
                          number(points.back().cpu_s, 1)});
  const std::string charts =
      chart(history, "Latency, 95th percentile", "ms",
            [](const HealthPoint& p) { return p.latency_ms_p95; }) +
      chart(history, "Peak memory", "MB",
            [](const HealthPoint& p) { return 1e-6 * p.peak_rss_bytes; }) +
      chart(history, "Processor time", "s", [](const HealthPoint& p) { return p.cpu_s; }) +
      chart(history, "Messages waiting", "messages", [](const HealthPoint& p) { return p.queue; });
  return {"Processes",
          "From each process's STATUS. Latency is from a message's arrival to the end of its "
          "handling; in lockstep messages wait for nobody, in a throughput run they may queue.",
          table_html(table) + "<div class=\"figures\">" + charts + "</div>\n"};
}

Section loop_section(const std::filesystem::path& session, const SessionHistory& history,
                     const Trajectory& way) {
  TopView view{"Closures", std::nullopt, {{"way", "plain", {}, {}}}, {}, 0.0};
  for (const StampedPose& pose : way)
    view.ways.front().points_m.emplace_back(pose.T_world_body.translation().head<2>());
  std::size_t off = 0;
  for (const ClosedLoop& loop : history.loops) {
    off += loop.switched_off ? 1U : 0U;
    const auto from = place_of(loop.from, history, way), to = place_of(loop.to, history, way);
    if (from && to)
      view.links.push_back({*from, *to, loop.switched_off ? "off" : "closure",
                            name_of(loop.from) + " - " + name_of(loop.to) + ", " + loop.source +
                                (loop.switched_off ? ", switched off: " + loop.reason : "")});
  }
  std::string text;
  try {
    text = read_session(session).text({});
  } catch (const std::exception& error) {
    text = error.what();
  }
  return {"Loops",
          std::to_string(history.loops.size()) + " closures, " + std::to_string(off) +
              " of them switched off again by the pose graph (dashed). Point at one to see which.",
          figure(top_view_svg(view)) + "<details><summary>what became of each idea</summary><pre>" +
              escape_html(text) + "</pre></details>\n"};
}

Section settings_section(const SessionHistory& history) {
  HtmlTable table{{"setting", "value"}, {}};
  if (history.robot) {
    const RobotModel& r = *history.robot;
    table.rows.push_back({"robot", r.name});
    table.rows.push_back({"moves", r.planar ? "on a flat floor" : "freely (6 degrees)"});
    table.rows.push_back({"map resolution, m", number(r.map_resolution_m, 3)});
    table.rows.push_back({"robot height, m", number(r.robot_height_m, 2)});
    table.rows.push_back({"floor clearance, m", number(r.floor_clearance_m, 2)});
    if (r.has_lidar) {
      table.rows.push_back({"LiDAR on base", pose_text(r.T_base_lidar)});
      table.rows.push_back({"LiDAR range, m", number(r.lidar.range_min_m, 2) + " - " +
                                                  number(r.lidar.range_max_m, 1)});
      table.rows.push_back({"LiDAR rate, Hz", number(r.lidar.rate_hz, 1)});
    }
    if (r.has_camera) table.rows.push_back({"camera on base", pose_text(r.T_base_camera)});
    table.rows.push_back({"wheel odometry", r.has_odometry ? "yes" : "no"});
  }
  if (history.camera) {
    const CameraModel& c = *history.camera;
    table.rows.push_back(
        {"image, pixels", std::to_string(c.width_px) + " x " + std::to_string(c.height_px)});
    table.rows.push_back({"fx, fy, cx, cy, pixels", number(c.fx_px, 1) + ", " + number(c.fy_px, 1) +
                                                        ", " + number(c.cx_px, 1) + ", " +
                                                        number(c.cy_px, 1)});
    table.rows.push_back({"depth, m", number(c.depth_min_m, 2) + " - " + number(c.depth_max_m, 1)});
    table.rows.push_back({"camera rate, Hz", number(c.rate_hz, 1)});
  }
  return {"Settings", "As the recording's ROBOT_MODEL and CAMERA_MODEL say.", table_html(table)};
}

}  // namespace fusion_slam
