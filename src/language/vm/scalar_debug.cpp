// What --debugnan and --debuguninit tell: see optimise/instrument.h.
#include <algorithm>
#include <cmath>

#include "language/optimise/instrument.h"
#include "language/vm/scalar.h"

namespace kinora::language {

namespace {

// Cells of the value that are looked at: an element, a component, or all.
struct Looked {
  uint32_t first = 0, end = 0;
};
Looked lookedAt(const Call& call, uint32_t point) {
  const uint32_t cells = call.cells(2);
  if (call.count() == 3 || cells == 0) return {0, cells};
  const auto index = [&](uint32_t k, uint32_t most) {
    return uint32_t(std::clamp(call.integer(k, point), 0, int32_t(most) - 1));
  };
  if (call.isArray(2)) {
    const uint32_t each = std::max(1u, uint32_t(componentsOf(call.base(2))));
    const uint32_t at = index(3, std::max(1u, cells / each)) * each;
    return {at, at + each};
  }
  const uint32_t at = call.count() == 5 ? std::min(index(3, 4) * 4 + index(4, 4), cells - 1) : index(3, cells);
  return {at, at + 1};
}

}  // namespace

// name, operation, value, place in it
void scalarDebugNan(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  const Span derivs[2] = {call.derivs(2, 1), call.derivs(2, 2)};
  const uint32_t n = call.varies(2) ? f.points : 1;
  for (uint32_t i = 0; i < n; ++i) {
    if (n > 1 && !call.isLive(i)) continue;
    const Looked looked = lookedAt(call, i);
    const auto tell = [&](float value, bool isDerivative) {
      if (value - value == 0) return false;
      tellOnce(f, call.siteNumber(), i,
               std::string("Detected ") +
                   (std::isnan(value) ? "nan"
                    : value < 0       ? "-inf"
                                      : "inf") +
                   " value in " + (isDerivative ? "the derivatives of " : "") + call.text(0, 0) + " at " +
                   call.site().position + " (op " + call.text(1, 0) + ")");
      return true;
    };
    bool isTold = false;
    for (uint32_t c = looked.first; c < looked.end && !isTold; ++c) isTold = tell(call.number(2, i, c), false);
    for (const Span& d : derivs)
      for (uint32_t c = looked.first; c < looked.end && c < d.components && !isTold; ++c)
        isTold = tell(d.number(c, i), true);
  }
}

// type and name, operation and argument, value, place in it
void scalarDebugUninit(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  static const int32_t kMark = internString(kUninitialisedText);
  const Base base = call.base(2);
  const uint32_t n = call.varies(2) ? f.points : 1;
  for (uint32_t i = 0; i < n; ++i) {
    if (n > 1 && !call.isLive(i)) continue;
    const Looked looked = lookedAt(call, i);
    bool isFound = false;
    for (uint32_t c = looked.first; c < looked.end; ++c) {
      const int32_t bits = call.integer(2, i, c);
      const float value = call.number(2, i, c);
      const bool isBad = base == Base::String ? bits == kMark
                         : base == Base::Int  ? bits == INT32_MIN
                                              : value - value != 0;
      if (!isBad) continue;
      isFound = true;
      call.set(2, i, int32_t(0), c);
    }
    if (!isFound) continue;
    std::string place = placeOf(*f.run->program, call.site());
    place.pop_back();
    tellOnce(f, call.siteNumber(), i,
             "Detected possible use of uninitialized value in " + call.text(0, 0) + " at " + place + ", " +
                 call.text(1, 0) + ")");
  }
}

}  // namespace kinora::language
