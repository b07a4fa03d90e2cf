#include "shade/shader_node.h"

#include <algorithm>

#include "language/optimise/structure.h"

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

void replaceIn(language::Block& block, language::SymbolId from, language::SymbolId to) {
  for (language::Instruction& i : block.code) {
    std::replace(i.arguments.begin(), i.arguments.end(), from, to);
    for (language::Block& inner : i.blocks) replaceIn(inner, from, to);
  }
}
bool writes(const language::Shader& shader, const language::Block& block, language::SymbolId symbol) {
  for (const language::Instruction& i : block.code) {
    for (uint32_t k = 0; k < i.arguments.size(); ++k)
      if (i.arguments[k] == symbol && accessOf(shader, i, k) != 'r') return true;
    for (const language::Block& inner : i.blocks)
      if (writes(shader, inner, symbol)) return true;
  }
  return false;
}

// Writing P, N or Ci changes nothing in a pattern: the shader gets a variable of its own instead. False: it writes none.
bool keepGlobals(language::Shader& shader) {
  bool hasChanged = false;
  const size_t count = shader.symbols.size();
  for (size_t s = 0; s < count; ++s) {
    const auto id = language::SymbolId(s);
    if (shader.symbols[s].kind != language::SymbolKind::Global || !writes(shader, shader.main, id)) continue;
    hasChanged = true;
    const auto global = language::SymbolId(shader.symbols.size());
    shader.symbols.push_back(shader.symbols[s]);
    shader.symbols[s].kind = language::SymbolKind::Local;
    shader.symbols[s].name = "$own_" + shader.symbols[s].name;
    for (language::Initialiser& i : shader.initialisers) replaceIn(i.code, id, global);
    if (shader.symbols[s].type.base == Base::Closure) continue;
    language::Instruction copy;
    copy.opcode = language::Opcode::Assign;
    copy.arguments = {id, global};
    shader.main.code.insert(shader.main.code.begin(), std::move(copy));
  }
  return hasChanged;
}

}  // namespace

std::shared_ptr<const ShaderNode> makeShaderNode(const std::string& file, std::shared_ptr<language::Shader> shader) {
  auto node = std::make_shared<ShaderNode>();
  node->file = file;
  node->descriptor.abiVersion = kAbiVersion;
  node->descriptor.descriptorBytes = sizeof(Descriptor);
  node->descriptor.kind = Kind::Pattern;
  node->descriptor.doc = "";
  if (shader) {
    auto pattern = std::make_shared<language::Shader>(*shader);
    const bool isSame = !keepGlobals(*pattern);
    node->shader = std::move(pattern);
    node->compiled = isSame ? node->shader : std::move(shader);
    describe(*node);
  }
  node->descriptor.name = node->texts.emplace_back(node->shader ? node->shader->name : file).c_str();
  return node;
}

}  // namespace kinora::shade
