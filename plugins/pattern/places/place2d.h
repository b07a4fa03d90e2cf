// Texture coordinates placed on a plane: chosen from primitive variables, turned, scaled and shifted about the origin,
// in this order, then inverted. What PxrManifold2D, PxrBumpManifold2D and the manifolds of tiles have in common. The
// footprint grows with the larger of the two scales, so that textures are never sampled too finely. Included per
// target.
#include <kinora/pattern_author.h>

#ifndef KINORA_PLACE2D_ONCE
#define KINORA_PLACE2D_ONCE
namespace kinora {
// Indices of the parameters; kNoPlaceParam: the node has no such one.
inline constexpr uint32_t kNoPlaceParam = ~0u;
struct PlaceParams {
  uint32_t angle, scaleS, scaleT, offsetS, offsetT, invertS, invertT, primvarS, primvarT;
  uint32_t globalScale = kNoPlaceParam;
};
#define KINORA_PLACE_ANGLE param::number("angle", 0.f).range(-180, 180).help("Rotation about the origin, degrees.")
#define KINORA_PLACE_PARAMS                                                                 \
  param::number("scaleS", 1.f).range(-8, 8).help("Factor of s: repetitions of a texture."), \
      param::number("scaleT", 1.f).range(-8, 8).help("Factor of t."),                       \
      param::number("offsetS", 0.f).range(-1, 1).help("Added to s after scaling."),         \
      param::number("offsetT", 0.f).range(-1, 1).help("Added to t after scaling.")
#define KINORA_PLACE_PRIMVARS                                                                \
  param::string("primvarS", "")                                                              \
      .help("Primitive variable of s, or of s and t when it has two components; \"\": st."), \
      param::string("primvarT", "").help("Primitive variable of t; \"\": the second component of primvarS.")
}  // namespace kinora
#endif

#if defined(KINORA_PLACE2D_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_PLACE2D_H_TARGET
#undef KINORA_PLACE2D_H_TARGET
#else
#define KINORA_PLACE2D_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

class Place2D {
 public:
  Place2D(const Context& c, const PlaceParams& p)
      : c_(c),
        angle_(c.param(p.angle)),
        scaleS_(c.param(p.scaleS)),
        scaleT_(c.param(p.scaleT)),
        offsetS_(c.param(p.offsetS)),
        offsetT_(c.param(p.offsetT)) {
    if (p.globalScale != kNoPlaceParam) {
      global_ = c.param(p.globalScale);
    } else {
      const float one = 1.f;
      global_ = constantValue(c, 1, &one);
    }
    invertS_ = p.invertS != kNoPlaceParam && fixedInteger(c, p.invertS) != 0;
    invertT_ = p.invertT != kNoPlaceParam && fixedInteger(c, p.invertT) != 0;
    turned_ = !angle_.uniform() || angle_.data[0][0] != 0.f;
    find(p.primvarS == kNoPlaceParam ? nullptr : c.fn->text(&c, p.primvarS),
         p.primvarT == kNoPlaceParam ? nullptr : c.fn->text(&c, p.primvarT));
  }
  bool uniform() const {
    return !hasAxes() &&
           allUniform({&angle_, &scaleS_, &scaleT_, &offsetS_, &offsetT_, &global_, &inS_, &inT_, &inRadius_});
  }
  // Turned, scaled and shifted; not inverted, since nodes that cut the plane into tiles invert within those.
  template <int W>
  KN_INLINE void at(At at, Float<W>& s, Float<W>& t, Float<W>& radius) const {
    s = loadFloat<W>(inS_, at);
    t = loadFloat<W>(inT_, at);
    if (turned_) {
      Float<W> sine, cosine;
      turning(at, sine, cosine);
      const Float<W> turnedS = fms(s, cosine, t * sine);
      t = fma(s, sine, t * cosine);
      s = turnedS;
    }
    const Float<W> g = loadFloat<W>(global_, at), fs = loadFloat<W>(scaleS_, at) * g,
                   ft = loadFloat<W>(scaleT_, at) * g;
    s = fma(s, fs, loadFloat<W>(offsetS_, at));
    t = fma(t, ft, loadFloat<W>(offsetT_, at));
    radius = loadFloat<W>(inRadius_, at) * max(abs(fs), abs(ft));
  }
  // Whether some footprints are ellipses, and half diameter k of them, turned and scaled as the place.
  bool hasAxes() const { return inAxis_[0].components > 1; }
  template <int W>
  KN_INLINE void axisAt(uint32_t k, At at, Float<W>& s, Float<W>& t) const {
    s = loadComponent<W>(inAxis_[k], 0, at);
    t = loadComponent<W>(inAxis_[k], 1, at);
    if (turned_) {
      Float<W> sine, cosine;
      turning(at, sine, cosine);
      const Float<W> turnedS = s * cosine - t * sine;
      t = s * sine + t * cosine;
      s = turnedS;
    }
    const Float<W> g = loadFloat<W>(global_, at);
    s = s * loadFloat<W>(scaleS_, at) * g;
    t = t * loadFloat<W>(scaleT_, at) * g;
  }
  // A manifold of the inverted coordinates, which are components of `place`.
  template <int W>
  void makeManifold(Manifold& m, Value& outS, Value& outT) const {
    using F = Float<W>;
    const bool one = uniform();
    float *st[3], *radius[3];
    m.dimensions = 2;
    makeOutput(c_, m.q, 2, one, st);
    makeOutput(c_, m.radius, 1, one, radius);
    for (uint32_t i = 0; i < extent(c_, one); i += W) {
      F s, t, r;
      at<W>(At{i, false}, s, t, r);
      (invertS_ ? F(1.f) - s : s).store(st[0] + i);
      (invertT_ ? F(1.f) - t : t).store(st[1] + i);
      r.store(radius[0] + i);
    }
    for (uint32_t k = 0; hasAxes() && k < 2; ++k) {
      float* axis[3];
      makeOutput(c_, m.axis[k], 2, false, axis);
      for (uint32_t i = 0; i < c_.padded; i += W) {
        F s, t;
        axisAt<W>(k, At{i, false}, s, t);
        (invertS_ ? F(0.f) - s : s).store(axis[0] + i);
        (invertT_ ? F(0.f) - t : t).store(axis[1] + i);
      }
    }
    shareComponent(m.q, 0, outS);
    shareComponent(m.q, 1, outT);
  }
  // The gradients of s and t, turned, scaled and inverted like them.
  template <int W>
  void makeGradients(Manifold& m) const {
    using F = Float<W>;
    const float signS = invertS_ ? -1.f : 1.f, signT = invertT_ ? -1.f : 1.f;
    const Value ofS = gradientOf(0), ofT = gradientOf(1);
    float *outS[3], *outT[3];
    makeOutput(c_, m.gradient[0], 3, false, outS);
    makeOutput(c_, m.gradient[1], 3, false, outT);
    for (uint32_t i = 0; i < c_.padded; i += W) {
      const At at{i, false};
      Vec3<W> s = loadVec<W>(ofS, at), t = loadVec<W>(ofT, at);
      if (turned_) {
        F sine, cosine;
        turning(at, sine, cosine);
        const Vec3<W> turnedS = s * cosine - t * sine;
        t = s * sine + t * cosine;
        s = turnedS;
      }
      const F g = loadFloat<W>(global_, at);
      (s * (loadFloat<W>(scaleS_, at) * g * F(signS))).store(outS, i);
      (t * (loadFloat<W>(scaleT_, at) * g * F(signT))).store(outT, i);
    }
  }

 private:
  // Where s or t comes from: a component of a primitive variable, or (null) of the surface's own.
  struct Source {
    const char* primvar = nullptr;
    uint32_t component = 0;
    const float* has = nullptr;  // by point, where not all objects have it: how many components
  };
  // Takes a component of a variable for one coordinate, at points whose object has more than `least` of them.
  void take(const Primvar& v, const char* name, uint32_t component, float least, Value& in, Source& from) {
    Value own;
    shareComponent(v.value, component, own);
    uint32_t points = v.components() ? 0 : c_.count;
    for (uint32_t i = 0; v.components() && i < c_.count; ++i) points += v.components()[i] > least;
    const bool isWhole = points == c_.count, isAnywhere = points > 0;
    if (!isAnywhere) return;
    from = {name, component, nullptr};
    if (isWhole) {
      in = own;
      return;
    }
    in = chosenByPoint(c_, v.components(), least, own, in);
    float* has = c_.alloc<float>(c_.padded);
    for (uint32_t i = 0; i < c_.padded; ++i) has[i] = v.components()[i] > least;
    from.has = has;
  }
  Value gradientOf(uint32_t coordinate) const {
    const Source& from = from_[coordinate];
    const Value v = c_.fn->gradient(&c_, from.primvar, from.component);
    return from.has ? chosenByPoint(c_, from.has, 0, v, c_.fn->gradient(&c_, nullptr, coordinate)) : v;
  }
  // The surface's own where the named variables are missing.
  void find(const char* nameS, const char* nameT) {
    const Value q = c_.builtin(Builtin::St);
    inRadius_ = c_.builtin(Builtin::StRadius);
    shareComponent(q, 0, inS_);
    shareComponent(q, 1, inT_);
    from_[1].component = 1;
    const Primvar ofS(c_, nameS), ofT(c_, nameT);
    if (ofS.value.components) {
      take(ofS, nameS, 0, 0, inS_, from_[0]);
      if (ofS.value.components > 1) take(ofS, nameS, 1, 1, inT_, from_[1]);
      inRadius_ = footprintOr(c_, ofS, inRadius_);
    }
    if (ofT.value.components == 1) take(ofT, nameT, 0, 0, inT_, from_[1]);
    if (ofT.value.components > 1) take(ofT, nameT, 1, 0, inT_, from_[1]);
    findAxes();
  }
  // Of both coordinates together: the variable's where it gives both, the surface's own where nothing gives either,
  // point by point; else circles.
  void findAxes() {
    const Source &s = from_[0], &t = from_[1];
    if (!s.primvar && !t.primvar) {
      c_.fn->ellipses(&c_, nullptr, inAxis_);
      return;
    }
    const bool isOne =
        s.primvar && t.primvar && !std::strcmp(s.primvar, t.primvar) && s.component == 0 && t.component == 1;
    Value ofVariable[2], own[2];
    const bool hasOfVariable = isOne && c_.fn->ellipses(&c_, s.primvar, ofVariable);
    if (!s.has && !t.has) {
      for (int k = 0; k < 2 && hasOfVariable; ++k) inAxis_[k] = ofVariable[k];
      return;
    }
    const bool hasOwn = c_.fn->ellipses(&c_, nullptr, own);
    const auto isFrom = [](const Source& from, uint32_t i) { return from.primvar && (!from.has || from.has[i] > 0); };
    for (int k = 0; k < 2 && (hasOfVariable || hasOwn); ++k) {
      float* out[3];
      makeOutput(c_, inAxis_[k], 2, false, out);
      for (uint32_t i = 0; i < c_.padded; ++i) {
        const bool isVariable = isFrom(s, i) && isFrom(t, i), isOwn = !isFrom(s, i) && !isFrom(t, i);
        const Value* const axis = isVariable && hasOfVariable ? ofVariable : isOwn && hasOwn ? own : nullptr;
        for (int j = 0; j < 2; ++j) out[j][i] = axis ? axis[k].data[j][axis[k].stride ? i : 0] : 0.f;
      }
    }
  }
  template <int W>
  KN_INLINE void turning(At at, Float<W>& sine, Float<W>& cosine) const {
    sincos(loadFloat<W>(angle_, at) * Float<W>(kPi / 180.f), sine, cosine);
  }

  const Context& c_;
  Value angle_, scaleS_, scaleT_, offsetS_, offsetT_, global_, inS_, inT_, inRadius_;
  Value inAxis_[2];
  Source from_[2];
  bool invertS_, invertT_, turned_;
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
