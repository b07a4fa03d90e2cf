#include "trace/embree_device.h"

#include <atomic>
#include <stdexcept>

namespace kinora::trace {

namespace {
std::atomic<int64_t> bytes{0};
bool onMemory(void*, ssize_t change, bool) {
  bytes += change;
  return true;
}
}  // namespace

RTCDevice device() {
  static const RTCDevice d = [] {
    const RTCDevice made = rtcNewDevice(kDeviceConfig);
    if (!made) throw std::runtime_error("Embree gives no device (does this CPU have AVX2?)");
    rtcSetDeviceMemoryMonitorFunction(made, onMemory, nullptr);
    return made;
  }();
  return d;
}

uint64_t deviceBytes() { return uint64_t(bytes.load()); }

}  // namespace kinora::trace
