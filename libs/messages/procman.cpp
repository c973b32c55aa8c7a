#include "libs/messages/procman.hpp"

namespace fusion_slam {
namespace {

procman_lcm::cmd_t to_message(const CommandSpec& spec) {
  procman_lcm::cmd_t message{};
  message.command_id = spec.id;
  message.exec_str = spec.exec;
  message.group = spec.group;
  message.auto_respawn = spec.auto_respawn ? 1 : 0;
  message.stop_signal = static_cast<std::int8_t>(spec.stop_signal);
  message.stop_time_allowed = static_cast<float>(spec.stop_time_allowed_s);
  return message;
}

CommandSpec from_message(const procman_lcm::cmd_t& message) {
  CommandSpec spec;
  spec.id = message.command_id;
  spec.exec = message.exec_str;
  spec.group = message.group;
  spec.auto_respawn = message.auto_respawn != 0;
  const int stop_signal{message.stop_signal};
  if (stop_signal >= 1 && stop_signal <= 64) spec.stop_signal = stop_signal;
  if (message.stop_time_allowed >= 0.0F && message.stop_time_allowed <= 3600.0F)
    spec.stop_time_allowed_s = static_cast<double>(message.stop_time_allowed);
  return spec;
}

}  // namespace

procman_lcm::deputy_info_t to_message(const DeputyInfo& info) {
  procman_lcm::deputy_info_t message{};
  message.utime = info.utime_us;
  message.deputy_id = info.deputy;
  message.cpu_load = info.load.cpu_load;
  message.phys_mem_total_bytes = info.load.memory_total_bytes;
  message.phys_mem_free_bytes = info.load.memory_free_bytes;
  message.swap_total_bytes = info.load.swap_total_bytes;
  message.swap_free_bytes = info.load.swap_free_bytes;
  for (const CommandStatus& status : info.commands) {
    procman_lcm::cmd_status_t out{};
    out.cmd = to_message(status.spec);
    out.pid = status.pid;
    out.actual_runid = status.actual_runid;
    out.exit_code = status.exit_code;
    out.cpu_usage = status.cpu_usage;
    out.mem_vsize_bytes = status.vsize_bytes;
    out.mem_rss_bytes = status.rss_bytes;
    message.cmds.push_back(out);
  }
  message.ncmds = static_cast<std::int32_t>(message.cmds.size());
  return message;
}

DeputyInfo from_message(const procman_lcm::deputy_info_t& message) {
  DeputyInfo info;
  info.utime_us = message.utime;
  info.deputy = message.deputy_id;
  info.load = {message.cpu_load, message.phys_mem_total_bytes, message.phys_mem_free_bytes,
               message.swap_total_bytes, message.swap_free_bytes};
  for (const procman_lcm::cmd_status_t& in : message.cmds)
    info.commands.push_back({from_message(in.cmd), in.pid, in.actual_runid, in.exit_code,
                             in.cpu_usage, in.mem_vsize_bytes, in.mem_rss_bytes});
  return info;
}

procman_lcm::orders_t to_message(const Orders& orders) {
  procman_lcm::orders_t message{};
  message.utime = orders.utime_us;
  message.deputy_id = orders.deputy;
  message.sheriff_id = orders.sheriff;
  for (const DesiredCommand& desired : orders.commands) {
    procman_lcm::cmd_desired_t out{};
    out.cmd = to_message(desired.spec);
    out.desired_runid = desired.desired_runid;
    out.force_quit = desired.force_quit ? 1 : 0;
    message.cmds.push_back(out);
  }
  message.ncmds = static_cast<std::int32_t>(message.cmds.size());
  return message;
}

Orders from_message(const procman_lcm::orders_t& message) {
  Orders orders;
  orders.utime_us = message.utime;
  orders.deputy = message.deputy_id;
  orders.sheriff = message.sheriff_id;
  for (const procman_lcm::cmd_desired_t& in : message.cmds)
    orders.commands.push_back({from_message(in.cmd), in.desired_runid, in.force_quit != 0});
  return orders;
}

}  // namespace fusion_slam
