// The readable form of the intermediate form.
#include <cstdio>

#include "language/program/program.h"
#include "language/program/quoted.h"

namespace kinora::language {

namespace {

constexpr size_t kMostValuesShown = 16;  // values of one symbol

std::string textOf(const Values& v) {
  std::vector<std::string> parts;
  for (const int32_t i : v.ints) parts.push_back(std::to_string(i));
  for (const float f : v.floats) parts.push_back(nineDigits(f));
  for (const std::string& s : v.strings) parts.push_back(inQuotes(s));
  if (parts.size() == 1) return parts[0];
  std::string s = "{";
  for (size_t i = 0; i < parts.size() && i < kMostValuesShown; ++i) s += (i ? ", " : "") + parts[i];
  return s + (parts.size() > kMostValuesShown ? ", ...}" : "}");
}

class Printer {
 public:
  explicit Printer(const Shader& shader) : shader_(shader) {}

  std::string run() {
    static constexpr const char* kKinds[] = {"shader", "surface", "displacement", "volume"};
    s_ = std::string(kKinds[size_t(shader_.kind)]) + " " + shader_.name + "\n";
    for (const Metadata& m : shader_.metadata) metadata(m);
    for (const Structure& t : shader_.structures) {
      s_ += "struct " + t.name + " {";
      for (const Field& f : t.fields) s_ += " " + typeName(f.type) + " " + f.name + ";";
      s_ += " }\n";
    }
    for (const Symbol& symbol : shader_.symbols) {
      if (symbol.kind == SymbolKind::Constant) continue;  // stands where it is used
      static constexpr const char* kSymbols[] = {"param", "output", "local", "temp", "global", "const"};
      s_ += std::string(kSymbols[size_t(symbol.kind)]) + " " + typeName(symbol.type) + " " + symbol.name;
      if (symbol.hasInitCode)
        s_ += " = code";
      else if (!symbol.values.empty())
        s_ += " = " + textOf(symbol.values);
      if (!symbol.lockGeometry) s_ += "  # primvar";
      s_ += "\n";
      for (const Metadata& m : symbol.metadata) metadata(m);
    }
    for (const Initialiser& i : shader_.initialisers) {
      s_ += "init " + name(i.parameter) + "\n";
      block(i.code, 1);
    }
    s_ += "main\n";
    block(shader_.main, 1);
    return std::move(s_);
  }

 private:
  std::string typeName(const Type& t) const {
    if (t.base != Base::Struct || t.structure < 0 || size_t(t.structure) >= shader_.structures.size())
      return nameOf(t);
    Type plain = t;
    plain.base = Base::Int;
    return shader_.structures[size_t(t.structure)].name + nameOf(plain).substr(3);
  }
  std::string name(SymbolId id) const {
    if (id < 0 || size_t(id) >= shader_.symbols.size()) return "?";
    const Symbol& s = shader_.symbols[size_t(id)];
    if (s.kind != SymbolKind::Constant) return s.name;
    const bool isPlainNumber = s.type.arrayLength == 0 && componentsOf(s.type.base) == 1;
    return isPlainNumber ? textOf(s.values) : nameOf(s.type) + textOf(s.values);
  }
  void metadata(const Metadata& m) { s_ += "  # " + nameOf(m.type) + " " + m.name + " = " + textOf(m.values) + "\n"; }
  void block(const Block& b, size_t depth) {
    for (const Instruction& i : b.code) instruction(i, depth);
  }
  void instruction(const Instruction& i, size_t depth) {
    const std::string indent(2 * depth, ' ');
    const size_t begin = s_.size();
    s_ += indent + std::string(factsOf(i.opcode).name);
    for (const SymbolId id : i.arguments) s_ += " " + name(id);
    if (i.pos.line && i.blocks.empty()) {
      const size_t width = s_.size() - begin;
      s_.append(width < 60 ? 60 - width : 2, ' ');
      s_ += "# " + std::to_string(i.pos.line);
    }
    s_ += "\n";
    static constexpr const char* kLoop[] = {"init", "condition", "body", "step"};
    for (size_t n = 0; n < i.blocks.size(); ++n) {
      const char* title = i.opcode == Opcode::If     ? (n == 0 ? nullptr : "else")
                          : i.opcode == Opcode::Call ? nullptr
                                                     : kLoop[n & 3];
      if (title && i.blocks[n].code.empty()) continue;
      if (title) s_ += indent + " " + title + "\n";
      block(i.blocks[n], depth + 1);
    }
  }

  const Shader& shader_;
  std::string s_;
};

}  // namespace

std::string toText(const Shader& shader) { return Printer(shader).run(); }

}  // namespace kinora::language
