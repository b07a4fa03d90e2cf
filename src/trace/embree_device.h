// The one Embree device of a process. isa=avx2: hits have the same bits on every CPU that Kinora runs on.
#pragma once
#include <embree3/rtcore.h>
#include <cstdint>

namespace kinora::trace {

inline constexpr const char* kDeviceConfig = "isa=avx2,threads=0,set_affinity=0";
RTCDevice device();
// After a build: MemoryExceeded when Embree was refused memory since the last call; what was built is then not
// usable.
void throwIfRefused();
uint64_t deviceBytes();  // memory Embree holds now

// What a callback for bounds answers.
inline void setBounds(RTCBounds& b, const float lower[3], const float upper[3]) {
  b.lower_x = lower[0];
  b.lower_y = lower[1];
  b.lower_z = lower[2];
  b.upper_x = upper[0];
  b.upper_y = upper[1];
  b.upper_z = upper[2];
}

}  // namespace kinora::trace
