// A driver plug-in for the OpenNI2 runtime: one camera, whose frames, clock and faults come from a
// FeedWriter. The runtime loads it from OpenNI2/Drivers beside its library.
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <utility>

#include <Driver/OniDriverAPI.h>
#include <fcntl.h>
#include <opencv2/core.hpp>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/support/virtual_openni2/feed.hpp"

namespace fusion_slam {
namespace {

constexpr auto kLook = std::chrono::milliseconds(1);
constexpr const char* kUri = "fusion-slam-virtual";

void copy_text(char* to, const char* text) { std::strncpy(to, text, ONI_MAX_STR - 1); }

OniDeviceInfo device_info() {
  OniDeviceInfo info{};
  copy_text(info.uri, kUri);
  copy_text(info.vendor, "Fusion-SLAM");
  copy_text(info.name, "virtual RGB-D camera");
  return info;
}

template <class T>
OniStatus give(T value, void* data, int* size) {
  if (*size != static_cast<int>(sizeof(T))) return ONI_STATUS_BAD_PARAMETER;
  std::memcpy(data, &value, sizeof(T));
  return ONI_STATUS_OK;
}

// The mapped feed; none while the file isn't there.
class Feed {
 public:
  explicit Feed(const std::string& path) {
    const int file = open(path.c_str(), O_RDWR | O_CLOEXEC);
    if (file < 0) return;
    struct stat status {};
    if (fstat(file, &status) == 0 && status.st_size > static_cast<off_t>(sizeof(FeedHeader))) {
      size_ = static_cast<std::size_t>(status.st_size);
      memory_ = mmap(nullptr, size_, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    }
    inode_ = status.st_ino;
    close(file);
  }
  ~Feed() {
    if (memory_ != MAP_FAILED) munmap(memory_, size_);
  }
  Feed(const Feed&) = delete;
  Feed& operator=(const Feed&) = delete;

  bool good() const {
    return memory_ != MAP_FAILED && header().magic == kFeedMagic &&
           size_ >= feed_bytes(header().width_px, header().height_px);
  }
  FeedHeader& header() const { return *static_cast<FeedHeader*>(memory_); }
  CameraFault fault() const { return static_cast<CameraFault>(header().fault.load()); }
  ino_t inode() const { return inode_; }
  const std::uint8_t* slot(std::uint64_t number) const {
    return static_cast<const std::uint8_t*>(memory_) + sizeof(FeedHeader) +
           (number % kFeedSlots) * slot_bytes(header().width_px, header().height_px);
  }

 private:
  void* memory_ = MAP_FAILED;
  std::size_t size_ = 0;
  ino_t inode_ = 0;
};

class VirtualDevice;

class VirtualStream : public oni::driver::StreamBase {
 public:
  VirtualStream(VirtualDevice& device, OniSensorType sensor) : device_(device), sensor_(sensor) {}
  OniStatus start() override { return running_ = true, ONI_STATUS_OK; }
  void stop() override { running_ = false; }
  OniBool isPropertySupported(int id) override;
  OniStatus getProperty(int id, void* data, int* size) override;
  OniStatus setProperty(int id, const void* data, int size) override;
  void notifyAllProperties() override;
  void send(const std::uint8_t* slot, std::uint64_t number, std::uint64_t clock_base_us);
  OniVideoMode mode() const;

 private:
  bool colour() const { return sensor_ == ONI_SENSOR_COLOR; }

  VirtualDevice& device_;
  OniSensorType sensor_;
  std::atomic<bool> running_{false};
  std::atomic<bool> mirrored_{true};  // as many devices have it
  std::atomic<bool> auto_exposure_{true};
};

class VirtualDevice : public oni::driver::DeviceBase {
 public:
  explicit VirtualDevice(const std::string& path) : feed_(path) {
    if (!feed_.good()) return;
    for (int i = 0; i < 2; ++i) {
      modes_[i] = {i == 0 ? ONI_PIXEL_FORMAT_RGB888 : ONI_PIXEL_FORMAT_DEPTH_1_MM,
                   feed_.header().width_px, feed_.header().height_px, feed_.header().rate_hz};
      sensors_[i] = {i == 0 ? ONI_SENSOR_COLOR : ONI_SENSOR_DEPTH, 1, &modes_[i]};
    }
    ++feed_.header().opened;
    thread_ = std::thread([this] { run(); });
  }
  ~VirtualDevice() override {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }
  bool good() const { return feed_.good(); }
  Feed& feed() { return feed_; }
  bool registered() const { return registered_; }
  const OniVideoMode& mode(bool colour) const { return modes_[colour ? 0 : 1]; }

  OniStatus getSensorInfoList(OniSensorInfo** infos, int* n) override {
    *infos = sensors_;
    *n = 2;
    return ONI_STATUS_OK;
  }
  oni::driver::StreamBase* createStream(OniSensorType sensor) override {
    if (sensor != ONI_SENSOR_COLOR && sensor != ONI_SENSOR_DEPTH) return nullptr;
    const std::lock_guard<std::mutex> lock(mutex_);
    return *streams_.insert(new VirtualStream(*this, sensor)).first;
  }
  void destroyStream(oni::driver::StreamBase* stream) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    streams_.erase(static_cast<VirtualStream*>(stream));
    delete stream;
  }
  OniBool isImageRegistrationModeSupported(OniImageRegistrationMode mode) override {
    return mode == ONI_IMAGE_REGISTRATION_OFF || feed_.header().can_register != 0 ? TRUE : FALSE;
  }
  OniBool isPropertySupported(int id) override {
    return id == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION ? TRUE : FALSE;
  }
  OniStatus getProperty(int id, void* data, int* size) override {
    if (id != ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION) return ONI_STATUS_NOT_SUPPORTED;
    return give(registered_ ? ONI_IMAGE_REGISTRATION_DEPTH_TO_COLOR : ONI_IMAGE_REGISTRATION_OFF,
                data, size);
  }
  OniStatus setProperty(int id, const void* data, int size) override {
    OniImageRegistrationMode mode = ONI_IMAGE_REGISTRATION_OFF;
    if (id != ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION || size != static_cast<int>(sizeof mode))
      return ONI_STATUS_NOT_SUPPORTED;
    std::memcpy(&mode, data, sizeof mode);
    if (isImageRegistrationModeSupported(mode) == FALSE) return ONI_STATUS_NOT_SUPPORTED;
    registered_ = mode == ONI_IMAGE_REGISTRATION_DEPTH_TO_COLOR;
    feed_.header().registered = registered_ ? 1 : 0;
    return ONI_STATUS_OK;
  }

 private:
  void run() {
    std::uint64_t sent = feed_.header().written;
    while (!stop_) {
      std::this_thread::sleep_for(kLook);
      for (const std::uint64_t written = feed_.header().written; sent < written;) send(++sent);
    }
  }
  void send(std::uint64_t number) {
    const std::uint8_t* slot = feed_.slot(number);
    const auto* head = reinterpret_cast<const FeedSlot*>(slot);
    const CameraFault fault = feed_.fault();
    if (fault == CameraFault::kUnplug || fault == CameraFault::kStall) return;
    if (fault == CameraFault::kClockRestart && !restarted_) clock_base_us_ = head->colour_us;
    restarted_ = fault == CameraFault::kClockRestart;
    const std::lock_guard<std::mutex> lock(mutex_);
    for (VirtualStream* stream : streams_) stream->send(slot, number, clock_base_us_);
  }

  Feed feed_;
  OniVideoMode modes_[2] = {};
  OniSensorInfo sensors_[2] = {};
  std::atomic<bool> registered_{false};
  std::mutex mutex_;  // guards streams_
  std::set<VirtualStream*> streams_;
  bool restarted_ = false;
  std::uint64_t clock_base_us_ = 0;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

OniVideoMode VirtualStream::mode() const { return device_.mode(colour()); }

OniBool VirtualStream::isPropertySupported(int id) {
  switch (id) {
    case ONI_STREAM_PROPERTY_VIDEO_MODE:
    case ONI_STREAM_PROPERTY_HORIZONTAL_FOV:
    case ONI_STREAM_PROPERTY_VERTICAL_FOV:
    case ONI_STREAM_PROPERTY_MIRRORING:
    case ONI_STREAM_PROPERTY_MAX_VALUE:
    case ONI_STREAM_PROPERTY_MIN_VALUE:
    case ONI_STREAM_PROPERTY_STRIDE:
    case ONI_STREAM_PROPERTY_CROPPING:
      return TRUE;
    case ONI_STREAM_PROPERTY_AUTO_EXPOSURE:
    case ONI_STREAM_PROPERTY_AUTO_WHITE_BALANCE:
      return colour() ? TRUE : FALSE;
    default:
      return FALSE;
  }
}

OniStatus VirtualStream::getProperty(int id, void* data, int* size) {
  const FeedHeader& head = device_.feed().header();
  // With registration on, depth has the colour camera's field of view.
  const bool as_colour = colour() || device_.registered();
  switch (id) {
    case ONI_STREAM_PROPERTY_VIDEO_MODE:
      return give(mode(), data, size);
    case ONI_STREAM_PROPERTY_HORIZONTAL_FOV:
      return give(as_colour ? head.colour_fov_x_rad : head.depth_fov_x_rad, data, size);
    case ONI_STREAM_PROPERTY_VERTICAL_FOV:
      return give(as_colour ? head.colour_fov_y_rad : head.depth_fov_y_rad, data, size);
    case ONI_STREAM_PROPERTY_CROPPING:  // the player of recordings wants to be told
      return give(OniCropping{}, data, size);
    case ONI_STREAM_PROPERTY_MIRRORING:
      return give<OniBool>(mirrored_ ? TRUE : FALSE, data, size);
    case ONI_STREAM_PROPERTY_AUTO_EXPOSURE:
    case ONI_STREAM_PROPERTY_AUTO_WHITE_BALANCE:
      return give<OniBool>(auto_exposure_ ? TRUE : FALSE, data, size);
    case ONI_STREAM_PROPERTY_MAX_VALUE:
      return give<int>(colour() ? 255 : 10'000, data, size);
    case ONI_STREAM_PROPERTY_MIN_VALUE:
      return give<int>(0, data, size);
    case ONI_STREAM_PROPERTY_STRIDE:
      return give<int>(mode().resolutionX * (colour() ? 3 : 2), data, size);
    default:
      return ONI_STATUS_NOT_SUPPORTED;
  }
}

OniStatus VirtualStream::setProperty(int id, const void* data, int size) {
  FeedHeader& head = device_.feed().header();
  if (id == ONI_STREAM_PROPERTY_VIDEO_MODE) {
    OniVideoMode wanted{};
    if (size != static_cast<int>(sizeof wanted)) return ONI_STATUS_BAD_PARAMETER;
    std::memcpy(&wanted, data, sizeof wanted);
    const OniVideoMode have = mode();
    const bool same = wanted.resolutionX == have.resolutionX &&
                      wanted.resolutionY == have.resolutionY && wanted.fps == have.fps &&
                      wanted.pixelFormat == have.pixelFormat;
    return same ? ONI_STATUS_OK : ONI_STATUS_NOT_SUPPORTED;
  }
  OniBool value = FALSE;
  if (size != static_cast<int>(sizeof value)) return ONI_STATUS_BAD_PARAMETER;
  std::memcpy(&value, data, sizeof value);
  if (id == ONI_STREAM_PROPERTY_MIRRORING) {
    mirrored_ = value != FALSE;
    head.mirrored = mirrored_ ? 1 : 0;
  } else if (id == ONI_STREAM_PROPERTY_AUTO_EXPOSURE && colour()) {
    auto_exposure_ = value != FALSE;
    head.auto_exposure = auto_exposure_ ? 1 : 0;
  } else if (id != ONI_STREAM_PROPERTY_AUTO_WHITE_BALANCE || !colour()) {
    return ONI_STATUS_NOT_SUPPORTED;
  }
  return ONI_STATUS_OK;
}

// A recording keeps what is told here.
void VirtualStream::notifyAllProperties() {
  const std::pair<int, std::size_t> all[] = {{ONI_STREAM_PROPERTY_VIDEO_MODE, sizeof(OniVideoMode)},
                                             {ONI_STREAM_PROPERTY_HORIZONTAL_FOV, sizeof(float)},
                                             {ONI_STREAM_PROPERTY_VERTICAL_FOV, sizeof(float)},
                                             {ONI_STREAM_PROPERTY_MIRRORING, sizeof(OniBool)},
                                             {ONI_STREAM_PROPERTY_MAX_VALUE, sizeof(int)},
                                             {ONI_STREAM_PROPERTY_MIN_VALUE, sizeof(int)},
                                             {ONI_STREAM_PROPERTY_STRIDE, sizeof(int)},
                                             {ONI_STREAM_PROPERTY_CROPPING, sizeof(OniCropping)}};
  for (const auto& [id, bytes] : all) {
    char value[64];
    int size = static_cast<int>(bytes);
    if (getProperty(id, value, &size) == ONI_STATUS_OK) raisePropertyChanged(id, value, size);
  }
}

void VirtualStream::send(const std::uint8_t* slot, std::uint64_t number,
                         std::uint64_t clock_base_us) {
  if (!running_) return;
  const CameraFault fault = device_.feed().fault();
  if (fault == (colour() ? CameraFault::kStallColour : CameraFault::kStallDepth)) return;
  const auto* head = reinterpret_cast<const FeedSlot*>(slot);
  OniFrame* frame = getServices().acquireFrame();
  if (frame == nullptr) return;
  const OniVideoMode have = mode();
  const int pixel = colour() ? 3 : 2;
  const auto area =
      static_cast<std::size_t>(have.resolutionX) * static_cast<std::size_t>(have.resolutionY);
  const std::uint8_t* pixels =
      slot + sizeof(FeedSlot) + (colour() ? 0 : (device_.registered() ? 5 : 3) * area);
  frame->width = have.resolutionX;
  frame->height = have.resolutionY;
  frame->stride = have.resolutionX * pixel;
  frame->dataSize = frame->stride * frame->height;
  frame->videoMode = have;
  frame->croppingEnabled = FALSE;
  frame->cropOriginX = frame->cropOriginY = 0;
  frame->sensorType = sensor_;
  frame->frameIndex = static_cast<int>(number);
  frame->timestamp = (colour() ? head->colour_us : head->depth_us) - clock_base_us;
  auto* to = static_cast<std::uint8_t*>(frame->data);
  std::memcpy(to, pixels, static_cast<std::size_t>(frame->dataSize));
  if (mirrored_) {
    const cv::Mat image(frame->height, frame->width, colour() ? CV_8UC3 : CV_16UC1, to);
    cv::flip(image.clone(), image, 1);
  }
  if (fault == CameraFault::kCorrupt) frame->dataSize = frame->dataSize * 2 / 3;
  if (fault == CameraFault::kWrongSize) {
    frame->width /= 2;
    frame->stride /= 2;
    frame->dataSize /= 2;
  }
  if (head->number == number) raiseNewFrame(frame);  // not overwritten meanwhile
  getServices().releaseFrame(frame);
}

class VirtualDriver : public oni::driver::DriverBase {
 public:
  explicit VirtualDriver(OniDriverServices* services) : DriverBase(services) {
    if (const char* path = std::getenv(kFeedVariable)) path_ = path;
  }
  OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                       oni::driver::DeviceDisconnectedCallback disconnected,
                       oni::driver::DeviceStateChangedCallback changed, void* cookie) override {
    DriverBase::initialize(connected, disconnected, changed, cookie);
    look();  // who asks for the list right away must see it
    thread_ = std::thread([this] {
      while (!stop_) {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        look();
      }
    });
    return ONI_STATUS_OK;
  }
  void shutdown() override {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }
  oni::driver::DeviceBase* deviceOpen(const char*, const char*) override {
    auto* device = new VirtualDevice(path_);
    const bool usable = device->good() && device->feed().fault() != CameraFault::kUnplug &&
                        device->feed().fault() != CameraFault::kBusy;
    if (usable) return device;
    delete device;
    getServices().errorLoggerAppend("the virtual camera is in use by another program");
    return nullptr;
  }
  void deviceClose(oni::driver::DeviceBase* device) override { delete device; }

 private:
  void look() {
    const OniDeviceInfo info = device_info();
    bool there = false;
    struct stat status {};
    if (stat(path_.c_str(), &status) == 0) {
      if (!feed_ || feed_->inode() != status.st_ino) feed_ = std::make_unique<Feed>(path_);
      there = feed_->good() && feed_->fault() != CameraFault::kUnplug;
    }
    if (there == connected_) return;
    connected_ = there;
    if (there) {
      deviceConnected(&info);
    } else {
      deviceDisconnected(&info);
    }
  }

  std::string path_;
  std::unique_ptr<Feed> feed_;
  bool connected_ = false;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace
}  // namespace fusion_slam

#define XN_NEW(type, argument) new type(argument)
#define XN_DELETE(pointer) delete pointer
ONI_EXPORT_DRIVER(fusion_slam::VirtualDriver)
