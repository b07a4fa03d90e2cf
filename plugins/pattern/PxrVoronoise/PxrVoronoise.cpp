// PxrVoronoise: each lattice cell has a point and a value; a point in space gets the mean of the values about it,
// weighted by distance. Steep weights give Voronoi cells, flat ones smooth noise (after I. Quilez, "Voronoise", 2014;
// here in three dimensions; weights end at the same distance, the square root of 2. Jittered points leave no room for a
// ball of that size without any, while one of radius 1 is empty here and there). Layers below the footprint fade out.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrVoronoise/PxrVoronoise.cpp"
#include <kinora/pattern_author.h>
#include <kinora/math/noise.h>

#include "plugins/pattern/cells/cells.h"

KINORA_KERNELS_BEGIN

enum : uint32_t {
  kFrequency,
  kOctaves,
  kGain,
  kLacunarity,
  kJitter,
  kSmoothness,
  kTurbulent,
  kSurfacePosition,
  kManifold
};
constexpr Param kParams[] = {
    param::number("frequency", 1.f).range(0.1f, 32).help("Cells per unit."),
    param::integer("octaves", 3).range(1, 8).help("Number of noises added."),
    param::number("gain", 0.5f).help("How high each octave is beside the one before."),
    param::number("lacunarity", 2.f).range(1, 4).help("How many times finer each octave is."),
    param::number("jitter", 0.f).help("0: points at the middle of cells, 1: anywhere in them."),
    param::number("smoothness", 1.f).help("0: flat cells, 1: smooth."),
    param::flag("turbulent", false).help("1: absolute values about the middle, which leave creases."),
    param::integer("surfacePosition", 0).options("0 object, 1 world").help("Space where no manifold is connected."),
    param::structure("manifold").help("Position; the surface's where not connected."),
    param::output(Type::Float, "resultF"),
    KINORA_COLOR_OUTPUTS,
};

struct PxrVoronoise {
  static constexpr uint32_t kComponents = 1;
  struct Setup {
    Value frequency, gain, lacunarity, jitter, smoothness;
    Manifold m;
    int octaves;
    bool turbulent;
    explicit Setup(const Context& c)
        : frequency(c.param(kFrequency)),
          gain(c.param(kGain)),
          lacunarity(c.param(kLacunarity)),
          jitter(c.param(kJitter)),
          smoothness(c.param(kSmoothness)) {
      octaves = fixedInteger(c, kOctaves);
      octaves = octaves < 1 ? 1 : octaves > 16 ? 16 : octaves;
      turbulent = fixedInteger(c, kTurbulent) != 0;
      if (const Manifold* connected = c.fn->manifold(&c, kManifold)) {
        m = *connected;
        return;
      }
      m.dimensions = 3;
      const bool world = fixedInteger(c, kSurfacePosition) == 1;
      m.q = c.builtin(world ? Builtin::Pworld : Builtin::Po);
      m.radius = c.builtin(Builtin::PoRadius);
      if (world) {
        m.radius.data[0] = c.radius;
        m.radius.stride = m.radius.components = 1;
      }
    }
    bool uniform() const {
      return allUniform({&frequency, &gain, &lacunarity, &jitter, &smoothness, &m.q, &m.radius});
    }
  };
  static constexpr int kCells = 64;
  static constexpr float kInvReach = 0.70710678f;  // of where weights end; cells as far as 1.5 are visited
  // In 0..1.
  template <int W>
  static KN_INLINE Float<W> cells(Vec3<W> p, Float<W> jitter, Float<W> steep, uint32_t seed) {
    using F = Float<W>;
    F near[kCells], value[kCells], nearest(0.f), sum(0.f), weights(0.f);
    int n = 0;
    forNearCellPoints(p, jitter, seed, [&](Vec3<W> d, Int<W> bits) {
      const F t = max(fnma(F(kInvReach), length(d), F(1.f)), F(0.f));
      near[n] = t * t * fnma(F(2.f), t, F(3.f));
      value[n] = toUnitFloat(bits);
      nearest = max(nearest, near[n]);
      ++n;
    });
    // relative to the nearest point, so that steep weights do not all underflow
    const F scale = F(1.f) / max(nearest, F(1e-20f));
    const Mask<W> isPlain = steep == F(1.f);
    for (int k = 0; k < kCells; ++k) {
      const F x = near[k] * scale;
      if (!(x > F(0.f)).any()) continue;  // most cells are out of reach
      const F w = isPlain.all() ? x : select(isPlain, x, pow(x, steep));
      sum = fma(w, value[k], sum);
      weights += w;
    }
    return select(weights > F(0.f), sum / max(weights, F(1e-30f)), F(0.5f));
  }
  template <int W>
  static KN_INLINE Vec3<W> at(const Setup& s, At at) {
    using F = Float<W>;
    const F f = loadFloat<W>(s.frequency, at), jitter = clamp(loadFloat<W>(s.jitter, at), F(0.f), F(1.f));
    const F rough = F(1.f) - clamp(loadFloat<W>(s.smoothness, at), F(0.f), F(1.f)), rough2 = rough * rough;
    const F steep = fma(F(63.f), rough2 * rough2, F(1.f));
    const F gain = loadFloat<W>(s.gain, at), lacunarity = loadFloat<W>(s.lacunarity, at);
    Vec3<W> p = loadPosition<W>(s.m, at) * f;
    const F radius = abs(loadFloat<W>(s.m.radius, at) * f);
    F sum(0.f), total(0.f), amplitude(1.f), frequency(1.f);
    for (int i = 0; i < s.octaves; ++i) {
      const F visible = layerVisibility(radius, frequency);
      const F mean(s.turbulent ? kMeanAbs : 0.5f);
      F n = mean;
      if ((visible > F(0.f)).any()) {
        n = cells(p, jitter, steep, 0x3d4d51cbu + uint32_t(i) * 0x632be5abu);
        if (s.turbulent) n = abs(fma(F(2.f), n, F(-1.f)));
        n = lerp(mean, n, visible);
      }
      sum = fma(n, amplitude, sum);
      total += amplitude;
      amplitude *= gain;
      frequency *= lacunarity;
      p = p * lacunarity + Vec3<W>(F(17.317f), F(31.719f), F(23.541f));
    }
    const F r = sum / select(abs(total) > F(1e-12f), total, F(1.f));
    return Vec3<W>(r, r, r);
  }
  static constexpr float kMeanAbs = 0.2f;  // of |2n - 1|, about; smoother settings have less
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrVoronoise, .help = "Noise between cells and clouds.", .params = kParams)
