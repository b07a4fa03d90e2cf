// Helpers for pattern authors: loading values and making outputs for W points. Included per target.
#include <kinora/pattern.h>
#include <kinora/primvar_kind.h>
#include <cstring>
#include <initializer_list>
#include <iterator>
#ifdef KINORA_KERNEL_FILE
#include <kinora/simd/foreach_target.h>
#endif
#include <kinora/bxdf_author.h>

// A colour and its parts, the outputs that shareComponents() fills (the convention of reference colour nodes).
#ifndef KINORA_COLOR_OUTPUTS
#define KINORA_COLOR_OUTPUTS                                                      \
  param::output(Type::Color, "resultRGB"), param::output(Type::Float, "resultR"), \
      param::output(Type::Float, "resultG"), param::output(Type::Float, "resultB")
#endif

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

// resultRGB at `rgb`, its parts at rgb+1 .. rgb+3 (KINORA_COLOR_OUTPUTS): parts share the arrays.
inline void shareComponents(const PatternArgs& a, uint32_t rgb) {
  for (uint32_t i = 0; i < 3; ++i) {
    Value& v = a.outputs[rgb + 1 + i];
    v.data[0] = a.outputs[rgb].data[i];
    v.stride = a.outputs[rgb].stride;
    v.components = 1;
  }
}

// ---- inputs ----
// Fixed parameters (modes, switches) are the same for all points.
inline int fixedInteger(const Context& c, uint32_t index) { return int(c.param(index).data[0][0]); }

inline bool allUniform(std::initializer_list<const Value*> values) {
  for (const Value* v : values)
    if (!v->uniform()) return false;
  return true;
}

// One component of a value; a component that it lacks repeats the last one it has.
template <int W>
KN_INLINE Float<W> loadComponent(const Value& v, uint32_t k, At at) {
  const uint32_t last = v.components > 1 ? v.components - 1 : 0;
  const float* p = v.data[k < last ? k : last];
  return v.stride ? loadFloat<W>(p, at) : Float<W>(p[0]);
}

// What a struct parameter is connected to, else the surface's texture coordinates. `gradients`: of a parameter
// declared with them, they are there; a manifold that tells none lies like the texture coordinates.
inline Manifold surfaceManifold(const Context& c, uint32_t index, bool gradients = false) {
  Manifold m;
  if (const Manifold* connected = c.fn->manifold(&c, index)) {
    m = *connected;
  } else {
    m.q = c.builtin(Builtin::St);
    m.radius = c.builtin(Builtin::StRadius);
  }
  for (uint32_t k = 0; gradients && k < 2; ++k)
    if (!m.gradient[k].components) m.gradient[k] = c.fn->gradient(&c, nullptr, k);
  return m;
}
// A manifold's position at W points; z is 0 of a 2D one.
template <int W>
KN_INLINE Vec3<W> loadPosition(const Manifold& m, At at) {
  return {loadComponent<W>(m.q, 0, at), loadComponent<W>(m.q, 1, at),
          m.dimensions > 2 ? loadComponent<W>(m.q, 2, at) : Float<W>(0.f)};
}

// Handle of a file parameter at a point; negative: no file.
inline int32_t handleAt(const Value& handles, uint32_t point) {
  int32_t h;
  std::memcpy(&h, &handles.data[0][handles.stride ? point : 0], sizeof h);
  return h;
}
inline bool hasFile(const Value& handles) { return !handles.uniform() || handleAt(handles, 0) >= 0; }

// ---- outputs ----
// A node whose inputs are all uniform computes one chunk of lanes and hands on a uniform value:
//   const bool one = allUniform({&a, &b});
//   makeOutput(c, args->outputs[0], 3, one, out);
//   for (uint32_t i = 0; i < extent(c, one); i += W) ...store(out, i);
// The loop runs to `padded`, so that the padding of outputs holds valid numbers at every width.
inline uint32_t extent(const Context& c, bool uniform) { return uniform ? 1 : c.padded; }
inline void makeOutput(const Context& c, Value& out, uint32_t components, bool uniform, float* data[3]) {
  for (uint32_t i = 0; i < 3; ++i) {
    data[i] = i < components ? c.alloc<float>(uniform ? kPad : c.padded) : nullptr;
    out.data[i] = data[i];
  }
  out.stride = uniform ? 0 : 1;
  out.components = components;
}
// An output that is one of another's components.
inline void shareComponent(const Value& from, uint32_t component, Value& out) {
  out = Value();
  out.data[0] = from.data[component];
  out.stride = from.stride;
  out.components = 1;
}
// `count` numbers, the same for all points.
inline Value constantValue(const Context& c, uint32_t count, const float* numbers) {
  Value v;
  v.components = count;
  for (uint32_t i = 0; i < count; ++i) {
    float* p = c.alloc<float>(1);
    *p = numbers[i];
    v.data[i] = p;
  }
  return v;
}

// The elliptical footprints of lookups at a manifold, or at the texture coordinates where none is connected, for
// ContextFunctions::texture: begin, store each chunk of points, then axes().
class LookupEllipses {
 public:
  // param: the manifold. flipsT: the lookup takes 1 - t.
  LookupEllipses(const Context& c, uint32_t param, bool flipsT) : flipsT_(flipsT) {
    if (const Manifold* m = c.fn->manifold(&c, param)) {
      in_[0] = m->axis[0];
      in_[1] = m->axis[1];
    } else if (!c.fn->ellipses(&c, nullptr, in_)) {
      return;
    }
    has_ = in_[0].components > 1 && in_[1].components > 1;
    for (uint32_t k = 0; has_ && k < 4; ++k) axes_[k] = c.alloc<float>(c.padded);
  }
  // Scaled, then widened by `blur` and to `least` on all sides, as the parameters of lookups ask.
  template <int W>
  KN_INLINE void store(uint32_t i, Float<W> scale, Float<W> blur, Float<W> least) const {
    using F = Float<W>;
    if (!has_) return;
    const At at{i, false};
    F s[2], t[2], length[2];
    for (uint32_t k = 0; k < 2; ++k) {
      s[k] = loadComponent<W>(in_[k], 0, at);
      t[k] = loadComponent<W>(in_[k], 1, at);
      length[k] = sqrt(s[k] * s[k] + t[k] * t[k]);
    }
    for (uint32_t k = 0; k < 2; ++k) {
      const F wanted = max(fma(length[k], scale, blur), least);
      // an axis without length is widened across the other one; circles stay what they are
      const Mask<W> is = length[k] > F(0.f), isOther = length[1 - k] > F(0.f);
      const F l = select(is, length[k], select(isOther, length[1 - k], F(1.f)));
      const F x = select(is, s[k], F(0.f) - t[1 - k]), y = select(is, t[k], s[1 - k]);
      (x * wanted / l).store(axes_[2 * k] + i);
      (y * (flipsT_ ? F(0.f) - wanted : wanted) / l).store(axes_[2 * k + 1] + i);
    }
  }
  const float* const* axes() const { return has_ ? axes_ : nullptr; }

 private:
  Value in_[2];
  float* axes_[4] = {};
  bool flipsT_, has_ = false;
};

// `B` has `template <int W> static void compute(const Context*, const PatternArgs*)`, or is a pointwise node (below).
template <class B>
struct PointwiseRunner;
template <class B>
struct PatternRunner {
  template <int W>
  static constexpr PatternFunctions table() {
    if constexpr (requires { typename B::Setup; })
      return PointwiseRunner<B>::template table<W>();
    else
      return PatternFunctions{&B::template compute<W>};
  }
};

// ---- spaces ----
// How a value moves with a matrix: points with its translation, normals with the inverse's transpose.
enum class Moves { No, Point, Vector, Normal };
inline Moves movesLike(const char* type) {
  return !std::strcmp(type, "point")    ? Moves::Point
         : !std::strcmp(type, "vector") ? Moves::Vector
         : !std::strcmp(type, "normal") ? Moves::Normal
                                        : Moves::No;
}
// A vector at W points moved by a matrix. Normals move by its inverse's transpose: for them hand over the matrix of
// the way back.
template <int W>
KN_INLINE Vec3<W> moveBy(const MatrixValue& m, Moves how, Vec3<W> v, At at) {
  using F = Float<W>;
  const auto entry = [&](uint32_t i) { return m.stride ? loadFloat<W>(m.m[i], at) : F(m.m[i][0]); };
  const uint32_t row = how == Moves::Normal ? 1 : 4, column = how == Moves::Normal ? 4 : 1;
  F r[3];
  for (uint32_t k = 0; k < 3; ++k) {
    r[k] = how == Moves::Point ? entry(12 + k) : F(0.f);
    r[k] = fma(v.x, entry(column * k), r[k]);
    r[k] = fma(v.y, entry(row + column * k), r[k]);
    r[k] = fma(v.z, entry(2 * row + column * k), r[k]);
  }
  return Vec3<W>(r[0], r[1], r[2]);
}
// Takes a value from one named space to another; unknown spaces leave it where it is.
template <int W>
inline void between(const Context& c, const char* from, const char* to, Moves how, Value& v) {
  MatrixValue m;
  const bool normal = how == Moves::Normal;
  if (how == Moves::No || !(normal ? c.fn->matrix(&c, to, from, &m) : c.fn->matrix(&c, from, to, &m))) return;
  const bool one = v.uniform() && m.uniform();
  const Value in = v;
  float* out[3];
  makeOutput(c, v, 3, one, out);
  for (uint32_t i = 0; i < extent(c, one); i += W) {
    const At at{i, false};
    const Vec3<W> x(loadComponent<W>(in, 0, at), loadComponent<W>(in, 1, at), loadComponent<W>(in, 2, at));
    moveBy<W>(m, how, x, at).store(out, i);
  }
}

template <int W>
inline void toSpace(const Context& c, const char* space, Moves how, Value& v) {
  between<W>(c, "render", space, how, v);
}

// ---- primitive variables ----
// A primitive variable at the points of a context, whose objects may have one of that name or not.
struct Primvar {
  Value value;   // components 0: no object of the scene has it
  Value radius;  // ContextFunctions::primvar's; null where value is
  bool isSomewhere = false, isEverywhere = false;
  // name: null or "" for none.
  Primvar(const Context& c, const char* name) {
    if (!name || !*name) return;
    value = c.fn->primvar(&c, name, &radius);
    if (!value.components) return;
    isEverywhere = isSomewhere = true;
    if (radius.components < 3) return;  // of contexts whose points are all alike
    isSomewhere = false;
    for (uint32_t i = 0; i < c.count; ++i) (components()[i] > 0 ? isSomewhere : isEverywhere) = components()[i] > 0;
  }
  // By point; null where all points have as many as the value.
  const float* components() const { return radius.components < 3 ? nullptr : radius.data[kPrimvarComponents]; }
  const float* kinds() const { return radius.components < 3 ? nullptr : radius.data[kPrimvarKind]; }
};

// `a` at points that have more than `least`, else `b`; as many components as `a` has, numbers fill them.
inline Value chosenByPoint(const Context& c, const float* has, float least, const Value& a, const Value& b) {
  Value out;
  float* data[3];
  makeOutput(c, out, a.components, false, data);
  for (uint32_t k = 0; k < a.components; ++k) {
    const float* other = b.data[k < b.components ? k : b.components - 1];
    for (uint32_t i = 0; i < c.padded; ++i)
      data[k][i] = has[i] > least ? a.data[k][a.stride ? i : 0] : other[b.stride ? i : 0];
  }
  return out;
}
// The variable where objects have it, else `otherwise`.
inline Value primvarOr(const Context& c, const Primvar& v, const Value& otherwise) {
  if (v.isEverywhere) return v.value;
  return v.isSomewhere ? chosenByPoint(c, v.components(), 0, v.value, otherwise) : otherwise;
}
inline Value footprintOr(const Context& c, const Primvar& v, const Value& otherwise) {
  if (!v.isSomewhere || !v.radius.components) return otherwise;
  Value own;
  shareComponent(v.radius, kPrimvarFootprint, own);
  return v.isEverywhere ? own : chosenByPoint(c, v.components(), 0, own, otherwise);
}

// Positions or directions (`how`) that a variable of three components says, in a named space; `otherwise`, which lies
// in that space, where an object has none. They are the object's own: what is said as point, vector or normal moves as
// such to its space, what is said as numbers or as a colour is there already, and moves on as `how` says.
template <int W>
inline Value placesOr(const Context& c, const Primvar& v, const char* space, Moves how, const Value& otherwise) {
  if (!v.isSomewhere || v.value.components != 3) return otherwise;
  static constexpr Moves kMoves[] = {Moves::No, Moves::Point, Moves::Vector, Moves::Normal};
  const float* const kinds = v.kinds();
  uint32_t there = kinds ? 0 : 1u << uint32_t(how);
  for (uint32_t i = 0; kinds && i < c.count; ++i)
    if (v.components()[i] > 0) there |= 1u << uint32_t(kinds[i]);
  Value out;
  for (uint32_t kind = 0; kind < 4; ++kind) {
    if (!(there >> kind & 1)) continue;
    Value x = v.value;
    if (kMoves[kind] == how) {
      toSpace<W>(c, space, how, x);
    } else {
      toSpace<W>(c, "object", kMoves[kind], x);
      if (std::strcmp(space, "object")) between<W>(c, "object", space, how, x);
    }
    if (!out.components) {
      out = x;
      continue;
    }
    float* is = c.alloc<float>(c.padded);
    for (uint32_t i = 0; i < c.padded; ++i) is[i] = kinds[i] == float(kind);
    out = chosenByPoint(c, is, 0, x, out);
  }
  return v.isEverywhere || !v.components() ? out : chosenByPoint(c, v.components(), 0, out, otherwise);
}

// The gradients of the components of a position that toSpace() takes from render space: of P, or of a variable where
// objects have it.
template <int W>
inline void positionGradients(const Context& c, const char* space, const char* name, const Primvar& primvar,
                              Value out[3]) {
  MatrixValue m;
  c.fn->matrix(&c, "render", space, &m);
  Value own[3];
  for (uint32_t j = 0; primvar.isSomewhere && j < 3; ++j) own[j] = c.fn->gradient(&c, name, j);
  for (uint32_t k = 0; k < 3; ++k) {
    float* g[3];
    makeOutput(c, out[k], 3, false, g);
    for (uint32_t i = 0; i < c.padded; i += W) {
      const At at{i, false};
      const auto entry = [&](uint32_t j) {
        return m.stride ? loadFloat<W>(m.m[4 * j + k], at) : Float<W>(m.m[4 * j + k][0]);
      };
      const Vec3<W> ofP(entry(0), entry(1), entry(2));
      Vec3<W> sum = ofP;
      if (own[0].components)
        sum = fma(loadVec<W>(own[0], at), sum.x, fma(loadVec<W>(own[1], at), sum.y, loadVec<W>(own[2], at) * sum.z));
      if (primvar.isSomewhere && !primvar.isEverywhere)
        sum = select(Float<W>::load(primvar.components() + i) > Float<W>(0.f), sum, ofP);
      sum.store(g, i);
    }
  }
}

// A parameter whose very value decides what runs, beside what is connected to it: materials that differ in it have
// programs of their own, so that all points of a context have the same.
constexpr Param structural(Param p) {
  p.flags |= kParamFixed;
  return p;
}

// For nodes that make one colour (kComponents 3) or number (1) of inputs at the same point. `B` has
//   struct Setup {                            // values, modes, ...: read once a context
//     explicit Setup(const Context&);
//     bool uniform() const;
//   };
//   static constexpr uint32_t kComponents;
//   template <int W> static KN_INLINE Vec3<W> at(const Setup&, At);    // x alone counts for numbers
// The first output is the result; further ones are a colour's parts, or a number's repetition as a colour and its
// parts.
template <class B>
struct PointwiseRunner {
  template <int W>
  static void compute(const Context* c, const PatternArgs* a) {
    const typename B::Setup setup(*c);
    const bool one = setup.uniform();
    float* out[3];
    makeOutput(*c, a->outputs[0], B::kComponents, one, out);
    for (uint32_t i = 0; i < extent(*c, one); i += W) {
      const Vec3<W> v = B::template at<W>(setup, At{i, false});
      if constexpr (B::kComponents == 3) {
        v.store(out, i);
      } else {
        v.x.store(out[0] + i);
      }
    }
    if (B::kComponents == 3 && a->outputCount >= 4) shareComponents(*a, 0);
    if (B::kComponents == 1 && a->outputCount >= 5) {
      a->outputs[1] = a->outputs[0];
      a->outputs[1].components = 3;
      a->outputs[1].data[1] = a->outputs[1].data[2] = a->outputs[0].data[0];
      shareComponents(*a, 1);
    }
  }
  template <int W>
  static constexpr PatternFunctions table() {
    return PatternFunctions{&compute<W>};
  }
};
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif

#include <kinora/simd/tables.h>

// Ends the file of a plug-in, whose struct has its name.
#undef KINORA_PATTERN
#define KINORA_PATTERN(Name, ...) KINORA_PLUGIN(Name, PatternRunner<Name>, PatternPlugin, __VA_ARGS__)
