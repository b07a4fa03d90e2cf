#include "language/program/oso_writer.h"

#include "language/program/quoted.h"

#include <climits>
#include <cstdio>

namespace kinora::language {

namespace {

class Writer {
 public:
  explicit Writer(const Shader& shader)
      : shader_(shader), reads_(shader.symbols.size()), writes_(shader.symbols.size()) {}

  std::string run() {
    for (const Initialiser& i : shader_.initialisers) {
      sections_.push_back({shader_.symbols[size_t(i.parameter)].name, ops_.size()});
      flatten(i.code);
    }
    sections_.push_back({"___main___", ops_.size()});
    flatten(shader_.main);
    for (size_t i = 0; i < ops_.size(); ++i) {
      const Instruction& op = *ops_[i].instruction;
      for (size_t a = 0; a < op.arguments.size(); ++a) {
        const char access = accessOf(shader_, op, uint32_t(a));
        if (access != 'w') reads_[size_t(op.arguments[a])].add(int(i));
        if (access != 'r') writes_[size_t(op.arguments[a])].add(int(i));
      }
    }
    static constexpr const char* kKinds[] = {"shader", "surface", "displacement", "volume"};
    s_ = "OpenShadingLanguage 1.00\n# Compiled by kinora\n" + std::string(kKinds[size_t(shader_.kind)]) + " " +
         shader_.name;
    if (!shader_.metadata.empty()) s_ += "\t";
    for (const Metadata& m : shader_.metadata) metadata(m);
    s_ += "\n";
    for (size_t i = 0; i < shader_.symbols.size(); ++i) {
      const Symbol& s = shader_.symbols[i];
      if (s.kind == SymbolKind::Param || s.kind == SymbolKind::OutputParam) symbol(i);
    }
    // a struct is written whole or not at all
    std::vector<char> isNeeded(shader_.symbols.size());
    for (size_t i = 0; i < shader_.symbols.size(); ++i)
      if (isUsed(i)) isNeeded[whole(i)] = 1;
    for (size_t i = 0; i < shader_.symbols.size(); ++i) {
      const Symbol& s = shader_.symbols[i];
      if (s.kind != SymbolKind::Param && s.kind != SymbolKind::OutputParam && isNeeded[whole(i)]) symbol(i);
    }
    code();
    return std::move(s_);
  }

 private:
  struct Range {
    int first = INT_MAX, last = -1;
    void add(int i) {
      if (first == INT_MAX) first = i;
      last = i;
    }
  };
  struct Op {
    const Instruction* instruction;
    std::vector<size_t> jumps;
  };

  bool isUsed(size_t i) const { return reads_[i].last >= 0 || writes_[i].last >= 0; }

  size_t whole(size_t i) const {
    while (shader_.symbols[i].ofStruct != kNone) i = size_t(shader_.symbols[i].ofStruct);
    return i;
  }

  void flatten(const Block& block) {
    for (const Instruction& i : block.code) {
      if (i.opcode == Opcode::End) continue;
      const size_t at = ops_.size();
      ops_.push_back({&i, {}});
      std::vector<size_t> jumps;
      switch (i.opcode) {
        case Opcode::If:
          flatten(i.blocks[0]);
          jumps.push_back(ops_.size());
          flatten(i.blocks[1]);
          break;
        case Opcode::For:
        case Opcode::While:
        case Opcode::DoWhile:
          flatten(i.blocks[0]);
          for (size_t b = 1; b < 4; ++b) {
            jumps.push_back(ops_.size());
            flatten(i.blocks[b]);
          }
          break;
        case Opcode::Call:
          flatten(i.blocks[0]);
          break;
        default:
          continue;
      }
      jumps.push_back(ops_.size());
      ops_[at].jumps = std::move(jumps);
    }
  }

  static void code(const Type& t, const std::vector<Structure>& structures, std::string& out) {
    static constexpr char kLetters[] = {'x', 'i', 'f', 's', 'c', 'p', 'v', 'n', 'm', 'C'};
    out += t.base == Base::Struct ? "S" + structures[size_t(t.structure)].name
                                  : std::string(1, kLetters[size_t(t.base)]);
    if (t.arrayLength > 0) out += "[" + std::to_string(t.arrayLength) + "]";
    if (t.arrayLength < 0) out += "[]";
  }

  std::string typeText(const Type& t) const {
    if (t.base != Base::Struct) return nameOf(t);
    std::string s = "struct " + shader_.structures[size_t(t.structure)].name;
    if (t.arrayLength > 0) s += "[" + std::to_string(t.arrayLength) + "]";
    if (t.arrayLength < 0) s += "[]";
    return s;
  }

  void metadata(const Metadata& m) {
    s_ += "%meta{" + nameOf(m.type) + "," + m.name;
    for (const int32_t i : m.values.ints) s_ += "," + std::to_string(i);
    for (const float f : m.values.floats) s_ += "," + nineDigits(f);
    for (const std::string& v : m.values.strings) s_ += "," + inQuotes(v);
    s_ += "} ";
  }

  void values(const Symbol& s) {
    for (const int32_t i : s.values.ints) s_ += std::to_string(i) + " ";
    for (const float f : s.values.floats) s_ += nineDigits(f) + " ";
    for (const std::string& v : s.values.strings) s_ += inQuotes(v) + " ";
  }

  void symbol(size_t id) {
    static constexpr const char* kSymbols[] = {"param", "oparam", "local", "temp", "global", "const"};
    const Symbol& s = shader_.symbols[id];
    s_ += std::string(kSymbols[size_t(s.kind)]) + "\t" + typeText(s.type) + "\t" + s.name + "\t";
    if (s.kind == SymbolKind::Param || s.kind == SymbolKind::OutputParam || s.kind == SymbolKind::Constant) values(s);
    s_ += "\t";
    for (const Metadata& m : s.metadata) metadata(m);
    const auto range = [&](const char* name, const Range& r) {
      s_ += std::string("%") + name + "{" + std::to_string(r.first) + "," + std::to_string(r.last) + "} ";
    };
    range("read", reads_[id]);
    range("write", writes_[id]);
    if (s.type.base == Base::Struct) {
      const Structure& structure = shader_.structures[size_t(s.type.structure)];
      std::string names, codes;
      for (const Field& f : structure.fields) {
        names += (names.empty() ? "" : ",") + f.name;
        code(f.type, shader_.structures, codes);
      }
      s_ += "%struct{\"" + structure.name + "\"} %structfields{" + names + "} %structfieldtypes{\"" + codes +
            "\"} %structnfields{" + std::to_string(structure.fields.size()) + "} ";
    }
    if (s.ofStruct != kNone)
      s_ += "%mystruct{" + shader_.symbols[size_t(s.ofStruct)].name + "} %mystructfield{" + std::to_string(s.field) +
            "} ";
    if (s.hasInitCode) s_ += "%initexpr ";
    s_.back() = '\n';
  }

  void code() {
    size_t section = 0;
    std::string file;
    uint32_t line = 0;
    for (size_t i = 0; i <= ops_.size(); ++i) {
      while (section < sections_.size() && sections_[section].second == i) {
        s_ += "code " + sections_[section].first + "\n";
        ++section;
      }
      if (i == ops_.size()) break;
      const Instruction& op = *ops_[i].instruction;
      s_ += "\t" + std::string(factsOf(op.opcode).name) + "\t\t";
      std::string access;
      for (size_t a = 0; a < op.arguments.size(); ++a) {
        s_ += shader_.symbols[size_t(op.arguments[a])].name + " ";
        access += accessOf(shader_, op, uint32_t(a));
      }
      for (const size_t j : ops_[i].jumps) s_ += std::to_string(j) + " ";
      std::string hints;
      if (op.pos.file && *op.pos.file != file) {
        file = *op.pos.file;
        hints += "%filename{" + inQuotes(file) + "} ";
      }
      if (op.pos.line && op.pos.line != line) {
        line = op.pos.line;
        hints += "%line{" + std::to_string(line) + "} ";
      }
      if (!op.arguments.empty()) hints += "%argrw{\"" + access + "\"} ";
      if (!hints.empty()) {
        hints.pop_back();
        s_ += "\t" + hints;
      }
      s_ += "\n";
    }
    s_ += "\tend\n";
  }

  const Shader& shader_;
  std::vector<Range> reads_, writes_;
  std::vector<Op> ops_;
  std::vector<std::pair<std::string, size_t>> sections_;  // and their first operation
  std::string s_;
};

}  // namespace

std::string osoText(const Shader& shader) { return Writer(shader).run(); }

}  // namespace kinora::language
