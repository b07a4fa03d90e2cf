#include "shade/shader_node.h"

#include <algorithm>

#include "base/text.h"
#include "language/optimise/structure.h"
#include "language/optimise/walk.h"

namespace kinora::shade {

namespace {

using language::Base;

Type typeOf(Base base) {
  switch (base) {
    case Base::Int:
      return Type::Int;
    case Base::String:
      return Type::String;
    case Base::Color:
      return Type::Color;
    case Base::Point:
      return Type::Point;
    case Base::Vector:
      return Type::Vector;
    case Base::Normal:
      return Type::Normal;
    case Base::Matrix:
      return Type::Matrix;
    default:
      return Type::Float;
  }
}

// What the optimiser compiles in, and what has no place in a material's block, is part of the program.
void describe(ShaderNode& node) {
  const language::Shader& shader = *node.shader;
  const std::vector<bool> decides = language::structuralSymbols(shader);
  for (size_t i = 0; i < shader.symbols.size(); ++i) {
    const language::Symbol& s = shader.symbols[i];
    if (s.kind != language::SymbolKind::Param && s.kind != language::SymbolKind::OutputParam) continue;
    if (s.type.base == Base::Struct || s.type.base == Base::Closure || s.type.base == Base::Void) continue;
    Param p;
    p.name = node.texts.emplace_back(s.name).c_str();
    p.type = typeOf(s.type.base);
    if (s.kind == language::SymbolKind::OutputParam) p.flags |= kParamOutput;
    const bool isList = s.type.arrayLength != 0 || s.type.base == Base::Matrix;
    if (isList) p.flags |= kParamArray | kParamFixed;
    if ((p.type == Type::String || p.type == Type::Int) && (isList || decides[i]))
      p.flags |= kParamFixed;
    else if (p.type == Type::String)
      p.flags |= kParamFile;  // gathered by point; a shader's are handles of strings
    std::vector<float>& list = node.lists.emplace_back(s.values.floats);
    if (p.type == Type::Int) list.assign(s.values.ints.begin(), s.values.ints.end());
    if (isList) {
      p.list = list.data();
      p.listCount = uint32_t(list.size());
    } else {
      for (size_t k = 0; k < 3 && !list.empty(); ++k) p.value[k] = list[std::min(k, list.size() - 1)];
    }
    if (p.type == Type::String && !s.values.strings.empty())
      p.text = node.texts.emplace_back(s.values.strings[0]).c_str();
    node.params.push_back(p);
    node.symbolOf.push_back(language::SymbolId(i));
  }
  node.descriptor.params = node.params.data();
  node.descriptor.paramCount = uint32_t(node.params.size());
}

}  // namespace

std::string shaderNameOf(const scene::Node& node) {
  return sameName(node.plugin, "PxrOSL") ? node.params.getString("shader", "") : node.plugin;
}

std::shared_ptr<const ShaderNode> makeShaderNode(const std::string& file, std::shared_ptr<language::Shader> shader) {
  auto node = std::make_shared<ShaderNode>();
  node->file = file;
  node->descriptor.abiVersion = kAbiVersion;
  node->descriptor.descriptorBytes = sizeof(Descriptor);
  node->descriptor.kind = Kind::Pattern;
  node->descriptor.doc = "";
  if (shader) {
    node->shader = std::move(shader);
    describe(*node);
    const auto look = [&](const language::Instruction& in) {
      node->asksRayType |= in.opcode == language::Opcode::RayType;
    };
    for (const language::Initialiser& i : node->shader->initialisers) language::forEachInstruction(i.code, look);
    language::forEachInstruction(node->shader->main, look);
  }
  node->descriptor.name = node->texts.emplace_back(node->shader ? node->shader->name : file).c_str();
  return node;
}

std::shared_ptr<const ShaderNode> withMovedPoint(const ShaderNode& node) {
  using namespace language;
  const Shader& before = *node.shader;
  auto shader = std::make_shared<Shader>(before);
  const auto globalNamed = [&](const char* name, Base base) {
    for (size_t i = 0; i < shader->symbols.size(); ++i)
      if (shader->symbols[i].kind == SymbolKind::Global && shader->symbols[i].name == name) return SymbolId(i);
    Symbol global;
    global.name = name;
    global.kind = SymbolKind::Global;
    global.type.base = base;
    shader->symbols.push_back(std::move(global));
    return SymbolId(shader->symbols.size() - 1);
  };
  const SymbolId P = globalNamed("P", Base::Point), N = globalNamed("N", Base::Normal);
  bool isMoved = false, isTurned = false;
  const auto look = [&](const Instruction& in) {
    for (uint32_t k = 0; k < in.arguments.size(); ++k) {
      if (accessOf(before, in, k) == 'r') continue;
      isMoved |= in.arguments[k] == P;
      isTurned |= in.arguments[k] == N;
    }
  };
  forEachInstruction(before.main, look);
  if (!isMoved && !isTurned) return nullptr;
  Symbol name;
  name.name = "$body";
  name.kind = SymbolKind::Constant;
  name.type.base = Base::String;
  name.values.strings = {before.name};
  shader->symbols.push_back(std::move(name));
  // a return leaves the body alone
  Instruction body;
  body.opcode = Opcode::Call;
  body.arguments = {SymbolId(shader->symbols.size() - 1)};
  body.blocks.push_back(std::move(shader->main));
  shader->main = Block();
  shader->main.code.push_back(std::move(body));
  const auto give = [&](const char* output, SymbolId global) {
    Symbol moved;
    moved.name = output;
    moved.kind = SymbolKind::OutputParam;
    moved.type = shader->symbols[size_t(global)].type;
    moved.values.floats = {0, 0, 0};
    shader->symbols.push_back(std::move(moved));
    Instruction copy;
    copy.opcode = Opcode::Assign;
    copy.arguments = {SymbolId(shader->symbols.size() - 1), global};
    shader->main.code.push_back(std::move(copy));
  };
  give(kMovedPoint, P);
  if (isTurned) give(kMovedNormal, N);
  return makeShaderNode(node.file, std::move(shader));
}

}  // namespace kinora::shade
