// PxrTangentField: the tangent along s, turned about the normal by a number or to the direction that a colour holds.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrTangentField/PxrTangentField.cpp"
#include <kinora/pattern_author.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kInputRotation, kInputVector, kRotationOffset, kRotationRange, kCenteredVectors };
constexpr Param kParams[] = {
    param::number("inputRotation", 0.f).help("Angle: 0 none, 1 a full turn."),
    structural(param::color("inputVector", 0.f))
        .help("Direction: red along s, green across; takes the place of inputRotation where it is not black."),
    param::number("rotationOffset", 0.f).range(-1, 1).help("Added to the angle, in turns."),
    param::number("rotationRange", 1.f).range(-1, 1).help("Factor of inputRotation."),
    param::flag("centeredVectors", true)
        .help("1: 0.5 of inputVector stands for 0, so that directions go all around."),
    param::output(Type::Vector, "resultXYZ"),
    param::output(Type::Float, "resultX"),
    param::output(Type::Float, "resultY"),
    param::output(Type::Float, "resultZ"),
};

struct PxrTangentField {
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    using F = Float<W>;
    const Value rotation = c->param(kInputRotation), direction = c->param(kInputVector),
                offset = c->param(kRotationOffset), range = c->param(kRotationRange),
                tangent = c->builtin(Builtin::Tangent);
    const bool centered = fixedInteger(*c, kCenteredVectors) != 0, byVector = isBumped(direction);
    float* out[3];
    makeOutput(*c, args->outputs[0], 3, false, out);
    for (uint32_t i = 0; i < c->padded; i += W) {
      const At at{i, false};
      const Vec3<W> t = loadVec<W>(tangent, at), n = loadVec<W>(c->N, at), b = cross(n, t);
      F sine, cosine;
      F turns = loadFloat<W>(offset, at);
      if (!byVector) turns = fma(loadFloat<W>(rotation, at), loadFloat<W>(range, at), turns);
      sincos(turns * F(2 * kPi), sine, cosine);
      F x(1.f), y(0.f);
      if (byVector) {
        const Rgb<W> d = loadRgb<W>(direction, at);
        x = centered ? fma(F(2.f), d.x, F(-1.f)) : d.x;
        y = centered ? fma(F(2.f), d.y, F(-1.f)) : d.y;
        const F l = sqrt(fma(x, x, y * y));
        const Mask<W> none = l < F(1e-6f);
        x = select(none, F(1.f), x / max(l, F(1e-6f)));
        y = select(none, F(0.f), y / max(l, F(1e-6f)));
      }
      (t * (x * cosine - y * sine) + b * (x * sine + y * cosine)).store(out, i);
    }
    shareComponents(*args, 0);
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrTangentField, .help = "Tangents turned by a texture, for anisotropic highlights.",
               .params = kParams)
