// Rounding of small numbers as passes have it, for who shades while a world is built.
#pragma once
#include <cfenv>

#include "simd/dispatch.h"

namespace kinora::render {

// In force on this thread for as long as it lives.
class ShadingFloats {
 public:
  ShadingFloats() {
    std::fegetenv(&before_);
    setThreadFloatMode();
  }
  ~ShadingFloats() { std::fesetenv(&before_); }
  ShadingFloats(const ShadingFloats&) = delete;

 private:
  std::fenv_t before_;
};

}  // namespace kinora::render
