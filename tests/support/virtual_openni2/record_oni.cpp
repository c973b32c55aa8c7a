// record_oni FILE SECONDS: records colour and registered depth of the first OpenNI2 device through
// the runtime's own recorder. A process of its own: Debian's runtime can't be started again in a
// process that has recorded (oniInitialize asks a thread that is no more).
#include <chrono>
#include <cstdlib>
#include <iostream>
#include <thread>

#include <OniCAPI.h>

int main(int argc, char** argv) {
  if (argc != 3) return std::cerr << "usage: record_oni FILE SECONDS\n", 2;
  OniDeviceHandle device = nullptr;
  OniDeviceInfo* infos = nullptr;
  int n = 0;
  const auto good = [](OniStatus status) {
    if (status != ONI_STATUS_OK) std::cerr << "record_oni: " << oniGetExtendedError() << "\n";
    return status == ONI_STATUS_OK;
  };
  if (!good(oniInitialize(ONI_API_VERSION)) || !good(oniGetDeviceList(&infos, &n)) || n < 1 ||
      !good(oniDeviceOpen(infos[0].uri, &device)))
    return 1;
  oniReleaseDeviceList(infos);
  const OniImageRegistrationMode mode = ONI_IMAGE_REGISTRATION_DEPTH_TO_COLOR;
  oniDeviceSetProperty(device, ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION, &mode, sizeof mode);
  OniStreamHandle streams[2] = {};
  OniRecorderHandle recorder = nullptr;
  if (!good(oniDeviceCreateStream(device, ONI_SENSOR_DEPTH, &streams[0])) ||
      !good(oniDeviceCreateStream(device, ONI_SENSOR_COLOR, &streams[1])) ||
      !good(oniCreateRecorder(argv[1], &recorder)))
    return 1;
  const OniBool off = FALSE;
  for (OniStreamHandle stream : streams) {
    oniStreamSetProperty(stream, ONI_STREAM_PROPERTY_MIRRORING, &off, sizeof off);
    if (!good(oniRecorderAttachStream(recorder, stream, FALSE)) || !good(oniStreamStart(stream)))
      return 1;
  }
  if (!good(oniRecorderStart(recorder))) return 1;
  std::this_thread::sleep_for(std::chrono::duration<double>(std::atof(argv[2])));
  oniRecorderStop(recorder);
  oniRecorderDestroy(&recorder);
  for (OniStreamHandle stream : streams) {
    oniStreamStop(stream);
    oniStreamDestroy(stream);
  }
  oniDeviceClose(device);
  oniShutdown();
  return 0;
}
