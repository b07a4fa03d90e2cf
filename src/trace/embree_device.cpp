#include "trace/embree_device.h"

#include <atomic>
#include <stdexcept>

#include "base/memory.h"

namespace kinora::trace {

namespace {
std::atomic<int64_t> bytes{0};
std::atomic<bool> refused{false};
// Asked before Embree allocates (`after` false) and told after it frees. A refusal becomes RTC_ERROR_OUT_OF_MEMORY.
bool onMemory(void*, ssize_t change, bool after) {
  if (change > 0 && !after && !Memory::tryCharge(MemoryUse::Hierarchies, uint64_t(change))) {
    refused = true;
    return false;
  }
  if (change < 0 || after) Memory::count(MemoryUse::Hierarchies, change);
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

void throwIfRefused() {
  if (!refused.exchange(false)) return;
  (void)rtcGetDeviceError(device());  // said by the exception; the next build begins without it
  throw MemoryExceeded(Memory::refusal());
}

uint64_t deviceBytes() { return uint64_t(bytes.load()); }

}  // namespace kinora::trace
