#include <memory>
#include <string>

#include <CLI/CLI.hpp>

#include "libs/bus/process.hpp"
#include "services/localizer/localizer_process.hpp"

int main(int argc, char** argv) {
  std::string map;
  return fusion_slam::process_main(
      argc, argv, "localizer", "Says where the robot is in a saved map, which it only reads.",
      [&map](fusion_slam::Bus& bus) {
        return std::make_shared<fusion_slam::LocalizerProcess>(bus, map);
      },
      [&map](CLI::App& app) {
        app.add_option("--map", map, "the map's directory (`fusion-slam map save` makes one)")
            ->required();
      });
}
