#include "language/program/program.h"
#include "language/vm/services.h"
#include "language/vm/strings.h"

namespace kinora::language {

bool giveValue(const GivenValue& value, const Span& to, uint32_t point) {
  const Base base = Base(to.base);
  const size_t n = value.count;
  if (value.strings || base == Base::String) {
    if (!value.strings || base != Base::String || n != to.components) return false;
    for (uint32_t k = 0; k < to.components; ++k) to.set(k, point, internString(value.strings[k]));
    return true;
  }
  const auto put = [&](uint32_t k, size_t from) {
    if (base == Base::Int && value.ints)
      to.set(k, point, value.ints[from]);
    else if (base == Base::Int)
      to.set(
          k, point,
          value.floats[from] >= -0x1p31f && value.floats[from] < 0x1p31f ? int32_t(value.floats[from]) : INT32_MIN);
    else
      to.set(k, point, value.ints ? float(value.ints[from]) : value.floats[from]);
  };
  if (n == 1 && base == Base::Matrix) {
    for (uint32_t k = 0; k < 16; ++k) to.set(k, point, 0.f);
    for (uint32_t k = 0; k < 16; k += 5) put(k, 0);
    return true;
  }
  const bool fits = n == 1               ? to.components == 1 || base != Base::Int
                    : n == to.components ? value.ints || base != Base::Int
                                         : n == 2 && to.components == 3 && isTriple(base);
  if (n == 0 || !fits) return false;
  for (uint32_t k = 0; k < to.components; ++k)
    if (n == 2 && k == 2)
      to.set(k, point, 0.f);
    else
      put(k, n == 1 ? 0 : k);
  return true;
}

}  // namespace kinora::language
