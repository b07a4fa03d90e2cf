// PxrFacingRatio: the cosine between the normal and the view (or a direction), as it is, through a gamma, or as
// Fresnel reflectance of a dielectric. 1 where the surface faces, 0 at grazing angles.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrFacingRatio/PxrFacingRatio.cpp"
#include <kinora/pattern_author.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kUse, kDirection, kCoordSys, kFaceForward, kClamp, kInvert, kMode, kGamma, kIor, kBumpNormal };
constexpr Param kParams[] = {
    param::integer("use", 0).options("0 view, 1 direction").help("What the surface faces."),
    param::vector("direction", 0, 1, 0).help("Direction, where use is 1."),
    param::string("coordSys", "world").help("Space of direction."),
    param::flag("faceForward", true).help("1: both sides of the surface count as facing."),
    param::flag("clamp", false).help("1: negative results become 0."),
    param::flag("invert", false).help("1: one minus the result."),
    param::integer("mode", 0).range(0, 2).options("0 linear, 1 gamma, 2 Fresnel").help("Curve of the result."),
    param::number("gamma", 1.f).range(0.2f, 5).help("Power 1 / gamma, where mode is 1."),
    param::number("ior", 1.5f).range(1.01f, 3).help("Index of refraction, where mode is 2."),
    param::normal("bumpNormal").help("Shading normal from a bump pattern."),
    param::output(Type::Float, "resultF"),
};

struct PxrFacingRatio {
  static constexpr uint32_t kComponents = 1;
  struct Setup {
    const Context* context;
    Value direction, gamma, ior, bump;
    bool useDirection, faceForward, clamped, inverted, bumped;
    int mode;
    MatrixValue toRender;
    explicit Setup(const Context& c)
        : context(&c),
          direction(c.param(kDirection)),
          gamma(c.param(kGamma)),
          ior(c.param(kIor)),
          bump(c.param(kBumpNormal)) {
      useDirection = fixedInteger(c, kUse) == 1;
      faceForward = fixedInteger(c, kFaceForward) != 0;
      clamped = fixedInteger(c, kClamp) != 0;
      inverted = fixedInteger(c, kInvert) != 0;
      mode = fixedInteger(c, kMode);
      bumped = isBumped(bump);
      const char* space = c.fn->text(&c, kCoordSys);
      c.fn->matrix(&c, space && *space ? space : "world", "render", &toRender);
    }
    bool uniform() const { return false; }
  };
  // Unpolarised Fresnel reflectance at a cosine, from outside.
  template <int W>
  static KN_INLINE Float<W> fresnel(Float<W> cosine, Float<W> eta) {
    using F = Float<W>;
    const F t = safeSqrt(F(1.f) - (F(1.f) - cosine * cosine) / (eta * eta));
    const F s = (cosine - eta * t) / (cosine + eta * t), p = (eta * cosine - t) / (eta * cosine + t);
    return (s * s + p * p) * F(0.5f);
  }
  template <int W>
  static KN_INLINE Vec3<W> at(const Setup& s, At at) {
    using F = Float<W>;
    const Surface<W> surface(*s.context, at);
    const Vec3<W> n = s.bumped ? bumpedNormal<W>(s.bump, surface) : surface.N;
    Vec3<W> d = surface.wo;
    if (s.useDirection) {
      d = moveBy<W>(s.toRender, Moves::Vector, loadVec<W>(s.direction, at), at);
      d = d * (F(1.f) / sqrt(max(dot(d, d), F(1e-30f))));
    }
    F x = dot(n, d);
    // normals are on the viewer's side already; the outside normal is the other one where a path is inside
    if (!s.faceForward) x = select(surface.entering, x, -x);
    if (s.faceForward) x = abs(x);
    if (s.mode == 1) x = copySign(pow(abs(x), F(1.f) / max(loadFloat<W>(s.gamma, at), F(1e-3f))), x);
    if (s.mode == 2) x = F(1.f) - fresnel(clamp(abs(x), F(1e-4f), F(1.f)), max(loadFloat<W>(s.ior, at), F(1.0001f)));
    if (s.inverted) x = F(1.f) - x;
    if (s.clamped) x = max(x, F(0.f));
    return Vec3<W>(x, x, x);
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrFacingRatio, .help = "How much a surface faces the viewer or a direction.", .params = kParams)
