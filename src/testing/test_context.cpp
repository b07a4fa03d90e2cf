#include <kinora/testing/test_context.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <new>
#include <stdexcept>

namespace kinora::testing {

namespace {
Vec3 anyPerpendicular(Vec3 n) {
  const Vec3 a = std::abs(n.x) < 0.7f ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  Vec3 t{a.y * n.z - a.z * n.y, a.z * n.x - a.x * n.z, a.x * n.y - a.y * n.x};
  const float s = 1 / std::sqrt(t.x * t.x + t.y * t.y + t.z * t.z);
  return {t.x * s, t.y * s, t.z * s};
}
}  // namespace

uint32_t TestPoints::count() const {
  return uint32_t(std::max({P.size(), N.size(), Ng.size(), wo.size(), tangent.size(), bitangent.size(), uv.size(),
                            radius.size(), time.size(), outerIor.size(), entering.size(), size_t(1)}));
}

struct TestContext::Impl {
  struct Block {
    explicit Block(size_t bytes) {
      // each allocation stands alone, so that a memory checker sees the end of each
      const size_t whole = std::max<size_t>((bytes + 63) & ~size_t(63), 64);
      memory = std::aligned_alloc(64, whole);
      if (!memory) throw std::bad_alloc();
      std::memset(memory, 0xff, whole);  // NaN as float, -1 as integer: unwritten values show
    }
    ~Block() { std::free(memory); }
    Block(const Block&) = delete;
    Block& operator=(const Block&) = delete;
    void* memory;
  };
  const Descriptor* plugin;
  Setting setting;
  uint32_t count, paddedCount;
  mutable std::vector<std::unique_ptr<Block>> blocks;
  std::vector<Value> params;
  std::vector<const Manifold*> manifolds;
  std::map<std::string, std::pair<Value, Value>, std::less<>> primvars;
  Value builtins[uint32_t(Builtin::Count)];
  TestTexture texture;
  uint8_t slotOfLobe[kMaxLobes] = {};
  uint16_t eventOfSlot[kMaxSlots] = {};
  ContextFunctions functions{};

  template <class T>
  T* alloc(size_t n) const {
    blocks.push_back(std::make_unique<Block>(n * sizeof(T)));
    return static_cast<T*>(blocks.back()->memory);
  }
  float* spread(const std::vector<float>& v) const {
    float* p = alloc<float>(paddedCount);
    for (uint32_t i = 0; i < paddedCount; ++i) p[i] = v[v.size() == 1 ? 0 : std::min(i, count - 1)];
    return p;
  }
  void spread(const std::vector<Vec3>& v, const float* out[3]) const {
    std::vector<float> c[3];
    for (const Vec3& e : v) {
      c[0].push_back(e.x);
      c[1].push_back(e.y);
      c[2].push_back(e.z);
    }
    for (int k = 0; k < 3; ++k) out[k] = spread(c[k]);
  }
  // point-major values to arrays; one group: uniform unless `varying`
  Value make(uint32_t components, const std::vector<float>& values, bool varying) const {
    Value v;
    v.components = components;
    const bool one = values.size() == components;
    if (!one && values.size() != size_t(components) * count)
      throw std::invalid_argument("a test context needs one value, or one for each point");
    v.stride = one && !varying ? 0 : 1;
    for (uint32_t k = 0; k < components && k < 3; ++k) {
      float* p = alloc<float>(v.stride ? paddedCount : 1);
      for (uint32_t i = 0; i < (v.stride ? paddedCount : 1); ++i)
        p[i] = values[(one ? 0 : std::min(i, count - 1)) * components + k];
      v.data[k] = p;
    }
    return v;
  }
  uint32_t paramIndex(const std::string& name) const {
    for (uint32_t i = 0; i < plugin->paramCount; ++i)
      if (name == plugin->params[i].name) return i;
    throw std::invalid_argument(std::string(plugin->name) + " has no parameter '" + name + "'");
  }
};

TestContext::TestContext(const Descriptor& plugin, const Setting& setting, const TestPoints& points,
                         const TestContextOptions& options)
    : impl_(std::make_unique<Impl>()) {
  Impl& m = *impl_;
  m.plugin = &plugin;
  m.setting = setting;
  m.count = points.count();
  m.paddedCount = padded(m.count);
  for (const size_t n : {points.P.size(), points.N.size(), points.wo.size(), points.uv.size(), points.radius.size(),
                         points.time.size(), points.outerIor.size(), points.entering.size()})
    if (n != 1 && n != m.count) throw std::invalid_argument("a test context needs one entry, or one for each point");

  Context& c = context_;
  c.count = m.count;
  c.padded = m.paddedCount;
  c.width = options.width;
  c.traits = options.traits;
  m.spread(points.P, c.P);
  m.spread(points.N, c.N);
  m.spread(points.Ng.empty() ? points.N : points.Ng, c.Ng);
  m.spread(points.wo, c.wo);
  c.radius = m.spread(points.radius);
  c.distance = m.spread({1.f});
  c.spread = m.spread({0.001f});
  c.time = m.spread(points.time);
  c.bias = m.spread({1e-4f});
  c.outerIor = m.spread(points.outerIor);
  uint32_t* entering = m.alloc<uint32_t>(m.paddedCount);
  uint32_t* path = m.alloc<uint32_t>(m.paddedCount);
  uint32_t* seed = m.alloc<uint32_t>(m.paddedCount);
  for (uint32_t i = 0; i < m.paddedCount; ++i) {
    const uint32_t j = std::min(i, m.count - 1);
    entering[i] = points.entering[points.entering.size() == 1 ? 0 : j] ? ~0u : 0u;
    path[i] = j;
    seed[i] = j * 0x9E3779B9u + 1;
  }
  c.entering = entering;
  c.path = path;
  c.sampleSeed = seed;
  c.sampleIndex = path;
  c.depth = 0;

  uint32_t lobes = 1;
  if (plugin.kind == Kind::Bxdf && plugin.traits) {
    const BxdfTraits& t = *static_cast<const BxdfTraits*>(plugin.traits);
    lobes = std::min(t.lobeCount, kMaxLobes);
    uint32_t reflecting = 0, transmitting = 0;
    c.slotCount = 1;
    for (uint32_t l = 0; l < lobes && options.slots == Slots::PerLobe; ++l) {
      const uint32_t slot = lobes <= kMaxSlots                 ? l
                            : t.lobes[l].flags & kLobeTransmit ? 4 + transmitting++ % 4
                                                               : reflecting++ % 4;
      m.slotOfLobe[l] = uint8_t(slot);
      c.slotCount = std::max(c.slotCount, slot + 1);
    }
    for (uint32_t s = 0; s < kMaxSlots; ++s) m.eventOfSlot[s] = uint16_t(s);
  } else {
    c.slotCount = 1;
  }
  c.lobeCount = lobes;
  c.slotOfLobe = m.slotOfLobe;
  c.eventOfSlot = m.eventOfSlot;

  m.params.resize(plugin.paramCount);
  m.manifolds.resize(plugin.paramCount, nullptr);
  for (uint32_t i = 0; i < plugin.paramCount; ++i) {
    const Param& p = plugin.params[i];
    if ((p.flags & (kParamOutput | kParamArray)) || p.type == Type::Struct) continue;
    if (p.type == Type::String) {
      // a file's handle: -1 says that there is none
      const int32_t none = -1;
      float handle;
      std::memcpy(&handle, &none, sizeof handle);
      if (p.flags & kParamFile) m.params[i] = m.make(1, {handle}, true);
      continue;
    }
    const bool fixed = p.flags & (kParamFixed | kParamNotConnectable);
    const std::vector<float>& v = setting.numbers[i];
    // what the setting leaves at its default is not connected and stays uniform, as in a render
    if (v.size() <= 3) m.params[i] = m.make(uint32_t(v.size()), v, options.varying && !fixed && setting.given[i]);
  }

  const auto builtin = [&](Builtin b) -> Value& { return m.builtins[uint32_t(b)]; };
  const float* tangent[3];
  std::vector<Vec3> t = points.tangent;
  if (t.empty())
    for (const Vec3& n : points.N) t.push_back(anyPerpendicular(n));
  m.spread(t, tangent);
  const float* bitangent[3];
  float* b[3];
  for (int k = 0; k < 3; ++k) bitangent[k] = b[k] = m.alloc<float>(m.paddedCount);
  if (!points.bitangent.empty()) m.spread(points.bitangent, bitangent);
  for (uint32_t i = 0; points.bitangent.empty() && i < m.paddedCount; ++i)
    for (int k = 0; k < 3; ++k) {
      const int p = (k + 1) % 3, q = (k + 2) % 3;
      b[k][i] = c.N[p][i] * tangent[q][i] - c.N[q][i] * tangent[p][i];
    }
  const auto three = [](const float* const d[3]) {
    Value v;
    for (int k = 0; k < 3; ++k) v.data[k] = d[k];
    v.stride = 1;
    v.components = 3;
    return v;
  };
  const float* uv[3];
  m.spread(points.uv, uv);
  const auto one = [](const float* d) {
    Value v;
    v.data[0] = d;
    v.stride = 1;
    v.components = 1;
    return v;
  };
  builtin(Builtin::U) = one(uv[0]);
  builtin(Builtin::V) = one(uv[1]);
  builtin(Builtin::St) = three(uv);
  builtin(Builtin::St).components = 2;
  builtin(Builtin::StRadius) = one(c.radius);
  builtin(Builtin::DPdu) = three(tangent);
  builtin(Builtin::DPdv) = three(bitangent);
  builtin(Builtin::Tangent) = three(tangent);
  builtin(Builtin::FacetEdge1) = three(tangent);
  builtin(Builtin::FacetEdge2) = three(bitangent);
  for (const Builtin flat : {Builtin::DNEdge1, Builtin::DNEdge2, Builtin::DNdu, Builtin::DNdv})
    builtin(flat) = m.make(3, {0, 0, 0}, false);
  builtin(Builtin::Po) = three(c.P);
  builtin(Builtin::PoRadius) = one(c.radius);
  builtin(Builtin::Pworld) = three(c.P);
  builtin(Builtin::ObjectId) = m.make(1, {1}, false);
  builtin(Builtin::Fiber) = m.make(3, {0, 0, 0}, true);  // surfaces

  ContextFunctions& f = m.functions;
  f.probe = [](const Context*, const ProbeRays*) { return 0; };  // nothing is around the points
  f.alloc = [](const Context* x, size_t bytes) -> void* {
    return static_cast<Impl*>(x->host)->alloc<uint8_t>(bytes);
  };
  f.param = [](const Context* x, uint32_t i) -> Value {
    const Impl& s = *static_cast<Impl*>(x->host);
    return i < s.params.size() ? s.params[i] : Value();
  };
  f.manifold = [](const Context* x, uint32_t i) -> const Manifold* {
    const Impl& s = *static_cast<Impl*>(x->host);
    return i < s.manifolds.size() ? s.manifolds[i] : nullptr;
  };
  f.text = [](const Context* x, uint32_t i) -> const char* {
    const Impl& s = *static_cast<Impl*>(x->host);
    return i < s.setting.strings.size() && !s.setting.strings[i].empty() ? s.setting.strings[i][0].c_str() : "";
  };
  f.list = [](const Context* x, uint32_t i, const float** numbers) -> uint32_t {
    const Impl& s = *static_cast<Impl*>(x->host);
    if (i >= s.setting.numbers.size()) return 0;
    *numbers = s.setting.numbers[i].data();
    return uint32_t(s.setting.numbers[i].size());
  };
  f.builtin = [](const Context* x, Builtin which) -> Value {
    return uint32_t(which) < uint32_t(Builtin::Count) ? static_cast<Impl*>(x->host)->builtins[uint32_t(which)]
                                                      : Value();
  };
  f.primvar = [](const Context* x, const char* name, Value* radius) -> Value {
    const Impl& s = *static_cast<Impl*>(x->host);
    const auto found = s.primvars.find(std::string_view(name));
    if (found == s.primvars.end()) return Value();
    if (radius) *radius = found->second.second;
    return found->second.first;
  };
  f.texture = [](const Context* x, const Value*, const float* s, const float* t, const float* radius,
                 const float* const*, const TextureOptions* o, float* const rgba[4]) {
    const Impl& self = *static_cast<Impl*>(x->host);
    for (uint32_t i = 0; i < x->padded; ++i) {
      float color[4] = {o->missingColor[0], o->missingColor[1], o->missingColor[2], o->missingAlpha};
      if (self.texture) self.texture(s[i], t[i], radius ? radius[i] : 0, color);
      for (int k = 0; k < 4; ++k)
        if (rgba[k]) rgba[k][i] = color[k];
    }
  };
  f.matrix = [](const Context*, const char* from, const char* to, MatrixValue* out) -> int {
    static constexpr float kZero = 0, kOne = 1;
    for (int i = 0; i < 16; ++i) out->m[i] = i % 5 == 0 ? &kOne : &kZero;
    out->stride = 0;
    const auto known = [](std::string_view s) {
      return s == "render" || s == "world" || s == "object" || s == "camera";
    };
    return known(from) && known(to);
  };
  // texture coordinates run along the tangents, primvars are constant
  f.gradient = [](const Context* x, const char* name, uint32_t component) -> Value {
    Impl& s = *static_cast<Impl*>(x->host);
    if (!name) return s.builtins[uint32_t(component ? Builtin::DPdv : Builtin::DPdu)];
    return s.primvars.contains(std::string_view(name)) ? s.make(3, {0, 0, 0}, false) : Value();
  };
  f.ellipses = [](const Context*, const char*, Value*) { return 0; };
  // what differs from point to point stands for a pattern, which is not known where the points are not
  f.isConnected = [](const Context* x, uint32_t i) -> int {
    const Impl& s = *static_cast<Impl*>(x->host);
    return i < s.params.size() && !s.params[i].uniform();
  };
  f.paramGradient = [](const Context*, uint32_t, uint32_t) { return Value(); };
  c.fn = &f;
  c.host = impl_.get();
}

TestContext::~TestContext() = default;

void TestContext::setPrimvar(const std::string& name, uint32_t components, const std::vector<float>& values,
                             float radius) {
  impl_->primvars[name] = {impl_->make(components, values, false), impl_->make(1, {radius}, false)};
}
void TestContext::setBuiltin(Builtin which, uint32_t components, const std::vector<float>& values) {
  impl_->builtins[uint32_t(which)] = impl_->make(components, values, true);
}
void TestContext::setParameter(const std::string& name, const std::vector<float>& values) {
  const uint32_t i = impl_->paramIndex(name);
  impl_->params[i] = impl_->make(uint32_t(impl_->setting.numbers[i].size()), values, true);
}
void TestContext::setManifold(const std::string& name, const Manifold& manifold) {
  const uint32_t i = impl_->paramIndex(name);
  impl_->blocks.push_back(std::make_unique<Impl::Block>(sizeof(Manifold)));
  impl_->manifolds[i] = new (impl_->blocks.back()->memory) Manifold(manifold);
}
void TestContext::setTexture(TestTexture texture) { impl_->texture = std::move(texture); }

void TestContext::bind(const BxdfFunctions& functions) {
  context_.bxdf = &functions;
  context_.closure = functions.begin(&context_);
}

float* TestContext::floats(uint32_t n) const { return impl_->alloc<float>(padded(n)); }
uint32_t* TestContext::words(uint32_t n) const { return impl_->alloc<uint32_t>(padded(n)); }

}  // namespace kinora::testing
