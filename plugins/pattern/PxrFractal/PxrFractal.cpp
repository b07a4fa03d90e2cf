// PxrFractal: a fractal sum of gradient noise over position or a manifold. Layers finer than the footprint fade to
// their mean (math/noise.h), so that distant surfaces stay calm. Results lie in 0..1 about 0.5, turbulent ones in
// 0..1 from 0.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrFractal/PxrFractal.cpp"
#include <kinora/pattern_author.h>
#include <kinora/math/noise.h>

KINORA_KERNELS_BEGIN

enum : uint32_t {
  kSurfacePosition,
  kLayers,
  kFrequency,
  kLacunarity,
  kDimension,
  kErosion,
  kVariation,
  kTurbulent,
  kColorScale,
  kColorOffset,
  kFloatScale,
  kFloatOffset,
  kManifold
};
constexpr Param kParams[] = {
    param::integer("surfacePosition", 0)
        .range(0, 2)
        .options("0 object, 1 world, 2 reference (primvar Pref)")
        .help("Space of the noise where no manifold is connected."),
    param::integer("layers", 6).range(1, 10).help("Number of noises added."),
    param::number("frequency", 1.f).range(0.1f, 32).help("Features of the first layer per unit of length."),
    param::number("lacunarity", 2.f).range(1, 4).help("How many times finer each layer is than the one before."),
    param::number("dimension", 1.f)
        .range(0, 2)
        .help("Roughness: each layer is lacunarity^-dimension as high as the last."),
    param::number("erosion", 0.f).help("Fine layers vanish in the valleys of coarse ones, 0..1."),
    param::number("variation", 0.f).range(0, 10).help("Moves smoothly from one pattern to another."),
    param::flag("turbulent", false).help("1: absolute values, which leave creases."),
    param::color("colorScale", 1.f).help("Factor of resultRGB."),
    param::color("colorOffset", 0.f).range(-1, 1).help("Added to resultRGB."),
    param::number("floatScale", 1.f).help("Factor of resultF."),
    param::number("floatOffset", 0.f).range(-1, 1).help("Added to resultF."),
    param::structure("manifold").help("Position; the surface's where not connected."),
    param::output(Type::Float, "resultF"),
    KINORA_COLOR_OUTPUTS,
};

template <int W>
inline Manifold noisePlace(const Context& c) {
  if (const Manifold* m = c.fn->manifold(&c, kManifold)) return *m;
  Manifold m;
  m.dimensions = 3;
  m.radius = c.builtin(Builtin::PoRadius);
  const int use = fixedInteger(c, kSurfacePosition);
  if (use == 1) {
    m.q = c.builtin(Builtin::Pworld);
    m.radius.data[0] = c.radius;  // render space has the world's unit of length
    m.radius.stride = m.radius.components = 1;
    return m;
  }
  m.q = c.builtin(Builtin::Po);
  if (use != 2) return m;
  for (const char* name : {"Pref", "__Pref"}) {  // the second counts where there are both
    const Primvar reference(c, name);
    if (reference.value.components < 3) continue;
    m.q = placesOr<W>(c, reference, "object", Moves::Point, m.q);
    m.radius = footprintOr(c, reference, m.radius);
  }
  return m;
}

struct PxrFractal {
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    using F = Float<W>;
    const Manifold m = noisePlace<W>(*c);
    const Value frequency = c->param(kFrequency), lacunarity = c->param(kLacunarity),
                dimension = c->param(kDimension);
    const Value erosion = c->param(kErosion), variation = c->param(kVariation);
    FractalShape<W> shape;
    shape.layers = fixedInteger(*c, kLayers);
    shape.turbulent = fixedInteger(*c, kTurbulent) != 0;
    const bool one = allUniform({&m.q, &m.radius, &frequency, &lacunarity, &dimension, &erosion, &variation});
    float* noise[3];
    Value raw;
    makeOutput(*c, raw, 1, one, noise);
    for (uint32_t i = 0; i < extent(*c, one); i += W) {
      const At at{i, false};
      shape.lacunarity = loadFloat<W>(lacunarity, at);
      shape.dimension = loadFloat<W>(dimension, at);
      shape.erosion = loadFloat<W>(erosion, at);
      shape.variation = loadFloat<W>(variation, at);
      const F f = loadFloat<W>(frequency, at);
      const F n = fractalNoise(shape, loadPosition<W>(m, at) * f, abs(loadFloat<W>(m.radius, at) * f), 0x51ab3c05u);
      (shape.turbulent ? n : fma(n, F(0.5f), F(0.5f))).store(noise[0] + i);
    }
    scaled<W>(*c, raw, c->param(kFloatScale), c->param(kFloatOffset), 1, args->outputs[0]);
    scaled<W>(*c, raw, c->param(kColorScale), c->param(kColorOffset), 3, args->outputs[1]);
    shareComponents(*args, 1);
  }

  // raw * scale + offset; the arrays are shared where that changes nothing
  template <int W>
  static void scaled(const Context& c, const Value& raw, const Value& scale, const Value& offset, uint32_t components,
                     Value& out) {
    bool plain = allUniform({&scale, &offset});
    for (uint32_t k = 0; plain && k < components; ++k) plain = scale.data[k][0] == 1.f && offset.data[k][0] == 0.f;
    if (plain) {
      out = raw;
      out.components = components;
      for (uint32_t k = 0; k < components; ++k) out.data[k] = raw.data[0];
      return;
    }
    const bool one = allUniform({&raw, &scale, &offset});
    float* data[3];
    makeOutput(c, out, components, one, data);
    for (uint32_t i = 0; i < extent(c, one); i += W) {
      const At at{i, false};
      const Float<W> n = loadFloat<W>(raw, at);
      for (uint32_t k = 0; k < components; ++k)
        fma(n, loadComponent<W>(scale, k, at), loadComponent<W>(offset, k, at)).store(data[k] + i);
    }
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrFractal, .help = "Fractal noise over space or texture coordinates.", .params = kParams)
