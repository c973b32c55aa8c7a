// render_sheet: pictures of a world for people to look at. Colour above, depth below, for some
// moments of its route; and how much there is for a feature detector, beside a real picture when
// one is given.
#include <algorithm>
#include <cstdio>
#include <exception>
#include <iostream>
#include <string>

#include <CLI/CLI.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "drivers/simulator/camera_renderer.hpp"
#include "drivers/simulator/drive.hpp"
#include "drivers/simulator/route.hpp"
#include "drivers/simulator/world.hpp"

namespace {

using namespace fusion_slam;

constexpr double kFarM = 8.0;  // white in the depth pictures

// What a camera makes of the light, without noise.
cv::Mat photo(const RenderedFrame& frame) {
  cv::Mat image;
  frame.colour_bgr.convertTo(image, CV_8UC3, 1.05);
  return image;
}

// Near is dark; nothing there, or too far for the sensor, is blue.
cv::Mat depth_picture(const RenderedFrame& frame) {
  cv::Mat grey, image;
  frame.depth_m.convertTo(grey, CV_8U, 255.0 / kFarM);
  cv::cvtColor(grey, image, cv::COLOR_GRAY2BGR);
  image.setTo(cv::Scalar(120, 40, 0), frame.depth_m <= 0.0F);
  image.setTo(cv::Scalar(120, 40, 0), frame.depth_m > kFarM);
  return image;
}

void print_statistics(const std::string& name, const cv::Mat& image) {
  cv::Mat grey, laplacian;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  cv::Laplacian(grey, laplacian, CV_64F);
  cv::Scalar mean, deviation, unused, sharpness;
  cv::meanStdDev(grey, mean, deviation);
  cv::meanStdDev(laplacian, unused, sharpness);
  std::vector<cv::KeyPoint> fast20, fast7, orb;
  cv::FAST(grey, fast20, 20);
  cv::FAST(grey, fast7, 7);
  cv::ORB::create(100000, 1.2F, 8, 31, 0, 2, cv::ORB::FAST_SCORE, 31, 20)->detect(grey, orb);
  std::printf(
      "%-28s grey %5.1f +- %4.1f  Laplacian sigma %5.1f  FAST(20) %5zu  FAST(7) %6zu  ORB(20) "
      "%5zu\n",
      name.c_str(), mean[0], deviation[0], sharpness[0], fast20.size(), fast7.size(), orb.size());
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Renders moments of a route into one picture", "render_sheet");
  std::string world_file, route_file, out, real;
  int n = 4, width = 480;
  double noise = 2.5;
  app.add_option("WORLD", world_file, "world file")->required();
  app.add_option("--route", route_file, "route file, for worlds without a route");
  app.add_option("--out", out, "the PNG or JPG to write")->required();
  app.add_option("--frames", n, "how many moments, evenly over the first lap")
      ->check(CLI::Range(1, 64));
  app.add_option("--width", width, "of each picture")->check(CLI::Range(64, 640));
  app.add_option("--noise", noise, "grey values of noise for the statistics")
      ->capture_default_str();
  app.add_option("--real", real, "a photograph to compare with");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    World world = load_world(world_file);
    for (const std::string& warning : world.warnings) std::cerr << warning << "\n";
    RouteCamera mount;
    double seconds = 0.0;
    if (!route_file.empty()) {
      const Route route = load_route(route_file);
      world.route_m = route.way_points_m;
      world.limits = route.limits;
      if (route.camera) mount = *route.camera;
      seconds = route.seconds.value_or(0.0);
    }
    const Drive drive(world.route_m, world.limits, seconds > 0.0 ? seconds : 600.0);
    if (!(seconds > 0.0)) seconds = drive.lap_s() > 0.0 ? drive.lap_s() : 600.0;
    const Scene scene(world.boxes, world.meshes);
    CameraModel camera;
    camera.fx_px = mount.fx_px;
    camera.fy_px = mount.fy_px;
    const CameraRenderer renderer(scene, world.lighting, camera);
    SE3 T_base_camera = from_xyz_rpy(mount.x_m, 0.0, mount.z_m, 0.0, mount.pitch_rad, 0.0);
    T_base_camera.linear() = T_base_camera.linear() * optical_to_body();

    std::size_t triangles = 0;
    for (const Mesh& mesh : world.meshes) triangles += mesh.triangles.size();
    std::printf("%s: %zu boxes, %zu meshes, %zu triangles, %.1f s\n", world_file.c_str(),
                world.boxes.size(), world.meshes.size(), triangles, seconds);
    const int height = width * camera.height_px / camera.width_px;
    const int columns = std::min(n, 4), rows = 2 * ((n + columns - 1) / columns);
    cv::Mat sheet(rows * height, columns * width, CV_8UC3, cv::Scalar::all(0));
    cv::RNG random(1);
    if (!real.empty()) print_statistics("photograph", cv::imread(real));
    for (int i = 0; i < n; ++i) {
      const SE3 T_world_base = to_se3(drive.T_world_base(seconds * (i + 0.5) / n));
      const RenderedFrame frame = renderer.render(T_world_base * T_base_camera);
      cv::Mat image = photo(frame), depth = depth_picture(frame), small,
              grain(image.size(), CV_16SC3);
      const cv::Rect place(i % columns * width, i / columns * 2 * height, width, height);
      cv::resize(image, small, {width, height}, 0, 0, cv::INTER_AREA);
      small.copyTo(sheet(place));
      cv::resize(depth, small, {width, height}, 0, 0, cv::INTER_NEAREST);
      small.copyTo(sheet(place + cv::Point(0, height)));
      random.fill(grain, cv::RNG::NORMAL, 0.0, noise);
      cv::add(image, grain, image, cv::noArray(), CV_8UC3);
      print_statistics("frame at " + std::to_string(seconds * (i + 0.5) / n) + " s", image);
    }
    if (!cv::imwrite(out, sheet)) throw std::runtime_error(out + " cannot be written");
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "render_sheet: " << error.what() << "\n";
    return 1;
  }
}
