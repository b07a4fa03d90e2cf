// A bump as a surface gradient: the slope of its height along the surface (M. Mikkelsen, "Surface Gradient-Based Bump
// Mapping Framework", JCGT 2020). What it bends is the normal minus the gradient. Included per target.
#include <kinora/pattern_author.h>

#ifndef KINORA_BENT_NORMAL_OUTPUTS
#define KINORA_BENT_NORMAL_OUTPUTS param::output(Type::Normal, "resultN"), param::output(Type::Vector, "resultNG")
#endif

#if defined(KINORA_SURFACE_GRADIENT_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_SURFACE_GRADIENT_H_TARGET
#undef KINORA_SURFACE_GRADIENT_H_TARGET
#else
#define KINORA_SURFACE_GRADIENT_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// Of what bent N to n. Normals more than 89.4 degrees off count as if they were that far off.
template <int W>
KN_INLINE Vec3<W> surfaceGradient(Vec3<W> n, Vec3<W> N) {
  return N - n * (Float<W>(1.f) / max(dot(n, N), Float<W>(0.01f)));
}

// An output of the gradients that turned the surface's own normals into `bent`.
template <int W>
inline void makeSurfaceGradients(const Context& c, const float* const bent[3], Value& out) {
  float* g[3];
  makeOutput(c, out, 3, false, g);
  for (uint32_t i = 0; i < c.padded; i += W)
    surfaceGradient(Vec3<W>::load(bent, i), Vec3<W>::load(c.N, i)).store(g, i);
}

// A pattern of these outputs: Pattern::bend() gives the first.
template <class Pattern>
struct BendsNormals {
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    Pattern::template bend<W>(c, args);
    if (args->wanted[1]) makeSurfaceGradients<W>(*c, args->outputs[0].data, args->outputs[1]);
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
