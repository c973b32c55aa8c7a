#include "drivers/openni2_camera/runtime.hpp"

namespace fusion_slam {

std::string openni_reason() {
  std::string text = oniGetExtendedError();
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  for (char& c : text)
    if (c == '\n' || c == '\t') c = ' ';
  return text.empty() ? "" : " (OpenNI2 says: " + text + ")";
}

std::string describe(const std::vector<CameraCandidate>& devices) {
  if (devices.empty())
    return "no OpenNI2 device is plugged in, or none may be used: see "
           "drivers/openni2_camera/README.md "
           "for the udev rule, and for the plug-in that Orbbec's cameras need";
  std::string text =
      std::to_string(devices.size()) + " OpenNI2 device" + (devices.size() == 1 ? "" : "s") + ":";
  for (const CameraCandidate& device : devices) text += " " + device.uri + " (" + device.name + ")";
  return text;
}

OpenniRuntime::OpenniRuntime() {
  if (oniInitialize(ONI_API_VERSION) != ONI_STATUS_OK)
    throw CameraError("the OpenNI2 runtime does not start" + openni_reason());
  OniDeviceCallbacks callbacks{};
  callbacks.deviceDisconnected = [](const OniDeviceInfo*, void* self) {
    static_cast<OpenniRuntime*>(self)->gone_ = true;
  };
  callbacks.deviceStateChanged = [](const OniDeviceInfo*, OniDeviceState state, void* self) {
    if (state == ONI_DEVICE_STATE_EOF) static_cast<OpenniRuntime*>(self)->ended_ = true;
    if (state == ONI_DEVICE_STATE_ERROR) static_cast<OpenniRuntime*>(self)->gone_ = true;
  };
  oniRegisterDeviceCallbacks(&callbacks, this, &callbacks_);
}

OpenniRuntime::~OpenniRuntime() {
  if (callbacks_ != nullptr) oniUnregisterDeviceCallbacks(callbacks_);
  oniShutdown();
}

std::vector<CameraCandidate> OpenniRuntime::devices() const {
  OniDeviceInfo* infos = nullptr;
  int n = 0;
  std::vector<CameraCandidate> devices;
  if (oniGetDeviceList(&infos, &n) != ONI_STATUS_OK) return devices;
  for (int i = 0; i < n; ++i)
    devices.push_back({infos[i].uri, std::string(infos[i].vendor) + " " + infos[i].name});
  oniReleaseDeviceList(infos);
  return devices;
}

}  // namespace fusion_slam
