// PxrManifold3D: the position of a point in a chosen space, or a reference position carried by the geometry, scaled.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrManifold3D/PxrManifold3D.cpp"
#include <kinora/pattern_author.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kScale, kUse, kPref, kCoordsys };
constexpr Param kParams[] = {
    param::number("scale", 1.f).range(-8, 8).help("Factor of the position: features per unit of length."),
    param::integer("use", 0).options("0 position, 1 primitive variable pref").help("Which position."),
    param::string("pref", "__Pref").help("Primitive variable with the reference position."),
    param::string("coordsys", "object").help("Space of the position."),
    param::output(Type::Struct, "result"),
    param::output(Type::Float, "resultX"),
    param::output(Type::Float, "resultY"),
    param::output(Type::Float, "resultZ"),
};

struct PxrManifold3D {
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    const char *space = c->fn->text(c, kCoordsys), *name = c->fn->text(c, kPref);
    if (!space || !*space) space = "object";
    Value p, r;
    if (!std::strcmp(space, "object")) {
      p = c->builtin(Builtin::Po);
      r = c->builtin(Builtin::PoRadius);
    } else {
      for (uint32_t k = 0; k < 3; ++k) p.data[k] = c->P[k];
      p.stride = 1;
      p.components = 3;
      toSpace<W>(*c, space, Moves::Point, p);
      r.data[0] = c->radius;
      r.stride = r.components = 1;
    }
    const Primvar reference(*c, fixedInteger(*c, kUse) == 1 ? name : nullptr);
    if (reference.value.components == 3) {
      p = placesOr<W>(*c, reference, space, Moves::Point, p);
      r = footprintOr(*c, reference, r);
    }
    const Value scale = c->param(kScale);
    const bool one = allUniform({&scale, &p, &r});
    Manifold& m = args->manifolds[0];
    m.dimensions = 3;
    float *q[3], *radius[3];
    makeOutput(*c, m.q, 3, one, q);
    makeOutput(*c, m.radius, 1, one, radius);
    for (uint32_t i = 0; i < extent(*c, one); i += W) {
      const At at{i, false};
      const Float<W> f = loadFloat<W>(scale, at);
      (loadVec<W>(p, at) * f).store(q, i);
      (loadFloat<W>(r, at) * abs(f)).store(radius[0] + i);
    }
    args->outputs[0] = m.q;
    for (uint32_t k = 0; k < 3; ++k) shareComponent(m.q, k, args->outputs[1 + k]);
    if (!(args->wanted[0] & kWantGradients)) return;
    Value of[3];
    positionGradients<W>(*c, space, name, reference, of);
    for (uint32_t k = 0; k < 2; ++k) {
      float* g[3];
      makeOutput(*c, m.gradient[k], 3, false, g);
      for (uint32_t i = 0; i < c->padded; i += W) {
        const At at{i, false};
        (loadVec<W>(of[k], at) * loadFloat<W>(scale, at)).store(g, i);
      }
    }
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrManifold3D, .help = "Positions in space for 3D patterns.", .params = kParams)
