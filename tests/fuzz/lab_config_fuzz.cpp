// link: fs_procman
// Any text as a lab configuration: refused with a place and a reason, or taken, and then written
// and read again it is the same; its commands as exec lines: split, or refused with a reason.
#include <cstdint>
#include <cstdlib>
#include <string>

#include "libs/procman/exec_line.hpp"
#include "libs/procman/lab_config.hpp"

namespace {

void require(bool ok) {
  if (!ok) std::abort();
}

void try_exec(const std::string& exec) {
  std::string why;
  const auto line = fusion_slam::parse_exec_line(
      exec, [](const std::string&) { return std::string("$X 'a"); }, &why);
  require(line ? !line->argv.empty() : !why.empty());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  try_exec(text);
  try {
    const fusion_slam::LabConfig config = fusion_slam::parse_lab_config(text, "fuzz");
    for (const auto& command : config.commands) try_exec(command.spec.exec);
    const std::string written = fusion_slam::to_text(config);
    require(fusion_slam::to_text(fusion_slam::parse_lab_config(written, "again")) == written);
  } catch (const fusion_slam::LabConfigError& error) {
    require(std::string(error.what()).rfind("fuzz", 0) == 0);
  }
  return 0;
}
