// Helpers for pattern authors: loading values and making outputs for W points. Included per target.
#include <kinora/pattern.h>
#include <kinora/bxdf_author.h>

#if defined(KINORA_PATTERN_AUTHOR_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_PATTERN_AUTHOR_H_TARGET
#undef KINORA_PATTERN_AUTHOR_H_TARGET
#else
#define KINORA_PATTERN_AUTHOR_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// Allocates a varying output of n components in the context and returns the writable arrays.
inline void makeOutput(const Context& c, Value& out, uint32_t components, float* data[3]) {
  for (uint32_t i = 0; i < 3; ++i) {
    data[i] = i < components ? c.alloc<float>(c.padded) : nullptr;
    out.data[i] = data[i];
  }
  out.stride = 1;
  out.components = components;
}

// resultRGB at `rgb`, its parts at rgb+1 .. rgb+3 (the convention of reference colour nodes): parts share the arrays.
inline void shareComponents(const PatternArgs& a, uint32_t rgb) {
  for (uint32_t i = 0; i < 3; ++i) {
    Value& v = a.outputs[rgb + 1 + i];
    v.data[0] = a.outputs[rgb].data[i];
    v.stride = a.outputs[rgb].stride;
    v.components = 1;
  }
}

// `B` has `template <int W> static void compute(const Context*, const PatternArgs*)`.
template <class B>
struct PatternRunner {
  template <int W> static constexpr PatternFunctions table() { return PatternFunctions{&B::template compute<W>}; }
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
