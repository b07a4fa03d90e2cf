// Colour spaces and spectra.
#define KINORA_KERNEL_FILE "language/vm/color.cpp"
#include "language/vm/kernel.h"
#include "language/library/color_system.h"
#include <kinora/simd/foreach_target.h>
#include "language/library/color.h"
#include "language/vm/access.h"
#include "language/vm/operands.h"
#include "language/vm/width_tables.h"

KINORA_KERNELS_BEGIN
using namespace kinora::language;

template <class T, int W>
void luminance(const Frame& f, const uint32_t* w) {
  const ColorSystem& s = defaultColorSystem();
  KN_EACH(f, i, W) T::put(f, w, i, lang::luminance(s, T::triple(f, w + T::kResult, i)));
}
template <class T, int W>
void transformColor(const Frame& f, const uint32_t* w) {
  const ColorSystem& s = defaultColorSystem();
  KN_EACH(f, i, W)
  T::put(
      f, w + 2, i,
      lang::transformc(s, ColorSpace(int32_t(w[0])), ColorSpace(int32_t(w[1])), T::triple(f, w + 2 + T::kResult, i)));
}
template <int W, bool kBlackbody>
void spectrum(const Frame& f, const uint32_t* w) {
  using T = lang::PlainWords<W>;
  const ColorSystem& s = defaultColorSystem();
  KN_EACH(f, i, W) {
    const Float<W> x = T::number(f, w + T::kResult, i);
    if constexpr (kBlackbody)
      T::put(f, w, i, lang::blackbody(s, x));
    else
      T::put(f, w, i, lang::wavelengthColor(s, x));
  }
}

template <int W>
constexpr KernelFunction kColor[] = {&luminance<lang::PlainWords<W>, W>,
                                     &luminance<lang::DualWords<W>, W>,
                                     &transformColor<lang::PlainWords<W>, W>,
                                     &transformColor<lang::DualWords<W>, W>,
                                     &spectrum<W, true>,
                                     &spectrum<W, false>};
KN_VM_TABLES(kColor)
KINORA_KERNELS_END

#if HWY_ONCE
namespace kinora::language {
const KernelFunction* colorKernels(uint32_t width) { return KN_VM_PICK(width); }
}  // namespace kinora::language
#endif
