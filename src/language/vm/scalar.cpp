// Work that goes point by point, the same for every width: array elements by an index that varies, the limit of
// loops, refusals. Text stands in scalar_text.cpp, what the renderer answers in scalar_services.cpp.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "language/vm/scalar.h"

namespace kinora::language {

// components, result, array, array varies, index, index varies
void scalarArrayRead(const Frame& f, const uint32_t* w) {
  const uint32_t n = w[0];
  const bool varies = w[3];
  const float* index = f.cells[w[4]];
  if (!w[5]) {
    const uint32_t at = uint32_t(intAt(index, 0)) * n;
    for (uint32_t c = 0; c < n; ++c) {
      const float* from = f.cells[w[2] + at + c];
      float* to = f.cells[w[1] + c];
      if (varies)
        std::memcpy(to, from, size_t(f.points) * 4);
      else
        std::fill(to, to + f.points, from[0]);
    }
    return;
  }
  for (uint32_t c = 0; c < n; ++c) {
    float* to = f.cells[w[1] + c];
    for (uint32_t i = 0; i < f.points; ++i) to[i] = f.cells[w[2] + uint32_t(intAt(index, i)) * n + c][varies ? i : 0];
  }
}

// components of one element, array, value, its step, value varies, index, index varies, has a mask, mask
void scalarArrayWrite(const Frame& f, const uint32_t* w) {
  const uint32_t n = w[0];
  const float* index = f.cells[w[5]];
  for (uint32_t c = 0; c < n; ++c) {
    const float* value = f.cells[w[2] + c * w[3]];
    for (uint32_t i = 0; i < f.points; ++i) {
      if (w[7] && !takesPart(f, w[8], i)) continue;
      f.cells[w[1] + uint32_t(intAt(index, w[6] ? i : 0)) * n + c][i] = value[w[4] ? i : 0];
    }
  }
}

// site, result, index, varies, length, has a mask, mask
void scalarCheckIndex(const Frame& f, const uint32_t* w) {
  float* to = f.cells[w[1]];
  const float* from = f.cells[w[2]];
  const int32_t length = int32_t(w[4]);
  for (uint32_t i = 0; i < f.points; ++i) {
    const int32_t index = intAt(from, w[3] ? i : 0), kept = std::clamp(index, 0, length - 1);
    setInt(to, i, kept);
    if (kept == index || (w[5] && !takesPart(f, w[6], i))) continue;
    const Executable& e = *f.run->program;
    if ((f.run->toldOnce[w[0]] && !f.run->tellsEveryPoint) || !SiteAccess::rangeCheck(e)) continue;
    const Site& site = SiteAccess::site(e, w[0]);
    tellOnce(f, w[0], i,
             "Index [" + std::to_string(index) + "] out of range " + site.name + "[0.." + std::to_string(length - 1) +
                 "]: " + placeOf(e, site));
  }
}

// count, site, limit: a loop has turned as often as it may, or all loops together have
void scalarLoopLimit(const Frame& f, const uint32_t* w) {
  const Executable& e = *f.run->program;
  const std::string place = " turns: " + placeOf(e, SiteAccess::site(e, w[1]));
  if (f.run->isSpent)
    f.run->say(f.first, MessageKind::Error,
               "loops inside each other were stopped after " + std::to_string(SiteAccess::mostTurns(e)) + place);
  else
    tellOnce(f, w[1], 0, "a loop was stopped after " + std::to_string(w[2]) + place);
}

void scalarRefuse(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  for (uint32_t i = 0; i < f.points; ++i) {
    if (!call.isLive(i)) continue;
    tellOnce(f, call.siteNumber(), i,
             call.site().name + (call.extra() == 2 ? ": " : " is not supported: ") +
                 placeOf(*f.run->program, call.site()));
    break;
  }
}
namespace {

constexpr KernelFunction kScalar[] = {
#define KN_X(name) &scalar##name,
    KN_VM_SCALAR(KN_X)
#undef KN_X
};

}  // namespace

const KernelFunction* scalarKernels() { return kScalar; }

}  // namespace kinora::language
