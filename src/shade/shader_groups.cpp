#include "shade/shader_groups.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

#include "language/vm/strings.h"
#include "shade/clock.h"
#include "shade/context_host.h"
#include "shade/implied_primvars.h"
#include "shade/shader_library.h"
#include "shade/shader_services.h"

namespace kinora::shade {

using language::Base;

namespace {

bool isShader(const ProgramNode& n) { return n.source && n.source->shader; }

// Nodes of one level share a group: a shader that reads a C++ pattern which reads a shader stands one level higher.
std::vector<int> levelsOf(const Program& p) {
  std::vector<int> level(p.nodes.size(), 0);
  for (size_t n = 0; n < p.nodes.size(); ++n) {
    const auto reads = [&](uint32_t node) {
      level[n] = std::max(level[n], level[node] + int(isShader(p.nodes[node]) && !isShader(p.nodes[n])));
    };
    for (const ParamSource& s : p.nodes[n].params)
      if (s.from == ParamSource::From::Connected) reads(s.node);
    for (const PartSource& s : p.nodes[n].parts) reads(s.node);
  }
  return level;
}

std::string partName(const std::string& name, int32_t part) {
  return part < 0 ? name : name + "[" + std::to_string(part) + "]";
}
size_t lengthOf(const ParamSource& s, Base base) {
  return base == Base::String ? s.strings.size()
         : base == Base::Int  ? s.ints.size()
                              : s.list.size() / size_t(std::max(1, language::componentsOf(base)));
}

language::Values valuesOf(const ProgramNode& n, uint32_t i, const language::Type& type) {
  const ParamSource& s = n.params[i];
  const Param& p = n.plugin->params[i];
  language::Values v;
  if (p.type == Type::String) {
    int32_t handle;
    std::memcpy(&handle, s.constant, 4);
    if (p.flags & kParamFile)
      v.strings.assign(1, language::stringOf(handle));
    else if (p.flags & kParamArray)
      v.strings = s.strings;
    else
      v.strings.assign(1, s.text);
  } else if (type.base == Base::Int) {
    if (p.flags & kParamArray) {
      v.ints = s.ints;
    } else {
      v.ints.resize(1);
      std::memcpy(v.ints.data(), s.constant, 4);
    }
  } else {
    v.floats = p.flags & kParamArray ? s.list : std::vector<float>(s.constant, s.constant + s.components);
  }
  return v;
}

float floatOf(int32_t bits) {
  float x;
  std::memcpy(&x, &bits, 4);
  return x;
}

std::vector<float> asMachineHas(const language::Values& v) {
  std::vector<float> out = v.floats;
  for (const int n : v.ints) out.push_back(floatOf(n));
  for (const std::string& text : v.strings) out.push_back(floatOf(language::internString(text)));
  return out;
}

// Whether a primvar of the parameter's name stands before its value. Strings that decide what the code is are none, nor
// are arrays without a length; of arrays and strings a default that code computes stays.
bool takesPrimvars(const ProgramNode& node, uint32_t i, const language::Symbol& symbol) {
  const Param& p = node.plugin->params[i];
  const ParamSource& s = node.params[i];
  if (symbol.lockGeometry || s.from == ParamSource::From::Connected || p.type == Type::Matrix) return false;
  const bool isArray = symbol.type.arrayLength != 0;
  if (!isArray && p.type != Type::String) return true;
  if (symbol.type.arrayLength < 0 || (symbol.hasInitCode && !s.given)) return false;
  if (!isArray) return p.flags & kParamFile;
  return std::none_of(node.parts.begin(), node.parts.end(), [&](const PartSource& x) { return x.param == i; });
}

}  // namespace

void makeShaderUses(Program& p, language::ExecutableCache& cache, uint32_t width, Diagnostics& diagnostics) {
  const std::vector<int> level = levelsOf(p);
  std::map<int, std::vector<uint32_t>> byLevel;
  for (uint32_t n = 0; n < p.nodes.size(); ++n)
    if (isShader(p.nodes[n])) byLevel[level[n]].push_back(n);
  for (const auto& [l, members] : byLevel) {
    ShaderUse use;
    use.nodes = members;
    language::ShaderGroup group;
    std::map<uint32_t, std::string> layerOf;
    std::map<std::string, uint32_t> nodeOfLayer;
    for (const uint32_t n : members) {
      std::string name = p.nodes[n].handle.empty() ? "shader" : p.nodes[n].handle;
      while (!nodeOfLayer.try_emplace(name, n).second) name += "'";
      layerOf[n] = name;
    }
    std::map<std::pair<std::string, std::string>, ShaderUse::Varying> varying;  // by layer and parameter
    for (const uint32_t n : members) {
      const ProgramNode& node = p.nodes[n];
      language::Layer layer{node.source->shader, layerOf[n], {}};
      for (uint32_t i = 0; i < node.plugin->paramCount; ++i) {
        const Param& q = node.plugin->params[i];
        if (q.flags & kParamOutput) continue;
        const ParamSource& s = node.params[i];
        const language::Symbol& symbol = node.source->shader->symbols[size_t(node.source->symbolOf[i])];
        if (s.from == ParamSource::From::Connected) {
          const bool inside = isShader(p.nodes[s.node]) && level[s.node] == l;
          if (inside) {
            const ProgramNode& from = p.nodes[s.node];
            group.connections.push_back({layerOf[s.node],
                                         partName(from.plugin->params[from.outputParam[s.output]].name, s.part),
                                         layer.name, q.name});
            continue;
          }
        }
        ShaderUse::Varying v{n, i, false, symbol.type.base, s.from == ParamSource::From::Connected};
        const bool differs = s.from != ParamSource::From::Constant && symbol.type.arrayLength == 0;
        if (s.given && s.from == ParamSource::From::Constant)
          layer.settings.push_back({q.name,
                                    symbol.type.arrayLength < 0
                                        ? language::Type{symbol.type.base, int32_t(lengthOf(s, symbol.type.base))}
                                        : symbol.type,
                                    valuesOf(node, i, symbol.type)});
        // materials that differ in a number say it point by point; an object's primvar stands before either
        v.isPrimvar = takesPrimvars(node, i, symbol);
        if (v.isPrimvar) {
          v.elements = uint32_t(symbol.type.arrayLength);
          if (v.elements) v.otherwise = asMachineHas(s.given ? valuesOf(node, i, symbol.type) : symbol.values);
          if (symbol.hasInitCode && !s.given && !isAlwaysImplied(q.name)) {
            ShaderUse::Varying& asks = varying[{layer.name, std::string(q.name) + "?"}];
            asks = v;
            asks.base = Base::Int;
            asks.asksWhether = true;
          }
        }
        if (differs || v.isPrimvar) varying[{layer.name, q.name}] = v;
      }
      for (const PartSource& s : node.parts) {
        const ProgramNode& from = p.nodes[s.node];
        const std::string name = from.plugin->params[from.outputParam[s.output]].name;
        if (level[s.node] == l)
          group.connections.push_back({layerOf[s.node], partName(name, s.fromPart), layer.name,
                                       partName(node.plugin->params[s.param].name, s.part)});
        else
          diagnostics.warning("SHADER-OUTPUT", node.pos,
                              "part " + std::to_string(s.part) + " of '" + node.plugin->params[s.param].name +
                                  "' of shader node '" + node.handle + "' is fed by '" + from.handle +
                                  "' from behind a plug-in",
                              "its default is used");
      }
      group.layers.push_back(std::move(layer));
    }
    group.name = p.nodes.back().handle;
    group.perPoint = [&](const language::Layer& layer, const language::Symbol& parameter) {
      const auto it = varying.find({layer.name, parameter.name});
      language::PerPoint out;
      out.isVarying = it != varying.end();
      out.hasDerivs = out.isVarying && it->second.isPrimvar && it->second.base != Base::Int &&
                      it->second.base != Base::String && it->second.elements == 0;
      out.isConnected = out.isVarying && it->second.isConnected;
      out.isPartial = varying.count({layer.name, parameter.name + "?"}) != 0;
      return out;
    };
    // what somebody outside of the group reads
    std::vector<ShaderUse::Out> outs;
    const auto read = [&](uint32_t node, uint32_t output) {
      const bool known = std::any_of(outs.begin(), outs.end(),
                                     [&](const ShaderUse::Out& o) { return o.node == node && o.output == output; });
      if (known || !layerOf.count(node)) return;
      const ProgramNode& from = p.nodes[node];
      const uint32_t param = from.outputParam[output];
      const language::Symbol& symbol = from.source->shader->symbols[size_t(from.source->symbolOf[param])];
      if (symbol.type.arrayLength != 0 || language::componentsOf(symbol.type.base) > 3 ||
          symbol.type.base == Base::String) {
        diagnostics.warning("SHADER-OUTPUT", from.pos,
                            "output '" + symbol.name + "' of shader node '" + from.handle + "' is a " +
                                nameOf(symbol.type) + ", which only another shader can take",
                            "what it feeds uses its default");
        return;
      }
      outs.push_back({node, output, symbol.type.base});
      group.outputs.push_back(layerOf[node] + "." + symbol.name);
    };
    for (uint32_t n = 0; n < p.nodes.size(); ++n) {
      const bool isInside = isShader(p.nodes[n]) && level[n] == l;
      for (const ParamSource& s : p.nodes[n].params)
        if (!isInside && s.from == ParamSource::From::Connected) read(s.node, s.output);
    }
    for (const Program::Tee& t : p.tees) read(t.node, t.output);
    if (outs.empty()) continue;
    language::MachineOptions options;
    options.width = width;
    std::string error;
    use.code = cache.get(group, options, error);
    if (!use.code) {
      diagnostics.error("SHADER-GROUP", p.nodes[members.back()].pos,
                        "the shaders that feed '" + group.name + "' cannot run: " + error,
                        "what they feed uses its defaults");
      continue;
    }
    for (const uint32_t n : members) {
      const std::string& shader = p.nodes[n].source->shader->name;
      if (use.name.size() < 60)
        use.name += (use.name.empty() ? "" : " + ") + shader;
      else if (!use.name.ends_with("..."))
        use.name += " ...";
    }
    use.inputs = use.code->inputsOf(group);
    for (const language::Input& input : use.code->inputs())
      if (input.isVarying) use.varying.push_back(varying[{group.layers[size_t(input.layer)].name, input.parameter}]);
    use.outputs = std::move(outs);
    use.wantsDerivs = use.code->usesDerivs();
    for (const ShaderUse::Varying& v : use.varying) use.hasPrimvars |= v.isPrimvar;
    for (size_t g = 0; g < use.wants.size(); ++g)
      use.wants[g] = use.code->usesGlobal(language::GlobalValues::Name(g));
    for (const uint32_t n : members) p.nodes[n].shader = int32_t(p.shaders.size());
    p.shaders.push_back(std::move(use));
  }
}

namespace {

float* newFloats(const Context* c) { return c->alloc<float>(c->padded); }

// The step from a point to the next one on the raster is twice its footprint's radius, along dPdu and across it.
struct Steps {
  float* x[3];  // render space
  float* y[3];
};
Steps stepsOf(const Context* c) {
  Steps s;
  for (int k = 0; k < 3; ++k) s.x[k] = newFloats(c), s.y[k] = newFloats(c);
  const Value du = c->builtin(Builtin::DPdu);
  for (int k = 0; k < 3; ++k) std::memcpy(s.x[k], du.data[k], c->padded * sizeof(float));
  ContextHost::of(c).surface.kernels().across(c->padded, c->Ng, s.x);
  for (uint32_t i = 0; i < c->padded; ++i) {
    const float size = 2 * c->radius[i];
    for (int k = 0; k < 3; ++k) s.x[k][i] *= size;
    for (int k = 0; k < 3; ++k)
      s.y[k][i] = c->Ng[(k + 1) % 3][i] * s.x[(k + 2) % 3][i] - c->Ng[(k + 2) % 3][i] * s.x[(k + 1) % 3][i];
  }
  return s;
}

const float* gatherWhether(const Context* c, const ContextHost& h, const char* name) {
  const Implied implied = impliedBy(name);
  const geometry::Primvar* const* of = primvarsOf(c, name);
  float* has = newFloats(c);
  for (uint32_t i = 0; i < c->padded; ++i) {
    const int32_t n = hasPrimvar(c, h.group->world(), of[i], implied, i);
    std::memcpy(has + i, &n, 4);
  }
  return has;
}

// The bits of the nearest int: primvars are floats here.
float asInt(float x) {
  const int32_t n = x >= -0x1p31f && x < 0x1p31f ? int32_t(std::nearbyint(x)) : 0;
  std::memcpy(&x, &n, 4);
  return x;
}

// A parameter that primvars replace, with derivatives: by component.
struct PrimvarArrays {
  float* v[3];
  float* dx[3];
  float* dy[3];
};
// `otherwise`: the parameter's value, for objects without the primvar.
void gatherPrimvar(const Context* c, ContextHost& h, const ShaderUse::Varying& in, const char* name,
                   const Value& otherwise, const Steps* steps, PrimvarArrays& out) {
  const uint32_t width = uint32_t(language::componentsOf(in.base));
  const ShadingWorld& world = h.group->world();
  const Implied implied = impliedBy(name);
  SurfacePoints& surface = h.surface;
  const geometry::Primvar* const* of = primvarsOf(c, name);
  const Slopes s = surface.slopes({SlopeSource::What::Primvar, of, implied}, width);
  // along the steps' parts of both edges
  float* part[2][2] = {};
  if (steps) {
    for (auto& direction : part)
      for (float*& x : direction) x = newFloats(c);
    surface.kernels().alongEdges(c->padded, surface.edge(0), surface.edge(1), steps->x, part[0][0], part[0][1]);
    surface.kernels().alongEdges(c->padded, surface.edge(0), surface.edge(1), steps->y, part[1][0], part[1][1]);
  }
  for (uint32_t k = 0; k < 3; ++k) {
    out.v[k] = k < width ? s.value[k] : nullptr;
    out.dx[k] = k < width && steps ? newFloats(c) : nullptr;
    out.dy[k] = k < width && steps ? newFloats(c) : nullptr;
  }
  for (uint32_t i = 0; i < c->padded; ++i) {
    const geometry::Primvar* p = of[i];
    const bool has = hasPrimvar(c, world, p, implied, i);
    for (uint32_t j = 0; j < width; ++j) {
      if (!has)
        out.v[j][i] = otherwise.data[j][otherwise.stride ? i : 0];
      else if (in.base == Base::Int)
        out.v[j][i] = asInt(out.v[j][i]);
      if (!steps) continue;
      out.dx[j][i] = has ? part[0][0][i] * s.d1[j][i] + part[0][1][i] * s.d2[j][i] : 0.f;
      out.dy[j][i] = has ? part[1][0][i] * s.d1[j][i] + part[1][1][i] * s.d2[j][i] : 0.f;
    }
    if (!p || width != 3 || p->width != 3) continue;
    const auto turn = [&](float* const* q, bool isDifference) {
      float f[3] = {q[0][i], q[1][i], q[2][i]};
      primvarToRender(*p, surface.args(), i, f, isDifference);
      const bool isPoint = !isDifference && p->type == scene::ValueType::Point;
      for (int j = 0; j < 3; ++j) q[j][i] = f[j] + (isPoint ? float(world.worldOrigin[j]) : 0.f);
    };
    turn(out.v, false);
    if (steps) turn(out.dx, true), turn(out.dy, true);
  }
}

// The strings that points have by that name, `count` each; null: the object has none, or another number of them.
class StringsByPoint {
 public:
  StringsByPoint(const Context* c, const ContextHost& h, const char* name, uint32_t count)
      : place_(c->place), world_(*h.group->world().world), name_(name), count_(count) {}
  const std::string* at(uint32_t point) {
    const uint32_t geometry = place_.geometry[point];
    if (geometry != geometry_) {
      geometry_ = geometry;
      found_ = world_.mesh(geometry).find(name_);
      if (found_ && uint32_t(found_->width) != count_) found_ = nullptr;
    }
    if (!found_) return nullptr;
    const bool isByFace = found_->rate == geometry::Primvar::Rate::PerFace;
    const size_t first =
        isByFace ? size_t(count_) * world_.mesh(geometry).faceOf(place_.primitive[point]) : size_t(0);
    return first + count_ <= found_->strings.size() ? found_->strings.data() + first : nullptr;
  }

 private:
  const Places& place_;
  const trace::World& world_;
  const char* const name_;
  const uint32_t count_;
  uint32_t geometry_ = ~0u;
  const geometry::Primvar* found_ = nullptr;
};

// A string or an array of strings that primvars replace: handles, by element. `said`: the value of a single one.
void gatherStrings(const Context* c, const ContextHost& h, const ShaderUse::Varying& in, const char* name,
                   const Value& said, float* const* out) {
  const uint32_t n = std::max(1u, in.elements);
  StringsByPoint strings(c, h, name, n);
  const std::string* last = nullptr;
  for (uint32_t i = 0; i < c->padded; ++i) {
    const std::string* own = strings.at(i);
    for (uint32_t k = 0; k < n; ++k) {
      if (!own)
        out[k][i] = !in.elements              ? said.data[0][said.stride ? i : 0]
                    : k < in.otherwise.size() ? in.otherwise[k]
                                              : floatOf(language::internString(""));
      else
        out[k][i] = own == last ? out[k][i - 1] : floatOf(language::internString(own[k]));
    }
    last = own;
  }
}

// An array of numbers that primvars of as many replace, without derivatives: by element and component.
void gatherArray(const Context* c, ContextHost& h, const ShaderUse::Varying& in, const char* name,
                 float* const* out) {
  const uint32_t per = uint32_t(language::componentsOf(in.base)), n = in.elements * per;
  const geometry::Primvar* const* of = primvarsOf(c, name);
  const double* origin = h.group->world().worldOrigin;
  for (uint32_t first = 0; first < n; first += 3) {
    const uint32_t width = std::min(3u, n - first);
    const Slopes s = h.surface.slopes({SlopeSource::What::Primvar, of, Implied::None, first}, width);
    for (uint32_t i = 0; i < c->padded; ++i) {
      const bool has = of[i] && uint32_t(of[i]->width) == n;
      float f[3] = {0, 0, 0};
      for (uint32_t j = 0; j < width; ++j) f[j] = s.value[j][i];
      if (has && per == 3) {
        primvarToRender(*of[i], h.surface.args(), i, f);
        for (int j = 0; j < 3 && of[i]->type == scene::ValueType::Point; ++j) f[j] += float(origin[j]);
      }
      for (uint32_t j = 0; j < width; ++j) {
        const uint32_t k = first + j;
        if (has)
          out[k][i] = in.base == Base::Int ? asInt(f[j]) : f[j];
        else
          out[k][i] = k < in.otherwise.size() ? in.otherwise[k] : 0.f;
      }
    }
  }
}

}  // namespace

uint64_t ShaderUse::bytes() const {
  return sizeof *this + inputs.capacity() * sizeof(float) + varying.capacity() * sizeof(Varying) +
         outputs.capacity() * sizeof(Out) + nodes.capacity() * sizeof(uint32_t);
}

void runShaders(const Context* c, ContextHost& h, const ShaderUse& use) {
  ShaderCounts& counts = h.group->shaderCounts[use.number];
  const Clock clock(counts.nanoseconds);
  using G = language::GlobalValues;
  language::GlobalValues globals;
  const bool derivs = use.wantsDerivs, wantsUV = use.wants[G::u] || use.wants[G::v];
  Steps steps;
  if (derivs && (use.wants[G::P] || wantsUV || use.hasPrimvars)) steps = stepsOf(c);
  const auto set = [&](G::Name name, const Value& v) {
    for (uint32_t k = 0; k < v.components; ++k) globals.of[name].v[k] = v.data[k];
  };
  if (use.wants[G::P]) {
    set(G::P, c->builtin(Builtin::Pworld));
    for (int k = 0; derivs && k < 3; ++k) globals.of[G::P].dx[k] = steps.x[k], globals.of[G::P].dy[k] = steps.y[k];
  }
  if (wantsUV) {
    set(G::u, c->builtin(Builtin::U));
    set(G::v, c->builtin(Builtin::V));
    if (derivs) {
      float* d[4];
      for (float*& x : d) x = newFloats(c);
      const Value du = c->builtin(Builtin::DPdu), dv = c->builtin(Builtin::DPdv);
      const SurfaceKernels& k = h.surface.kernels();
      k.alongEdges(c->padded, du.data, dv.data, steps.x, d[0], d[1]);
      k.alongEdges(c->padded, du.data, dv.data, steps.y, d[2], d[3]);
      globals.of[G::u].dx[0] = d[0], globals.of[G::u].dy[0] = d[2];
      globals.of[G::v].dx[0] = d[1], globals.of[G::v].dy[0] = d[3];
    }
  }
  if (use.wants[G::I])
    for (int k = 0; k < 3; ++k) {
      float* in = newFloats(c);
      for (uint32_t i = 0; i < c->padded; ++i) in[i] = -c->wo[k][i];
      globals.of[G::I].v[k] = in;
    }
  for (int k = 0; k < 3; ++k) globals.of[G::N].v[k] = c->N[k], globals.of[G::Ng].v[k] = c->Ng[k];
  if (use.wants[G::dPdu]) set(G::dPdu, c->builtin(Builtin::DPdu));
  if (use.wants[G::dPdv]) set(G::dPdv, c->builtin(Builtin::DPdv));
  globals.of[G::time].v[0] = c->time;

  language::VaryingInput* varying = c->alloc<language::VaryingInput>(use.varying.size() + 1);
  const uint32_t before = h.node;
  for (size_t i = 0; i < use.varying.size(); ++i) {
    const ShaderUse::Varying& in = use.varying[i];
    const Param& param = h.program->nodes[in.node].plugin->params[in.param];
    if (in.elements || (in.isPrimvar && in.base == Base::String)) {
      const uint32_t n = std::max(1u, in.elements) * uint32_t(language::componentsOf(in.base));
      float** own = c->alloc<float*>(n);
      for (uint32_t k = 0; k < n; ++k) own[k] = newFloats(c);
      varying[i] = {own, nullptr, nullptr};
      h.node = in.node;
      const Value said = in.elements ? Value() : c->param(in.param);
      if (in.base == Base::String)
        gatherStrings(c, h, in, param.name, said, own);
      else
        gatherArray(c, h, in, param.name, own);
      continue;
    }
    const float** v = c->alloc<const float*>(9);
    varying[i] = {v, nullptr, nullptr};
    if (in.asksWhether) {
      v[0] = gatherWhether(c, h, param.name);
      continue;
    }
    h.node = in.node;
    const ParamSource& source = h.program->nodes[in.node].params[in.param];
    Value value = c->param(in.param);
    if (in.isPrimvar) {
      PrimvarArrays arrays;
      gatherPrimvar(c, h, in, param.name, value, derivs ? &steps : nullptr, arrays);
      for (int k = 0; k < 3; ++k) v[k] = arrays.v[k], v[3 + k] = arrays.dx[k], v[6 + k] = arrays.dy[k];
      if (derivs) varying[i].dx = v + 3, varying[i].dy = v + 6;
      continue;
    }
    const uint32_t components = uint32_t(language::componentsOf(in.base));
    for (uint32_t k = 0; k < components; ++k) {
      const float* from = value.data[std::min(k, value.components - 1)];
      // what plug-ins make lies in render space, what the scene says already in the world
      const bool isShifted = in.base == Base::Point && source.from == ParamSource::From::Connected;
      const float shift = isShifted ? float(h.group->world().worldOrigin[k]) : 0.f;
      const bool isBits =
          param.type == Type::String || (param.type == Type::Int && source.from == ParamSource::From::Gathered);
      if (value.stride && shift == 0 && (isBits || in.base != Base::Int)) {
        v[k] = from;
        continue;
      }
      float* own = newFloats(c);
      for (uint32_t j = 0; j < c->padded; ++j) own[j] = from[value.stride ? j : 0] + shift;
      if (in.base == Base::Int)
        for (uint32_t j = 0; j < c->padded; ++j) {
          const int32_t n = int32_t(own[j]);
          std::memcpy(own + j, &n, 4);
        }
      v[k] = own;
    }
  }
  h.node = before;

  language::OutputValues* outputs = c->alloc<language::OutputValues>(use.outputs.size());
  for (size_t i = 0; i < use.outputs.size(); ++i) {
    float** to = c->alloc<float*>(3);
    for (int k = 0; k < language::componentsOf(use.outputs[i].base); ++k) to[k] = newFloats(c);
    outputs[i] = {to};
  }
  const ShaderServices services(c, h);
  language::RunArguments run;
  run.points = c->count;
  run.globals = &globals;
  run.inputs = use.inputs.data();
  run.varyingInputs = varying;
  run.outputs = outputs;
  run.services = &services.table();
  run.counts = &counts.machine;
  use.code->run(h.group->shaderState(), run);

  for (size_t i = 0; i < use.outputs.size(); ++i) {
    const ShaderUse::Out& out = use.outputs[i];
    Value& value = h.outputs[h.firstOutput[out.node] + out.output];
    value.components = uint32_t(language::componentsOf(out.base));
    value.stride = 1;
    for (uint32_t k = 0; k < value.components; ++k) {
      float* v = outputs[i].v[k];
      if (out.base == Base::Int)
        for (uint32_t j = 0; j < c->count; ++j) {
          int32_t n;
          std::memcpy(&n, v + j, 4);
          v[j] = float(n);
        }
      if (out.base == Base::Point)
        for (uint32_t j = 0; j < c->count; ++j) v[j] -= float(h.group->world().worldOrigin[k]);
      for (uint32_t j = c->count; j < c->padded; ++j) v[j] = v[c->count - 1];
      value.data[k] = v;
    }
  }
}

}  // namespace kinora::shade
