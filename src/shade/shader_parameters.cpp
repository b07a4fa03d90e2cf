#include "shade/shader_parameters.h"

#include <algorithm>
#include <cstdlib>

#include "base/text.h"

namespace kinora::shade {

namespace {

using language::Base;
using language::SymbolId;

bool isTripleType(Type t) { return t == Type::Color || t == Type::Point || t == Type::Vector || t == Type::Normal; }

// The parameter's value in the form that its symbol has; false where the declared type does not fit.
bool convertValue(const language::Type& type, scene::Parameter& p) {
  const size_t per = size_t(language::componentsOf(type.base));
  const auto lengthFits = [&](size_t elements) {
    return type.arrayLength < 0 ? elements > 0 : elements == size_t(std::max(1, type.arrayLength));
  };
  if (type.base == Base::String) return p.type == scene::ValueType::String && lengthFits(p.strings.size());
  if (type.base == Base::Int) return p.type == scene::ValueType::Int && lengthFits(p.ints.size());
  if (p.type == scene::ValueType::Int) {
    p.floats.assign(p.ints.begin(), p.ints.end());
    p.ints.clear();
    p.type = scene::ValueType::Float;
  }
  if (!scene::isFloatBased(p.type)) return false;
  const bool isScalar = p.type == scene::ValueType::Float;
  if (!isScalar && size_t(scene::componentsOf(p.type)) != per) return false;
  if (isScalar && per > 1 && lengthFits(p.floats.size())) {  // a number fills a triple, and is a matrix' diagonal
    std::vector<float> spread;
    for (const float f : p.floats)
      for (size_t k = 0; k < per; ++k) spread.push_back(per == 3 || k % 5 == 0 ? f : 0.f);
    p.floats = std::move(spread);
  }
  return p.floats.size() % per == 0 && lengthFits(p.floats.size() / per);
}

std::string spelledType(const scene::Parameter& p) {
  std::string text = nameOf(p.type);
  const size_t per = scene::isFloatBased(p.type) ? size_t(scene::componentsOf(p.type)) : 1;
  if (p.size() / per != 1) text += "[" + std::to_string(p.size() / per) + "]";
  return text;
}

}  // namespace

int32_t splitIndex(std::string& name) {
  const size_t open = name.find_last_of('[');
  if (open == std::string::npos || name.back() != ']' || open + 2 >= name.size()) return -1;
  for (size_t i = open + 1; i + 1 < name.size(); ++i)
    if (name[i] < '0' || name[i] > '9' || i > open + 8) return -1;
  const int32_t index = std::atoi(name.c_str() + open + 1);
  name.resize(open);
  return index;
}

scene::Node forShader(const scene::Node& node, const ShaderNode& shader, std::vector<PartReference>& parts,
                      Diagnostics& diagnostics) {
  scene::Node out = node;
  out.params = {};
  if (!shader.shader) return out;
  const language::Shader& code = *shader.shader;
  const auto complain = [&](const scene::Parameter& p, const std::string& what) {
    diagnostics.warning("PARAM-TYPE", p.pos, code.name + "." + p.name + " of '" + node.handle + "' " + what,
                        "its default is used");
  };
  const auto indexOf = [&](SymbolId id) {
    const auto it = std::find(shader.symbolOf.begin(), shader.symbolOf.end(), id);
    return it == shader.symbolOf.end() ? -1 : int(it - shader.symbolOf.begin());
  };
  const bool isNamed = sameName(node.plugin, "PxrOSL");
  for (const scene::Parameter& given : node.params) {
    if (isNamed && given.name == "shader") continue;
    std::string name = given.name;
    SymbolId id = code.find(name);
    int32_t part = -1;
    if (id == language::kNone && (part = splitIndex(name)) >= 0) id = code.find(name);
    const bool isParam = id != language::kNone && code.symbols[size_t(id)].kind == language::SymbolKind::Param;
    if (!isParam) {
      out.params.set(given);  // ResolvedParams says that there is none
      continue;
    }
    const language::Symbol& symbol = code.symbols[size_t(id)];
    const language::Type& type = symbol.type;
    if (type.base == Base::Struct) {
      if (!given.isReference) {
        complain(given, "is a struct, whose members are given one by one: \"" + name + ".member\"");
        continue;
      }
      // "handle:output" feeds every member from the output's member of that name
      for (const language::Symbol& field : code.symbols) {
        if (field.ofStruct == language::kNone || !field.name.starts_with(name + ".")) continue;
        if (field.type.base == Base::Struct || given.strings.empty()) continue;
        scene::Parameter p = given;
        p.name = field.name;
        p.strings = {given.strings[0] + field.name.substr(name.size())};
        out.params.set(std::move(p));
      }
      continue;
    }
    const int index = indexOf(id);
    if (index < 0) {
      complain(given, "is a " + nameOf(type) + ", which a scene cannot give");
      continue;
    }
    if (given.isReference) {
      const bool isSeveral = type.arrayLength != 0 && given.strings.size() > 1;
      if (part < 0 && !isSeveral) {
        out.params.set(given);
        continue;
      }
      const int32_t most = type.arrayLength > 0 ? type.arrayLength
                           : type.arrayLength == 0
                               ? language::componentsOf(type.base) > 1 ? language::componentsOf(type.base) : 0
                               : int32_t(0);
      const auto add = [&](int32_t element, const std::string& from) {
        if (from.empty()) return;
        if (element < most)
          parts.push_back({uint32_t(index), element, from});
        else
          complain(given, "is a " + nameOf(type) + " and has no part " + std::to_string(element));
      };
      if (part >= 0 && !given.strings.empty()) add(part, given.strings[0]);
      for (size_t i = 0; part < 0 && i < given.strings.size(); ++i) add(int32_t(i), given.strings[i]);
      continue;
    }
    if (part >= 0) {
      complain(given, "is a part of a parameter: only a reference may feed it alone");
      continue;
    }
    scene::Parameter p = given;
    if (!convertValue(type, p)) {
      complain(given, "is a " + nameOf(type) + " and is given a " + spelledType(given));
      continue;
    }
    out.params.set(std::move(p));
  }
  return out;
}

std::optional<scene::Node> withElements(const scene::Node& node, const Descriptor& plugin, Diagnostics& diagnostics) {
  const auto isDeclared = [&](const std::string& name) {
    for (uint32_t i = 0; i < plugin.paramCount; ++i)
      if (sameName(plugin.params[i].name, name)) return true;
    return false;
  };
  std::optional<scene::Node> out;
  for (const scene::Parameter& given : node.params) {
    if (!given.isReference) continue;
    if (std::string array = given.name; splitIndex(array) >= 0 && isDeclared(array + "_0")) {
      // one element: "name[2]"
      if (!out) out = node;
      out->params.erase(given.name);
      scene::Parameter element = given;
      element.name = array + "_" + given.name.substr(array.size() + 1, given.name.size() - array.size() - 2);
      out->params.set(std::move(element));
      continue;
    }
    if (!isDeclared(given.name + "_0")) continue;
    if (!out) out = node;
    // the list keeps the number of its elements
    scene::Parameter list = given;
    list.isReference = false;
    list.floats.assign(given.strings.size() * 3, 0.f);
    list.strings.clear();
    out->params.set(std::move(list));
    for (size_t k = 0; k < given.strings.size(); ++k) {
      scene::Parameter element = given;
      element.name = given.name + "_" + std::to_string(k);
      if (!isDeclared(element.name)) {
        diagnostics.warning("PARAM-TYPE", given.pos,
                            std::string(plugin.name) + "." + given.name + " of '" + node.handle +
                                "' is connected to " + std::to_string(given.strings.size()) + " nodes",
                            "those from number " + std::to_string(k) + " on are left out");
        break;
      }
      element.strings = {given.strings[k]};
      if (!given.strings[k].empty()) out->params.set(std::move(element));
    }
  }
  return out;
}

std::string connectionProblem(const Param& from, bool fromShader, int32_t fromPart, const Param& to, bool toShader,
                              int32_t toPart) {
  const auto isList = [](const Param& p) { return (p.flags & kParamArray) && p.type != Type::Matrix; };
  struct Kind {
    Type type;
    bool isArray;
  };
  const auto kindOf = [&](const Param& p, int32_t part) {
    if (part < 0) return Kind{p.type, isList(p)};
    return Kind{isList(p) ? p.type : Type::Float, false};
  };
  const Kind a = kindOf(from, fromPart), b = kindOf(to, toPart);
  const auto spelled = [](const Kind& k) {
    static const char* const kNames[] = {"float",  "int",    "string", "color", "point",
                                         "vector", "normal", "matrix", "struct"};
    const size_t n = size_t(k.type);
    return std::string(n < std::size(kNames) ? kNames[n] : "value") + (k.isArray ? "[]" : "");
  };
  const std::string wrong = "a " + spelled(a) + " cannot feed a " + spelled(b);
  if (fromPart >= 0 && !(fromShader && (isList(from) || isTripleType(from.type) || from.type == Type::Matrix)))
    return wrong;
  if (a.isArray != b.isArray) return wrong;
  if (a.type == b.type) return "";
  if (isTripleType(a.type) && isTripleType(b.type)) return "";
  if (a.isArray || a.type == Type::String || b.type == Type::String || a.type == Type::Struct ||
      b.type == Type::Struct)
    return wrong;
  if (b.type == Type::Matrix) return a.type == Type::Float || a.type == Type::Int ? "" : wrong;
  if (a.type == Type::Matrix) return wrong;
  if (!fromShader || !toShader) return "";  // numbers and triples, as plug-ins take them
  return isTripleType(b.type) || (b.type == Type::Float && a.type == Type::Int) ? "" : wrong;
}

}  // namespace kinora::shade
