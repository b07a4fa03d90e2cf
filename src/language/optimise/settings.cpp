#include "language/optimise/settings.h"

#include <algorithm>

#include "language/optimise/optimise.h"
#include "language/optimise/walk.h"

namespace kinora::language {

std::string keyOf(const Type& type, const Values& values) {
  std::string key = nameOf(type) + "|";
  const auto add = [&](const void* data, size_t bytes) { key.append(static_cast<const char*>(data), bytes); };
  add(values.ints.data(), values.ints.size() * 4);
  add(values.floats.data(), values.floats.size() * 4);
  for (const std::string& s : values.strings) key += std::to_string(s.size()) + ":" + s;
  return key;
}

size_t countOf(const Type& type) { return size_t(componentsOf(type.base)) * size_t(std::max(1, type.arrayLength)); }
size_t elementsIn(const Type& type, const Values& values) {
  const size_t per = std::max<size_t>(1, size_t(componentsOf(type.base)));
  const size_t n = type.base == Base::String ? values.strings.size()
                   : type.base == Base::Int  ? values.ints.size()
                                             : values.floats.size();
  return n / per;
}

bool convertSetting(const Type& from, const Values& values, const Type& to, Values& out) {
  out = Values();
  const size_t n = countOf(to);
  if (to.base == Base::String) {
    if (from.base != Base::String) return false;
    out.strings = values.strings;
    if (out.strings.size() != n) return false;
    return true;
  }
  if (to.base == Base::Int) {
    if (from.base != Base::Int) return false;
    out.ints = values.ints;
    return out.ints.size() == n;
  }
  std::vector<float> numbers = values.floats;
  if (from.base == Base::Int)
    for (const int32_t i : values.ints) numbers.push_back(float(i));
  else if (from.base == Base::String || from.base == Base::Closure || from.base == Base::Struct)
    return false;
  if (isTriple(to.base) && (from.base == Base::Float || from.base == Base::Int) && numbers.size() * 3 == n) {
    for (const float f : numbers) out.floats.insert(out.floats.end(), 3, f);
    return true;
  }
  if (to.base == Base::Matrix && from.base != Base::Matrix && numbers.size() == 1 && n == 16) {
    out.floats.assign(16, 0.f);
    for (int i = 0; i < 4; ++i) out.floats[size_t(i) * 5] = numbers[0];
    return true;
  }
  if (componentsOf(from.base) != componentsOf(to.base) && !(from.base == Base::Float && numbers.size() == n))
    return false;
  out.floats = std::move(numbers);
  return out.floats.size() == n;
}

namespace {
void gatherFacts(const Shader& shader, const Block& block, ShaderFacts& facts) {
  forEachInstruction(block, [&](const Instruction& in) {
    bool keepsInts = false;
    switch (in.opcode) {
      case Opcode::Assign:
      case Opcode::Add:
      case Opcode::Sub:
      case Opcode::Mul:
      case Opcode::Div:
      case Opcode::MakeColor:
      case Opcode::MakePoint:
      case Opcode::MakeVector:
      case Opcode::MakeNormal:
        keepsInts = !in.arguments.empty() && shader.symbols[size_t(in.arguments[0])].type.base != Base::Int;
        break;
      default:
        break;
    }
    for (uint32_t i = 0; i < in.arguments.size(); ++i) {
      const char access = accessOf(shader, in, i);
      if (access != 'r')
        facts.isWritten[size_t(in.arguments[i])] = true;
      else if (!keepsInts)
        facts.isStructural[size_t(in.arguments[i])] = true;
    }
  });
}
}  // namespace
ShaderFacts factsOfShader(const Shader& shader) {
  ShaderFacts facts;
  facts.isWritten.resize(shader.symbols.size());
  facts.isStructural.resize(shader.symbols.size());
  gatherFacts(shader, shader.main, facts);
  for (const Initialiser& i : shader.initialisers) gatherFacts(shader, i.code, facts);
  return facts;
}
bool isCompiledIn(const ShaderFacts& facts, const Shader& shader, SymbolId id) {
  const Base base = shader.symbols[size_t(id)].type.base;
  return base == Base::String || (base == Base::Int && facts.isStructural[size_t(id)]);
}

bool isParam(const Symbol& s) { return s.kind == SymbolKind::Param || s.kind == SymbolKind::OutputParam; }

const Setting* settingOf(const Layer& layer, const std::string& name) {
  for (auto s = layer.settings.rbegin(); s != layer.settings.rend(); ++s)
    if (s->parameter == name) return &*s;
  return nullptr;
}

void settingValues(const Layer& layer, const std::string& parameter, const Type& type, Values& values) {
  const Setting* setting = settingOf(layer, parameter);
  Values converted;
  if (setting && convertSetting(setting->type, setting->values, type, converted)) values = std::move(converted);
}

std::string structureKey(const ShaderGroup& group) {
  std::string key;
  for (const Layer& layer : group.layers) {
    const ShaderFacts facts = factsOfShader(*layer.shader);
    key += "L" + layer.name + "@" + std::to_string(reinterpret_cast<uintptr_t>(layer.shader.get())) + "{";
    std::vector<const Setting*> settings;
    for (const Setting& s : layer.settings)
      if (settingOf(layer, s.parameter) == &s) settings.push_back(&s);
    std::sort(settings.begin(), settings.end(),
              [](const Setting* a, const Setting* b) { return a->parameter < b->parameter; });
    for (const Setting* s : settings) {
      const SymbolId id = layer.shader->find(s->parameter);
      if (id == kNone) continue;
      key += s->parameter + ":" + nameOf(s->type) + std::to_string(elementsIn(s->type, s->values)) + "=";
      if (isCompiledIn(facts, *layer.shader, id)) key += keyOf(s->type, s->values);
      key += ";";
    }
    if (group.perPoint)
      for (const Symbol& s : layer.shader->symbols)
        if (isParam(s)) {
          const PerPoint p = group.perPoint(layer, s);
          if (p.isVarying || p.isConnected)
            key += (p.isVarying ? "~" : "!") + s.name + (p.hasDerivs ? "'" : "") + (p.isConnected ? "<" : "") +
                   (p.isPartial ? "?" : "");
        }
    key += "}";
  }
  for (const Connection& c : group.connections)
    key += "C" + c.fromLayer + "." + c.from + ">" + c.toLayer + "." + c.to;
  for (const std::string& o : group.outputs) key += "O" + o + ";";
  for (const std::string& e : group.entries) key += "E" + e + ";";
  for (const std::string& e : group.eager) key += "F" + e + ";";
  return key;
}

}  // namespace kinora::language
