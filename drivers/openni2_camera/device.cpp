#include "drivers/openni2_camera/device.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <tuple>
#include <vector>

namespace fusion_slam {
namespace {

// Best first.
const std::vector<std::pair<OniPixelFormat, PixelFormat>> kColourFormats = {
    {ONI_PIXEL_FORMAT_RGB888, PixelFormat::kRgb},
    {ONI_PIXEL_FORMAT_YUV422, PixelFormat::kUyvy},
    {ONI_PIXEL_FORMAT_YUYV, PixelFormat::kYuyv},
    {ONI_PIXEL_FORMAT_JPEG, PixelFormat::kJpeg},
    {ONI_PIXEL_FORMAT_GRAY8, PixelFormat::kGrey}};
const std::vector<std::pair<OniPixelFormat, PixelFormat>> kDepthFormats = {
    {ONI_PIXEL_FORMAT_DEPTH_1_MM, PixelFormat::kDepthMm},
    {ONI_PIXEL_FORMAT_DEPTH_100_UM, PixelFormat::kDepth100um}};

std::string text_of(const OniVideoMode& mode) {
  return std::to_string(mode.resolutionX) + " x " + std::to_string(mode.resolutionY) + " at " +
         std::to_string(mode.fps) + " Hz";
}

// The mode of a stream that fits best: exactly the wanted size (depth: else any of the same shape,
// when we register it ourselves), then the nearest rate, then the best format.
struct Choice {
  OniVideoMode mode{};
  PixelFormat format = PixelFormat::kRgb;
};
std::optional<Choice> choose(const OniSensorInfo& sensor, bool colour, const CameraModel& camera,
                             bool any_size) {
  using Cost = std::tuple<int, double, std::size_t>;
  std::optional<std::pair<Cost, Choice>> best;
  const auto& formats = colour ? kColourFormats : kDepthFormats;
  for (int i = 0; i < sensor.numSupportedVideoModes; ++i) {
    const OniVideoMode& mode = sensor.pSupportedVideoModes[i];
    const int size_off = std::abs(mode.resolutionX - camera.width_px) +
                         std::abs(mode.resolutionY - camera.height_px);
    const bool same_shape =
        mode.resolutionX * camera.height_px == mode.resolutionY * camera.width_px;
    if (size_off != 0 && !(any_size && same_shape)) continue;
    for (std::size_t f = 0; f < formats.size(); ++f) {
      if (formats[f].first != mode.pixelFormat) continue;
      const Cost cost{size_off, std::abs(mode.fps - camera.rate_hz), f};
      if (!best || cost < best->first) best = {cost, {mode, formats[f].second}};
    }
  }
  if (!best) return std::nullopt;
  return best->second;
}

std::string all_modes(const OniSensorInfo& sensor) {
  std::vector<std::string> seen;
  for (int i = 0; i < sensor.numSupportedVideoModes; ++i) {
    const std::string text = text_of(sensor.pSupportedVideoModes[i]);
    if (std::find(seen.begin(), seen.end(), text) == seen.end()) seen.push_back(text);
  }
  std::string list;
  for (const std::string& text : seen) list += (list.empty() ? "" : ", ") + text;
  return list;
}

}  // namespace

OpenniDevice::OpenniDevice(const OpenniRuntime& runtime, const CameraDriverConfig& config) {
  try {
    if (config.file.empty()) {
      const auto devices = runtime.devices();
      const std::string& wanted = config.connection.uri;
      const auto found = std::find_if(devices.begin(), devices.end(), [&](const auto& device) {
        return wanted.empty() || device.uri == wanted;
      });
      if (devices.empty()) throw CameraError(describe(devices));
      if (found == devices.end())
        throw CameraError("there is no device " + wanted + "; " + describe(devices));
      name_ = found->name + " (" + found->uri + ")";
      open(found->uri);
    } else {
      name_ = "recording " + config.file.string();
      open(config.file.string());
      const OniBool repeat = config.repeat ? TRUE : FALSE;
      oniDeviceSetProperty(device_, ONI_DEVICE_PROPERTY_PLAYBACK_REPEAT_ENABLED, &repeat,
                           sizeof repeat);
    }
    set_registration(config);
    set_up(false, config);
    if (config.connection.colour == "openni2") set_up(true, config);
    for (const Stream* stream : {&depth_, &colour_})
      if (stream->handle != nullptr && oniStreamStart(stream->handle) != ONI_STATUS_OK)
        throw CameraError(name_ + ": a stream does not start" + openni_reason());
  } catch (...) {
    close();
    throw;
  }
}

OpenniDevice::~OpenniDevice() { close(); }

void OpenniDevice::open(const std::string& uri) {
  if (oniDeviceOpen(uri.c_str(), &device_) != ONI_STATUS_OK) {
    device_ = nullptr;
    throw CameraError(name_ + " can't be opened" + openni_reason() +
                      ": is it in use by another program, may you use it (udev rule)?");
  }
}

void OpenniDevice::set_registration(const CameraDriverConfig& config) {
  const std::string& wanted = config.connection.registration;
  const bool can = oniDeviceIsImageRegistrationModeSupported(
                       device_, ONI_IMAGE_REGISTRATION_DEPTH_TO_COLOR) != FALSE;
  // A device registers to its own colour camera only.
  const bool own_colour = config.connection.colour == "openni2";
  registers_ = can && own_colour && (wanted == "auto" || wanted == "device");
  if (wanted == "device" && !registers_)
    throw CameraError(name_ +
                      " can't register depth to colour itself: set registration to auto or "
                      "own in the camera's file");
  const OniImageRegistrationMode mode =
      registers_ ? ONI_IMAGE_REGISTRATION_DEPTH_TO_COLOR : ONI_IMAGE_REGISTRATION_OFF;
  const OniStatus status =
      oniDeviceSetProperty(device_, ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION, &mode, sizeof mode);
  // A recording keeps the registration that it was made with.
  if (registers_ && status != ONI_STATUS_OK && config.file.empty())
    throw CameraError(name_ + " refuses to register depth to colour" + openni_reason());
}

void OpenniDevice::set_up(bool colour, const CameraDriverConfig& config) {
  Stream& stream = colour ? colour_ : depth_;
  const char* what = colour ? "colour" : "depth";
  const OniSensorType sensor = colour ? ONI_SENSOR_COLOR : ONI_SENSOR_DEPTH;
  const OniSensorInfo* info = oniDeviceGetSensorInfo(device_, sensor);
  if (info == nullptr || oniDeviceCreateStream(device_, sensor, &stream.handle) != ONI_STATUS_OK)
    throw CameraError(name_ + " has no " + what + " stream" +
                      (colour ? ": if its colour is a UVC camera, set 'colour: /dev/video0' in the "
                                "camera's file"
                              : ": it is no RGB-D camera"));
  const auto choice = choose(*info, colour, config.camera, !colour && !registers_);
  if (!choice)
    throw CameraError(name_ + " has no " + what + " mode of " +
                      std::to_string(config.camera.width_px) + " x " +
                      std::to_string(config.camera.height_px) +
                      " that we can read; it offers: " + all_modes(*info));
  stream.mode = choice->mode;
  stream.format = choice->format;
  if (config.file.empty() &&
      oniStreamSetProperty(stream.handle, ONI_STREAM_PROPERTY_VIDEO_MODE, &stream.mode,
                           sizeof stream.mode) != ONI_STATUS_OK)
    throw CameraError(name_ + " refuses " + what + " of " + text_of(stream.mode) + openni_reason());
  set_flag(stream, ONI_STREAM_PROPERTY_MIRRORING, false);
  if (!colour) return;
  set_flag(stream, ONI_STREAM_PROPERTY_AUTO_EXPOSURE, config.connection.auto_exposure);
  set_flag(stream, ONI_STREAM_PROPERTY_AUTO_WHITE_BALANCE, config.connection.auto_exposure);
}

void OpenniDevice::set_flag(const Stream& stream, int property, bool value) const {
  if (oniStreamIsPropertySupported(stream.handle, property) == FALSE) return;
  const OniBool flag = value ? TRUE : FALSE;
  oniStreamSetProperty(stream.handle, property, &flag, sizeof flag);
}

FieldOfView OpenniDevice::fov(const Stream& stream) const {
  if (stream.handle == nullptr) return {};
  float x = 0.0F;
  float y = 0.0F;
  int size = sizeof x;
  if (oniStreamGetProperty(stream.handle, ONI_STREAM_PROPERTY_HORIZONTAL_FOV, &x, &size) !=
          ONI_STATUS_OK ||
      oniStreamGetProperty(stream.handle, ONI_STREAM_PROPERTY_VERTICAL_FOV, &y, &size) !=
          ONI_STATUS_OK)
    return {};
  return {x, y};
}

std::optional<DeviceFrame> OpenniDevice::read(int wait_ms) {
  std::array<OniStreamHandle, 2> streams = {depth_.handle, colour_.handle};
  int which = -1;
  const int n = colour_.handle != nullptr ? 2 : 1;
  const OniStatus status = oniWaitForAnyStream(streams.data(), n, &which, wait_ms);
  if (status == ONI_STATUS_TIME_OUT) return std::nullopt;
  OniFrame* frame = nullptr;
  if (status != ONI_STATUS_OK || which < 0 || which >= n ||
      oniStreamReadFrame(streams.at(static_cast<std::size_t>(which)), &frame) != ONI_STATUS_OK)
    throw CameraError(name_ + ": its stream broke" + openni_reason());
  const Stream& stream = which == 1 ? colour_ : depth_;
  DeviceFrame out;
  out.colour = which == 1;
  out.device_us = static_cast<std::int64_t>(frame->timestamp);
  RawImage raw;
  raw.format = stream.format;
  raw.width_px = frame->width;
  raw.height_px = frame->height;
  raw.stride_bytes = frame->stride;
  raw.bytes = static_cast<const std::uint8_t*>(frame->data);
  raw.size_bytes = static_cast<std::size_t>(std::max(0, frame->dataSize));
  if (auto image = read_image(raw, {stream.mode.resolutionX, stream.mode.resolutionY}, &out.why))
    out.image = *image;
  oniFrameRelease(frame);
  return out;
}

std::string OpenniDevice::modes() const {
  std::string text;
  if (colour_.handle != nullptr) text = "colour " + text_of(colour_.mode) + ", ";
  return text + "depth " + text_of(depth_.mode) + (registers_ ? ", registered by the device" : "");
}

void OpenniDevice::close() {
  for (Stream* stream : {&colour_, &depth_}) {
    if (stream->handle == nullptr) continue;
    oniStreamStop(stream->handle);
    oniStreamDestroy(stream->handle);
    stream->handle = nullptr;
  }
  if (device_ != nullptr) oniDeviceClose(device_);
  device_ = nullptr;
}

}  // namespace fusion_slam
