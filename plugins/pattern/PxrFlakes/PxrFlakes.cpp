// PxrFlakes: metal flakes in paint: space is full of scattered points, and what lies nearest to one of them, within
// its size, leans the way that this point drew. Flakes narrower than the footprint are not faded: each sample meets
// one of them, and the mean over samples is what all of them reflect, as it should be; a mean normal would reflect
// like a mirror.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrFlakes/PxrFlakes.cpp"
#include <kinora/pattern_author.h>
#include <kinora/random.h>

#include "plugins/pattern/cells/cells.h"

KINORA_KERNELS_BEGIN

enum : uint32_t {
  kInputNormal,
  kFlakeAmount,
  kFlakeFreq,
  kDensity,
  kSize,
  kOctaves,
  kJitter,
  kValidateNormals,
  kManifold
};
constexpr Param kParams[] = {
    param::normal("inputNormal").help("Normal that the flakes lean away from; the surface's where it is 0 0 0."),
    param::number("flakeAmount", 0.5f).help("How far flakes lean: 0 not at all, 1 by up to some 60 degrees."),
    param::number("flakeFreq", 57.3f).range(1, 500).help("Flakes along a unit of the manifold."),
    param::number("density", 1.f).help("Share of the places for flakes that hold one."),
    param::number("size", 1.f).help("How far a flake reaches from its middle, in units of their mean distance."),
    param::integer("octaves", 1).range(1, 4).help("Sizes of flakes, each half of the one before, between them."),
    param::number("jitter", 0.75f).help("0: flakes on a grid, 1: scattered."),
    param::flag("validateNormals", false).help("1: flakes that look away are bent until they are seen."),
    param::structure("manifold").help("Position; the surface's in object space where not connected."),
    param::output(Type::Normal, "resultN"),
    param::output(Type::Float, "resultA"),
};

struct PxrFlakes {
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    using F = Float<W>;
    const Value input = c->param(kInputNormal), amount = c->param(kFlakeAmount), frequency = c->param(kFlakeFreq),
                density = c->param(kDensity), size = c->param(kSize), jitter = c->param(kJitter);
    const Manifold m = spaceManifold(*c, kManifold);
    int octaves = fixedInteger(*c, kOctaves);
    octaves = octaves < 1 ? 1 : octaves > 8 ? 8 : octaves;
    const bool given = isBumped(input), validate = fixedInteger(*c, kValidateNormals) != 0;
    float *out[3], *covered[3];
    Value bent;
    makeOutput(*c, bent, 3, false, out);
    makeOutput(*c, args->outputs[1], 1, false, covered);
    args->outputs[0] = bent;
    for (uint32_t i = 0; i < c->padded; i += W) {
      const At at{i, false};
      const Surface<W> s(*c, at);
      const Vec3<W> n = given ? bumpedNormal<W>(input, s) : s.N;
      Vec3<W> p = loadPosition<W>(m, at) * loadFloat<W>(frequency, at), lean;
      F on(0.f);
      for (int octave = 0; octave < octaves; ++octave) {
        const Nearest<W> flake(p, loadFloat<W>(jitter, at), loadFloat<W>(density, at), loadFloat<W>(size, at),
                               m.dimensions > 2, uint32_t(octave));
        lean = select(flake.hit & (on == F(0.f)), flake.lean, lean);
        on = select(flake.hit, F(1.f), on);
        p = p * F(2.f) + Vec3<W>(F(17.317f), F(31.719f), F(23.541f));
      }
      lean = lean * loadFloat<W>(amount, at);
      lean = fma(n, -dot(n, lean), lean);
      normalize(n + lean).store(out, i);
      on.store(covered[0] + i);
    }
    for (uint32_t i = 0; validate && i < c->padded; i += W)
      bumpedNormal<W>(bent, Surface<W>(*c, At{i, false})).store(out, i);
  }
  // The flake at a place, if there is one; `lean` is uniform in a ball of radius sqrt(3).
  template <int W>
  struct Nearest {
    Mask<W> hit;
    Vec3<W> lean;
    KN_INLINE Nearest(Vec3<W> p, Float<W> jitter, Float<W> density, Float<W> size, bool solid, uint32_t octave) {
      using F = Float<W>;
      F first(1e30f);
      Int<W> own(0u);
      forCellPoints(p, clamp(jitter, F(0.f), F(1.f)), solid, 0x1f123bb5u + octave * 0x632be5abu,
                    [&](Vec3<W> d, Int<W> bits) {
                      const F l = select(toUnitFloat(bits) < density, length(d), F(1e30f));
                      own = select(l < first, bits, own);
                      first = min(first, l);
                    });
      hit = first <= size;
      // an even direction and radius of a ball, of three more random numbers
      const Int<W> a = hashWords(own, Int<W>(0x6b43a9b5u)), b = hashWords(own, Int<W>(0x1c69b3f7u));
      const F z = fma(F(2.f), toUnitFloat(a), F(-1.f)), r = safeSqrt(fnma(z, z, F(1.f)));
      F sine, cosine;
      sincos(toUnitFloat(b) * F(2 * kPi), sine, cosine);
      const F u = toUnitFloat(hashWords(a, b));
      lean = Vec3<W>(r * cosine, r * sine, z) * (F(1.7320508f) * exp2(log2(max(u, F(1e-9f))) * F(1.f / 3.f)));
    }
  };
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrFlakes, .help = "Normals of metal flakes in paint.", .params = kParams)
