// What kernels share that work point by point.
#pragma once
#include <cstring>
#include <string>

#include "language/program/program.h"
#include "language/vm/executable.h"
#include "language/vm/kernel.h"
#include "language/vm/strings.h"

namespace kinora::language {

#define KN_X(name) void scalar##name(const Frame&, const uint32_t* words);
KN_VM_SCALAR(KN_X)
#undef KN_X

inline int32_t intAt(const float* p, uint32_t i) {
  int32_t value;
  std::memcpy(&value, p + i, 4);
  return value;
}
inline void setInt(float* p, uint32_t i, int32_t value) { std::memcpy(p + i, &value, 4); }

inline std::string placeOf(const Executable& e, const Site& site) {
  return site.position + " (group " + e.group() + ", layer " + std::to_string(site.layer) + " " +
         SiteAccess::layer(e, site.layer) + ", shader " + SiteAccess::shader(e, site.layer) + ")";
}

// A message of a site, once a run: that of the first point that has cause; or that of each.
inline void tellOnce(const Frame& f, uint32_t number, uint32_t point, const std::string& text) {
  RunState& run = *f.run;
  if (run.toldOnce[number] && !run.tellsEveryPoint) return;
  run.toldOnce[number] = 1;
  run.say(f.first + point, MessageKind::Error, text);
}

// Whether a point takes part, by the mask in a cell.
inline bool takesPart(const Frame& f, uint32_t mask, uint32_t i) {
  return (f.chunks >> (i / 16) & 1) && intAt(f.cells[mask], i) != 0;
}

// An operation with a list of arguments: see CodeGenerator::scalar.
struct Call {
  const Frame& f;
  const uint32_t* w;
  uint32_t count() const { return w[0]; }
  uint32_t siteNumber() const { return w[1]; }
  const Site& site() const { return SiteAccess::site(*f.run->program, w[1]); }
  uint32_t extra() const { return w[2]; }
  bool isLive(uint32_t i) const { return !w[3] || takesPart(f, w[4], i); }
  const uint32_t* argument(uint32_t k) const { return w + 5 + 4 * k; }
  Base base(uint32_t k) const { return Base(argument(k)[1] & 255); }
  bool varies(uint32_t k) const { return argument(k)[1] >> 8 & 1; }
  bool isArray(uint32_t k) const { return argument(k)[1] >> 10 & 1; }
  uint32_t cells(uint32_t k) const { return argument(k)[2]; }
  float number(uint32_t k, uint32_t i, uint32_t c = 0) const {
    return f.cells[argument(k)[0] + c][varies(k) ? i : 0];
  }
  int32_t integer(uint32_t k, uint32_t i, uint32_t c = 0) const {
    return intAt(f.cells[argument(k)[0] + c], varies(k) ? i : 0);
  }
  const std::string& text(uint32_t k, uint32_t i, uint32_t c = 0) const { return stringOf(integer(k, i, c)); }
  void set(uint32_t k, uint32_t i, float value, uint32_t c = 0) const {
    f.cells[argument(k)[0] + c][varies(k) ? i : 0] = value;
  }
  void set(uint32_t k, uint32_t i, int32_t value, uint32_t c = 0) const {
    setInt(f.cells[argument(k)[0] + c], varies(k) ? i : 0, value);
  }
  // With a mask that is right for all points: that of a region holds what it did before where no point takes part.
  Batch batch() const {
    if (!w[3]) return {f.points, f.first, nullptr};
    float* mask = f.run->scratch(RunState::kScratch - 1);
    for (uint32_t i = 0; i < f.points; ++i) setInt(mask, i, isLive(i) ? -1 : 0);
    return {f.points, f.first, reinterpret_cast<const int32_t*>(mask)};
  }
  Span span(uint32_t k) const {
    Span s;
    s.cells = f.cells + argument(k)[0];
    s.components = cells(k);
    s.base = uint8_t(base(k));
    s.varies = varies(k);
    return s;
  }
  Span derivs(uint32_t k, uint32_t axis) const {  // no components: none
    Span s = span(k);
    if (argument(k)[1] >> 9 & 1)
      s.cells = f.cells + argument(k)[3] + (axis == 1 ? 0 : cells(k));
    else
      s.components = 0;
    return s;
  }
};

template <class F>
void eachLive(const Call& call, F&& work) {
  const bool once = !call.varies(0);
  for (uint32_t i = 0; i < (once ? 1u : call.f.points); ++i)
    if (once || call.isLive(i)) work(i);
}

}  // namespace kinora::language
