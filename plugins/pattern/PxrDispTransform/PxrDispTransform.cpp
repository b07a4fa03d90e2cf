// PxrDispTransform: what a map of displacement means: around which value it lies, how far it reaches, and in which space
// its vectors and lengths are. The result is in object units and object space, as PxrDisplace wants it.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrDispTransform/PxrDispTransform.cpp"
#include <kinora/pattern_author.h>

#include <cmath>

#ifndef KINORA_PXR_DISP_TRANSFORM_ONCE
#define KINORA_PXR_DISP_TRANSFORM_ONCE
namespace kinora::dispTransform {

// Factors by which lengths grow on the way that a matrix leads, by point; one where that is the same for all.
inline Value lengthsOf(const Context& c, const MatrixValue& m) {
  const uint32_t n = m.stride ? c.padded : 1;
  float* out = c.alloc<float>(m.stride ? n : kPad);
  for (uint32_t i = 0; i < n; ++i) {
    const auto e = [&](int k) { return m.m[k][m.stride ? i : 0]; };
    const float det = e(0) * (e(5) * e(10) - e(6) * e(9)) - e(1) * (e(4) * e(10) - e(6) * e(8)) +
                      e(2) * (e(4) * e(9) - e(5) * e(8));
    out[i] = std::cbrt(std::fabs(det));
  }
  Value v;
  v.data[0] = out;
  v.stride = m.stride ? 1 : 0;
  v.components = 1;
  return v;
}

}  // namespace kinora::dispTransform
#endif

KINORA_KERNELS_BEGIN

enum : uint32_t {
  kType,
  kScalar,
  kVector,
  kVectorSpace,
  kHeight,
  kDepth,
  kRemap,
  kCenter,
  kScaleSpace,
  kUseDirection,
  kDirection,
  kDirectionSpace
};
constexpr Param kParams[] = {
    param::integer("dispType", 1)
        .range(1, 4)
        .options("1 scalar, 2 vector, 3 Mudbox vector, 4 ZBrush vector")
        .help("What is transformed. 3: y lies along the normal in tangent space; 4 is read as 2."),
    param::number("dispScalar", 0.f).range(-1, 1).help("Distance, or what a map says of it."),
    param::vector("dispVector", 0, 0, 0).help("Vector, or what a map says of it."),
    param::integer("vectorSpace", 3)
        .range(1, 4)
        .options("1 world, 2 object, 3 tangent, 4 current")
        .help("Space of dispVector. Tangent: x along st's first direction, y towards its second, z along the normal. "
              "Current is the object's."),
    param::number("dispHeight", 1.f).range(0, 2).help("How far values that lead outward reach."),
    param::number("dispDepth", 1.f).range(0, 2).help("How far values that lead inward reach."),
    param::integer("dispRemapMode", 1)
        .range(1, 3)
        .options("1 none, 2 centered, 3 interpolate")
        .help("1: values times dispHeight. 2: what is above dispCenter times dispHeight, below times dispDepth. 3: 0 "
              "is -dispDepth, .5 nothing, 1 dispHeight, on a smooth curve."),
    param::number("dispCenter", 0.5f).help("Value that moves nothing, where dispRemapMode is 2."),
    param::string("dispScaleSpace", "object").help("Space in whose units lengths are: object, world, or a name."),
    param::flag("useDispDirection", false).help("1: distances lead along dispDirection, as resultXYZ."),
    param::vector("dispDirection", 0, 1, 0).help("Direction of distances; any length."),
    param::string("dispDirectionSpace", "object").help("Space of dispDirection: object, world, or a name."),
    param::output(Type::Vector, "resultXYZ"),
    param::output(Type::Float, "resultX"),
    param::output(Type::Float, "resultY"),
    param::output(Type::Float, "resultZ"),
    param::output(Type::Float, "resultF"),
};

struct PxrDispTransform {
  template <int W>
  static KN_INLINE Float<W> remapped(int mode, Float<W> x, Float<W> height, Float<W> depth, Float<W> center) {
    using F = Float<W>;
    if (mode == 1) return x * height;
    if (mode == 2) {
      const F d = x - center;
      return d * select(d < F(0.f), depth, height);
    }
    // Catmull-Rom through -depth, -depth, 0, height, height: two pieces
    const F t = clamp(x, F(0.f), F(1.f)) * F(2.f);
    const Mask<W> upper = t >= F(1.f);
    const F zero(0.f), s = select(upper, t - F(1.f), t);
    const F p0 = -depth, p1 = select(upper, zero, -depth), p2 = select(upper, height, zero), p3 = height;
    const F a = F(3.f) * (p1 - p2) + p3 - p0, b = F(2.f) * p0 - F(5.f) * p1 + F(4.f) * p2 - p3, d = p2 - p0;
    return fma(F(0.5f) * s, fma(s, fma(s, a, b), d), p1);
  }

  // From a space to the object's, without growth.
  template <int W>
  static KN_INLINE Vec3<W> turnedToObject(const MatrixValue& m, const Value& lengths, Vec3<W> v, At at) {
    const Float<W> growth = loadFloat<W>(lengths, at);
    const Vec3<W> moved = moveBy<W>(m, Moves::Vector, v, at);
    return moved * select(growth > Float<W>(0.f), Float<W>(1.f) / growth, Float<W>(0.f));
  }

  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    using F = Float<W>;
    const auto toObject = [&](const char* space) {
      MatrixValue m;
      c->fn->matrix(c, space && *space ? space : "object", "object", &m);
      return m;
    };
    const int type = fixedInteger(*c, kType), mode = fixedInteger(*c, kRemap), space = fixedInteger(*c, kVectorSpace);
    const bool isScalar = type == 1, isDirected = isScalar && fixedInteger(*c, kUseDirection) != 0,
               isTangent = !isScalar && space == 3;
    const Value height = c->param(kHeight), depth = c->param(kDepth), center = c->param(kCenter);
    const Value scale = dispTransform::lengthsOf(*c, toObject(c->fn->text(c, kScaleSpace)));
    const Value in = isScalar ? c->param(kScalar) : c->param(kVector);
    const Value direction = isDirected ? c->param(kDirection) : Value();
    const MatrixValue way = toObject(isDirected                ? c->fn->text(c, kDirectionSpace)
                                     : isTangent               ? "render"
                                     : space == 1 && !isScalar ? "world"
                                                               : "object");
    const Value growth = dispTransform::lengthsOf(*c, way);
    const Value tangent = isTangent ? c->builtin(Builtin::Tangent) : Value();
    const Value alongS = isTangent ? c->fn->gradient(c, nullptr, 0) : Value(),
                alongT = isTangent ? c->fn->gradient(c, nullptr, 1) : Value();
    const bool one = !isTangent && way.uniform() && allUniform({&height, &depth, &center, &scale, &in, &direction});
    float *vector[3], *number[3];
    makeOutput(*c, args->outputs[0], 3, one, vector);
    makeOutput(*c, args->outputs[4], 1, one, number);
    for (uint32_t i = 0; i < extent(*c, one); i += W) {
      const At at{i, false};
      const F h = loadFloat<W>(height, at), d = loadFloat<W>(depth, at), middle = loadFloat<W>(center, at),
              unit = loadFloat<W>(scale, at);
      F distance(0.f);
      Vec3<W> v(0.f);
      if (isScalar) {
        distance = remapped<W>(mode, loadFloat<W>(in, at), h, d, middle) * unit;
        if (isDirected) {
          const Vec3<W> along = turnedToObject<W>(way, growth, loadVec<W>(direction, at), at);
          const F l = length(along);
          v = along * select(l > F(0.f), distance / l, F(0.f));
          distance = F(0.f);
        }
      } else {
        v = loadVec<W>(in, at);
        v = Vec3<W>(remapped<W>(mode, v.x, h, d, middle), remapped<W>(mode, v.y, h, d, middle),
                    remapped<W>(mode, v.z, h, d, middle));
        if (isTangent) {
          const Vec3<W> x = loadVec<W>(tangent, at), z = Vec3<W>::load(c->N, i);
          // towards growing t: what is mirrored turns its normal's side over, or st
          const Vec3<W> turned = cross(z, x);
          const Mask<W> mirrored = dot(cross(loadVec<W>(alongS, at), loadVec<W>(alongT, at)), z) < F(0.f);
          const Vec3<W> y = select(mirrored, -turned, turned);
          v = type == 3 ? x * v.x + z * v.y + y * v.z : x * v.x + y * v.y + z * v.z;
        }
        v = turnedToObject<W>(way, growth, v, at) * unit;
      }
      v.store(vector, i);
      distance.store(number[0] + i);
    }
    shareComponents(*args, 0);
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrDispTransform,
               .help = "Says what a map of displacement means: its middle, its reach, the space of its vectors.",
               .params = kParams)
